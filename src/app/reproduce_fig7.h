/* app/reproduce_fig7.h - what the parts of Fig. 7 share: reproduce_fig7_measure.c measures frames,
 * or finds what was measured before; reproduce_fig7.c sums up over frames and angles;
 * reproduce_fig7_tables.c and reproduce_fig7_plots.c write and draw. */
#ifndef TULLE_APP_REPRODUCE_FIG7_H
#define TULLE_APP_REPRODUCE_FIG7_H

#include "app/reproduce_kept.h"
#include "app/reproduce_plot.h"

/* The last one knows no angle: the same work at each, and so what the machine's other load does to
 * the times. */
typedef enum fig7_rules { FIG7_PAPER, FIG7_PROVEN, FIG7_PATCHES, FIG7_BVOX, FIG7_RULES } fig7_rules;
extern const char *const fig7_rules_names[FIG7_RULES];

/* One frame, or sums over frames. */
typedef struct fig7_times {
    double partition, trees, traversal, intrinsic, total; /* [s] cloth alone */
    double with_obstacles;                                /* [s]; 0: not asked */
    uint64_t events, patches, patch_triangles;
} fig7_times;

/* What the paper tells of an angle. */
typedef struct fig7_published {
    double angle;         /* [degrees] */
    double self_seconds;  /* [s] a frame; 0: not told, as the following */
    double self_total;    /* [s] over the run */
    double total_seconds; /* [s] over the run, obstacles too: it shows these angles' curves */
} fig7_published;
/* Null where it tells nothing. */
const fig7_published *fig7_find_published(double angle);
/* Whether it shows the angle frame by frame. */
bool fig7_has_curve(double angle);

/* ---- reproduce_fig7_measure.c ---- */

/* The frames of a run, read once for all angles. */
typedef struct fig7_frames {
    reproduce_frames cloth, all; /* without and with obstacles */
    uint32_t frame;              /* which one they hold; 0: none yet */
} fig7_frames;

/* One angle: a detector for each of the rules, made when the first frame has to be measured. */
typedef struct fig7_pass {
    reproduce *self;
    double angle; /* [degrees] */
    fig7_frames *frames;
    bool has_obstacles; /* also asked with them */
    tulle_detector *detectors[FIG7_RULES], *with_obstacles[FIG7_RULES];
    bool is_begun;
    reproduce_kept kept;
} fig7_pass;

/* Rows are kept in measured/fig7_LABELANGLE.csv. To be ended also after a failure. */
tulle_status fig7_pass_begin(fig7_pass *pass, const char *label, tulle_error *error);
/* One frame by each of the rules, measured or found. */
tulle_status fig7_pass_look(fig7_pass *pass, uint32_t frame, fig7_times times[FIG7_RULES],
                            tulle_error *error);
/* Saves what is measured; `status` or, if that is TULLE_OK, that of saving. Also of one that was
 * not begun. */
tulle_status fig7_pass_end(fig7_pass *pass, tulle_status status, tulle_error *error);

/* ---- sums over the frames that were looked at ---- */

enum { FIG7_ANGLES_MAX = 16 };

typedef struct fig7_sums {
    double angle; /* [degrees] */
    fig7_times sums[FIG7_RULES];
} fig7_sums;

typedef struct fig7 {
    reproduce *self;
    const char *label; /* in names of files */
    const double *angles;
    int angle_count;
    fig7_frames frames;
    fig7_pass passes[FIG7_ANGLES_MAX];
    fig7_sums sums[FIG7_ANGLES_MAX]; /* of each angle */
    uint32_t looks;                  /* frames that were looked at */
    reproduce_table by_frame;
    plot_page curves, totals; /* frame by frame, without and with obstacles */
} fig7;

/* [s] mean of a frame. */
double fig7_get_mean(const fig7 *figure, int index, fig7_rules by);
/* [s] the same with obstacles. */
double fig7_get_total(const fig7 *figure, int index, fig7_rules by);
/* [%] of the whole time. */
double fig7_get_share(double seconds, const fig7_times *of);

/* ---- reproduce_fig7_tables.c ---- */

/* A line an angle and rules, in a table of these columns. */
int fig7_write_angles(const fig7 *figure, const char *file);
int fig7_write_totals(const fig7 *figure);
int fig7_write_findings(const fig7 *figure);

/* ---- reproduce_fig7_plots.c ---- */

/* A frame in the curves of its angle. */
void fig7_plot_frame(fig7 *figure, double angle, uint32_t frame,
                     const fig7_times times[FIG7_RULES]);
int fig7_draw(fig7 *figure);

#endif
