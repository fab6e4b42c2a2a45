// nanort as a plugin of rtbench: its BVH, and its watertight triangle test. It has no query for shadow rays;
// rtbench asks it for closest hits.
#include <numeric>
#include <stdexcept>

#include "nanort.h"
#include "peer.h"

namespace {

constexpr size_t STRIDE = 3 * sizeof(float);

class Peer {
    const float *positions;
    std::vector<unsigned> faces;
    nanort::BVHAccel<float> bvh;

  public:
    static constexpr peer::Shadows shadows = peer::Shadows::NONE;

    Peer(const float *positions, size_t count, const rtbench_scene &scene) : positions(positions), faces(3 * count) {
        if (count > 0x7fffffff / 3) throw std::runtime_error("too many triangles for its indices");
        std::iota(faces.begin(), faces.end(), 0u);
        nanort::BVHBuildOptions<float> options;
        options.min_leaf_primitives = unsigned(std::atoi(scene.settings[0]));
        options.bin_size = unsigned(std::atoi(scene.settings[1]));
        options.cache_bbox = peer::is_on(scene, 2);
        nanort::TriangleMesh<float> mesh(positions, faces.data(), STRIDE);
        nanort::TriangleSAHPred<float> order(positions, faces.data(), STRIDE);
        if (!bvh.Build(unsigned(count), mesh, order, options)) throw std::runtime_error("BVHAccel::Build fails");
    }

    bool intersect(const rtbench_ray &ray, rtbench_hit &hit) const {
        nanort::Ray<float> own;
        for (int k = 0; k < 3; k++) own.org[k] = ray.origin[k], own.dir[k] = ray.direction[k];
        own.min_t = ray.t_min, own.max_t = ray.t_max;
        nanort::TriangleIntersector<> intersector(positions, faces.data(), STRIDE);
        nanort::TriangleIntersection<> found;
        if (!bvh.Traverse(own, intersector, &found)) return false;
        hit = {found.t, found.prim_id};
        return true;
    }

    void stats(rtbench_stats &stats) const {
        nanort::BVHBuildStatistics own = bvh.GetStatistics();
        stats.inner_nodes += own.num_branch_nodes, stats.leaves += own.num_leaf_nodes;
        stats.references += bvh.GetIndices().size();
    }
};

const rtbench_setting settings[] = {
    {"leaf", "triangles from which on a node is split", "4", RTBENCH_INTEGER, 1, 64, nullptr},
    {"bins", "of the SAH", "64", RTBENCH_INTEGER, 2, 1024, nullptr},
    {"cache-boxes", "boxes of triangles kept while it builds", "no", RTBENCH_CHOICE, 0, 0, "no yes"},
};

const rtbench_plugin plugin = peer::plugin<Peer>("nanort", PEER_VERSION("unversioned"), "nanort over rtbench.h", settings);

} // namespace

extern "C" RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
