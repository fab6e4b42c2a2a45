/* rtbench.h: the interface between rtbench and a ray-tracing structure of yours. C99 or C++.
 *
 * A plugin is a shared library with one function, rtbench_plugin_describe. `rtbench run SCENE --plugin
 * FILE.so` loads it and measures it beside the structures of rtbench. docs/bring-your-own.md shows how.
 *
 * Strings are UTF-8, end with a zero, and live as long as the library. Nothing may throw through this
 * interface: that ends the process. All lengths and ids are zero-based counts; all coordinates are world units,
 * of a scene far from the origin relative to a point that rtbench has moved it by (docs/scenes.md).
 *
 * License: MIT OR Apache-2.0, as rtbench. Copy this file into your own tree.
 */
#ifndef RTBENCH_H
#define RTBENCH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What this header describes. A later version that only appends fields keeps the number; `size` says
 * how many bytes of a struct there are. */
#define RTBENCH_ABI_VERSION 1u

/* The id of "no triangle". */
#define RTBENCH_MISS 0xffffffffu

/* What a plugin answers: bits of rtbench_plugin.answers. */
#define RTBENCH_TRIANGLES_F32 1u /* closest hits with triangles in f32; every plugin has this */
#define RTBENCH_OCCLUSION 2u     /* has a query of its own for shadow rays; else they ask for closest hits */
#define RTBENCH_TRIANGLES_F64 4u /* the same in double, by the functions *_f64 of rtbench_plugin */
#define RTBENCH_MIXED 8u         /* reserved: other primitives */
#define RTBENCH_REFIT 16u        /* reserved: vertices that move */
#define RTBENCH_INDICES 32u      /* asks for rtbench_scene.vertices and .indices, which else are NULL */
#define RTBENCH_DEVICE 64u       /* computes on a device: its calls are timed by time of day, and have whole batches with any -j */

/* How a plugin answers many rays in one call: rtbench_plugin.query. */
#define RTBENCH_ONE_RAY 0u /* each is traced to its end before the next one begins */
#define RTBENCH_BATCH 1u   /* several are in flight, or are sorted */

/* Whose triangle test decides: rtbench_plugin.test. */
#define RTBENCH_OWN_TEST 0u  /* the plugin's: answers are compared up to rounding, and differences at edges counted */
#define RTBENCH_HOST_TEST 1u /* rtbench_scene.intersect, and of equal t the lowest id: all bits must agree */

/* Kinds of settings. */
#define RTBENCH_INTEGER 0u
#define RTBENCH_REAL 1u
#define RTBENCH_CHOICE 2u

/* A ray: a hit counts when t_min <= t <= t_max, from both sides of a triangle. The direction need not be
 * of unit length; t is in multiples of it. t_max may be infinite. rtbench asks
 * only what is a ray, as it does of its own structures: direction finite and not zero, interval not empty, the
 * origin at most 8 times as far from the world's as the scene (what begins farther is brought near first). */
typedef struct rtbench_ray {
    float origin[3];
    float t_min;
    float direction[3];
    float t_max;
} rtbench_ray;

/* The closest hit of a ray. `t` is not read where `id` is RTBENCH_MISS. */
typedef struct rtbench_hit {
    float t;
    uint32_t id;
} rtbench_hit;

/* A setting that users can change: -s NAME:setting=value. */
typedef struct rtbench_setting {
    const char *name;    /* a-z, 0-9 and hyphens */
    const char *summary; /* one line */
    const char *initial; /* the default, as a user would type it */
    uint32_t kind;       /* RTBENCH_INTEGER, RTBENCH_REAL or RTBENCH_CHOICE */
    double min, max;     /* closed range of a number */
    const char *words;   /* of a choice: its words with blanks between, else NULL */
} rtbench_setting;

/* A ray made ready for rtbench_scene.intersect. */
typedef struct rtbench_prepared {
    uint64_t words[16];
} rtbench_prepared;

/* What a structure is built over. All of it stays valid until `destroy`. */
typedef struct rtbench_scene {
    uint32_t size;               /* sizeof(rtbench_scene) */
    uint32_t threads;            /* how many threads the build may use; as many will trace */
    uint64_t triangles;          /* how many; at least 1, less than RTBENCH_MISS */
    const float *positions;      /* nine coordinates for each: x y z of its three corners */
    const uint8_t *transmissive; /* a byte for each: not 0 where shadow rays pass; NULL: none lets them pass */
    const char *const *settings; /* the value of each setting as text, in the order described */
    const void *host;            /* for the two functions below */
    /* rtbench's watertight triangle test: prepares a ray once, then tests it with triangles. `intersect`
     * returns 1 and writes t where t_min <= t <= t_max, else 0. Any thread may call them. */
    void (*prepare)(const void *host, const rtbench_ray *ray, rtbench_prepared *prepared);
    int (*intersect)(const void *host, const rtbench_prepared *prepared, uint32_t id, float t_max, float *t);
    /* The same triangles with each vertex once, for a plugin with RTBENCH_INDICES; found outside of the time
     * of the build. An rtbench from before these fields has a smaller scene: see RTBENCH_HAS_INDICES. */
    uint64_t vertex_count;
    const float *vertices;   /* three coordinates for each */
    const uint32_t *indices; /* three vertices for each triangle */
} rtbench_scene;

/* Whether a scene has vertices and indices. */
#define RTBENCH_HAS_INDICES(scene) \
    ((scene)->size >= offsetof(rtbench_scene, indices) + sizeof(const uint32_t *) && (scene)->indices)

/* The four structs above in double, for a plugin with RTBENCH_TRIANGLES_F64: field by field the same. */
typedef struct rtbench_ray_f64 {
    double origin[3];
    double t_min;
    double direction[3];
    double t_max;
} rtbench_ray_f64;

typedef struct rtbench_hit_f64 {
    double t;
    uint32_t id;
    uint32_t unused; /* not read */
} rtbench_hit_f64;

typedef struct rtbench_prepared_f64 {
    uint64_t words[32];
} rtbench_prepared_f64;

typedef struct rtbench_scene_f64 {
    uint32_t size; /* sizeof(rtbench_scene_f64) */
    uint32_t threads;
    uint64_t triangles;
    const double *positions;
    const uint8_t *transmissive;
    const char *const *settings;
    const void *host;
    void (*prepare)(const void *host, const rtbench_ray_f64 *ray, rtbench_prepared_f64 *prepared);
    int (*intersect)(const void *host, const rtbench_prepared_f64 *prepared, uint32_t id, double t_max, double *t);
    uint64_t vertex_count; /* as in rtbench_scene, with RTBENCH_INDICES; else 0 and NULL */
    const double *vertices;
    const uint32_t *indices;
} rtbench_scene_f64;

/* What was built. Set what you know; all is zero before. */
typedef struct rtbench_stats {
    uint32_t size;                /* set by rtbench: sizeof(rtbench_stats) */
    uint32_t has_counters;        /* not 0 if the last two fields are counted: the same at every call */
    uint64_t bytes;               /* of the structure, without rtbench's copy of the triangles */
    uint64_t inner_nodes;         /* N_IN */
    uint64_t leaves;              /* N_V: leaves, cells */
    uint64_t empty_leaves;        /* N_EV */
    uint64_t references;          /* N_OIV: triangle references in leaves */
    uint64_t intersection_tests;  /* N_IT: over all rays since the build, while counting */
    uint64_t traversal_steps;     /* N_TS: nodes visited, likewise */
    char note[256];               /* one line for the notes of the row, asked for after its answers were checked; an
                                   * rtbench from before it has a smaller struct: see `size` */
} rtbench_stats;

/* What a plugin is. */
typedef struct rtbench_plugin {
    uint32_t abi_version; /* RTBENCH_ABI_VERSION */
    uint32_t size;        /* sizeof(rtbench_plugin) */
    const char *name;     /* of its row: a-z, 0-9 and hyphens, none of rtbench's own structures */
    const char *version;
    const char *summary;  /* one line */
    uint32_t answers;     /* RTBENCH_TRIANGLES_F32, ... */
    uint32_t query;       /* RTBENCH_ONE_RAY or RTBENCH_BATCH */
    uint32_t test;        /* RTBENCH_OWN_TEST or RTBENCH_HOST_TEST */
    uint32_t settings_count;
    const rtbench_setting *settings;

    /* Builds a structure and writes it to `*built`; returns 0. Anything else refuses, with the reason in
     * `message` (its size includes the final zero). The call is timed. */
    int (*build)(const rtbench_scene *scene, void **built, char *message, size_t message_size);

    /* Writes the closest hit of each ray. The call is timed. Several threads may call at once. */
    void (*closest)(void *built, const rtbench_ray *rays, rtbench_hit *hits, size_t count);

    /* Writes 1 for each ray that a triangle blocks which is not transmissive, else 0. NULL without
     * RTBENCH_OCCLUSION. Timed; several threads may call at once. */
    void (*occluded)(void *built, const rtbench_ray *rays, uint8_t *blocked, size_t count);

    /* Says what was built. Not timed. May be NULL. */
    void (*stats)(void *built, rtbench_stats *stats);

    /* Turns counting on (not 0) or off; it is off after the build, and while rays are timed. With -j N several
     * threads trace while it is on: counters are then atomic, or one for each thread. NULL: nothing is counted. */
    void (*count)(void *built, int on);

    /* Frees what was built. Not timed. */
    void (*destroy)(void *built);

    /* The same six for a plugin with RTBENCH_TRIANGLES_F64, which `--precision f64` asks; else NULL. What
     * `build_f64` builds is given to these alone, what `build` builds to those above. An rtbench from before
     * these fields does not read them, and a plugin from before them has a smaller rtbench_plugin. */
    int (*build_f64)(const rtbench_scene_f64 *scene, void **built, char *message, size_t message_size);
    void (*closest_f64)(void *built, const rtbench_ray_f64 *rays, rtbench_hit_f64 *hits, size_t count);
    void (*occluded_f64)(void *built, const rtbench_ray_f64 *rays, uint8_t *blocked, size_t count);
    void (*stats_f64)(void *built, rtbench_stats *stats);
    void (*count_f64)(void *built, int on);
    void (*destroy_f64)(void *built);
} rtbench_plugin;

/* The one symbol of a plugin. Export it: extern "C", default visibility. */
#if defined(_WIN32)
#define RTBENCH_EXPORT __declspec(dllexport)
#else
#define RTBENCH_EXPORT __attribute__((visibility("default")))
#endif
RTBENCH_EXPORT const rtbench_plugin *rtbench_plugin_describe(void);

#ifdef __cplusplus
}
#endif
#endif
