// madmann91/bvh, version 2, as a plugin of rtbench: its default builder, its triangles prepared and in the
// order of the leaves, as its benchmark has them.
#include <cstdlib>

#include <bvh/v2/bvh.h>
#include <bvh/v2/default_builder.h>
#include <bvh/v2/node.h>
#include <bvh/v2/ray.h>
#include <bvh/v2/stack.h>
#include <bvh/v2/thread_pool.h>
#include <bvh/v2/tri.h>
#include <bvh/v2/vec.h>

#include "peer.h"

namespace {

using Vec = bvh::v2::Vec<float, 3>;
using Tri = bvh::v2::Tri<float, 3>;
using Node = bvh::v2::Node<float, 3>;
using Bvh = bvh::v2::Bvh<Node>;
using Ray = bvh::v2::Ray<float, 3>;
using Builder = bvh::v2::DefaultBuilder<Node>;

class Peer {
    Bvh bvh;
    std::vector<bvh::v2::PrecomputedTri<float>> triangles;
    const uint8_t *passes; // may be NULL
    bool robust;

  public:
    static constexpr peer::Shadows shadows = peer::Shadows::FILTERED;

    Peer(const float *positions, size_t count, const rtbench_scene &scene)
        : passes(scene.transmissive), robust(peer::is_on(scene, 1)) {
        std::vector<Tri> given;
        std::vector<bvh::v2::BBox<float, 3>> boxes;
        std::vector<Vec> centers;
        for (const float *p = positions; p < positions + 9 * count; p += 9) {
            given.emplace_back(Vec(p[0], p[1], p[2]), Vec(p[3], p[4], p[5]), Vec(p[6], p[7], p[8]));
            boxes.push_back(given.back().get_bbox());
            centers.push_back(given.back().get_center());
        }
        Builder::Config config;
        std::string quality = scene.settings[0];
        config.quality = quality == "low"      ? Builder::Quality::Low
                         : quality == "medium" ? Builder::Quality::Medium
                                               : Builder::Quality::High;
        if (scene.threads > 1) {
            bvh::v2::ThreadPool pool(scene.threads);
            bvh = Builder::build(pool, boxes, centers, config);
        } else bvh = Builder::build(boxes, centers, config);
        for (size_t id : bvh.prim_ids) triangles.emplace_back(given[id]);
    }

    template <bool any, bool is_robust> size_t trace(Ray &ray) const {
        constexpr size_t none = ~size_t(0);
        size_t found = none;
        bvh::v2::SmallStack<Bvh::Index, 256> stack;
        bvh.intersect<any, is_robust>(ray, bvh.get_root().index, stack, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; i++) {
                if (any && passes && passes[bvh.prim_ids[i]]) continue;
                if (auto hit = triangles[i].intersect(ray)) ray.tmax = std::get<0>(*hit), found = i;
            }
            return found != none;
        });
        return found;
    }

    static Ray asked(const rtbench_ray &ray) {
        auto vec = [](const float *v) { return Vec(v[0], v[1], v[2]); };
        return Ray(vec(ray.origin), vec(ray.direction), ray.t_min, ray.t_max);
    }

    bool intersect(const rtbench_ray &ray, rtbench_hit &hit) const {
        Ray own = asked(ray);
        size_t found = robust ? trace<false, true>(own) : trace<false, false>(own);
        if (found >= triangles.size()) return false;
        hit = {own.tmax, uint32_t(bvh.prim_ids[found])};
        return true;
    }

    bool occluded(const rtbench_ray &ray) const {
        Ray own = asked(ray);
        return (robust ? trace<true, true>(own) : trace<true, false>(own)) < triangles.size();
    }

    void stats(rtbench_stats &stats) const {
        stats.inner_nodes += bvh.nodes.size() / 2, stats.leaves += bvh.nodes.size() / 2 + 1;
        stats.references += bvh.prim_ids.size();
    }
};

const rtbench_setting settings[] = {
    {"quality", "of its default builder; high optimizes by reinsertion", "high", RTBENCH_CHOICE, 0, 0, "low medium high"},
    {"robust", "its robust traversal", "no", RTBENCH_CHOICE, 0, 0, "no yes"},
};

const rtbench_plugin plugin = peer::plugin<Peer>("bvh-v2", PEER_VERSION("2.0"), "madmann91/bvh over rtbench.h", settings);

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
