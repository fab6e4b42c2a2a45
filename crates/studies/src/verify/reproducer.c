/* @HEADING@
 * @WHAT@
 *
 * cc -I DIR_OF_RTBENCH_H THIS.c PLUGIN.so -lm -o case && ./case      prints each ray; exit code 1: wrong
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rtbench.h"

static const @NUMBER@ triangles[][9] = {
@TRIANGLES@
};
static const rtbench_ray@SUFFIX@ rays[] = { /* origin, t_min, direction, t_max */
@RAYS@
};
static const rtbench_hit@SUFFIX@ right[] = {
@HITS@
};
static const uint8_t right_blocked[] = {@BLOCKED@};
static const char *const changed[][2] = { /* settings that are not the default */
@SETTINGS@
    {NULL, NULL},
};

enum { TRIANGLES = sizeof triangles / sizeof *triangles, RAYS = sizeof rays / sizeof *rays };

/* Of no use to a plugin with its own triangle test; one with rtbench's needs those of rtbench. */
static void prepare(const void *host, const rtbench_ray@SUFFIX@ *ray, rtbench_prepared@SUFFIX@ *prepared) {
    (void)host, (void)ray, (void)prepared;
}
static int intersect(const void *host, const rtbench_prepared@SUFFIX@ *prepared, uint32_t id, @NUMBER@ t_max,
                     @NUMBER@ *t) {
    return (void)host, (void)prepared, (void)id, (void)t_max, (void)t, 0;
}

int main(void) {
    const rtbench_plugin *plugin = rtbench_plugin_describe();
    if (!(plugin->answers & RTBENCH_TRIANGLES_@BIT@)) return printf("not of @BIT@\n"), 2;
    const char *settings[256] = {0};
    for (uint32_t i = 0; i < plugin->settings_count && i < 256; i++) {
        settings[i] = plugin->settings[i].initial;
        for (int k = 0; changed[k][0]; k++)
            if (!strcmp(changed[k][0], plugin->settings[i].name)) settings[i] = changed[k][1];
    }
    uint32_t indices[3 * TRIANGLES];
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++) indices[i] = i;
    const rtbench_scene@SUFFIX@ scene = {sizeof scene, 1, TRIANGLES, triangles[0], NULL, settings, NULL, prepare,
                                       intersect, 3 * TRIANGLES, triangles[0], indices};
    void *built = NULL;
    char message[512] = "";
    if (plugin->build@SUFFIX@(&scene, &built, message, sizeof message)) return printf("refused: %s\n", message), 2;
    rtbench_hit@SUFFIX@ hits[RAYS];
    uint8_t blocked[RAYS];
    int wrong = 0;
    plugin->closest@SUFFIX@(built, rays, hits, RAYS);
    for (int i = 0; i < RAYS; i++) blocked[i] = hits[i].id != RTBENCH_MISS;
    if (plugin->answers & RTBENCH_OCCLUSION) plugin->occluded@SUFFIX@(built, rays, blocked, RAYS);
    for (int i = 0; i < RAYS; i++) {
        double o = 0, d = 0; /* what rounding does to t depends on where the ray begins */
        for (int k = 0; k < 3; k++) o = fmax(o, fabs(rays[i].origin[k])), d = fmax(d, fabs(rays[i].direction[k]));
        int is_hit = right[i].id != RTBENCH_MISS;
        int is_wrong = hits[i].id != right[i].id || blocked[i] != right_blocked[i] ||
                       (is_hit && !(fabs(hits[i].t - right[i].t) <= @ROUNDING@ * (fabs(right[i].t) + o / d)));
        printf("ray %d: triangle %d at %a, blocked %d; right: %d at %a, blocked %d%s\n", i, (int)hits[i].id, hits[i].t,
               blocked[i], (int)right[i].id, right[i].t, right_blocked[i], is_wrong ? "  WRONG" : "");
        wrong |= is_wrong;
    }
    plugin->destroy@SUFFIX@(built);
    return wrong;
}
