/* fuzz/targets/detect.c - the detector beside all pairs in rational arithmetic: up to three small
 * surfaces that move twice, so that what was kept from the first call is checked in the second. No
 * pair is missed, by no method; and no method has events that the plain trees have not. */
#include "support/detect_scene.h"
#include "support/soup.h"

#include "detect/detector/detector_parts.h"

#include <math.h>
#include <string.h>

enum {
    SURFACES_MAX = 3,
    SIDE_MAX = 3,  /* squares along the side of a sheet */
    LOOSE_MAX = 5, /* triangles that share corners at random */
    STATES = 3,
    CHOICE_BYTES = 5
};

static detect_scene scene;
static detect_truths truths;
static double states[STATES][3 * DETECT_MAX_VERTICES];

static void add_triangle(uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *const corners = scene.triangles + 3 * scene.triangle_count++;
    corners[0] = a, corners[1] = b, corners[2] = c;
}

/* A sheet whose vertices lie as the bytes say, about a flat one or anywhere. */
static void take_sheet(fuzz_bytes *bytes, soup_places places) {
    uint32_t const columns = 1 + fuzz_take_below(bytes, SIDE_MAX);
    uint32_t const rows = 1 + fuzz_take_below(bytes, SIDE_MAX), base = (uint32_t)scene.vertex_count;
    double const roughness = fuzz_take_below(bytes, 3) / 2.0;
    double sway[STATES][3];
    for (int s = 0; s < STATES; s++) soup_take_points(bytes, places, 1, sway[s]);
    for (uint32_t i = 0; i <= columns; i++)
        for (uint32_t j = 0; j <= rows; j++) {
            double const flat[3] = {i, j, 0.0};
            size_t const at = 3 * scene.vertex_count++;
            for (int s = 0; s < STATES; s++) {
                double rough[3];
                soup_take_points(bytes, places, 1, rough);
                for (size_t k = 0; k < 3; k++)
                    states[s][at + k] = flat[k] + sway[s][k] + roughness * rough[k];
            }
        }
    for (uint32_t i = 0; i < columns; i++)
        for (uint32_t j = 0; j < rows; j++) {
            uint32_t const a = base + i * (rows + 1) + j, b = a + rows + 1;
            add_triangle(a, b, a + 1);
            add_triangle(b, b + 1, a + 1);
        }
}

static void take_loose(fuzz_bytes *bytes, soup_places places) {
    uint32_t const vertex_count = 3 + fuzz_take_below(bytes, 2 * LOOSE_MAX);
    uint32_t const base = (uint32_t)scene.vertex_count;
    for (uint32_t left = 1 + fuzz_take_below(bytes, LOOSE_MAX); left > 0; left--) {
        uint32_t const a = fuzz_take_below(bytes, vertex_count);
        uint32_t const b = (a + 1 + fuzz_take_below(bytes, vertex_count - 1)) % vertex_count;
        uint32_t c = fuzz_take_below(bytes, vertex_count);
        while (c == a || c == b) c = (c + 1) % vertex_count;
        add_triangle(base + a, base + b, base + c);
    }
    for (int s = 0; s < STATES; s++)
        soup_take_points(bytes, places, vertex_count, states[s] + 3 * (size_t)base);
    scene.vertex_count += vertex_count;
}

static void take_surface(fuzz_bytes *bytes, soup_places places) {
    static const double thicknesses[] = {0.0, 0.0, 0.01, 0.5};
    unsigned const kind = fuzz_take(bytes);
    tulle_detect_surface surface = {.vertex_begin = (uint32_t)scene.vertex_count,
                                    .triangle_begin = (uint32_t)scene.triangle_count,
                                    .thickness = thicknesses[kind / 2 % 4],
                                    .is_obstacle = kind / 8 % 4 == 0,
                                    .ignores_self = kind / 32 % 4 == 0};
    if (kind % 2)
        take_sheet(bytes, places);
    else
        take_loose(bytes, places);
    surface.vertex_end = (uint32_t)scene.vertex_count;
    surface.triangle_end = (uint32_t)scene.triangle_count;
    scene.surfaces[scene.surface_count++] = surface;
}

/* Moves what lies at the border of the lattice so far that floats cannot hold sums of it. */
static void go_far(double *points) {
    for (size_t i = 0; i < 3 * scene.vertex_count; i++)
        if (fabs(points[i]) >= 2.0) points[i] *= 1e38;
}

static void take_scene(fuzz_bytes *bytes) {
    scene.triangle_count = scene.vertex_count = scene.surface_count = 0;
    soup_places const places = (soup_places)fuzz_take_below(bytes, SOUP_PLACES_COUNT);
    uint32_t const choice = fuzz_take_below(bytes, 3);
    scene.minimum_separation = choice == 1 ? 1e-3 : 0.0;
    unsigned const pairs = fuzz_take(bytes);
    for (uint32_t left = 1 + fuzz_take_below(bytes, SURFACES_MAX); left > 0; left--)
        take_surface(bytes, places);
    if (choice == 2) go_far(states[STATES - 1]);
    scene.has_collides = pairs % 4 == 0;
    for (size_t i = 0, bit = 2; i < scene.surface_count; i++)
        for (size_t j = 0; j <= i; j++, bit++)
            scene.collides[i * scene.surface_count + j] =
                scene.collides[j * scene.surface_count + i] = !(pairs >> bit & 1);
}

static tulle_detector *make_detector(const tulle_detect_def *def) {
    tulle_detector *detector = NULL;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_detector_create(def, &detector, &error), &error);
    detector->keeps_all_patches = true; /* also on meshes so small that patches do not pay */
    return detector;
}

/* The def of the scene with a method. */
static tulle_detect_def take_def(fuzz_bytes *bytes) {
    static const double degrees[] = {10.0, 30.0, 60.0, 89.0};
    tulle_detect_def def = detect_scene_get_def(&scene);
    def.method = (tulle_detect_method)fuzz_take_below(bytes, TULLE_DETECT_PAPER + 1);
    def.cone = (tulle_detect_cone)fuzz_take_below(bytes, 2);
    def.max_angle = degrees[fuzz_take_below(bytes, 4)] * 3.14159265358979 / 180.0;
    def.grows_patches_anew = (int)fuzz_take_below(bytes, 2);
    def.threads = 1 + (int)fuzz_take_below(bytes, 2);
    return def;
}

/* All events are, bit for bit, among those of the reference, which is sorted alike. */
static void check_subset(const tulle_detect_result *result, const tulle_detect_result *reference) {
    size_t at = 0;
    for (size_t i = 0; i < result->event_count; i++, at++) {
        while (at < reference->event_count &&
               memcmp(&result->events[i], &reference->events[at], sizeof *result->events) != 0)
            at++;
        FUZZ_CHECK(at < reference->event_count);
    }
}

/* Copies what comes, to compare it with what is found. */
typedef struct event_list {
    const tulle_detect_event *expected;
    size_t count;
} event_list;

static int receive(void *context, const tulle_detect_event *events, size_t count) {
    event_list *const list = context;
    FUZZ_CHECK(memcmp(events, list->expected + list->count, count * sizeof *events) == 0);
    list->count += count;
    return 0;
}

/* Streaming and the earliest event agree with `found`, which another detector owns. */
static void check_other_calls(tulle_detector *detector, const tulle_detect_result *found) {
    tulle_error error = {0};
    event_list list = {.expected = found->events};
    tulle_detect_receiver const receiver = {receive, &list};
    tulle_detect_result result;
    FUZZ_CHECK_OK(
        tulle_detector_stream_events(detector, scene.start, scene.end, receiver, &result, &error),
        &error);
    FUZZ_CHECK(list.count == found->event_count && result.earliest_time == found->earliest_time);
    FUZZ_CHECK_OK(tulle_detector_find_earliest(detector, scene.start, scene.end, &result, &error),
                  &error);
    FUZZ_CHECK(result.earliest_time == found->earliest_time);
    FUZZ_CHECK(result.event_count == (found->event_count > 0));
    for (size_t i = 0; i < found->event_count; i++) {
        if (found->events[i].time != found->earliest_time) continue;
        FUZZ_CHECK(memcmp(&found->events[i], &result.events[0], sizeof *result.events) == 0);
        return;
    }
}

static void check_motion(tulle_detector *plain, tulle_detector *detector, bool has_patches) {
    tulle_detect_result reference, result;
    tulle_error error = {0};
    detect_scene_find_truths(&scene, &truths);
    FUZZ_CHECK_OK(tulle_detector_find_events(plain, scene.start, scene.end, &reference, &error),
                  &error);
    detect_events_check(&scene, reference.events, reference.event_count);
    FUZZ_CHECK(detect_events_contain(&truths, reference.events, reference.event_count));
    FUZZ_CHECK_OK(tulle_detector_find_events(detector, scene.start, scene.end, &result, &error),
                  &error);
    FUZZ_CHECK(detect_events_contain(&truths, result.events, result.event_count));
    check_subset(&result, &reference);
    FUZZ_CHECK(has_patches || result.event_count == reference.event_count);
    if (!has_patches) check_other_calls(detector, &reference);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_bytes bytes = {data, size, 0};
    soup_pool_numbers();
    /* The method stands in front: a change of the scene leaves it. */
    fuzz_bytes choices = fuzz_take_part(&bytes, CHOICE_BYTES);
    take_scene(&bytes);
    tulle_detect_def const def = take_def(&choices);
    tulle_detect_def plain_def = detect_scene_get_def(&scene);
    plain_def.method = TULLE_DETECT_REFIT;
    plain_def.threads = 1;
    bool const has_patches = def.method == TULLE_DETECT_PATCHES || def.method == TULLE_DETECT_PAPER;
    tulle_detector *const plain = make_detector(&plain_def), *const detector = make_detector(&def);
    for (int s = 0; s + 1 < STATES; s++) {
        memcpy(scene.start, states[s], 3 * scene.vertex_count * sizeof(double));
        memcpy(scene.end, states[s + 1], 3 * scene.vertex_count * sizeof(double));
        check_motion(plain, detector, has_patches);
    }
    tulle_detector_destroy(plain);
    tulle_detector_destroy(detector);
    return 0;
}

void fuzz_make_seeds(void) { fuzz_put_random_seeds(24, 400); }
