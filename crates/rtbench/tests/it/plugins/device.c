/* For tests: a plugin that waits for a device, which takes no processor time. It tests every triangle with rtbench's
 * own test, and its note says how many rays its largest call had. With PROCESSOR it hides that there is a device. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <time.h>

#include "rtbench.h"

/* Longer than all of its calls compute. */
static const struct timespec device = {0, 50000000};

static unsigned long most;

static int build(const rtbench_scene *scene, void **built, char *message, size_t message_size)
{
    (void)message, (void)message_size;
    *built = (void *)scene;
    return 0;
}

static void closest(void *built, const rtbench_ray *rays, rtbench_hit *hits, size_t count)
{
    const rtbench_scene *scene = built;
    nanosleep(&device, NULL);
    if (count > most) most = (unsigned long)count;
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

static void stats(void *built, rtbench_stats *stats)
{
    (void)built;
    snprintf(stats->note, sizeof stats->note, "its largest call\nhad %lu rays", most);
}

static void destroy(void *built) { (void)built; }

#ifdef PROCESSOR
#define DEVICE 0
#else
#define DEVICE RTBENCH_DEVICE
#endif

static const rtbench_plugin plugin = {
    .abi_version = RTBENCH_ABI_VERSION,
    .size = sizeof(rtbench_plugin),
    .name = "device",
    .version = "1.0",
    .summary = "every triangle, while it waits",
    .answers = RTBENCH_TRIANGLES_F32 | DEVICE,
    .query = RTBENCH_BATCH,
    .test = RTBENCH_HOST_TEST,
    .build = build,
    .closest = closest,
    .stats = stats,
    .destroy = destroy,
};

const rtbench_plugin *rtbench_plugin_describe(void) { return &plugin; }
