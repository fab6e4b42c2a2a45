// Embree 3 or 4 as a plugin of rtbench: triangles as one geometry, rtcIntersect1 and rtcOccluded1, its own
// triangle test. Triangles that let light pass are a second geometry, whose filter lets all shadow rays by.
//
// The library is opened at run time, so that neither its headers nor the library are needed to compile this.
// What of its interface is used is declared here, after its documentation (Embree API, "rtcNewDevice" and so
// on); the two versions differ by the context that a ray of version 3 comes with. EMBREE says which it is.
#include <dlfcn.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "rtbench.h"

#define TEXT(x) #x
#define NUMBER(x) TEXT(x)
#define LIBRARY "libembree" NUMBER(EMBREE) ".so"
#define VARIABLE "EMBREE" NUMBER(EMBREE) "_LIBRARY"

namespace {

struct alignas(16) Ray { // RTCRay
    float origin[3], tnear, direction[3], time, tfar;
    unsigned mask, id, flags;
};

struct alignas(16) RayHit { // RTCRayHit
    Ray ray;
    float normal[3], u, v;
    unsigned prim, geom, instance, instance_prim, padding[3]; // the last since 4.2
};

struct Context { // RTCIntersectContext of version 3
    unsigned flags;
    void *filter;
    unsigned instance;
};

struct FilterArguments { // RTCFilterFunctionNArguments
    int *valid;
    void *user, *context, *ray, *hit;
    unsigned count;
};

enum : unsigned { INVALID = ~0u };
enum { VERSION_PROPERTY = 0, TRIANGLES = 0, INDICES = 0, VERTICES = 1, UINT3 = 0x5003, FLOAT3 = 0x9003, ROBUST = 1 << 2 };

using Device = void *;
using Scene = void *;
using Geometry = void *;

// The functions that are used, by their names without "rtc".
struct Embree {
    void *library = nullptr;
    std::string fault, version = "not found";

#define FUNCTION(result, name, ...) result (*name)(__VA_ARGS__) = find<result (*)(__VA_ARGS__)>("rtc" #name)
    template <class F> F find(const char *name) {
        if (!library) open();
        void *found = library ? dlsym(library, name) : nullptr;
        if (library && !found) fault = std::string(LIBRARY " has no ") + name;
        return reinterpret_cast<F>(found);
    }
    FUNCTION(Device, NewDevice, const char *);
    FUNCTION(void, ReleaseDevice, Device);
    FUNCTION(int, GetDeviceError, Device);
    FUNCTION(ssize_t, GetDeviceProperty, Device, int);
    FUNCTION(void, SetDeviceMemoryMonitorFunction, Device, bool (*)(void *, ssize_t, bool), void *);
    FUNCTION(Scene, NewScene, Device);
    FUNCTION(void, ReleaseScene, Scene);
    FUNCTION(void, SetSceneBuildQuality, Scene, int);
    FUNCTION(void, SetSceneFlags, Scene, int);
    FUNCTION(void, JoinCommitScene, Scene);
    FUNCTION(Geometry, NewGeometry, Device, int);
    FUNCTION(void, SetGeometryBuildQuality, Geometry, int);
    FUNCTION(void *, SetNewGeometryBuffer, Geometry, int, unsigned, int, size_t, size_t);
    FUNCTION(void, SetGeometryOccludedFilterFunction, Geometry, void (*)(const FilterArguments *));
    FUNCTION(void, CommitGeometry, Geometry);
    FUNCTION(void, AttachGeometryByID, Scene, Geometry, unsigned);
    FUNCTION(void, ReleaseGeometry, Geometry);
#if EMBREE == 3
    FUNCTION(void, Intersect1, Scene, Context *, RayHit *);
    FUNCTION(void, Occluded1, Scene, Context *, Ray *);
#else
    FUNCTION(void, Intersect1, Scene, RayHit *, void *);
    FUNCTION(void, Occluded1, Scene, Ray *, void *);
#endif

    Embree() {
        if (!library || !fault.empty()) return;
        Device device = NewDevice("threads=1");
        if (!device) return;
        ssize_t number = GetDeviceProperty(device, VERSION_PROPERTY); // 10000 for each of the first number
        ReleaseDevice(device);
        version = std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." + std::to_string(number % 100);
        if (number / 10000 != EMBREE) fault = "it is version " + version + ", expected " NUMBER(EMBREE);
    }

  private:
    void open() {
        const char *named = std::getenv(VARIABLE);
        for (const char *file : {named ? named : LIBRARY "." NUMBER(EMBREE), LIBRARY})
            if ((library = dlopen(file, RTLD_NOW | RTLD_LOCAL)) || named) break;
        if (!library) fault = std::string(LIBRARY " cannot be opened, set " VARIABLE ": ") + dlerror();
    }
};

Embree &embree() {
    static Embree once;
    return once;
}

struct Built {
    Device device = nullptr;
    Scene scene = nullptr;
    std::vector<uint32_t> ids[2]; // of opaque triangles, of others
    long long bytes = 0;
};

bool count_bytes(void *user, ssize_t bytes, bool) {
    __atomic_fetch_add(&static_cast<Built *>(user)->bytes, static_cast<long long>(bytes), __ATOMIC_RELAXED);
    return true;
}

void let_pass(const FilterArguments *arguments) {
    for (unsigned i = 0; i < arguments->count; i++) arguments->valid[i] = 0;
}

void destroy(void *pointer) {
    auto *built = static_cast<Built *>(pointer);
    if (built->scene) embree().ReleaseScene(built->scene);
    if (built->device) embree().ReleaseDevice(built->device);
    delete built;
}

int quality_of(const rtbench_scene &scene) {
    std::string quality = scene.settings[0];
    return quality == "low" ? 0 : quality == "high" ? 2 : 1;
}

void attach(Built &built, const rtbench_scene &from, unsigned which) {
    const auto &ids = built.ids[which];
    if (ids.empty()) return;
    Geometry geometry = embree().NewGeometry(built.device, TRIANGLES);
    embree().SetGeometryBuildQuality(geometry, quality_of(from));
    auto *vertices = static_cast<float *>(embree().SetNewGeometryBuffer(geometry, VERTICES, 0, FLOAT3, 12, 3 * ids.size()));
    auto *indices = static_cast<uint32_t *>(embree().SetNewGeometryBuffer(geometry, INDICES, 0, UINT3, 12, ids.size()));
    if (vertices && indices) {
        for (size_t i = 0; i < ids.size(); i++) {
            std::memcpy(vertices + 9 * i, from.positions + 9 * size_t(ids[i]), 36);
            for (uint32_t k = 0; k < 3; k++) indices[3 * i + k] = uint32_t(3 * i + k);
        }
        if (which == 1) embree().SetGeometryOccludedFilterFunction(geometry, let_pass);
        embree().CommitGeometry(geometry);
        embree().AttachGeometryByID(built.scene, geometry, which);
    }
    embree().ReleaseGeometry(geometry);
}

int build(const rtbench_scene *scene, void **out, char *message, size_t size) {
    if (!embree().fault.empty()) return std::snprintf(message, size, "%s", embree().fault.c_str()), 1;
    auto *built = new Built;
    std::string config = "user_threads=1,threads=" + std::to_string(scene->threads);
    const char *avx512 = std::getenv("RTBENCH_AVX512"); // as for rtbench's own rows
    if (avx512 && avx512 == std::string("off")) config += ",isa=avx2";
    built->device = embree().NewDevice(config.c_str());
    if (!built->device) {
        std::snprintf(message, size, "rtcNewDevice fails with error %d", embree().GetDeviceError(nullptr));
        return destroy(built), 1;
    }
    embree().SetDeviceMemoryMonitorFunction(built->device, count_bytes, built);
    built->scene = embree().NewScene(built->device);
    embree().SetSceneBuildQuality(built->scene, quality_of(*scene));
    embree().SetSceneFlags(built->scene, scene->settings[1] == std::string("yes") ? ROBUST : 0);
    for (uint32_t id = 0; id < scene->triangles; id++)
        built->ids[scene->transmissive && scene->transmissive[id]].push_back(id);
    attach(*built, *scene, 0);
    attach(*built, *scene, 1);
    embree().JoinCommitScene(built->scene);
    if (int error = embree().GetDeviceError(built->device)) {
        std::snprintf(message, size, "Embree reports error %d", error);
        return destroy(built), 1;
    }
    *out = built;
    return 0;
}

Ray asked(const rtbench_ray &ray) {
    Ray own = {};
    std::memcpy(own.origin, ray.origin, sizeof own.origin);
    std::memcpy(own.direction, ray.direction, sizeof own.direction);
    own.tnear = ray.t_min, own.tfar = ray.t_max, own.mask = ~0u;
    return own;
}

void closest(void *pointer, const rtbench_ray *rays, rtbench_hit *hits, size_t count) {
    const auto &built = *static_cast<Built *>(pointer);
    auto intersect = embree().Intersect1;
    [[maybe_unused]] Context context = {0, nullptr, INVALID};
    for (size_t i = 0; i < count; i++) {
        RayHit own;
        own.ray = asked(rays[i]);
        own.geom = own.instance = own.instance_prim = INVALID;
#if EMBREE == 3
        intersect(built.scene, &context, &own);
#else
        intersect(built.scene, &own, nullptr);
#endif
        hits[i] = {own.ray.tfar, own.geom == INVALID ? RTBENCH_MISS : built.ids[own.geom][own.prim]};
    }
}

void occluded(void *pointer, const rtbench_ray *rays, uint8_t *blocked, size_t count) {
    const auto &built = *static_cast<Built *>(pointer);
    auto ask = embree().Occluded1;
    [[maybe_unused]] Context context = {0, nullptr, INVALID};
    for (size_t i = 0; i < count; i++) {
        Ray own = asked(rays[i]);
#if EMBREE == 3
        ask(built.scene, &context, &own);
#else
        ask(built.scene, &own, nullptr);
#endif
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

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) {
    static const rtbench_plugin plugin = {
        RTBENCH_ABI_VERSION, sizeof(rtbench_plugin), "embree-" NUMBER(EMBREE), embree().version.c_str(),
        "Embree " NUMBER(EMBREE) " over rtbench.h, one ray per call",
        RTBENCH_TRIANGLES_F32 | RTBENCH_OCCLUSION, RTBENCH_ONE_RAY, RTBENCH_OWN_TEST,
        sizeof settings / sizeof *settings, settings,
        build, closest, occluded, stats, nullptr, destroy,
        nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, // Embree has no f64
    };
    return &plugin;
}
