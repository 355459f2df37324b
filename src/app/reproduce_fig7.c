/* app/reproduce_fig7.c - Fig. 7: what self-collision detection of the recorded frames of example
 * one costs at patch angles from 30 to 89 degrees, by the paper's rules, by patches that are proven
 * and by ours, which live from frame to frame; with obstacles too at three angles.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Fig. 7. */
#include "app/commands.h"
#include "app/interrupt.h"
#include "app/reproduce.h"
#include "app/reproduce_plot.h"
#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>

enum { FRAMES_QUICK = 20, FRAMES_FULL = 600 };
static const double MS = 1000.0;                                                     /* [ms/s] */
static const double angles[] = {30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89}; /* [degrees] */
enum { ANGLE_COUNT = sizeof angles / sizeof angles[0] };

typedef enum rules { RULES_PAPER, RULES_PROVEN, RULES_PATCHES, RULES_COUNT } rules;
static const char *const rules_names[RULES_COUNT] = {"paper", "proven", "patches"};

/* What the paper tells, for the angles that it tells of. */
static const struct {
    double angle;
    double self_seconds;  /* [s] a frame; 0: not told */
    double self_total;    /* [s] over the run */
    double total_seconds; /* [s] over the run, obstacles too */
} published[] = {{30, 0.8, 1910, 2070}, {60, 0, 700, 860}, {85, 0.23, 540, 780}};
enum { PUBLISHED_COUNT = sizeof published / sizeof published[0] };

typedef struct stage_sums {
    double partition, trees, traversal, intrinsic, total; /* [s] */
    uint64_t events, patches, patch_triangles;
    uint32_t frames;
} stage_sums;

/* One angle: a detector for each of the rules, and sums of what they did. */
typedef struct angle_pass {
    double angle;
    tulle_detector *detectors[RULES_COUNT], *with_obstacles[RULES_COUNT]; /* the latter may be null
                                                                           */
    stage_sums sums[RULES_COUNT], obstacle_sums[RULES_COUNT];
} angle_pass;

typedef struct fig7 {
    reproduce *self;
    reproduce_frames cloth, all; /* without and with obstacles */
    reproduce_table by_angle, by_frame, totals;
    plot_page means, curves, sums, shares;
    double first_self[RULES_COUNT], first_total[RULES_COUNT]; /* [s] a frame at the first angle */
    double best_angle, best_seconds;                          /* of the paper's rules */
} fig7;

/* Index in `published`, or -1. */
static int find_published(double angle) {
    for (int i = 0; i < PUBLISHED_COUNT; i++)
        if (published[i].angle == angle) return i;
    return -1;
}

static tulle_detect_def use_rules(tulle_detect_def def, rules by, double angle) {
    if (by == RULES_PAPER) return reproduce_use_paper_rules(def, angle);
    tulle_detect_def made = reproduce_use_proof(def, angle);
    if (by == RULES_PATCHES) made.method = TULLE_DETECT_PATCHES;
    return made;
}

static tulle_status begin_pass(fig7 *figure, double angle, angle_pass *pass, tulle_error *error) {
    *pass = (angle_pass){.angle = angle};
    tulle_detect_def const cloth = reproduce_frames_get_def(figure->self, &figure->cloth);
    tulle_detect_def const all = reproduce_frames_get_def(figure->self, &figure->all);
    tulle_status status = TULLE_OK;
    for (rules by = 0; by < RULES_COUNT && status == TULLE_OK; by++) {
        tulle_detect_def def = use_rules(cloth, by, angle);
        status = tulle_detector_create(&def, &pass->detectors[by], error);
        def = use_rules(all, by, angle);
        if (status == TULLE_OK && find_published(angle) >= 0)
            status = tulle_detector_create(&def, &pass->with_obstacles[by], error);
    }
    return status;
}

static void end_pass(angle_pass *pass) {
    for (rules by = 0; by < RULES_COUNT; by++) {
        tulle_detector_destroy(pass->detectors[by]);
        tulle_detector_destroy(pass->with_obstacles[by]);
    }
}

static void add_statistics(stage_sums *sums, const tulle_detect_result *result) {
    const tulle_detect_statistics *const s = &result->statistics;
    sums->partition += s->patch_seconds;
    sums->trees += s->tree_seconds;
    sums->traversal += s->traversal_seconds;
    sums->intrinsic += s->filter_seconds + s->impact_seconds + s->event_seconds;
    sums->total += s->total_seconds;
    sums->events += result->event_count;
    sums->patches += s->patch_count;
    sums->patch_triangles += s->patch_triangles;
    sums->frames++;
}

/* One timed call. A detector that keeps patches is first asked about the frame before, untimed:
 * frames that are looked at do not follow one another. */
static tulle_status ask(tulle_detector *detector, const reproduce_frames *frames, bool warms_up,
                        stage_sums *sums, tulle_error *error) {
    tulle_detect_result result = {0};
    tulle_status status = TULLE_OK;
    if (warms_up)
        status = tulle_detector_find_events(detector, frames->start, frames->start, &result, error);
    if (status == TULLE_OK)
        status = tulle_detector_find_events(detector, frames->start, frames->end, &result, error);
    if (status == TULLE_OK) add_statistics(sums, &result);
    return status;
}

/* All detectors on one frame, one after the other, so that a busy machine troubles all alike. */
static tulle_status look_at_frame(fig7 *figure, angle_pass *pass, uint32_t frame,
                                  tulle_error *error) {
    bool const has_obstacles = pass->with_obstacles[0] != NULL;
    tulle_status status = reproduce_frames_read(&figure->cloth, frame, error);
    if (status == TULLE_OK && has_obstacles)
        status = reproduce_frames_read(&figure->all, frame, error);
    double time = 0.0;
    (void)tulle_run_reader_get_frame(figure->cloth.reader, frame, &time, NULL, NULL);
    for (rules by = 0; by < RULES_COUNT && status == TULLE_OK; by++) {
        double const before = pass->sums[by].total;
        bool const warms_up = by == RULES_PATCHES;
        status = ask(pass->detectors[by], &figure->cloth, warms_up, &pass->sums[by], error);
        if (status != TULLE_OK || !has_obstacles) continue;
        double const seconds = pass->sums[by].total - before;
        status =
            ask(pass->with_obstacles[by], &figure->all, warms_up, &pass->obstacle_sums[by], error);
        fprintf(figure->by_frame.stream, "%s,%.0f,%u,%.6g,%.5g\n", rules_names[by], pass->angle,
                (unsigned)frame, time, MS * seconds);
        char name[PLOT_NAME_SIZE];
        snprintf(name, sizeof name, "%.0f degrees", pass->angle);
        plot_panel *const panel = &figure->curves.panels[by == RULES_PATCHES];
        if (by != RULES_PROVEN)
            plot_add_point(&figure->curves, plot_get_series(panel, name), frame, MS * seconds);
    }
    return status;
}

/* [%] of the whole. */
static double get_share(double seconds, const stage_sums *of) {
    return of->total > 0.0 ? 100.0 * seconds / of->total : 0.0;
}

/* A number that the paper tells, or nothing. */
static void write_published(FILE *stream, double value) {
    if (value > 0.0)
        fprintf(stream, ",%g", value);
    else
        fputc(',', stream);
}

static void write_angle(fig7 *figure, const angle_pass *pass) {
    FILE *const stream = figure->by_angle.stream;
    double const run_frames = (double)figure->cloth.info->frame_count - 1.0;
    int const told = find_published(pass->angle);
    for (rules by = 0; by < RULES_COUNT; by++) {
        const stage_sums *const sums = &pass->sums[by];
        double const mean = sums->total / (double)sums->frames;
        fprintf(stream, "%s,%.0f,%.5g,%.5g,%.3g,%.3g,%.3g,%.3g,%.4g,%.3g,%" PRIu64, rules_names[by],
                pass->angle, MS * mean, mean * run_frames, get_share(sums->partition, sums),
                get_share(sums->trees, sums), get_share(sums->traversal, sums),
                get_share(sums->intrinsic, sums), (double)sums->patches / (double)sums->frames,
                100.0 * (double)sums->patch_triangles /
                    ((double)sums->frames * (double)figure->cloth.triangle_count),
                sums->events);
        bool const is_paper = by == RULES_PAPER && told >= 0;
        write_published(stream, is_paper ? MS * published[told].self_seconds : 0.0);
        write_published(stream, is_paper ? published[told].self_total : 0.0);
        fputc('\n', stream);
        if (by == RULES_PAPER && (figure->best_seconds == 0.0 || mean < figure->best_seconds)) {
            figure->best_seconds = mean;
            figure->best_angle = pass->angle;
        }
    }
}

static void plot_angle(fig7 *figure, const angle_pass *pass) {
    for (rules by = 0; by < RULES_COUNT; by++) {
        const stage_sums *const sums = &pass->sums[by];
        double const mean = sums->total / (double)sums->frames;
        if (pass->angle == angles[0]) figure->first_self[by] = mean;
        plot_panel *const panels = figure->means.panels;
        plot_add_point(&figure->means, plot_get_series(&panels[0], rules_names[by]), pass->angle,
                       MS * mean);
        plot_add_point(&figure->means, plot_get_series(&panels[1], rules_names[by]), pass->angle,
                       mean / figure->first_self[by]);
        if (by == RULES_PROVEN) continue;
        plot_panel *const panel = &figure->shares.panels[by == RULES_PATCHES];
        double const parts[] = {sums->partition, sums->trees, sums->traversal, sums->intrinsic};
        static const char *const names[] = {"partition", "trees", "traversal", "intrinsic test"};
        for (int i = 0; i < 4; i++)
            plot_add_point(&figure->shares, plot_get_series(panel, names[i]), pass->angle,
                           get_share(parts[i], sums));
    }
}

static void write_total(fig7 *figure, const angle_pass *pass) {
    int const told = find_published(pass->angle);
    double const run_frames = (double)figure->cloth.info->frame_count - 1.0;
    if (told < 0) return;
    for (rules by = 0; by < RULES_COUNT; by++) {
        const stage_sums *const with = &pass->obstacle_sums[by];
        double const self = pass->sums[by].total / (double)with->frames;
        double const total = with->total / (double)with->frames;
        if (told == 0) figure->first_total[by] = total;
        fprintf(figure->totals.stream, "%s,%.0f,%.5g,%.5g,%.5g,%.4g,%g,%g,%.4g\n", rules_names[by],
                pass->angle, MS * total, self * run_frames, total * run_frames,
                total / figure->first_total[by], published[told].self_total,
                published[told].total_seconds,
                published[told].total_seconds / published[0].total_seconds);
        plot_add_point(&figure->sums, plot_get_series(&figure->sums.panels[0], rules_names[by]),
                       pass->angle, total / figure->first_total[by]);
    }
    plot_series *const paper = plot_get_series(&figure->sums.panels[0], "published");
    if (paper) paper->is_published = true;
    plot_add_point(&figure->sums, paper, pass->angle,
                   published[told].total_seconds / published[0].total_seconds);
}

static tulle_status look_at_angle(fig7 *figure, int index, tulle_error *error) {
    angle_pass pass;
    uint32_t const count = figure->cloth.info->frame_count;
    uint32_t const stride =
        reproduce_find_stride(count, figure->self->is_quick ? FRAMES_QUICK : FRAMES_FULL);
    tulle_status status = begin_pass(figure, angles[index], &pass, error);
    for (uint32_t frame = 1; frame < count && status == TULLE_OK; frame += stride) {
        if (interrupt_is_pending()) status = error_set(error, TULLE_ERROR_INTERRUPTED, "stopped");
        if (status == TULLE_OK) status = look_at_frame(figure, &pass, frame, error);
        reproduce_show_work(figure->self, "fig7", (uint64_t)index * count + frame,
                            (uint64_t)ANGLE_COUNT * count);
    }
    if (status == TULLE_OK) {
        write_angle(figure, &pass);
        plot_angle(figure, &pass);
        write_total(figure, &pass);
    }
    end_pass(&pass);
    return status;
}

static plot_panel make_panel(const char *title, const char *x_label, const char *y_label) {
    return (plot_panel){.title = title, .x_label = x_label, .y_label = y_label};
}

static void name_panels(fig7 *figure) {
    static const char *const axis = "largest surface angle [degrees]";
    figure->means.panels[0] = make_panel("Self-collision of a frame", axis, "mean time [ms]");
    figure->means.panels[1] = make_panel("The same, in times of 30 degrees", axis, "ratio");
    figure->curves.panels[0] =
        make_panel("Self-collision frame by frame, the rules of the paper", "frame", "time [ms]");
    figure->curves.panels[1] =
        make_panel("Self-collision frame by frame, patches kept and proven", "frame", "time [ms]");
    figure->sums.panels[0] =
        make_panel("Detection with obstacles, in times of 30 degrees", axis, "ratio");
    figure->shares.panels[0] = make_panel("Shares, the rules of the paper", axis, "share [%]");
    figure->shares.panels[1] = make_panel("Shares, patches kept and proven", axis, "share [%]");
    figure->means.panel_count = figure->curves.panel_count = figure->shares.panel_count = 2;
    figure->sums.panel_count = 1;
    plot_series *const paper = plot_get_series(&figure->means.panels[1], "published");
    paper->is_published = true;
    for (int i = 0; i < PUBLISHED_COUNT; i++)
        if (published[i].self_seconds > 0.0)
            plot_add_point(&figure->means, paper, published[i].angle,
                           published[i].self_seconds / published[0].self_seconds);
}

static bool begin_tables(fig7 *figure) {
    if (!reproduce_table_begin(&figure->by_angle)) return false;
    if (!reproduce_table_begin(&figure->by_frame)) return false;
    if (!reproduce_table_begin(&figure->totals)) return false;
    fputs("rules,angle,self_ms,self_run_seconds,partition_percent,trees_percent,traversal_percent,"
          "intrinsic_percent,patches,patch_triangles_percent,events,published_self_ms,"
          "published_self_run_seconds\n",
          figure->by_angle.stream);
    fputs("rules,angle,frame,time,self_ms\n", figure->by_frame.stream);
    fputs("rules,angle,total_ms,self_run_seconds,total_run_seconds,ratio_to_30,"
          "published_self_run_seconds,published_total_run_seconds,published_ratio_to_30\n",
          figure->totals.stream);
    return true;
}

static int end_tables(fig7 *figure) {
    const struct {
        reproduce_table *table;
        const char *file;
    } all[] = {{&figure->by_angle, "fig7_angles.csv"},
               {&figure->by_frame, "fig7_frames.csv"},
               {&figure->totals, "fig7_totals.csv"}};
    int code = APP_EXIT_FINE;
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        int const written = reproduce_table_end(figure->self, all[i].table, all[i].file);
        if (code == APP_EXIT_FINE) code = written;
    }
    return code;
}

static int write_findings(fig7 *figure) {
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("finding,ours,published\n", table.stream);
    fprintf(table.stream, "best angle of the paper's rules [degrees],%.0f,85\n",
            figure->best_angle);
    fprintf(table.stream, "time at 30 degrees over time at the best angle,%.3g,%.3g\n",
            figure->first_self[RULES_PAPER] / figure->best_seconds,
            published[0].self_seconds / published[PUBLISHED_COUNT - 1].self_seconds);
    return reproduce_table_end(figure->self, &table, "fig7_findings.csv");
}

static int draw(fig7 *figure) {
    int code = plot_draw(figure->self, &figure->means, "fig7a.svg");
    if (code == APP_EXIT_FINE) code = plot_draw(figure->self, &figure->curves, "fig7b.svg");
    if (code == APP_EXIT_FINE) code = plot_draw(figure->self, &figure->sums, "fig7c.svg");
    if (code == APP_EXIT_FINE) code = plot_draw(figure->self, &figure->shares, "fig7d.svg");
    return code;
}

static int make_figure(fig7 *figure, const reproduce_run *run) {
    tulle_error error = {0};
    tulle_status status = reproduce_frames_open(figure->self, run, false, &figure->cloth, &error);
    if (status == TULLE_OK)
        status = reproduce_frames_open(figure->self, run, true, &figure->all, &error);
    if (status != TULLE_OK) return reproduce_fail(&error);
    name_panels(figure);
    reproduce_begin_work(figure->self);
    for (int i = 0; i < ANGLE_COUNT && status == TULLE_OK; i++)
        status = look_at_angle(figure, i, &error);
    reproduce_end_work(figure->self);
    return status == TULLE_OK ? APP_EXIT_FINE : reproduce_fail(&error);
}

static void discard_table(reproduce_table *table) {
    if (table->stream) fclose(table->stream);
    free(table->bytes);
}

int reproduce_fig7(reproduce *self, const reproduce_figure *of) {
    if (!reproduce_has_run(self, &of->runs[0])) return APP_EXIT_FINE;
    fig7 *const figure = calloc(1, sizeof *figure);
    if (!figure) return APP_EXIT_OUT_OF_MEMORY;
    figure->self = self;
    int code = begin_tables(figure) ? make_figure(figure, &of->runs[0]) : APP_EXIT_OUT_OF_MEMORY;
    if (code == APP_EXIT_FINE) code = end_tables(figure);
    if (code == APP_EXIT_FINE) code = write_findings(figure);
    if (code == APP_EXIT_FINE) code = draw(figure);
    discard_table(&figure->by_angle);
    discard_table(&figure->by_frame);
    discard_table(&figure->totals);
    plot_release(&figure->means);
    plot_release(&figure->curves);
    plot_release(&figure->sums);
    plot_release(&figure->shares);
    reproduce_frames_close(&figure->cloth);
    reproduce_frames_close(&figure->all);
    free(figure);
    return code;
}
