// What the peers in C++ share: rtbench.h over a class of a library. Such a class has
//
//   Peer(const float *positions, size_t triangles, const rtbench_scene &scene)  builds, nine floats a triangle;
//                                                         whatever it throws is the reason why it is not built
//   bool intersect(const rtbench_ray &ray, rtbench_hit &hit) const              the closest hit, if there is one
//   bool occluded(const rtbench_ray &ray) const                                 but for Shadows::NONE
//   void stats(rtbench_stats &stats) const                                      adds nodes and references
//   static constexpr peer::Shadows shadows                                      its query for shadow rays
#pragma once

#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "rtbench.h"

// The library's version: of its header, and the commit if the Makefile knows it.
#ifdef COMMIT
#define PEER_VERSION(version) version " (" COMMIT ")"
#else
#define PEER_VERSION(version) version
#endif

namespace peer {

// What a library does with shadow rays.
enum class Shadows {
    NONE,     // it has no query for them
    FILTERED, // its query passes by triangles that let light pass
    ALL,      // its query stops at every triangle: where some let light pass, it is asked of a second structure,
              // over the others alone, which is built and counted with the first
};

// Bytes that this process has allocated. 0 where the allocator does not say.
inline size_t allocated() {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
    struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
#else
    return 0;
#endif
}

inline bool is_on(const rtbench_scene &scene, size_t setting) { return scene.settings[setting] == std::string("yes"); }

template <class Peer> struct Built {
    std::unique_ptr<Peer> all, opaque; // the second only where some triangles let shadow rays pass
    size_t bytes = 0;

    explicit Built(const rtbench_scene &scene) {
        size_t before = allocated();
        all = std::make_unique<Peer>(scene.positions, scene.triangles, scene);
        std::vector<float> others;
        bool are_some = false;
        for (size_t id = 0; Peer::shadows == Shadows::ALL && scene.transmissive && id < scene.triangles; id++)
            are_some |= scene.transmissive[id] != 0;
        for (size_t id = 0; are_some && id < scene.triangles; id++)
            if (!scene.transmissive[id])
                others.insert(others.end(), scene.positions + 9 * id, scene.positions + 9 * id + 9);
        // without a single one nothing is there to build over
        if (are_some && others.empty()) others.assign(9, 0.0f);
        if (are_some) opaque = std::make_unique<Peer>(others.data(), others.size() / 9, scene);
        size_t after = allocated();
        bytes = after > before ? after - before : 0;
        kept.swap(others);
    }

  private:
    std::vector<float> kept; // libraries may go on reading them
};

template <class Peer> int build(const rtbench_scene *scene, void **built, char *message, size_t size) {
    try {
        *built = new Built<Peer>(*scene);
        return 0;
    } catch (const std::exception &error) {
        std::snprintf(message, size, "%s", error.what());
        return 1;
    }
}

template <class Peer> void closest(void *built, const rtbench_ray *rays, rtbench_hit *hits, size_t count) {
    const Peer &all = *static_cast<Built<Peer> *>(built)->all;
    for (size_t i = 0; i < count; i++)
        if (!all.intersect(rays[i], hits[i])) hits[i] = {rays[i].t_max, RTBENCH_MISS};
}

template <class Peer> void occluded(void *pointer, const rtbench_ray *rays, uint8_t *blocked, size_t count) {
    const auto &built = *static_cast<Built<Peer> *>(pointer);
    const Peer &asked = built.opaque ? *built.opaque : *built.all;
    for (size_t i = 0; i < count; i++) blocked[i] = asked.occluded(rays[i]);
}

template <class Peer> void stats(void *pointer, rtbench_stats *stats) {
    const auto &built = *static_cast<Built<Peer> *>(pointer);
    stats->bytes = built.bytes;
    built.all->stats(*stats);
    if (built.opaque) built.opaque->stats(*stats);
}

template <class Peer> void destroy(void *built) { delete static_cast<Built<Peer> *>(built); }

// What a library's plugin is: its own triangle test, one ray after another.
template <class Peer, size_t N>
rtbench_plugin plugin(const char *name, const char *version, const char *summary, const rtbench_setting (&settings)[N]) {
    rtbench_plugin plugin = {};
    plugin.abi_version = RTBENCH_ABI_VERSION, plugin.size = sizeof plugin;
    plugin.name = name, plugin.version = version, plugin.summary = summary;
    plugin.answers = RTBENCH_TRIANGLES_F32, plugin.query = RTBENCH_ONE_RAY, plugin.test = RTBENCH_OWN_TEST;
    plugin.settings_count = N, plugin.settings = settings;
    plugin.build = build<Peer>, plugin.closest = closest<Peer>, plugin.stats = stats<Peer>, plugin.destroy = destroy<Peer>;
    if constexpr (Peer::shadows != Shadows::NONE) plugin.answers |= RTBENCH_OCCLUSION, plugin.occluded = occluded<Peer>;
    return plugin;
}

} // namespace peer
