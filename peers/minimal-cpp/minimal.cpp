// A naive BVH as a plugin of rtbench: halves its triangles along the longest axis until few are left.
// Its own triangle test is that of Moeller and Trumbore in f32. The setting `fault` plants mistakes, for
// the tests of rtbench: leave it out of yours.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "rtbench.h"

namespace {

struct Vec { float x, y, z; };
Vec at(const float *p) { return {p[0], p[1], p[2]}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

struct Node {
    float low[3], high[3];
    uint32_t first, count; // of a leaf: its ids; else count is 0, and the children are at first, first + 1
};

struct Bvh {
    const rtbench_scene *scene;
    std::vector<Node> nodes;
    std::vector<uint32_t> ids;
    uint32_t leaf;
    std::string fault;
    std::vector<char> hoard = {};
    bool ignores_t_min = fault == "t-min", drops = fault == "drop", leaks = fault == "edges";
    bool is_coarse = fault == "last-bits";

    const float *corners(uint32_t id) const { return scene->positions + 9 * size_t(id); }

    void split(uint32_t index, uint32_t first, uint32_t count) {
        Node node = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, first, count};
        for (uint32_t i = first; i < first + count; i++)
            for (int k = 0; k < 9; k++) {
                float x = corners(ids[i])[k], pad = 1e-5f * std::fabs(x) + 1e-30f; // rounding loses no hit
                node.low[k % 3] = std::min(node.low[k % 3], x - pad);
                node.high[k % 3] = std::max(node.high[k % 3], x + pad);
            }
        if (count > leaf) {
            int axis = 0;
            for (int k = 1; k < 3; k++)
                if (node.high[k] - node.low[k] > node.high[axis] - node.low[axis]) axis = k;
            auto centre = [&](uint32_t id) { const float *p = corners(id) + axis; return p[0] + p[3] + p[6]; };
            auto begin = ids.begin() + first;
            std::nth_element(begin, begin + count / 2, begin + count,
                             [&](uint32_t a, uint32_t b) { return centre(a) < centre(b); });
            node = {{node.low[0], node.low[1], node.low[2]}, {node.high[0], node.high[1], node.high[2]},
                    uint32_t(nodes.size()), 0};
            nodes.resize(nodes.size() + 2);
            split(node.first, first, count / 2);
            split(node.first + 1, first + count / 2, count - count / 2);
        }
        nodes[index] = node;
    }

    bool test(const rtbench_ray &ray, uint32_t id, float t_max, float &t) const {
        const float *p = corners(id);
        Vec a = at(p), e1 = at(p + 3) - a, e2 = at(p + 6) - a, d = at(ray.direction);
        Vec h = cross(d, e2);
        float det = dot(e1, h);
        if (det == 0) return false;
        Vec s = at(ray.origin) - a, q = cross(s, e1);
        float u = dot(s, h) / det, v = dot(d, q) / det, found = dot(e2, q) / det;
        if (!(u >= 0 && v >= 0 && u + v <= 1)) return false;
        if (!(found >= (ignores_t_min ? -INFINITY : ray.t_min) && found <= t_max)) return false;
        if (drops && id % 7 == 3) return false;
        if (leaks && std::min({u, v, 1 - u - v}) < 1e-6f) return false;
        t = is_coarse ? std::clamp(std::nextafter(found, 0.0f), ray.t_min, ray.t_max) : found;
        return true;
    }

    bool trace(const rtbench_ray &ray, bool any, rtbench_hit &hit) const {
        hit = {ray.t_max, RTBENCH_MISS};
        float inverse[3]; // of a direction without zeros: no box then has NaN
        for (int k = 0; k < 3; k++)
            inverse[k] = 1 / (std::fabs(ray.direction[k]) < 1e-30f ? 1e-30f : ray.direction[k]);
        auto centre = [&](uint32_t n) { // twice its way along the ray
            float sum = 0;
            for (int k = 0; k < 3; k++) sum += (nodes[n].low[k] + nodes[n].high[k]) * ray.direction[k];
            return sum;
        };
        uint32_t stack[128], top = 0;
        stack[top++] = 0;
        while (top > 0) {
            const Node &node = nodes[stack[--top]];
            float enter = ignores_t_min ? -INFINITY : ray.t_min, leave = hit.t;
            for (int k = 0; k < 3; k++) {
                float a = (node.low[k] - ray.origin[k]) * inverse[k], b = (node.high[k] - ray.origin[k]) * inverse[k];
                enter = std::max(enter, std::min(a, b));
                leave = std::min(leave, std::max(a, b));
            }
            if (enter > leave * (leave > 0 ? 1.00001f : 0.99999f)) continue;
            for (uint32_t i = node.first; i < node.first + node.count; i++) {
                uint32_t id = ids[i];
                if (any && scene->transmissive && scene->transmissive[id]) continue;
                float t;
                if (test(ray, id, hit.t, t)) hit = {t, id};
            }
            if (any && hit.id != RTBENCH_MISS) return true;
            if (node.count == 0) { // the nearer child next
                uint32_t nearer = node.first + (centre(node.first) > centre(node.first + 1));
                stack[top++] = 2 * node.first + 1 - nearer;
                stack[top++] = nearer;
            }
        }
        return hit.id != RTBENCH_MISS;
    }
};

int build(const rtbench_scene *scene, void **built, char *message, size_t size) {
    if (scene->triangles > 100000000) return std::snprintf(message, size, "too many triangles"), 1;
    auto *bvh = new Bvh{scene, std::vector<Node>(1), std::vector<uint32_t>(scene->triangles),
                        uint32_t(std::atoi(scene->settings[0])), scene->settings[1]};
    std::iota(bvh->ids.begin(), bvh->ids.end(), 0u);
    bvh->split(0, 0, uint32_t(scene->triangles));
    if (bvh->fault == "memory") bvh->hoard.assign(size_t(1) << 30, 1);
    *built = bvh;
    return 0;
}

void closest(void *built, const rtbench_ray *rays, rtbench_hit *hits, size_t count) {
    const Bvh &bvh = *static_cast<Bvh *>(built);
    for (volatile bool hangs = bvh.fault == "hang"; hangs;) {}
    if (bvh.fault == "crash") std::raise(SIGSEGV);
    if (bvh.fault == "wild-write") const_cast<rtbench_ray *>(rays)->t_max = 0;
    if (bvh.fault == "exit") std::exit(0);
    std::thread spins;
    if (bvh.fault == "spin") spins = std::thread([] { for (volatile int i = 0; i < 10000000; i = i + 1) {} });
    for (size_t i = 0; i < count; i++) {
        bvh.trace(rays[i], false, hits[i]);
        if (bvh.fault == "id" && hits[i].id != RTBENCH_MISS) hits[i].id = (hits[i].id + 1) % uint32_t(bvh.ids.size());
    }
    if (spins.joinable()) spins.join();
}

void occluded(void *built, const rtbench_ray *rays, uint8_t *blocked, size_t count) {
    const Bvh &bvh = *static_cast<Bvh *>(built);
    for (size_t i = 0; i < count; i++) {
        rtbench_hit hit;
        blocked[i] = bvh.trace(rays[i], true, hit) != (bvh.fault == "occlusion" && i % 5 == 0);
    }
}

void stats(void *built, rtbench_stats *stats) {
    const Bvh &bvh = *static_cast<Bvh *>(built);
    stats->bytes = sizeof(Bvh) + bvh.nodes.size() * sizeof(Node) + bvh.ids.size() * 4;
    stats->inner_nodes = bvh.nodes.size() / 2;
    stats->leaves = bvh.nodes.size() / 2 + 1;
    stats->references = bvh.ids.size();
}

void destroy(void *built) { delete static_cast<Bvh *>(built); }

const rtbench_setting settings[] = {
    {"leaf", "most triangles of a leaf", "4", RTBENCH_INTEGER, 1, 64, nullptr},
    {"fault", "a planted mistake, for tests", "none", RTBENCH_CHOICE, 0, 0,
     "none drop id t-min occlusion last-bits edges hang crash wild-write exit memory spin"},
};

const rtbench_plugin plugin = {
    RTBENCH_ABI_VERSION, sizeof(rtbench_plugin), "minimal-cpp", "1.0", "a naive BVH in C++",
    RTBENCH_TRIANGLES_F32 | RTBENCH_OCCLUSION, RTBENCH_ONE_RAY, RTBENCH_OWN_TEST,
    sizeof settings / sizeof *settings, settings,
    build, closest, occluded, stats, nullptr, destroy,
};

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
