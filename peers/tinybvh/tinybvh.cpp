// tinybvh as a plugin of rtbench: four of its layouts, its builders and its own triangle tests.
// Its rays have no smallest t: one that begins later is given an origin that lies further on.
// One source for 1.6 (one header) and for 1.9 (several headers, templates and hooks for threads).
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <variant>

#define INST_IDX_BITS 32 // else hit.prim has 22 bits for the triangle in some of 1.9
#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"
#if TINY_BVH_VERSION_MAJOR == 1 && TINY_BVH_VERSION_MINOR < 8
#define HAS_SOA // 1.8 calls BVH_SoA deprecated, 1.9 has none
#endif

#include "peer.h"

namespace {

using namespace tinybvh;

// The binary tree that each layout is made from.
BVH &base(BVH &bvh) { return bvh; }
#ifdef HAS_SOA
BVH &base(BVH_SoA &bvh) { return bvh.bvh; }
#endif
BVH &base(BVH4_CPU &bvh) { return bvh.bvh4.bvh; }
BVH &base(BVH8_CPU &bvh) { return bvh.bvh8.bvh; }

// Builds with one thread: by a switch, from 1.8 on by taking away the functions that start tasks.
template <class Layout> void one_thread(Layout &bvh) {
    base(bvh).threadedBuild = false;
    if constexpr (requires { bvh.context.spawn; })
        bvh.context.spawn = nullptr, bvh.context.barrier = nullptr, bvh.context.parallel_for = nullptr;
}

// The binned builder with SIMD: 1.8's Build() chooses it, that of 1.6 is the scalar one.
template <class Layout> void binned(Layout &bvh, const bvhvec4 *vertices, uint32_t count) {
    if constexpr (requires { bvh.settings; }) bvh.Build(vertices, count);
    else if constexpr (requires { bvh.BuildAVX(vertices, count); }) bvh.BuildAVX(vertices, count);
    else bvh.Build(vertices, count);
}

class Peer {
    std::vector<bvhvec4> vertices; // of 16 bytes, as it wants them
#ifdef HAS_SOA
    std::variant<BVH, BVH_SoA, BVH4_CPU, BVH8_CPU> layout;
#else
    std::variant<BVH, BVH4_CPU, BVH8_CPU> layout;
#endif

  public:
    static constexpr peer::Shadows shadows = peer::Shadows::ALL;

    Peer(const float *positions, size_t triangles, const rtbench_scene &scene) : vertices(3 * triangles) {
        for (size_t i = 0; i < vertices.size(); i++)
            vertices[i] = bvhvec4(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2], 0);
        std::string name = scene.settings[0], builder = scene.settings[1];
        uint32_t count = uint32_t(triangles), optimize = uint32_t(std::atoi(scene.settings[2]));
#ifdef HAS_SOA
        if (name == "soa") layout.emplace<BVH_SoA>();
#else
        if (name == "soa") throw std::runtime_error("this version has no BVH_SoA");
#endif
        if (name == "bvh4") layout.emplace<BVH4_CPU>();
        if (name == "bvh8") layout.emplace<BVH8_CPU>();
        if (builder == "hq" && optimize > 0) throw std::runtime_error("a tree with spatial splits cannot be optimized");
        std::visit([&](auto &bvh) {
            if (scene.threads == 1) one_thread(bvh);
            if (builder == "hq") bvh.BuildHQ(vertices.data(), count);
            else binned(bvh, vertices.data(), count);
            if (optimize > 0) bvh.Optimize(optimize, true);
        }, layout);
    }

    static Ray asked(const rtbench_ray &ray) {
        Ray own; // as its constructor would make it, but for the length of the direction
        float o[3];
        for (int k = 0; k < 3; k++) o[k] = ray.t_min > 0 ? ray.origin[k] + ray.t_min * ray.direction[k] : ray.origin[k];
        own.O = bvhvec3(o[0], o[1], o[2]);
        own.D = bvhvec3(ray.direction[0], ray.direction[1], ray.direction[2]);
        own.rD = tinybvh_rcp(own.D);
        own.hit.t = std::min(ray.t_max - std::max(ray.t_min, 0.0f), BVH_FAR);
        own.hit.prim = RTBENCH_MISS;
        return own;
    }

    bool intersect(const rtbench_ray &ray, rtbench_hit &hit) const {
        Ray own = asked(ray);
        std::visit([&](const auto &bvh) { bvh.Intersect(own); }, layout);
        hit = {own.hit.t + std::max(ray.t_min, 0.0f), own.hit.prim};
        return own.hit.prim != RTBENCH_MISS;
    }

    bool occluded(const rtbench_ray &ray) const {
        Ray own = asked(ray);
        return std::visit([&](const auto &bvh) { return bvh.IsOccluded(own); }, layout);
    }

    void stats(rtbench_stats &stats) {
        std::visit([&](auto &bvh) {
            stats.references += uint64_t(base(bvh).PrimCount());
            if constexpr (requires { bvh.bvh4; }) count(bvh.bvh4, 0, stats);
            else if constexpr (requires { bvh.bvh8; }) count(bvh.bvh8, 0, stats);
            else {
                uint64_t leaves = uint64_t(base(bvh).LeafCount());
                stats.leaves += leaves, stats.inner_nodes += leaves - 1;
            }
        }, layout);
    }

  private:
    template <int M> static void count(const MBVH<M> &wide, uint32_t index, rtbench_stats &stats) {
        const auto &node = wide.mbvhNode[index];
        (node.isLeaf() ? stats.leaves : stats.inner_nodes)++;
        for (uint32_t i = 0; i < M && !node.isLeaf(); i++)
            if (node.child[i]) count(wide, node.child[i], stats);
    }
};

const rtbench_setting settings[] = {
    {"layout", "BVH (32-byte nodes), BVH_SoA, BVH4_CPU or BVH8_CPU", "bvh8", RTBENCH_CHOICE, 0, 0, "bvh soa bvh4 bvh8"},
    {"build", "binned SAH, or with spatial splits (BuildHQ)", "hq", RTBENCH_CHOICE, 0, 0, "sah hq"},
    {"optimize", "passes of its optimizer, by reinsertion; not with hq", "0", RTBENCH_INTEGER, 0, 1000, nullptr},
};

#define TEXT(x) #x
#define NUMBER(x) TEXT(x)
#define VERSION NUMBER(TINY_BVH_VERSION_MAJOR) "." NUMBER(TINY_BVH_VERSION_MINOR) "." NUMBER(TINY_BVH_VERSION_SUB)
const rtbench_plugin plugin = peer::plugin<Peer>("tinybvh", PEER_VERSION(VERSION), "tinybvh over rtbench.h", settings);

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
