/* detect/detector/detector_parts.h - the inside of tulle_detector, shared by the files detector*.c
 * only. */
#ifndef TULLE_DETECT_DETECTOR_DETECTOR_PARTS_H
#define TULLE_DETECT_DETECTOR_DETECTOR_PARTS_H

#include "detect/impact/narrow_phase.h"
#include "detect/patches/kept_patches.h"
#include "detect/trees/broad_phase.h"
#include "tulle/detect.h"

#define DETECT_DEF_COOKIE 0x54447431U

struct tulle_detector {
    memory heap;
    tulle_detect_def def; /* its pointers are null */
    int threads;
    topology topo;
    surface_set set;
    surface_range *surfaces;
    unsigned char *collides;  /* surface_count^2; null: all */
    double *separations;      /* [m] surface_count^2 */
    uint32_t *vertex_surface; /* null with one surface */
    double margin;            /* [m] largest separation of surfaces that may meet */
    double reach;             /* [m] half the largest separation of a surface from itself */
    double *static_positions; /* [m] 3 a vertex of static surfaces, in order */
    size_t static_vertex_count;
    bool has_static_positions;
    broad_phase *broad;     /* null until there are positions to shape it from */
    kept_patches *patches;  /* null for methods without */
    bool keeps_all_patches; /* see patch_rules; set by tests */
    int call_count;         /* of those that succeeded; 2: or more */
    narrow_phase *narrow;
    ARRAY(tulle_detect_event) events;
    const uint32_t *labels; /* of the last call; null: none */
    bool is_streaming;      /* a receiver has the word */
};

/* What one pass over the candidates gives. */
typedef struct detector_pass {
    const double *start, *end; /* [m] 3 * vertex_count */
    bool only_earliest;
    const raw_event *events; /* sorted by (kind, key); owned by the detector */
    size_t event_count;
    tulle_detect_statistics statistics;
} detector_pass;

/* detector_input.c: all that can be wrong with a def; nothing is made. */
tulle_status detect_def_check(const tulle_detect_def *def, tulle_error *error);
/* Both arrays given and finite, static surfaces where they were. */
tulle_status detector_check_positions(tulle_detector *detector, const double *start,
                                      const double *end, tulle_error *error);

/* detector_pass.c: the stages of one call. */
tulle_status detector_shape_trees(tulle_detector *detector, const double *rest, tulle_error *error);
void detector_destroy_stages(tulle_detector *detector);
tulle_status detector_run_pass(tulle_detector *detector, detector_pass *pass, tulle_error *error);

/* detector_events.c: the public form of pass->events[begin .. end - 1]. */
void detector_fill_events(const tulle_detector *detector, const detector_pass *pass, size_t begin,
                          size_t end, tulle_detect_event *events);

#endif
