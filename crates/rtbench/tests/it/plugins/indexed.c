/* For tests: a plugin that asks for vertices and indices, or with NOT_ASKED does not, and refuses to build where they
 * are not what rtbench.h promises. It tests every triangle with rtbench's own test, in f32 and f64: this file includes
 * itself for each. With NO_FUNCTION it says that it has f64, and lacks a function. */
#ifndef NUMBER
#include <string.h>

#include "rtbench.h"

#ifdef NOT_ASKED
#define ASKED 0
#else
#define ASKED RTBENCH_INDICES
#endif

static int refuse(char *message, size_t size, const char *why)
{
    strncpy(message, why, size - 1);
    return 1;
}

#define NUMBER float
#define IN(name) name
#include __FILE__
#undef NUMBER
#undef IN
#define NUMBER double
#define IN(name) name##_f64
#include __FILE__

static void destroy(void *built) { (void)built; }

static const rtbench_plugin plugin = {
    .abi_version = RTBENCH_ABI_VERSION,
    .size = sizeof(rtbench_plugin),
    .name = "indexed",
    .version = "1.0",
    .summary = "every triangle, by indices",
    .answers = RTBENCH_TRIANGLES_F32 | RTBENCH_TRIANGLES_F64 | ASKED,
    .query = RTBENCH_ONE_RAY,
    .test = RTBENCH_HOST_TEST,
    .build = build,
    .closest = closest,
    .destroy = destroy,
    .build_f64 = build_f64,
#ifndef NO_FUNCTION
    .closest_f64 = closest_f64,
#endif
    .destroy_f64 = destroy,
};

const rtbench_plugin *rtbench_plugin_describe(void)
{
    (void)closest_f64;
    return &plugin;
}

#else

static int IN(build)(const IN(rtbench_scene) *scene, void **built, char *message, size_t size)
{
    *built = (void *)scene;
    if (!RTBENCH_HAS_INDICES(scene)) return ASKED ? refuse(message, size, "there are no indices") : 0;
    if (!ASKED) return refuse(message, size, "there are indices that nobody asked for");
    size_t bytes = 3 * sizeof(NUMBER);
    for (uint64_t corner = 0; corner < 3 * scene->triangles; corner++) {
        uint32_t vertex = scene->indices[corner];
        if (vertex >= scene->vertex_count) return refuse(message, size, "an index is too large");
        if (memcmp(scene->vertices + 3 * (size_t)vertex, scene->positions + 3 * corner, bytes))
            return refuse(message, size, "an index is of another vertex");
    }
    for (uint64_t a = 0; a < scene->vertex_count; a++)
        for (uint64_t b = 0; b < a; b++)
            if (!memcmp(scene->vertices + 3 * a, scene->vertices + 3 * b, bytes))
                return refuse(message, size, "a vertex is there twice");
    return 0;
}

static void IN(closest)(void *built, const IN(rtbench_ray) *rays, IN(rtbench_hit) *hits, size_t count)
{
    const IN(rtbench_scene) *scene = built;
    for (size_t i = 0; i < count; i++) {
        IN(rtbench_prepared) ray;
        IN(rtbench_hit) hit = {.t = rays[i].t_max, .id = RTBENCH_MISS};
        scene->prepare(scene->host, &rays[i], &ray);
        for (uint32_t id = 0; id < scene->triangles; id++) {
            NUMBER t;
            if (scene->intersect(scene->host, &ray, id, hit.t, &t) && (t < hit.t || id < hit.id))
                hit.t = t, hit.id = id;
        }
        hits[i] = hit;
    }
}

#endif
