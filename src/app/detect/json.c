/* app/detect/json.c - the report of `tulle detect` as one JSON document, a line for each member of
 * the whole and for each event. */
#include "app/cli/json_text.h"
#include "app/detect/report.h"
#include "base/parallel.h"
#include "base/words.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static const double DEGREES_PER_RADIAN = 57.29577951308232;
static const double MILLISECONDS_PER_SECOND = 1e3;

/* Members of an object, with what stands before them: a comma, or nothing. */
static void print_number(const char *before, const char *key, double value) {
    printf("%s\"%s\":", before, key);
    json_print_double(stdout, value);
}

static void print_count(const char *before, const char *key, uint64_t value) {
    printf("%s\"%s\":%" PRIu64, before, key, value);
}

static const char *bool_name(bool value) { return value ? "true" : "false"; }

static void print_settings(const detect_passes *passes) {
    const tulle_detect_def *const def = &passes->def;
    printf("\"settings\":{\"method\":\"%s\",\"cone\":\"%s\"", method_words[def->method],
           cone_words[def->cone]);
    printf(",\"alpha_max_degrees\":%.12g", def->max_angle * DEGREES_PER_RADIAN);
    printf(",\"certificate\":%s,\"patches\":\"%s\"", bool_name(def->has_certificate != 0),
           def->grows_patches_anew || def->method == TULLE_DETECT_PAPER ? "grow" : "keep");
    print_number(",", "thickness", def->thickness);
    print_number(",", "minimum_separation", def->minimum_separation);
    print_count(",", "threads", (uint64_t)parallel_resolve_threads(def->threads));
    print_count(",", "repeat", passes->repeat_count);
    printf(",\"earliest\":%s},\n", bool_name(passes->is_earliest));
}

static void print_events(const detect_report *report, const detect_passes *passes) {
    printf("\"events\":{\"complete\":%s", bool_name(detect_is_complete(passes)));
    print_count(",", "all", passes->result.event_count);
    print_count(",", "vertex_face", detect_count_kind(passes, TULLE_DETECT_VERTEX_FACE));
    print_count(",", "edge_edge", detect_count_kind(passes, TULLE_DETECT_EDGE_EDGE));
    print_count(",", "hit", detect_count_state(passes, TULLE_DETECT_HIT));
    print_count(",", "touching_at_start",
                detect_count_state(passes, TULLE_DETECT_TOUCHING_AT_START));
    print_count(",", "unresolved", detect_count_state(passes, TULLE_DETECT_UNRESOLVED));
    if (report->crossing_count <= DETECT_CROSSINGS_MAX)
        print_count(",", "crossing_at_start", report->crossing_count);
    else
        printf(",\"crossing_at_start\":null");
    print_number(",", "earliest_time",
                 passes->result.event_count > 0 ? passes->result.earliest_time : (double)INFINITY);
    print_number(",", "earliest_hit_time", passes->earliest_hit);
    if (passes->has_bare_search)
        print_count(",", "without_patches", passes->bare_event_count);
    else
        printf(",\"without_patches\":null");
    puts("},");
}

static void print_counts(const detect_passes *passes) {
    const tulle_detect_statistics *const statistics = &passes->result.statistics;
    printf("\"counts\":{\"box_pairs\":");
    if (passes->has_bare_search)
        printf("%" PRIu64, passes->bare_box_pairs);
    else if (!statistics->uses_patches)
        printf("%" PRIu64, statistics->box_pairs);
    else
        printf("null");
    print_count(",", "after_patches", statistics->box_pairs);
    print_count(",", "after_filter", statistics->filtered_pairs);
    print_count(",", "tested", statistics->tested_pairs);
    print_count(",", "leaf_pairs", statistics->leaf_pairs);
    puts("},");
}

static void print_patches(const detect_passes *passes) {
    const tulle_detect_statistics *const statistics = &passes->result.statistics;
    double const share = (double)statistics->patch_triangles / (double)passes->def.triangle_count;
    printf("\"patches\":{\"used\":%s", bool_name(statistics->uses_patches != 0));
    print_count(",", "count", statistics->patch_count);
    print_count(",", "triangles", statistics->patch_triangles);
    print_number(",", "triangle_share", share);
    print_number(",", "certified_share", passes->def.has_certificate ? share : 0.0);
    print_count(",", "certified_by_star", statistics->certified_by_star);
    print_count(",", "certified_by_contour", statistics->certified_by_contour);
    print_count(",", "dissolved", statistics->uncertified_count);
    print_count(",", "checked_again", statistics->checked_again);
    puts("},");
}

static void print_times(const detect_passes *passes) {
    printf("\"time_ms\":{");
    for (int stage = 0; stage < DETECT_STAGE_COUNT; stage++) {
        const detect_times *const times = &passes->times[stage];
        printf("%s\"%s\":{", stage > 0 ? "," : "", detect_stage_names[stage]);
        print_number("", "first", times->first * MILLISECONDS_PER_SECOND);
        print_number(",", "median", times->median * MILLISECONDS_PER_SECOND);
        print_number(",", "minimum", times->minimum * MILLISECONDS_PER_SECOND);
        putchar('}');
    }
    putchar('}');
}

static void print_list(const detect_passes *passes) {
    printf(",\n\"list\":[");
    for (size_t i = 0; i < passes->result.event_count; i++) {
        const tulle_detect_event *const event = &passes->result.events[i];
        const uint32_t *const v = event->vertices;
        printf("%s\n{\"kind\":\"%s\",\"features\":", i > 0 ? "," : "",
               detect_kind_names[event->kind]);
        if (event->kind == TULLE_DETECT_VERTEX_FACE)
            printf("[%" PRIu32 ",%" PRIu32 "]", v[0], event->face);
        else
            printf("[[%" PRIu32 ",%" PRIu32 "],[%" PRIu32 ",%" PRIu32 "]]", v[0], v[1], v[2], v[3]);
        print_number(",", "time", event->time);
        printf(",\"state\":\"%s\"}", detect_state_names[event->state]);
        if (i % DETECT_LIST_STRIDE == 0 && ferror(stdout)) return;
    }
    putchar(']');
}

void detect_report_json(const detect_report *report, const detect_passes *passes) {
    printf("{\"format\":\"tulle detect\",\"format_version\":1,\n\"start\":");
    json_print_text(stdout, report->start_path);
    printf(",\"end\":");
    json_print_text(stdout, report->end_path);
    printf(",\n\"mesh\":{\"vertices\":%zu,\"triangles\":%zu},\n", passes->def.vertex_count,
           passes->def.triangle_count);
    print_settings(passes);
    print_events(report, passes);
    print_counts(passes);
    print_patches(passes);
    print_times(passes);
    if (report->has_list) print_list(passes);
    puts("}");
}
