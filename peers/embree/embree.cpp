// Embree 3 as a plugin of rtbench: triangles as one geometry, rtcIntersect1 and rtcOccluded1, its own
// triangle test. Triangles that let light pass are a second geometry, whose filter lets all shadow rays by.
#include <embree3/rtcore.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "rtbench.h"

namespace {

struct Built {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<uint32_t> ids[2]; // of opaque triangles, of others
    long long bytes = 0;
};

bool count_bytes(void *user, ssize_t bytes, bool) {
    __atomic_fetch_add(&static_cast<Built *>(user)->bytes, static_cast<long long>(bytes), __ATOMIC_RELAXED);
    return true;
}

void let_pass(const RTCFilterFunctionNArguments *arguments) {
    for (unsigned i = 0; i < arguments->N; i++) arguments->valid[i] = 0;
}

void destroy(void *pointer) {
    auto *built = static_cast<Built *>(pointer);
    if (built->scene) rtcReleaseScene(built->scene);
    if (built->device) rtcReleaseDevice(built->device);
    delete built;
}

void attach(Built &built, const rtbench_scene &from, unsigned which) {
    const auto &ids = built.ids[which];
    if (ids.empty()) return;
    RTCGeometry geometry = rtcNewGeometry(built.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto *vertices = static_cast<float *>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * ids.size()));
    auto *indices = static_cast<uint32_t *>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, ids.size()));
    if (vertices && indices) {
        for (size_t i = 0; i < ids.size(); i++) {
            std::memcpy(vertices + 9 * i, from.positions + 9 * size_t(ids[i]), 36);
            for (uint32_t k = 0; k < 3; k++) indices[3 * i + k] = uint32_t(3 * i + k);
        }
        if (which == 1) rtcSetGeometryOccludedFilterFunction(geometry, let_pass);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(built.scene, geometry, which);
    }
    rtcReleaseGeometry(geometry);
}

int build(const rtbench_scene *scene, void **out, char *message, size_t size) {
    auto *built = new Built;
    std::string config = "threads=" + std::to_string(scene->threads);
    built->device = rtcNewDevice(config.c_str());
    if (!built->device) {
        std::snprintf(message, size, "rtcNewDevice fails with error %d", int(rtcGetDeviceError(nullptr)));
        return destroy(built), 1;
    }
    rtcSetDeviceMemoryMonitorFunction(built->device, count_bytes, built);
    std::string quality = scene->settings[0];
    built->scene = rtcNewScene(built->device);
    rtcSetSceneBuildQuality(built->scene, quality == "low"    ? RTC_BUILD_QUALITY_LOW
                                          : quality == "high" ? RTC_BUILD_QUALITY_HIGH
                                                              : RTC_BUILD_QUALITY_MEDIUM);
    bool robust = scene->settings[1] == std::string("yes");
    rtcSetSceneFlags(built->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    for (uint32_t id = 0; id < scene->triangles; id++)
        built->ids[scene->transmissive && scene->transmissive[id]].push_back(id);
    attach(*built, *scene, 0);
    attach(*built, *scene, 1);
    rtcCommitScene(built->scene);
    if (RTCError error = rtcGetDeviceError(built->device)) {
        std::snprintf(message, size, "Embree reports error %d", int(error));
        return destroy(built), 1;
    }
    *out = built;
    return 0;
}

RTCRay asked(const rtbench_ray &ray) {
    RTCRay own = {};
    own.org_x = ray.origin[0], own.org_y = ray.origin[1], own.org_z = ray.origin[2];
    own.dir_x = ray.direction[0], own.dir_y = ray.direction[1], own.dir_z = ray.direction[2];
    own.tnear = ray.t_min, own.tfar = ray.t_max, own.mask = 0xffffffffu;
    return own;
}

void closest(void *pointer, const rtbench_ray *rays, rtbench_hit *hits, size_t count) {
    const auto &built = *static_cast<Built *>(pointer);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < count; i++) {
        RTCRayHit own;
        own.ray = asked(rays[i]);
        own.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        own.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(built.scene, &context, &own);
        bool is_hit = own.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        hits[i] = {own.ray.tfar, is_hit ? built.ids[own.hit.geomID][own.hit.primID] : RTBENCH_MISS};
    }
}

void occluded(void *pointer, const rtbench_ray *rays, uint8_t *blocked, size_t count) {
    const auto &built = *static_cast<Built *>(pointer);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < count; i++) {
        RTCRay own = asked(rays[i]);
        rtcOccluded1(built.scene, &context, &own);
        blocked[i] = own.tfar < 0; // minus infinity says "occluded"
    }
}

void stats(void *pointer, rtbench_stats *stats) {
    const auto &built = *static_cast<Built *>(pointer);
    stats->bytes = built.bytes > 0 ? uint64_t(built.bytes) : 0;
    stats->references = built.ids[0].size() + built.ids[1].size();
}

const rtbench_setting settings[] = {
    {"quality", "what the build aims at", "medium", RTBENCH_CHOICE, 0, 0, "low medium high"},
    {"robust", "Embree's robust traversal", "no", RTBENCH_CHOICE, 0, 0, "no yes"},
};

const rtbench_plugin plugin = {
    RTBENCH_ABI_VERSION, sizeof(rtbench_plugin), "embree-plugin", RTC_VERSION_STRING,
    "Embree 3 over rtbench.h, one ray per call",
    RTBENCH_TRIANGLES_F32 | RTBENCH_OCCLUSION, RTBENCH_ONE_RAY, RTBENCH_OWN_TEST,
    sizeof settings / sizeof *settings, settings,
    build, closest, occluded, stats, nullptr, destroy,
};

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
