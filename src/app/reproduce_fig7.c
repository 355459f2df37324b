/* app/reproduce_fig7.c - Fig. 7: what self-collision detection of the recorded frames of example
 * one costs at patch angles from 30 to 89 degrees, by the paper's rules, by patches that are proven
 * and by ours, which live from frame to frame; with obstacles too at three angles. Sums, tables and
 * plots of what reproduce_fig7_measure.c measures.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Fig. 7. */
#include "app/reproduce_fig7.h"
#include "app/commands.h"
#include "app/reproduce_plot.h"

#include <inttypes.h>
#include <stdlib.h>

enum { FRAMES_QUICK = 100, FRAMES_FULL = 600 };
static const double MS = 1000.0;                                                     /* [ms/s] */
static const double angles[] = {30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89}; /* [degrees] */
enum { ANGLE_COUNT = sizeof angles / sizeof angles[0] };

/* What the paper tells, for the angles that it tells of. */
static const struct {
    double angle;
    double self_seconds;  /* [s] a frame; 0: not told */
    double self_total;    /* [s] over the run */
    double total_seconds; /* [s] over the run, obstacles too */
} published[] = {{30, 0.8, 1910, 2070}, {60, 0, 700, 860}, {85, 0.23, 540, 780}};
enum { PUBLISHED_COUNT = sizeof published / sizeof published[0] };

/* Sums over the frames that were looked at, for each of the rules. */
typedef struct angle_sums {
    double angle; /* [degrees] */
    uint32_t frames;
    fig7_times sums[FIG7_RULES];
} angle_sums;

typedef struct fig7 {
    reproduce *self;
    reproduce_frames cloth, all; /* without and with obstacles */
    reproduce_table by_angle, by_frame, totals;
    plot_page means, curves, sums, shares;
    double first_self[FIG7_RULES], first_total[FIG7_RULES]; /* [s] a frame at the first angle */
    double best_angle, best_seconds;                        /* of the paper's rules */
} fig7;

/* Index in `published`, or -1. */
static int find_published(double angle) {
    for (int i = 0; i < PUBLISHED_COUNT; i++)
        if (published[i].angle == angle) return i;
    return -1;
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

/* A frame in the sums, and one by one where the paper tells its curve. */
static void add_frame(fig7 *figure, angle_sums *of, uint32_t frame,
                      const fig7_times times[FIG7_RULES]) {
    double time = 0.0;
    (void)tulle_run_reader_get_frame(figure->cloth.reader, frame, &time, NULL, NULL);
    of->frames++;
    for (fig7_rules by = 0; by < FIG7_RULES; by++) {
        add_times(&of->sums[by], &times[by]);
        if (find_published(of->angle) < 0) continue;
        double const ms = MS * times[by].total;
        fprintf(figure->by_frame.stream, "%s,%.0f,%u,%.6g,%.5g\n", fig7_rules_names[by], of->angle,
                (unsigned)frame, time, ms);
        char name[PLOT_NAME_SIZE];
        snprintf(name, sizeof name, "%.0f degrees", of->angle);
        plot_panel *const panel = &figure->curves.panels[by == FIG7_PATCHES];
        if (by != FIG7_PROVEN)
            plot_add_point(&figure->curves, plot_get_series(panel, name), frame, ms);
    }
}

/* [%] of the whole. */
static double get_share(double seconds, const fig7_times *of) {
    return of->total > 0.0 ? 100.0 * seconds / of->total : 0.0;
}

/* A number that the paper tells, or nothing. */
static void write_published(FILE *stream, double value) {
    if (value > 0.0)
        fprintf(stream, ",%g", value);
    else
        fputc(',', stream);
}

static void write_angle(fig7 *figure, const angle_sums *of) {
    FILE *const stream = figure->by_angle.stream;
    double const run_frames = (double)figure->cloth.info->frame_count - 1.0;
    int const told = find_published(of->angle);
    for (fig7_rules by = 0; by < FIG7_RULES; by++) {
        const fig7_times *const sums = &of->sums[by];
        double const mean = sums->total / (double)of->frames;
        fprintf(stream, "%s,%.0f,%.5g,%.5g,%.3g,%.3g,%.3g,%.3g,%.4g,%.3g,%" PRIu64,
                fig7_rules_names[by], of->angle, MS * mean, mean * run_frames,
                get_share(sums->partition, sums), get_share(sums->trees, sums),
                get_share(sums->traversal, sums), get_share(sums->intrinsic, sums),
                (double)sums->patches / (double)of->frames,
                100.0 * (double)sums->patch_triangles /
                    ((double)of->frames * (double)figure->cloth.triangle_count),
                sums->events);
        bool const is_paper = by == FIG7_PAPER && told >= 0;
        write_published(stream, is_paper ? MS * published[told].self_seconds : 0.0);
        write_published(stream, is_paper ? published[told].self_total : 0.0);
        fputc('\n', stream);
        if (by == FIG7_PAPER && (figure->best_seconds == 0.0 || mean < figure->best_seconds)) {
            figure->best_seconds = mean;
            figure->best_angle = of->angle;
        }
    }
}

static void plot_angle(fig7 *figure, const angle_sums *of) {
    for (fig7_rules by = 0; by < FIG7_RULES; by++) {
        const fig7_times *const sums = &of->sums[by];
        double const mean = sums->total / (double)of->frames;
        if (of->angle == angles[0]) figure->first_self[by] = mean;
        plot_panel *const panels = figure->means.panels;
        plot_add_point(&figure->means, plot_get_series(&panels[0], fig7_rules_names[by]), of->angle,
                       MS * mean);
        plot_add_point(&figure->means, plot_get_series(&panels[1], fig7_rules_names[by]), of->angle,
                       mean / figure->first_self[by]);
        if (by == FIG7_PROVEN) continue;
        plot_panel *const panel = &figure->shares.panels[by == FIG7_PATCHES];
        double const parts[] = {sums->partition, sums->trees, sums->traversal, sums->intrinsic};
        static const char *const names[] = {"partition", "trees", "traversal", "intrinsic test"};
        for (int i = 0; i < 4; i++)
            plot_add_point(&figure->shares, plot_get_series(panel, names[i]), of->angle,
                           get_share(parts[i], sums));
    }
}

static void write_total(fig7 *figure, const angle_sums *of) {
    int const told = find_published(of->angle);
    double const run_frames = (double)figure->cloth.info->frame_count - 1.0;
    if (told < 0) return;
    for (fig7_rules by = 0; by < FIG7_RULES; by++) {
        double const self = of->sums[by].total / (double)of->frames;
        double const total = of->sums[by].with_obstacles / (double)of->frames;
        if (told == 0) figure->first_total[by] = total;
        fprintf(figure->totals.stream, "%s,%.0f,%.5g,%.5g,%.5g,%.4g,%g,%g,%.4g\n",
                fig7_rules_names[by], of->angle, MS * total, self * run_frames, total * run_frames,
                total / figure->first_total[by], published[told].self_total,
                published[told].total_seconds,
                published[told].total_seconds / published[0].total_seconds);
        plot_add_point(&figure->sums,
                       plot_get_series(&figure->sums.panels[0], fig7_rules_names[by]), of->angle,
                       total / figure->first_total[by]);
    }
    plot_series *const paper = plot_get_series(&figure->sums.panels[0], "published");
    if (paper) paper->is_published = true;
    plot_add_point(&figure->sums, paper, of->angle,
                   published[told].total_seconds / published[0].total_seconds);
}

static tulle_status look_at_angle(fig7 *figure, int index, tulle_error *error) {
    angle_sums of = {.angle = angles[index]};
    uint32_t const count = figure->cloth.info->frame_count;
    uint32_t const most = figure->self->is_quick ? FRAMES_QUICK : FRAMES_FULL;
    uint32_t const stride = reproduce_find_stride(count, most);
    uint32_t const looks = reproduce_count_looks(count, most);
    fig7_pass pass = {.self = figure->self,
                      .angle = of.angle,
                      .cloth = &figure->cloth,
                      .obstacles = find_published(of.angle) >= 0 ? &figure->all : NULL};
    tulle_status status = fig7_pass_begin(&pass, error);
    for (uint32_t frame = 1; frame < count && status == TULLE_OK; frame += stride) {
        fig7_times times[FIG7_RULES];
        status = fig7_pass_look(&pass, frame, times, error);
        if (status == TULLE_OK) add_frame(figure, &of, frame, times);
        reproduce_show_work(figure->self, "fig7", (uint64_t)index * looks + of.frames,
                            (uint64_t)ANGLE_COUNT * looks);
    }
    status = fig7_pass_end(&pass, status, error);
    if (status != TULLE_OK) return status;
    write_angle(figure, &of);
    plot_angle(figure, &of);
    write_total(figure, &of);
    return TULLE_OK;
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
            figure->first_self[FIG7_PAPER] / figure->best_seconds,
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
