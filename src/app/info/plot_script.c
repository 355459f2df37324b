/* app/info/plot_script.c - the commands for gnuplot: numbers as an inline block of data, then a
 * panel for each quantity over simulated time, all with the same axis. Ranges are computed here, so
 * that a quantity that is always zero or never known has a panel like any other. */
#include "app/info/plot.h"
#include "render/color_map.h"
#include "render/color_space.h"

#include <math.h>
#include <stdbool.h>

enum { PANEL_COUNT = 6 };
static double const missing = NAN;

/* Columns of the data block, from 1. */
enum {
    COLUMN_TIME = 1,
    COLUMN_STAGE, /* [ms] sums up to each stage */
    COLUMN_TOTAL = COLUMN_STAGE + TULLE_STAGE_COUNT,
    COLUMN_CONTACTS,
    COLUMN_NEW,
    COLUMN_STICK,
    COLUMN_SLIP,
    COLUMN_HARD,
    COLUMN_GAP, /* [mm] */
    COLUMN_KINETIC,
    COLUMN_GRAVITY,
    COLUMN_ELASTIC,
    COLUMN_ENERGY,
    COLUMN_ITERATIONS,
    COLUMN_RESIDUAL,
    COLUMN_STRETCH, /* [%] */
    COLUMN_ZONES,   /* height of a mark where there was a rescue of this kind, else missing */
    COLUMN_COMPONENTS,
    COLUMN_GLOBAL,
    COLUMN_PINCHED,
    COLUMN_END
};

/* Least and greatest of what a panel shows. */
typedef struct range {
    double low, high;
} range;

typedef struct plot_ranges {
    double time, milliseconds, contacts, iterations, stretch;
    range gap, residual, energy;
    uint64_t zones, components, global, pinched; /* steps with each */
} plot_ranges;

static void widen(range *found, double value) {
    if (!isfinite(value)) return;
    found->low = fmin(found->low, value);
    found->high = fmax(found->high, value);
}

static double get_stretch(const tulle_step_report *report) {
    return 100.0 * (report->max_stretch - 1.0);
}

static double get_energy(const tulle_step_report *report) {
    return report->kinetic_energy + report->gravity_energy + report->elastic_energy;
}

/* 8 percent of room above, and some height where all is zero. */
static double make_room(double high) { return high > 0.0 ? 1.08 * high : 1.0; }

/* Decades around a range of positive numbers; stands in for one where there are none. */
static range make_decades(range found, range otherwise) {
    if (!(found.low > 0.0 && found.low <= found.high)) return otherwise;
    return (range){pow(10.0, floor(log10(found.low))),
                   pow(10.0, floor(log10(2.0 * found.high)) + 1.0)};
}

static plot_ranges measure_ranges(const plot_content *content) {
    plot_ranges r = {.gap = {INFINITY, 0.0}, .residual = {INFINITY, 0.0}};
    for (size_t i = 0; i < content->report_count; i++) {
        const tulle_step_report *const report = &content->reports[i];
        r.time = fmax(r.time, report->time);
        r.milliseconds = fmax(r.milliseconds, 1000.0 * report->total_seconds);
        r.contacts = fmax(r.contacts, (double)report->contacts);
        r.iterations = fmax(r.iterations, (double)report->cg_iterations);
        r.stretch = fmax(r.stretch, get_stretch(report));
        if (report->smallest_gap > 0.0) widen(&r.gap, 1000.0 * report->smallest_gap);
        if (report->cg_residual > 0.0) widen(&r.residual, report->cg_residual);
        widen(&r.energy, report->kinetic_energy);
        widen(&r.energy, report->gravity_energy);
        widen(&r.energy, report->elastic_energy);
        widen(&r.energy, get_energy(report));
        r.zones += report->rescue_impact_zones > 0;
        r.components += report->rescue_component_scalings > 0;
        r.global += report->rescue_global_scalings > 0;
        r.pinched += report->pinched != 0;
    }
    r.time = r.time > 0.0 ? r.time : 1.0;
    r.milliseconds = make_room(1.04 * r.milliseconds);
    r.contacts = make_room(r.contacts);
    r.iterations = make_room(r.iterations);
    r.stretch = make_room(r.stretch);
    r.gap = make_decades(r.gap, (range){0.001, 1.0});
    r.residual = make_decades(r.residual, (range){1e-6, 1.0});
    r.energy =
        (range){r.energy.low - 0.08 * (r.energy.high - r.energy.low), make_room(r.energy.high)};
    return r;
}

/* A number, or the mark of one that is missing. */
static void write_number(FILE *script, double value) {
    if (isfinite(value))
        fprintf(script, " %.9g", value);
    else
        fputs(" ?", script);
}

static void write_row(FILE *script, const tulle_step_report *report, const plot_ranges *ranges) {
    double const mark = ranges->milliseconds * 0.96;
    double sum = 0.0;
    write_number(script, report->time);
    for (int i = 0; i < TULLE_STAGE_COUNT; i++)
        write_number(script, sum += 1000.0 * report->stage_seconds[i]);
    double const rest[] = {1000.0 * report->total_seconds,
                           (double)report->contacts,
                           (double)report->new_contacts,
                           (double)report->stick_contacts,
                           (double)report->slip_contacts,
                           (double)report->hard_contacts,
                           report->smallest_gap > 0.0 ? 1000.0 * report->smallest_gap : missing,
                           report->kinetic_energy,
                           report->gravity_energy,
                           report->elastic_energy,
                           get_energy(report),
                           (double)report->cg_iterations,
                           report->cg_residual > 0.0 ? report->cg_residual : missing,
                           get_stretch(report),
                           report->rescue_impact_zones ? mark : missing,
                           report->rescue_component_scalings ? mark : missing,
                           report->rescue_global_scalings ? mark : missing,
                           report->pinched ? mark : missing};
    _Static_assert(sizeof rest / sizeof rest[0] == COLUMN_END - COLUMN_TOTAL, "one each");
    for (size_t i = 0; i < sizeof rest / sizeof rest[0]; i++) write_number(script, rest[i]);
    fputc('\n', script);
}

/* Any text within single quotes: control characters and backquotes show as '?', quotes doubled. */
static void write_quoted(FILE *script, const char *text) {
    fputc('\'', script);
    for (; *text; text++) {
        unsigned char const c = (unsigned char)*text;
        if (c == '\'') fputc('\'', script);
        fputc(c < 0x20 || c == 0x7F || c == '`' ? '?' : c, script);
    }
    fputc('\'', script);
}

static void write_color(FILE *script, const float rgb[3]) {
    uint8_t bytes[3];
    color_to_bytes(rgb, bytes);
    fprintf(script, " lc rgb '#%02x%02x%02x'", bytes[0], bytes[1], bytes[2]);
}

/* One curve of the plot command that is being written. */
static void write_curve(FILE *script, int column, const char *title, const char *style) {
    fprintf(script, ", \\\n $rows using %d:%d with lines %s title '%s'", COLUMN_TIME, column, style,
            title);
}

/* The first panel is twice as high as the others, for the key of its ten stages and four marks:
 * gnuplot leaves out the entries of a key that is higher than its panel. */
static void begin_panel(FILE *script, int index, const char *label) {
    double const share = 0.92 / (PANEL_COUNT + 1);
    double const height = index == 0 ? 2.0 * share : share;
    double const top = 0.955 - (index == 0 ? 0 : index + 1) * share;
    fprintf(script,
            "set tmargin at screen %.4f; set bmargin at screen %.4f\n"
            "set label 1 '%s' at screen 0.022, graph 0.5 center rotate\n",
            top, top - height + 0.022, label);
    if (index == PANEL_COUNT - 1)
        fputs("set xlabel 'simulated time [s]'; set format x '%g'\n", script);
}

static void write_marks(FILE *script, int column, const char *title, uint64_t steps, int index) {
    static const char *const styles[] = {"pt 9 lc rgb '#d08000'", "pt 7 lc rgb '#8030a0'",
                                         "pt 5 lc rgb '#d02020'", "pt 2 lw 2 lc rgb '#000000'"};
    if (steps == 0) return;
    fprintf(script, ", \\\n $rows using %d:%d with points %s ps 0.6 title '%s: %llu steps'",
            COLUMN_TIME, column, styles[index], title, (unsigned long long)steps);
}

static void write_times(FILE *script, const plot_ranges *r) {
    begin_panel(script, 0, "step time [ms]");
    fprintf(script, "set yrange [0:%.9g]\n", r->milliseconds);
    fprintf(script, "plot $rows using %d:%d with filledcurves y1=0 lc rgb '#d0d0d0' title 'other'",
            COLUMN_TIME, COLUMN_TOTAL);
    for (int i = TULLE_STAGE_COUNT - 1; i >= 0; i--) {
        float rgb[3];
        color_map_patch((uint32_t)(i + COLOR_PATCH_COUNT / 2) % COLOR_PATCH_COUNT, rgb);
        fprintf(script, ", \\\n $rows using %d:%d with filledcurves y1=0", COLUMN_TIME,
                COLUMN_STAGE + i);
        write_color(script, rgb);
        fprintf(script, " title '%s'", tulle_stage_name(i));
    }
    write_marks(script, COLUMN_ZONES, "impact zones", r->zones, 0);
    write_marks(script, COLUMN_COMPONENTS, "pieces scaled", r->components, 1);
    write_marks(script, COLUMN_GLOBAL, "time shortened", r->global, 2);
    write_marks(script, COLUMN_PINCHED, "pinched", r->pinched, 3);
    fputs("\n", script);
}

static void write_contacts(FILE *script, const plot_ranges *r) {
    begin_panel(script, 1, "contacts");
    fprintf(script,
            "set yrange [0:%.9g]\nplot $rows using %d:%d with lines lw 1.6 lc rgb '#222222' title "
            "'all'",
            r->contacts, COLUMN_TIME, COLUMN_CONTACTS);
    static const struct {
        int column;
        color_contact state;
    } states[] = {{COLUMN_STICK, COLOR_CONTACT_STICK},
                  {COLUMN_SLIP, COLOR_CONTACT_SLIP},
                  {COLUMN_NEW, COLOR_CONTACT_NEW},
                  {COLUMN_HARD, COLOR_CONTACT_HARD}};
    for (int i = 0; i < 4; i++) {
        float rgb[3];
        color_map_contact(states[i].state, rgb);
        fprintf(script, ", \\\n $rows using %d:%d with lines lw 1.3", COLUMN_TIME,
                states[i].column);
        write_color(script, rgb);
        fprintf(script, " title '%s'", color_map_contact_name(states[i].state));
    }
    fputs("\n", script);
}

static void write_gap(FILE *script, const plot_content *content, const plot_ranges *r) {
    double least = INFINITY;
    for (size_t i = 0; i < content->report_count; i++)
        if (content->reports[i].smallest_gap > 0.0) /* infinite: nothing near */
            least = fmin(least, 1000.0 * content->reports[i].smallest_gap);
    begin_panel(script, 2, "smallest gap [mm]");
    fprintf(script, "set logscale y; set format y '10^{%%L}'; set yrange [%.9g:%.9g]\n", r->gap.low,
            r->gap.high);
    if (isfinite(least))
        fprintf(
            script,
            "plot $rows using %d:%d with lines lw 1.3 lc rgb '#1b6ab3' title 'smallest gap', \\\n"
            " %.9g with lines dt 2 lc rgb '#c03020' title sprintf('least: %%.3g mm', %.9g)\n",
            COLUMN_TIME, COLUMN_GAP, least, least);
    else
        fputs("plot NaN title 'nothing came near'\n", script);
    fputs("unset logscale y; set format y '%g'\n", script);
}

static void write_energies(FILE *script, const plot_ranges *r) {
    begin_panel(script, 3, "energy [J]");
    fprintf(script, "set yrange [%.9g:%.9g]\nplot NaN notitle", r->energy.low, r->energy.high);
    write_curve(script, COLUMN_ENERGY, "total", "lw 1.8 lc rgb '#222222'");
    write_curve(script, COLUMN_GRAVITY, "gravity", "lw 1.3 lc rgb '#1b6ab3'");
    write_curve(script, COLUMN_ELASTIC, "elastic", "lw 1.3 lc rgb '#e8642c'");
    write_curve(script, COLUMN_KINETIC, "kinetic", "lw 1.3 lc rgb '#2c9a57'");
    fputs("\n", script);
}

static void write_solves(FILE *script, const plot_ranges *r) {
    begin_panel(script, 4, "CG iterations");
    fprintf(script,
            "set yrange [0:%.9g]; set ytics nomirror\n"
            "set logscale y2; set y2range [%.9g:%.9g]; set y2tics format '10^{%%L}'\n"
            "plot NaN notitle",
            r->iterations, r->residual.low, r->residual.high);
    write_curve(script, COLUMN_ITERATIONS, "iterations", "lw 1.3 lc rgb '#1b6ab3'");
    write_curve(script, COLUMN_RESIDUAL, "residual (right)", "axes x1y2 lw 1.0 lc rgb '#e8a33c'");
    fputs("\nunset logscale y2; unset y2tics; set ytics mirror\n", script);
}

void plot_write_script(FILE *script, const plot_content *content, const char *terminal) {
    plot_ranges const ranges = measure_ranges(content);
    fputs("set datafile missing '?'\n$rows << END_OF_ROWS\n", script);
    for (size_t i = 0; i < content->report_count; i++)
        write_row(script, &content->reports[i], &ranges);
    fprintf(script, "END_OF_ROWS\nset encoding utf8\nset terminal %s\nset multiplot title ",
            terminal);
    write_quoted(script, content->name);
    fprintf(script,
            " noenhanced font ',13'\n"
            "set lmargin at screen 0.09; set rmargin at screen 0.735\n"
            "set key Left reverse samplen 1.6 spacing 0.95 font ',9'\n"
            "set key at screen 0.795, graph 1.0 left top noenhanced\n"
            "set border lc rgb '#555555' lw 0.8; set tics font ',9' textcolor rgb '#333333'\n"
            "set grid lc rgb '#dddddd' lt 1 lw 0.6; set format x ''\n"
            "set xrange [0:%.9g]\n",
            ranges.time);
    write_times(script, &ranges);
    write_contacts(script, &ranges);
    write_gap(script, content, &ranges);
    write_energies(script, &ranges);
    write_solves(script, &ranges);
    begin_panel(script, 5, "max stretch [%]");
    fprintf(script, "set yrange [0:%.9g]\nplot NaN notitle", ranges.stretch);
    write_curve(script, COLUMN_STRETCH, "longest edge", "lw 1.3 lc rgb '#b5308a'");
    fputs("\nunset multiplot\n", script);
}
