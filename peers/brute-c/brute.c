/* The smallest plugin of rtbench: tests every triangle with rtbench's own test. So all bits of its answers
 * are right. It has no query for shadow rays; rtbench asks it for closest hits instead. */
#include "rtbench.h"

static int build(const rtbench_scene *scene, void **built, char *message, size_t message_size)
{
    (void)message, (void)message_size;
    *built = (void *)scene; /* it stays as long as what is built */
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
            /* of equal t the lowest id */
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
    .name = "brute-c",
    .version = "1.0",
    .summary = "every triangle, in C",
    .answers = RTBENCH_TRIANGLES_F32,
    .query = RTBENCH_ONE_RAY,
    .test = RTBENCH_HOST_TEST,
    .build = build,
    .closest = closest,
    .destroy = destroy,
};

const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
