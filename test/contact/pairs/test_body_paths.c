/* Paths of rigid bodies: orientations among positions, and how far arcs leave their chords. */
#include "contact/pairs/body_paths.h"

#include "base/hash.h"
#include "support/test_support.h"

static double draw(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

static quaternion draw_rotation(uint64_t *random) {
    return quaternion_normalize(
        (quaternion){draw(random), draw(random), draw(random), draw(random)});
}

static void orientations_come_back(void **state) {
    (void)state;
    uint64_t random = 5;
    for (int i = 0; i < 10000; i++) {
        quaternion q = draw_rotation(&random);
        if (i % 3 == 0) q.w = 1e-17 * draw(&random); /* half turns */
        q = quaternion_normalize(q);
        vec3 const packed = pack_orientation(q);
        assert_true(vec3_norm(packed) <= 1.0 + 1e-15);
        quaternion const back = unpack_orientation(packed);
        double const sign = q.w < 0.0 ? -1.0 : 1.0;
        assert_true(fabs(back.w - sign * q.w) < 4e-16 && fabs(back.x - sign * q.x) < 4e-16 &&
                    fabs(back.y - sign * q.y) < 4e-16 && fabs(back.z - sign * q.z) < 4e-16);
        vec3 const again = pack_orientation(back);
        /* a half turn has two */
        assert_true(fmin(vec3_norm(vec3_sub(again, packed)), vec3_norm(vec3_add(again, packed))) <
                    1e-15);
    }
}

/* The largest way of a point of a free body from its chord over r angle^2. */
static double measure_arc(uint64_t *random, double angle) {
    double const a = random_uniform(random) + 0.01, b = random_uniform(random) + 0.01;
    double const c = fabs(a - b) + (a + b - fabs(a - b)) * random_uniform(random);
    rigid_body const body = {.mass = 1.0, .moments = {a, b, c}}; /* a true body's moments */
    rigid_state const start = {.orientation = draw_rotation(random)};
    rigid_state moving = start;
    vec3 const axis = vec3_normalize(vec3_make(draw(random), draw(random), draw(random)));
    moving.spin = rigid_compute_spin(&body, start.orientation, vec3_scale(axis, angle));
    double const point[3] = {draw(random), draw(random), draw(random)};
    double ends[2][3], now[3], largest = 0.0;
    rigid_state end = moving;
    assert_true(rigid_drift(&body, start.velocity, 1.0, &end));
    rigid_place(&moving, point, 1, ends[0]);
    rigid_place(&end, point, 1, ends[1]);
    for (int i = 1; i < 16; i++) {
        rigid_state middle = moving;
        assert_true(rigid_drift(&body, start.velocity, i / 16.0, &middle));
        rigid_place(&middle, point, 1, now);
        vec3 const chord = vec3_lerp(vec3_load(ends[0], 0), vec3_load(ends[1], 0), i / 16.0);
        largest = fmax(largest, vec3_norm(vec3_sub(vec3_load(now, 0), chord)));
    }
    return largest / (vec3_norm(vec3_load(point, 0)) * angle * angle);
}

static void arcs_stay_near_their_chords(void **state) {
    (void)state;
    uint64_t random = 7;
    double largest = 0.0;
    for (int i = 0; i < 20000; i++)
        largest = fmax(largest, measure_arc(&random, BODY_TURN_MAX * random_uniform(&random)));
    print_message("arcs leave chords by %.3f r angle^2 at most\n", largest);
    assert_true(largest <= BODY_CHORD_FACTOR);
    assert_true(largest > 0.12); /* the bound of a plain turn is an eighth */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orientations_come_back),
        cmocka_unit_test(arcs_stay_near_their_chords),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
