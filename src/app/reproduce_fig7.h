/* app/reproduce_fig7.h - what the two parts of Fig. 7 share: reproduce_fig7_measure.c measures
 * frames, or finds what was measured before; reproduce_fig7.c sums up and writes. */
#ifndef TULLE_APP_REPRODUCE_FIG7_H
#define TULLE_APP_REPRODUCE_FIG7_H

#include "app/reproduce_kept.h"

typedef enum fig7_rules { FIG7_PAPER, FIG7_PROVEN, FIG7_PATCHES, FIG7_RULES } fig7_rules;
extern const char *const fig7_rules_names[FIG7_RULES];

/* One frame, or sums over frames. */
typedef struct fig7_times {
    double partition, trees, traversal, intrinsic, total; /* [s] cloth alone */
    double with_obstacles;                                /* [s]; 0: not asked */
    uint64_t events, patches, patch_triangles;
} fig7_times;

/* One angle: a detector for each of the rules, made when the first frame has to be measured. */
typedef struct fig7_pass {
    reproduce *self;
    double angle;                /* [degrees] */
    reproduce_frames *cloth;     /* without obstacles */
    reproduce_frames *obstacles; /* with them; null: only cloth is asked about */
    tulle_detector *detectors[FIG7_RULES], *with_obstacles[FIG7_RULES];
    bool is_begun;
    reproduce_kept kept;
} fig7_pass;

/* To be ended also after a failure. */
tulle_status fig7_pass_begin(fig7_pass *pass, tulle_error *error);
/* One frame by each of the rules, measured or found. */
tulle_status fig7_pass_look(fig7_pass *pass, uint32_t frame, fig7_times times[FIG7_RULES],
                            tulle_error *error);
/* Saves what is measured; `status` or, if that is TULLE_OK, that of saving. */
tulle_status fig7_pass_end(fig7_pass *pass, tulle_status status, tulle_error *error);

#endif
