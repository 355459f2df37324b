/* app/reproduce_fig7.c - Fig. 7: what self-collision detection of the recorded frames of example
 * one costs at patch angles from 30 to 89 degrees, by the paper's rules, by patches that are proven
 * and by ours, which live from frame to frame; with obstacles too at three angles. All angles take
 * turns on each frame, so that the machine's other load troubles all of them alike.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Fig. 7. */
#include "app/reproduce_fig7.h"
#include "app/commands.h"

#include <stdlib.h>

enum { FRAMES_QUICK = 100, FRAMES_FULL = 300 };
static const double MS = 1000.0; /* [ms/s] */
static const double all_angles[] = {30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89};
static const double few_angles[] = {30, 60, 85};

/* The tables and plots of Fig. 7, and one more table of the run with high friction. */
enum { ALL_COUNT = sizeof all_angles / sizeof all_angles[0], FEW_COUNT = 3 };

static const fig7_published published[] = {
    {30, 0.8, 1910, 2070}, {60, 0, 700, 860}, {85, 0.23, 540, 780}, {89, 0.26, 0, 0}};

const fig7_published *fig7_find_published(double angle) {
    for (size_t i = 0; i < sizeof published / sizeof published[0]; i++)
        if (published[i].angle == angle) return &published[i];
    return NULL;
}

bool fig7_has_curve(double angle) {
    const fig7_published *const told = fig7_find_published(angle);
    return told && told->total_seconds > 0.0;
}

double fig7_get_mean(const fig7 *figure, int index, fig7_rules by) {
    return figure->sums[index].sums[by].total / (double)figure->looks;
}

double fig7_get_total(const fig7 *figure, int index, fig7_rules by) {
    return figure->sums[index].sums[by].with_obstacles / (double)figure->looks;
}

double fig7_get_share(double seconds, const fig7_times *of) {
    return of->total > 0.0 ? 100.0 * seconds / of->total : 0.0;
}

static void add_times(fig7_times *sum, const fig7_times *times) {
    sum->partition += times->partition;
    sum->trees += times->trees;
    sum->traversal += times->traversal;
    sum->intrinsic += times->intrinsic;
    sum->total += times->total;
    sum->with_obstacles += times->with_obstacles;
    sum->events += times->events;
    sum->patches += times->patches;
    sum->patch_triangles += times->patch_triangles;
}

/* A frame at one angle: in the sums, and one by one where the paper shows its curve. */
static void add_frame(fig7 *figure, int index, uint32_t frame, const fig7_times times[FIG7_RULES]) {
    double time = 0.0;
    double const angle = figure->angles[index];
    (void)tulle_run_reader_get_frame(figure->frames.cloth.reader, frame, &time, NULL, NULL);
    for (fig7_rules by = 0; by < FIG7_RULES; by++) {
        add_times(&figure->sums[index].sums[by], &times[by]);
        if (fig7_has_curve(angle))
            fprintf(figure->by_frame.stream, "%s,%.0f,%u,%.6g,%.5g,%.5g\n", fig7_rules_names[by],
                    angle, (unsigned)frame, time, MS * times[by].total,
                    MS * times[by].with_obstacles);
    }
    if (fig7_has_curve(angle)) fig7_plot_frame(figure, angle, frame, times);
}

/* One frame at every angle. Each frame begins with another one, which finds the frame's positions
 * not yet in the processor's caches. */
static tulle_status look_at_frame(fig7 *figure, uint32_t frame, uint64_t work, tulle_error *error) {
    fig7_times times[FIG7_ANGLES_MAX][FIG7_RULES];
    int const count = figure->angle_count;
    tulle_status status = TULLE_OK;
    for (int k = 0; k < count && status == TULLE_OK; k++) {
        int const index = (k + (int)(figure->looks % (uint32_t)count)) % count;
        status = fig7_pass_look(&figure->passes[index], frame, times[index], error);
        reproduce_show_work(figure->self, "fig7",
                            (uint64_t)figure->looks * (uint64_t)count + (uint64_t)k + 1, work);
    }
    for (int i = 0; i < count && status == TULLE_OK; i++) add_frame(figure, i, frame, times[i]);
    figure->looks += status == TULLE_OK;
    return status;
}

static tulle_status look_at_frames(fig7 *figure, tulle_error *error) {
    uint32_t const count = figure->frames.cloth.info->frame_count;
    uint32_t const most = figure->self->is_quick ? FRAMES_QUICK : FRAMES_FULL;
    uint32_t const stride = reproduce_find_stride(count, most);
    uint64_t const work =
        (uint64_t)reproduce_count_looks(count, most) * (uint64_t)figure->angle_count;
    tulle_status status = TULLE_OK;
    for (int i = 0; i < figure->angle_count && status == TULLE_OK; i++) {
        figure->sums[i].angle = figure->angles[i];
        figure->passes[i] = (fig7_pass){.self = figure->self,
                                        .angle = figure->angles[i],
                                        .frames = &figure->frames,
                                        .has_obstacles = fig7_has_curve(figure->angles[i])};
        status = fig7_pass_begin(&figure->passes[i], figure->label, error);
    }
    reproduce_begin_work(figure->self);
    for (uint32_t frame = 1; frame < count && status == TULLE_OK; frame += stride)
        status = look_at_frame(figure, frame, work, error);
    reproduce_end_work(figure->self);
    for (int i = 0; i < figure->angle_count; i++)
        status = fig7_pass_end(&figure->passes[i], status, error);
    return status;
}

static int measure(fig7 *figure, const reproduce_run *run) {
    tulle_error error = {0};
    reproduce *const self = figure->self;
    if (!reproduce_table_begin(&figure->by_frame)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("rules,angle,frame,time,self_ms,total_ms\n", figure->by_frame.stream);
    tulle_status status = reproduce_frames_open(self, run, false, &figure->frames.cloth, &error);
    if (status == TULLE_OK)
        status = reproduce_frames_open(self, run, true, &figure->frames.all, &error);
    if (status == TULLE_OK) status = look_at_frames(figure, &error);
    return status == TULLE_OK ? APP_EXIT_FINE : reproduce_fail(&error);
}

/* All angles, all tables and plots. */
static int make_whole(fig7 *figure, const reproduce_run *run) {
    figure->label = "";
    figure->angles = all_angles;
    figure->angle_count = ALL_COUNT;
    int code = measure(figure, run);
    code = reproduce_table_finish(figure->self, &figure->by_frame, "fig7_frames.csv", code);
    if (code == APP_EXIT_FINE) code = fig7_write_angles(figure, "fig7_angles.csv");
    if (code == APP_EXIT_FINE) code = fig7_write_totals(figure);
    if (code == APP_EXIT_FINE) code = fig7_write_findings(figure);
    if (code == APP_EXIT_FINE) code = fig7_draw(figure);
    return code;
}

/* Three angles, one table. */
static int make_short(fig7 *figure, const reproduce_run *run) {
    figure->label = "high_";
    figure->angles = few_angles;
    figure->angle_count = FEW_COUNT;
    int const code = measure(figure, run);
    return code == APP_EXIT_FINE ? fig7_write_angles(figure, "fig7_high.csv") : code;
}

static int make(reproduce *self, const reproduce_run *run,
                int (*make_part)(fig7 *figure, const reproduce_run *run)) {
    if (!reproduce_has_run(self, run)) return APP_EXIT_FINE;
    fig7 *const figure = calloc(1, sizeof *figure);
    if (!figure) return APP_EXIT_OUT_OF_MEMORY;
    figure->self = self;
    int const code = make_part(figure, run);
    reproduce_table_discard(&figure->by_frame);
    plot_release(&figure->curves);
    plot_release(&figure->totals);
    reproduce_frames_close(&figure->frames.cloth);
    reproduce_frames_close(&figure->frames.all);
    free(figure);
    return code;
}

int reproduce_fig7(reproduce *self, const reproduce_figure *of) {
    int const code = make(self, &of->runs[0], make_whole);
    return code == APP_EXIT_FINE ? make(self, &of->runs[1], make_short) : code;
}
