/* support/detect_scene.h - small moving surfaces for tulle_detector, and all that truly happens to
 * them, by brute force with rational arithmetic. Nothing of it is shared with the detector but the
 * public header. */
#ifndef TULLE_TEST_DETECT_SCENE_H
#define TULLE_TEST_DETECT_SCENE_H

#include "tulle/detect.h"

#include <stdbool.h>

enum {
    DETECT_MAX_TRIANGLES = 2000,
    DETECT_MAX_VERTICES = 3 * DETECT_MAX_TRIANGLES,
    DETECT_MAX_SURFACES = 5,
    DETECT_MAX_TRUTHS = 200000
};

typedef struct detect_scene {
    uint32_t triangles[3 * DETECT_MAX_TRIANGLES];
    double start[3 * DETECT_MAX_VERTICES], end[3 * DETECT_MAX_VERTICES];
    size_t triangle_count, vertex_count;
    tulle_detect_surface surfaces[DETECT_MAX_SURFACES];
    size_t surface_count; /* all of them are in `surfaces`, also a single one */
    unsigned char collides[DETECT_MAX_SURFACES * DETECT_MAX_SURFACES];
    bool has_collides;
    double minimum_separation;
    /* pairs are looked at all through the step, and not at five times alone; for separation 0 they
     * always are */
    bool is_thorough;
} detect_scene;

typedef enum detect_family {
    DETECT_FREE,     /* loose triangles that move a little */
    DETECT_FAST,     /* loose triangles that move far */
    DETECT_GRID,     /* small integer coordinates: touching, coincident, of no area */
    DETECT_COPLANAR, /* all in one plane for all t */
    DETECT_NEEDLES,  /* a million times longer than wide */
    DETECT_SHARED,   /* random corners from few vertices */
    DETECT_WAVE,     /* a sheet that waves */
    DETECT_ROUGH,    /* a sheet whose vertices move at random */
    DETECT_FOLD,     /* a sheet folded flat on itself, or nearly so */
    DETECT_CURL,     /* a sheet that rolls itself up, also past itself */
    DETECT_RAMP,     /* a spiral ramp whose turns pass through each other */
    DETECT_RING,     /* a flat, open ring that closes its gap */
    DETECT_FAMILY_COUNT
} detect_family;
extern const char *const detect_family_names[DETECT_FAMILY_COUNT];

/* Adds a surface of one family; size: about the square root of the triangles of a sheet, half the
 * number of loose ones. Zeroed is an empty scene. */
void detect_scene_add(detect_scene *scene, detect_family family, unsigned size, uint64_t *seed);
/* Multiplies all positions, and moves them away from the origin by `offset` before that. */
void detect_scene_place(detect_scene *scene, double scale, double offset);
/* The def of a scene, pointing into it; other values are the defaults. */
tulle_detect_def detect_scene_get_def(const detect_scene *scene);

/* A pair that collides, or whose distance is at most the separation at a time that was looked at.
 */
typedef struct detect_truth {
    tulle_detect_kind kind;
    uint32_t face, vertices[4];
} detect_truth;

typedef struct detect_truths {
    size_t count;
    detect_truth pairs[DETECT_MAX_TRUTHS]; /* in the order of events */
} detect_truths;

void detect_scene_find_truths(const detect_scene *scene, detect_truths *truths);
/* A time before which a true pair is farther apart than its separation, and one at which it is not,
 * or for separation 0 by which it has touched; they differ by 2^-12 at most, but where the pair is
 * so near before that this was not decided. */
void detect_scene_time_truth(const detect_scene *scene, const detect_truth *truth, double *from,
                             double *by);
/* Every true pair is among the events. On failure prints the first that is not. */
bool detect_events_contain(const detect_truths *truths, const tulle_detect_event *events,
                           size_t count);
/* Each event: an allowed pair, in order, whose fields agree with one another; its distance exceeds
 * the separation before its time. Fails the cmocka test otherwise. */
void detect_events_check(const detect_scene *scene, const tulle_detect_event *events, size_t count);

/* The distance that an event tells is the exact one, and no farther over the separation than where
 * the search for its time may end; else it fails the cmocka test. Returns false if the pair is
 * proven to keep its separation: the event is a near miss. */
bool detect_event_check_near(const detect_scene *scene, const tulle_detect_event *event);

#endif
