/* app/reproduce_fig6.c - Fig. 6: example one with low and with high friction. Numbers that tell
 * slipping from staying: the share of contacts that stick, how far the cloth has come from where it
 * started, and how high its centre is.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Fig. 6. */
#include "app/commands.h"
#include "app/reproduce.h"
#include "app/reproduce_plot.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double LAST_SHARE = 0.25; /* of the frames, over which the end is averaged */
enum { SCENES = 2 };

/* What tells slipping from staying, in one frame or as a mean. */
typedef struct friction_facts {
    double stick_share;   /* of the contacts that bear on friction, 0 without any; NAN: not known */
    double way;           /* [m] mean over the vertices, from the first frame */
    double centre_height; /* [m] mean over the vertices */
} friction_facts;

static friction_facts measure_cloth(const reproduce_frames *frames, const double *first) {
    friction_facts facts = {0};
    size_t const count = frames->vertex_count;
    for (size_t v = 0; v < count; v++) {
        double const *const now = frames->end + 3 * v, *const then = first + 3 * v;
        double const x = now[0] - then[0], y = now[1] - then[1], z = now[2] - then[2];
        facts.way += sqrt(x * x + y * y + z * z) / (double)count;
        facts.centre_height += now[2] / (double)count;
    }
    return facts;
}

static double get_stick_share(const tulle_step_report *report) {
    double const stick = (double)report->stick_contacts, slip = (double)report->slip_contacts;
    return stick + slip > 0.0 ? stick / (stick + slip) : 0.0;
}

static void add_facts(friction_facts *sum, friction_facts facts, double weight) {
    sum->stick_share += weight * facts.stick_share;
    sum->way += weight * facts.way;
    sum->centre_height += weight * facts.centre_height;
}

static void plot_facts(plot_page *page, const char *name, double time, friction_facts facts) {
    double const values[] = {facts.stick_share, facts.way, facts.centre_height};
    for (int i = 0; i < 3; i++)
        if (isfinite(values[i]))
            plot_add_point(page, plot_get_series(&page->panels[i], name), time, values[i]);
}

/* A share that is not known is an empty cell. */
static void write_facts(FILE *stream, friction_facts facts) {
    if (isfinite(facts.stick_share)) fprintf(stream, "%.4g", facts.stick_share);
    fprintf(stream, ",%.5g,%.5g\n", facts.way, facts.centre_height);
}

/* Every frame of a run; *last: the mean of its end. */
static tulle_status measure_frames(const char *name, reproduce_frames *frames, const double *first,
                                   reproduce_table *table, plot_page *page, friction_facts *last) {
    tulle_error error = {0};
    const tulle_step_report *reports = NULL;
    size_t report_count = 0;
    bool const has_reports =
        reproduce_get_reports(frames->reader, &reports, &report_count, NULL) == TULLE_OK;
    tulle_status status = TULLE_OK;
    uint32_t const count = frames->info->frame_count;
    uint32_t const from = count - 1 - (uint32_t)(LAST_SHARE * (count - 1));
    *last = (friction_facts){0};
    for (uint32_t frame = 1; frame < count && status == TULLE_OK; frame++) {
        double time = 0.0;
        uint64_t step = 0;
        status = reproduce_frames_read(frames, frame, &error);
        (void)tulle_run_reader_get_frame(frames->reader, frame, &time, &step, NULL);
        friction_facts facts = measure_cloth(frames, first);
        facts.stick_share =
            has_reports && step > 0 ? get_stick_share(&reports[step - 1]) : (double)NAN;
        if (frame >= from) add_facts(last, facts, 1.0 / (double)(count - from));
        fprintf(table->stream, "%s,%u,%.6g,", name, (unsigned)frame, time);
        write_facts(table->stream, facts);
        plot_facts(page, name, time, facts);
    }
    if (status != TULLE_OK) app_print_error("reproduce", &error);
    return status;
}

static tulle_status measure_run(reproduce *self, const reproduce_run *run, reproduce_table *table,
                                plot_page *page, friction_facts *last) {
    reproduce_frames frames;
    tulle_error error = {0};
    char name[REPRODUCE_PATH_SIZE];
    reproduce_name_run(run, name);
    tulle_status status = reproduce_frames_open(self, run, false, &frames, &error);
    double *first = NULL;
    if (status == TULLE_OK) status = reproduce_frames_read(&frames, 1, &error);
    if (status == TULLE_OK) {
        first = malloc(3 * frames.vertex_count * sizeof *first);
        if (!first) status = error_set(&error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a frame");
    }
    if (status == TULLE_OK) {
        memcpy(first, frames.start, 3 * frames.vertex_count * sizeof *first);
        status = measure_frames(name, &frames, first, table, page, last);
    } else {
        app_print_error("reproduce", &error);
    }
    free(first);
    reproduce_frames_close(&frames);
    return status;
}

static void write_finding(FILE *stream, const char *finding, double low, double high,
                          bool is_high_more) {
    if (!isfinite(low) || !isfinite(high))
        fprintf(stream, "%s,,,not known\n", finding);
    else
        fprintf(stream, "%s,%.5g,%.5g,%s\n", finding, low, high,
                (is_high_more ? high > low : high < low) ? "yes" : "no");
}

/* The first run is that with low friction. */
static int write_summary(const reproduce *self, const reproduce_figure *figure,
                         const friction_facts last[SCENES]) {
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("run,stick_share,mean_way,centre_height\n", table.stream);
    for (int i = 0; i < SCENES; i++) {
        char name[REPRODUCE_PATH_SIZE];
        reproduce_name_run(&figure->runs[i], name);
        fprintf(table.stream, "%s,", name);
        write_facts(table.stream, last[i]);
    }
    int code = reproduce_table_end(self, &table, "fig6.csv");
    if (code != APP_EXIT_FINE || !reproduce_table_begin(&table)) return code;
    fputs("finding,low,high,verdict\n", table.stream);
    write_finding(table.stream, "more contacts stick with high friction", last[0].stick_share,
                  last[1].stick_share, true);
    write_finding(table.stream, "the cloth goes less far with high friction", last[0].way,
                  last[1].way, false);
    write_finding(table.stream, "its centre stays higher with high friction", last[0].centre_height,
                  last[1].centre_height, true);
    return reproduce_table_end(self, &table, "fig6_findings.csv");
}

int reproduce_fig6(reproduce *self, const reproduce_figure *figure) {
    friction_facts last[SCENES];
    reproduce_table table;
    plot_page page = {
        .panels = {{.title = "Contacts that stick", .x_label = "time [s]", .y_label = "share"},
                   {.title = "Mean way of the cloth", .x_label = "time [s]", .y_label = "[m]"},
                   {.title = "Height of its centre", .x_label = "time [s]", .y_label = "[m]"}},
        .panel_count = 3};
    for (int i = 0; i < SCENES; i++)
        if (!reproduce_has_run(self, &figure->runs[i])) return reproduce_stills(self, figure);
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("run,frame,time,stick_share,mean_way,centre_height\n", table.stream);
    tulle_status status = TULLE_OK;
    for (int i = 0; i < SCENES && status == TULLE_OK; i++)
        status = measure_run(self, &figure->runs[i], &table, &page, &last[i]);
    int code =
        reproduce_table_finish(self, &table, "fig6_frames.csv",
                               status == TULLE_OK ? APP_EXIT_FINE : app_exit_for_run(status));
    if (code == APP_EXIT_FINE) code = write_summary(self, figure, last);
    if (code == APP_EXIT_FINE) code = plot_draw(self, &page, "fig6.svg");
    plot_release(&page);
    return code == APP_EXIT_FINE ? reproduce_stills(self, figure) : code;
}
