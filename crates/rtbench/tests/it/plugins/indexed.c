/* For tests: a plugin that asks for vertices and indices, or with NOT_ASKED does not, and refuses to build where they
 * are not what rtbench.h promises. It tests every triangle with rtbench's own test. */
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

static int build(const rtbench_scene *scene, void **built, char *message, size_t size)
{
    *built = (void *)scene;
    if (!RTBENCH_HAS_INDICES(scene)) return ASKED ? refuse(message, size, "there are no indices") : 0;
    if (!ASKED) return refuse(message, size, "there are indices that nobody asked for");
    for (uint64_t corner = 0; corner < 3 * scene->triangles; corner++) {
        uint32_t vertex = scene->indices[corner];
        if (vertex >= scene->vertex_count) return refuse(message, size, "an index is too large");
        if (memcmp(scene->vertices + 3 * (size_t)vertex, scene->positions + 3 * corner, 12))
            return refuse(message, size, "an index is of another vertex");
    }
    for (uint64_t a = 0; a < scene->vertex_count; a++)
        for (uint64_t b = 0; b < a; b++)
            if (!memcmp(scene->vertices + 3 * a, scene->vertices + 3 * b, 12))
                return refuse(message, size, "a vertex is there twice");
    return 0;
}

static void closest(void *built, const rtbench_ray *rays, rtbench_hit *hits, size_t count)
{
    const rtbench_scene *scene = built;
    for (size_t i = 0; i < count; i++) {
        rtbench_prepared ray;
        rtbench_hit hit = {rays[i].t_max, RTBENCH_MISS};
        scene->prepare(scene->host, &rays[i], &ray);
        for (uint32_t id = 0; id < scene->triangles; id++) {
            float t;
            if (scene->intersect(scene->host, &ray, id, hit.t, &t) && (t < hit.t || id < hit.id))
                hit.t = t, hit.id = id;
        }
        hits[i] = hit;
    }
}

static void destroy(void *built) { (void)built; }

static const rtbench_plugin plugin = {
    .abi_version = RTBENCH_ABI_VERSION,
    .size = sizeof(rtbench_plugin),
    .name = "indexed",
    .version = "1.0",
    .summary = "every triangle, by indices",
    .answers = RTBENCH_TRIANGLES_F32 | ASKED,
    .query = RTBENCH_ONE_RAY,
    .test = RTBENCH_HOST_TEST,
    .build = build,
    .closest = closest,
    .destroy = destroy,
};

const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
