/* app/detect/text.c - the report of `tulle detect` as text. */
#include "app/detect/report.h"
#include "base/parallel.h"
#include "base/words.h"
#include "io/text/number.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static const double DEGREES_PER_RADIAN = 57.29577951308232;
static const double MILLISECONDS_PER_SECOND = 1e3;

static void print_method(const detect_passes *passes) {
    const tulle_detect_def *const def = &passes->def;
    printf("  %-18s %s", "method", method_words[def->method]);
    if (detect_has_patches(passes))
        printf(": cones %s, up to %.6g deg, patches %s, certificate %s", cone_words[def->cone],
               def->max_angle * DEGREES_PER_RADIAN,
               def->grows_patches_anew || def->method == TULLE_DETECT_PAPER ? "grown anew" : "kept",
               def->has_certificate ? "on" : "off");
    printf("\n  %-18s %.6g m\n", "separation", def->thickness + def->minimum_separation);
    printf("  %-18s %d\n", "threads", parallel_resolve_threads(def->threads));
}

static void print_crossings(const detect_report *report) {
    if (report->crossing_count > DETECT_CROSSINGS_MAX)
        printf("  %-18s itself in more than %" PRIu64 " pairs of triangles\n", "start crosses",
               DETECT_CROSSINGS_MAX);
    else if (report->crossing_count > 0)
        printf("  %-18s itself in %" PRIu64 " pairs of triangles\n", "start crosses",
               report->crossing_count);
}

static void print_event_row(const detect_passes *passes, const char *label,
                            tulle_detect_state state) {
    printf("  %-18s %14" PRIu64 " %14" PRIu64 " %14" PRIu64 "\n", label,
           passes->event_counts[TULLE_DETECT_VERTEX_FACE][state],
           passes->event_counts[TULLE_DETECT_EDGE_EDGE][state], detect_count_state(passes, state));
}

static void print_events(const detect_passes *passes) {
    printf("%-20s %14s %14s %14s\n", passes->is_earliest ? "earliest event" : "events",
           "vertex/face", "edge/edge", "all");
    print_event_row(passes, "touching at start", TULLE_DETECT_TOUCHING_AT_START);
    print_event_row(passes, "hits", TULLE_DETECT_HIT);
    print_event_row(passes, "unresolved", TULLE_DETECT_UNRESOLVED);
    printf("  %-18s %14" PRIu64 " %14" PRIu64 " %14zu\n", "all",
           detect_count_kind(passes, TULLE_DETECT_VERTEX_FACE),
           detect_count_kind(passes, TULLE_DETECT_EDGE_EDGE), passes->result.event_count);
    if (passes->result.event_count == 0) {
        printf("  %-18s none\n", "earliest time");
        return;
    }
    printf("  %-18s %.9g", "earliest time", passes->result.earliest_time);
    if (isfinite(passes->earliest_hit) && passes->earliest_hit > passes->result.earliest_time)
        printf(", of those that do not touch at the start %.9g", passes->earliest_hit);
    putchar('\n');
}

static void print_count(const char *label, uint64_t count) {
    printf("  %-18s %14" PRIu64 "\n", label, count);
}

static void print_candidates(const detect_passes *passes) {
    const tulle_detect_statistics *const statistics = &passes->result.statistics;
    puts("candidates, vertex/face and edge/edge");
    if (passes->has_bare_search)
        print_count("box pairs", passes->bare_box_pairs);
    else if (!statistics->uses_patches)
        print_count("box pairs", statistics->box_pairs);
    print_count("after patches", statistics->box_pairs);
    print_count("after the filter", statistics->filtered_pairs);
    print_count("tested", statistics->tested_pairs);
}

static void print_patches(const detect_passes *passes) {
    const tulle_detect_statistics *const statistics = &passes->result.statistics;
    if (!detect_has_patches(passes)) return;
    puts("patches");
    if (!statistics->uses_patches) {
        puts("  none in use: none is proven, or they would not pay");
        return;
    }
    printf("  %-18s %14" PRIu64 "  with %.4g %% of the triangles\n",
           passes->def.has_certificate ? "certified" : "not certified", statistics->patch_count,
           100.0 * (double)statistics->patch_triangles / (double)passes->def.triangle_count);
    if (passes->def.has_certificate) {
        print_count("  by star", statistics->certified_by_star);
        print_count("  by contour", statistics->certified_by_contour);
        print_count("dissolved", statistics->uncertified_count);
    }
    print_count("kept from before", statistics->checked_again);
}

static void print_times(const detect_passes *passes) {
    static const char *const labels[DETECT_STAGE_COUNT] = {
        "patches",          "trees",  "search", "  traversal", "  filter",
        "  time of impact", "events", "total"};
    if (passes->repeat_count == 0)
        printf("%-20s %14s\n", "times [ms]", "one call");
    else
        printf("%-20s %14s %14s %14s  of %u further calls\n", "times [ms]", "first call", "median",
               "minimum", (unsigned)passes->repeat_count);
    for (int stage = 0; stage < DETECT_STAGE_COUNT; stage++) {
        const detect_times *const times = &passes->times[stage];
        printf("  %-18s %14.4f", labels[stage], times->first * MILLISECONDS_PER_SECOND);
        if (passes->repeat_count > 0)
            printf(" %14.4f %14.4f", times->median * MILLISECONDS_PER_SECOND,
                   times->minimum * MILLISECONDS_PER_SECOND);
        putchar('\n');
    }
}

static void print_warning(const detect_passes *passes) {
    if (!detect_has_patches(passes) || passes->def.has_certificate) return;
    puts("COLLISIONS MAY BE MISSED: with the certificate off, patches are skipped by their cones "
         "alone");
    if (passes->has_bare_search)
        printf("  the same search without patches finds %" PRIu64 " events\n",
               passes->bare_event_count);
}

static void print_list(const detect_passes *passes) {
    char time[NUMBER_TEXT_SIZE];
    for (size_t i = 0; i < passes->result.event_count; i++) {
        const tulle_detect_event *const event = &passes->result.events[i];
        const uint32_t *const v = event->vertices;
        printf("%s ", detect_kind_names[event->kind]);
        if (event->kind == TULLE_DETECT_VERTEX_FACE)
            printf("%" PRIu32 " %" PRIu32, v[0], event->face);
        else
            printf("%" PRIu32 "-%" PRIu32 " %" PRIu32 "-%" PRIu32, v[0], v[1], v[2], v[3]);
        number_format_double(event->time, time);
        printf(" %s %s\n", time, detect_state_names[event->state]);
        if (i % DETECT_LIST_STRIDE == 0 && ferror(stdout)) return;
    }
}

void detect_report_text(const detect_report *report, const detect_passes *passes) {
    printf("%s to %s\n", report->start_path, report->end_path);
    printf("  %-18s %zu vertices, %zu triangles\n", "mesh", passes->def.vertex_count,
           passes->def.triangle_count);
    print_crossings(report);
    print_method(passes);
    print_events(passes);
    print_candidates(passes);
    print_patches(passes);
    print_times(passes);
    print_warning(passes);
    if (report->has_list) print_list(passes);
}
