/* The detector on data: two surfaces that pass through themselves between two clean frames, and a
 * frame of a published simulation with its published truth. */
#include "support/query_file.h"
#include "support/test_support.h"
#include "tulle/detect.h"
#include "tulle/mesh.h"
#include "tulle_io/mesh_files.h"

#include <stdlib.h>
#include <string.h>

static tulle_mesh read_mesh(const char *name) {
    char path[2048];
    tulle_mesh mesh = {0};
    tulle_error error;
    snprintf(path, sizeof path, "%s/%s", getenv("TULLE_DATA_DIR"), name);
    tulle_status const status = tulle_mesh_read(path, &mesh, &error);
    if (status != TULLE_OK) print_error("%s: %s\n", path, error.message);
    assert_int_equal(status, TULLE_OK);
    return mesh;
}

/* Two frames of one surface. */
typedef struct frames {
    tulle_mesh start, end;
} frames;

static frames read_frames(const char *start, const char *end) {
    frames const both = {read_mesh(start), read_mesh(end)};
    assert_int_equal(both.start.vertex_count, both.end.vertex_count);
    return both;
}

static void destroy_frames(frames *both) {
    tulle_mesh_destroy(&both->start);
    tulle_mesh_destroy(&both->end);
}

static double degrees(double angle) { return angle * 3.14159265358979 / 180.0; }

static tulle_detect_def make_def(const frames *of, tulle_detect_method method) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = of->start.triangles;
    def.triangle_count = of->start.triangle_count;
    def.vertex_count = of->start.vertex_count;
    def.method = method;
    def.max_angle = degrees(89.0);
    def.threads = 1;
    return def;
}

static tulle_detector *find(const tulle_detect_def *def, const frames *of,
                            tulle_detect_result *result) {
    tulle_error error;
    tulle_detector *detector;
    assert_int_equal(tulle_detector_create(def, &detector, &error), TULLE_OK);
    assert_int_equal(tulle_detector_find_events(detector, of->start.positions, of->end.positions,
                                                result, &error),
                     TULLE_OK);
    return detector;
}

static const char *const method_names[] = {"patches", "refit", "bvox", "paper"};

/* Every method finds the same events with the certificate; the paper's own rule puts the whole
 * surface into one patch and finds none. */
static void passes_through_itself(const char *name) {
    char start[64], end[64];
    snprintf(start, sizeof start, "synthetic/%s_t0.obj", name);
    snprintf(end, sizeof end, "synthetic/%s_t1.obj", name);
    frames both = read_frames(start, end);
    size_t expected = 0;
    for (int variant = 0; variant < 16; variant++) {
        tulle_detect_method const method = (tulle_detect_method)(variant % 4);
        tulle_detect_def def = make_def(&both, method);
        def.cone = variant / 4 % 2 ? TULLE_CONE_PAPER : TULLE_CONE_BERNSTEIN;
        def.grows_patches_anew = variant / 8;
        tulle_detect_result result;
        tulle_detector *const detector = find(&def, &both, &result);
        if (expected == 0) expected = result.event_count;
        assert_true(result.event_count > 0 && result.event_count == expected);
        tulle_detector_destroy(detector);
    }
    print_message("%-6s %zu events by every method\n", name, expected);
    for (int method = 0; method < 4; method++) {
        tulle_detect_def def = make_def(&both, (tulle_detect_method)method);
        bool const has_patches = method == TULLE_DETECT_PATCHES || method == TULLE_DETECT_PAPER;
        def.has_certificate = 0;
        tulle_detect_result result;
        tulle_detector *const detector = find(&def, &both, &result);
        print_message("%-6s %zu events by %s without certificate, in %llu patches\n", name,
                      result.event_count, method_names[method],
                      (unsigned long long)result.statistics.patch_count);
        if (has_patches) {
            assert_int_equal(result.statistics.patch_count, 1);
            assert_int_equal(result.statistics.patch_triangles, both.start.triangle_count);
        }
        assert_int_equal(result.event_count, has_patches ? 0 : expected);
        tulle_detector_destroy(detector);
    }
    destroy_frames(&both);
}

static void the_ramp_passes_through_itself(void **state) {
    (void)state;
    passes_through_itself("ramp");
}

static void the_ring_passes_through_itself(void **state) {
    (void)state;
    passes_through_itself("cring");
}

/* ---- published truth ---- */

/* Vertices by where they are at both ends. */
typedef struct placed_vertex {
    double place[6];
    uint32_t vertex;
} placed_vertex;

static int compare_places(const void *first, const void *second) {
    const placed_vertex *const a = first, *const b = second;
    for (int k = 0; k < 6; k++)
        if (a->place[k] != b->place[k]) return a->place[k] < b->place[k] ? -1 : 1;
    return 0;
}

static placed_vertex *sort_vertices(const frames *of) {
    size_t const count = of->start.vertex_count;
    placed_vertex *const sorted = malloc(count * sizeof *sorted);
    assert_non_null(sorted);
    for (size_t v = 0; v < count; v++) {
        memcpy(sorted[v].place, of->start.positions + 3 * v, 3 * sizeof(double));
        memcpy(sorted[v].place + 3, of->end.positions + 3 * v, 3 * sizeof(double));
        sorted[v].vertex = (uint32_t)v;
    }
    qsort(sorted, count, sizeof *sorted, compare_places);
    for (size_t v = 1; v < count; v++) assert_true(compare_places(&sorted[v - 1], &sorted[v]) < 0);
    return sorted;
}

static uint32_t find_vertex(const placed_vertex *sorted, size_t count, vec3 start, vec3 end) {
    placed_vertex const wanted = {{start.x, start.y, start.z, end.x, end.y, end.z}, 0};
    const placed_vertex *const found =
        bsearch(&wanted, sorted, count, sizeof *sorted, compare_places);
    assert_non_null(found);
    return found->vertex;
}

static bool has_both(const uint32_t *set, size_t set_count, const uint32_t *wanted,
                     size_t wanted_count) {
    for (size_t i = 0; i < wanted_count; i++) {
        size_t k = 0;
        while (k < set_count && set[k] != wanted[i]) k++;
        if (k == set_count) return false;
    }
    return true;
}

/* Whether an event has these features, in either order of edges and in any order of corners. */
static bool is_reported(const tulle_detect_result *result, tulle_detect_kind kind,
                        const uint32_t vertices[4]) {
    for (size_t i = 0; i < result->event_count; i++) {
        const tulle_detect_event *const event = &result->events[i];
        if (event->kind != kind) continue;
        if (kind == TULLE_DETECT_VERTEX_FACE) {
            if (event->vertices[0] == vertices[0] &&
                has_both(event->vertices + 1, 3, vertices + 1, 3))
                return true;
        } else if ((has_both(event->vertices, 2, vertices, 2) &&
                    has_both(event->vertices + 2, 2, vertices + 2, 2)) ||
                   (has_both(event->vertices, 2, vertices + 2, 2) &&
                    has_both(event->vertices + 2, 2, vertices, 2))) {
            return true;
        }
    }
    return false;
}

static void check_truths(const tulle_detect_result *result, const placed_vertex *sorted,
                         size_t vertex_count, const char *method) {
    static const char *const names[2][2] = {
        {"cloth-funnel/queries/227vf.csv", "cloth-funnel/mma_bool/227vf_mma_bool.json"},
        {"cloth-funnel/queries/227ee.csv", "cloth-funnel/mma_bool/227ee_mma_bool.json"}};
    for (int kind = 0; kind < 2; kind++) {
        FILE *const queries = open_data(names[kind][0]), *const answers = open_data(names[kind][1]);
        moving_pair pair;
        int unused, collision_count = 0, query_count = 0;
        size_t event_count = 0;
        while (read_query(queries, &pair, &unused)) {
            uint32_t vertices[4];
            for (int k = 0; k < 4; k++)
                vertices[k] = find_vertex(sorted, vertex_count, pair.start[k], pair.end[k]);
            bool const collides = read_boolean(answers) == 1;
            query_count++;
            collision_count += collides;
            if (collides) assert_true(is_reported(result, (tulle_detect_kind)kind, vertices));
        }
        for (size_t i = 0; i < result->event_count; i++)
            event_count += (int)result->events[i].kind == kind;
        print_message("%-8s %s: %d of %d published queries collide, all found; %zu events\n",
                      method, kind == 0 ? "vertex/face" : "edge/edge", collision_count, query_count,
                      event_count);
        assert_true(collision_count > 0);
        fclose(queries);
        fclose(answers);
    }
}

static void the_published_frame_loses_nothing(void **state) {
    (void)state;
    frames both = read_frames("cloth-funnel/frames/227.ply", "cloth-funnel/frames/228.ply");
    placed_vertex *const sorted = sort_vertices(&both);
    for (int method = 0; method < 4; method++) {
        tulle_detect_def def = make_def(&both, (tulle_detect_method)method);
        def.max_angle = degrees(60.0);
        tulle_detect_result result;
        tulle_detector *const detector = find(&def, &both, &result);
        check_truths(&result, sorted, both.start.vertex_count, method_names[method]);
        tulle_detector_destroy(detector);
    }
    free(sorted);
    destroy_frames(&both);
}

int main(void) {
    if (!find_data_path("synthetic/ramp_t0.obj") ||
        !find_data_path("cloth-funnel/frames/227.ply")) {
        printf("skipped: TULLE_DATA_DIR names no folder with synthetic and cloth-funnel\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_ramp_passes_through_itself),
        cmocka_unit_test(the_ring_passes_through_itself),
        cmocka_unit_test(the_published_frame_loses_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
