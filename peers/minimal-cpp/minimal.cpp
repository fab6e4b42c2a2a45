// A naive BVH as a plugin of rtbench: halves its triangles along the longest axis until few are left.
// Its own triangle test is that of Moeller and Trumbore. All of it is a template of the number type T: float, and
// double for --precision f64. The setting `fault` plants mistakes, for the tests of rtbench: leave it out of yours.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "rtbench.h"

namespace {

template <class T> struct In; // the structs of rtbench.h
template <> struct In<float> { using Scene = rtbench_scene; using Ray = rtbench_ray; using Hit = rtbench_hit; };
template <> struct In<double> {
    using Scene = rtbench_scene_f64; using Ray = rtbench_ray_f64; using Hit = rtbench_hit_f64;
};

template <class T> struct Vec {
    T x, y, z;
    template <class U> static Vec at(const U *p) { return {T(p[0]), T(p[1]), T(p[2])}; }
    Vec operator-(Vec b) const { return {x - b.x, y - b.y, z - b.z}; }
};
template <class T> T dot(Vec<T> a, Vec<T> b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class T> Vec<T> cross(Vec<T> a, Vec<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T> struct Node {
    T low[3], high[3];
    uint32_t first, count; // of a leaf: its ids; else count is 0, and the children are at first, first + 1
};

template <class T> struct Bvh {
    using Ray = typename In<T>::Ray;
    using Hit = typename In<T>::Hit;
    static constexpr T infinity = std::numeric_limits<T>::infinity();
    static constexpr T rounding = 100 * std::numeric_limits<T>::epsilon();

    const typename In<T>::Scene *scene;
    std::vector<Node<T>> nodes;
    std::vector<uint32_t> ids;
    uint32_t leaf;
    std::string fault;
    std::vector<char> hoard = {};
    bool ignores_t_min = fault == "t-min", drops = fault == "drop", leaks = fault == "edges";
    bool is_coarse = fault == "last-bits", is_single = fault == "single";

    const T *corners(uint32_t id) const { return scene->positions + 9 * size_t(id); }

    void split(uint32_t index, uint32_t first, uint32_t count) {
        Node<T> node = {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, first, count};
        for (uint32_t i = first; i < first + count; i++)
            for (int k = 0; k < 9; k++) {
                T x = corners(ids[i])[k], pad = rounding * std::fabs(x) + T(1e-30); // rounding loses no hit
                node.low[k % 3] = std::min(node.low[k % 3], x - pad);
                node.high[k % 3] = std::max(node.high[k % 3], x + pad);
            }
        if (count > leaf) {
            int axis = 0;
            for (int k = 1; k < 3; k++)
                if (node.high[k] - node.low[k] > node.high[axis] - node.low[axis]) axis = k;
            auto centre = [&](uint32_t id) { const T *p = corners(id) + axis; return p[0] + p[3] + p[6]; };
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

    // In U: T, or float where that is planted.
    template <class U> bool test(const Ray &ray, uint32_t id, T t_max, T &t) const {
        const T *p = corners(id);
        auto at = [](const T *p) { return Vec<U>::at(p); };
        Vec<U> a = at(p), e1 = at(p + 3) - a, e2 = at(p + 6) - a, d = at(ray.direction);
        Vec<U> h = cross(d, e2);
        U det = dot(e1, h);
        if (det == 0) return false;
        Vec<U> s = at(ray.origin) - a, q = cross(s, e1);
        U u = dot(s, h) / det, v = dot(d, q) / det, found = dot(e2, q) / det;
        if (!(u >= 0 && v >= 0 && u + v <= 1)) return false;
        if (!(found >= (ignores_t_min ? -infinity : ray.t_min) && found <= t_max)) return false;
        if (drops && id % 7 == 3) return false;
        if (leaks && std::min({u, v, 1 - u - v}) < 8 * std::numeric_limits<U>::epsilon()) return false;
        t = is_coarse ? std::clamp(std::nextafter(T(found), T(0)), ray.t_min, ray.t_max) : found;
        return true;
    }

    bool trace(const Ray &ray, bool any, Hit &hit) const {
        hit.t = ray.t_max, hit.id = RTBENCH_MISS;
        T inverse[3]; // of a direction without zeros: no box then has NaN
        for (int k = 0; k < 3; k++)
            inverse[k] = 1 / (std::fabs(ray.direction[k]) < T(1e-30) ? T(1e-30) : ray.direction[k]);
        auto centre = [&](uint32_t n) { // twice its way along the ray
            T sum = 0;
            for (int k = 0; k < 3; k++) sum += (nodes[n].low[k] + nodes[n].high[k]) * ray.direction[k];
            return sum;
        };
        uint32_t stack[128], top = 0;
        stack[top++] = 0;
        while (top > 0) {
            const Node<T> &node = nodes[stack[--top]];
            T enter = ignores_t_min ? -infinity : ray.t_min, leave = hit.t;
            for (int k = 0; k < 3; k++) {
                T a = (node.low[k] - ray.origin[k]) * inverse[k], b = (node.high[k] - ray.origin[k]) * inverse[k];
                enter = std::max(enter, std::min(a, b));
                leave = std::min(leave, std::max(a, b));
            }
            if (enter > leave * (leave > 0 ? 1 + rounding : 1 - rounding)) continue;
            for (uint32_t i = node.first; i < node.first + node.count; i++) {
                uint32_t id = ids[i];
                if (any && scene->transmissive && scene->transmissive[id]) continue;
                T t;
                if (is_single ? test<float>(ray, id, hit.t, t) : test<T>(ray, id, hit.t, t)) hit.t = t, hit.id = id;
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

template <class T> int build(const typename In<T>::Scene *scene, void **built, char *message, size_t size) {
    if (scene->triangles > 100000000) return std::snprintf(message, size, "too many triangles"), 1;
    auto *bvh = new Bvh<T>{scene, std::vector<Node<T>>(1), std::vector<uint32_t>(scene->triangles),
                           uint32_t(std::atoi(scene->settings[0])), scene->settings[1]};
    std::iota(bvh->ids.begin(), bvh->ids.end(), 0u);
    bvh->split(0, 0, uint32_t(scene->triangles));
    if (bvh->fault == "memory") bvh->hoard.assign(size_t(1) << 30, 1);
    *built = bvh;
    return 0;
}

template <class T>
void closest(void *built, const typename In<T>::Ray *rays, typename In<T>::Hit *hits, size_t count) {
    const auto &bvh = *static_cast<Bvh<T> *>(built);
    for (volatile bool hangs = bvh.fault == "hang"; hangs;) {}
    if (bvh.fault == "crash") std::raise(SIGSEGV);
    if (bvh.fault == "wild-write") const_cast<typename In<T>::Ray *>(rays)->t_max = 0;
    if (bvh.fault == "exit") std::exit(0);
    std::thread spins;
    if (bvh.fault == "spin") spins = std::thread([] { for (volatile int i = 0; i < 10000000; i = i + 1) {} });
    for (size_t i = 0; i < count; i++) {
        bvh.trace(rays[i], false, hits[i]);
        if (bvh.fault == "id" && hits[i].id != RTBENCH_MISS) hits[i].id = (hits[i].id + 1) % uint32_t(bvh.ids.size());
    }
    if (spins.joinable()) spins.join();
}

template <class T> void occluded(void *built, const typename In<T>::Ray *rays, uint8_t *blocked, size_t count) {
    const auto &bvh = *static_cast<Bvh<T> *>(built);
    for (size_t i = 0; i < count; i++) {
        typename In<T>::Hit hit;
        blocked[i] = bvh.trace(rays[i], true, hit) != (bvh.fault == "occlusion" && i % 5 == 0);
    }
}

template <class T> void stats(void *built, rtbench_stats *stats) {
    const auto &bvh = *static_cast<Bvh<T> *>(built);
    stats->bytes = sizeof bvh + bvh.nodes.size() * sizeof(Node<T>) + bvh.ids.size() * 4;
    stats->inner_nodes = bvh.nodes.size() / 2;
    stats->leaves = bvh.nodes.size() / 2 + 1;
    stats->references = bvh.ids.size();
}

template <class T> void destroy(void *built) { delete static_cast<Bvh<T> *>(built); }

const rtbench_setting settings[] = {
    {"leaf", "most triangles of a leaf", "4", RTBENCH_INTEGER, 1, 64, nullptr},
    {"fault", "a planted mistake, for tests", "none", RTBENCH_CHOICE, 0, 0,
     "none drop id t-min occlusion last-bits edges single hang crash wild-write exit memory spin"},
};

const rtbench_plugin plugin = {
    RTBENCH_ABI_VERSION, sizeof(rtbench_plugin), "minimal-cpp", "1.0", "a naive BVH in C++",
    RTBENCH_TRIANGLES_F32 | RTBENCH_TRIANGLES_F64 | RTBENCH_OCCLUSION, RTBENCH_ONE_RAY, RTBENCH_OWN_TEST,
    sizeof settings / sizeof *settings, settings,
    build<float>, closest<float>, occluded<float>, stats<float>, nullptr, destroy<float>,
    build<double>, closest<double>, occluded<double>, stats<double>, nullptr, destroy<double>,
};

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
