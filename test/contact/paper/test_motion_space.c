/* Motion spaces: nearest points of half-spaces against problems built from a known optimum and
 * against the variational inequality; the cone algebra against sampled directions; sets without a
 * point by rule. */
#include "contact/paper/motion_space.h"
#include "support/test_support.h"

#include <stdlib.h>

#define RIGHT_ANGLE 1.5707963267948966
enum { PROBLEMS = 20000, MOST_SPACES = 40, SAMPLES = 40 };

static uint64_t random_state = 20050301;

/* splitmix64 */
static double draw(double low, double high) {
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return low + (high - low) * (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* Axes whose cross product has a smaller square than this span no plane. */
static const double OPPOSITE_SINE2 = 1e-24;

/* C1 ^ C2: the cone of the largest angle inside both. It is empty when they share at most their
 * tips. */
static canonical_cone intersect_cones(const canonical_cone *a, const canonical_cone *b) {
    canonical_cone const empty = {{0.0, 0.0, 0.0}, 0.0};
    if (!(vec3_norm2(a->axis) > 0.0) || !(vec3_norm2(b->axis) > 0.0)) return empty;
    vec3 const cross = vec3_cross(a->axis, b->axis);
    double const between = atan2(vec3_norm(cross), vec3_dot(a->axis, b->axis));
    if (between + a->angle <= b->angle) return *a;
    if (between + b->angle <= a->angle) return *b;
    if (between >= a->angle + b->angle || vec3_norm2(cross) < OPPOSITE_SINE2) return empty;
    /* the common arc runs on the great circle of the axes from between - b to a, seen from a */
    double const turn = 0.5 * (a->angle + between - b->angle);
    vec3 const across = vec3_normalize(vec3_cross(cross, a->axis));
    return (canonical_cone){
        vec3_normalize(vec3_add_scaled(vec3_scale(a->axis, cos(turn)), across, sin(turn))),
        0.5 * (a->angle + b->angle - between)};
}

/* C leaves open which of two arguments is computed first: whatever is drawn has a statement of its
 * own, so that all compilers make the same problems. */
static vec3 draw_direction(void) {
    for (;;) {
        vec3 v;
        v.x = draw(-1, 1);
        v.y = draw(-1, 1);
        v.z = draw(-1, 1);
        double const norm2 = vec3_norm2(v);
        if (norm2 > 0.01 && norm2 < 1.0) return vec3_scale(v, 1.0 / sqrt(norm2));
    }
}

static vec3 draw_vector(double size) {
    vec3 const direction = draw_direction();
    return vec3_scale(direction, draw(0.0, size));
}

static half_space draw_space(void) {
    vec3 const normal = draw_direction();
    return (half_space){normal, draw(-1.0, 1.0)};
}

static double angle_between(vec3 a, vec3 b) {
    return atan2(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}

/* A problem whose nearest point is known: v = best - sum of multipliers times active normals. */
typedef struct known_problem {
    half_space spaces[MOST_SPACES];
    size_t count;
    vec3 v, best;
    double conditioning; /* volume that the active normals span, 1: at right angles */
} known_problem;

static known_problem make_problem(void) {
    known_problem problem = {.best = draw_vector(2.0), .conditioning = 1.0};
    size_t const active = (size_t)draw(0.0, 3.999);
    problem.v = problem.best;
    for (size_t i = 0; i < active; i++) {
        vec3 const n = draw_direction();
        problem.spaces[i] = (half_space){n, vec3_dot(n, problem.best)};
        problem.v = vec3_add_scaled(problem.v, n, -draw(0.0, 1.0));
    }
    const half_space *const s = problem.spaces;
    if (active == 2) problem.conditioning = vec3_norm(vec3_cross(s[0].normal, s[1].normal));
    if (active == 3)
        problem.conditioning = fabs(vec3_dot(vec3_cross(s[0].normal, s[1].normal), s[2].normal));
    problem.count = active + (size_t)draw(0.0, (double)(MOST_SPACES - active));
    for (size_t i = active; i < problem.count; i++) {
        vec3 const n = i % 3 == 0 && active > 0 ? s[i % active].normal : draw_direction();
        /* Some are copies, some pass through the best point itself: where the active planes fix it
         * only loosely, rounding makes such a plane contradict them. */
        double const slack = i % 4 == 0 && problem.conditioning > 0.01 ? 0.0 : draw(0.0, 1.0);
        problem.spaces[i] = (half_space){n, vec3_dot(n, problem.best) - slack};
    }
    for (size_t i = problem.count; i-- > 1;) {
        size_t const j = (size_t)draw(0.0, (double)i + 0.999);
        half_space const moved = problem.spaces[i];
        problem.spaces[i] = problem.spaces[j];
        problem.spaces[j] = moved;
    }
    return problem;
}

static double find_most_missed(const half_space *spaces, size_t count, vec3 v) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, spaces[i].offset - vec3_dot(spaces[i].normal, v));
    return most;
}

static void finds_known_optima(void **state) {
    (void)state;
    double worst = 0.0, worst_violation = 0.0;
    for (int k = 0; k < PROBLEMS; k++) {
        known_problem const p = make_problem();
        vec3 found, again;
        assert_true(find_nearest_point(p.spaces, p.count, OFFSETS_AS_GIVEN, p.v, &found));
        double const error = vec3_norm(vec3_sub(found, p.best)) * p.conditioning;
        worst = fmax(worst, error);
        worst_violation = fmax(worst_violation, find_most_missed(p.spaces, p.count, found));
        assert_true(find_nearest_point(p.spaces, p.count, OFFSETS_AS_GIVEN, found, &again));
        assert_true(vec3_norm(vec3_sub(found, again)) * p.conditioning < 1e-12);
    }
    print_message("%d known optima: error %.2g, violation %.2g\n", PROBLEMS, worst,
                  worst_violation);
    assert_true(worst < 1e-12);
    assert_true(worst_violation < 1e-12);
}

/* x is nearest to v in a convex set when (v - x) . (y - x) <= 0 for all y of the set. Points y of
 * the intersection of half-spaces around `inside`: on rays until the first plane. */
static double find_worst_angle(const half_space *spaces, size_t count, vec3 inside, vec3 v,
                               vec3 x) {
    double worst = -1e300;
    for (int k = 0; k < SAMPLES; k++) {
        vec3 const direction = draw_direction();
        double reach = 10.0;
        for (size_t i = 0; i < count; i++) {
            double const speed = vec3_dot(spaces[i].normal, direction);
            double const room = vec3_dot(spaces[i].normal, inside) - spaces[i].offset;
            if (speed < 0.0) reach = fmin(reach, room / -speed);
        }
        vec3 const y = vec3_add_scaled(inside, direction, fmax(reach, 0.0));
        worst = fmax(worst, vec3_dot(vec3_sub(v, x), vec3_sub(y, x)));
    }
    return worst;
}

static void nothing_feasible_is_nearer(void **state) {
    (void)state;
    for (int k = 0; k < PROBLEMS; k++) {
        half_space spaces[MOST_SPACES];
        size_t const count = 1 + (size_t)draw(0.0, MOST_SPACES - 1.001);
        vec3 const inside = draw_vector(1.0), v = draw_vector(4.0);
        for (size_t i = 0; i < count; i++) {
            vec3 const n = draw_direction();
            spaces[i] = (half_space){n, vec3_dot(n, inside) - draw(0.0, 0.5)};
        }
        vec3 found;
        assert_true(find_nearest_point(spaces, count, OFFSETS_AS_GIVEN, v, &found));
        assert_true(find_most_missed(spaces, count, found) < 1e-12);
        assert_true(find_worst_angle(spaces, count, inside, v, found) < 1e-11);
    }
}

/* Farkas: normals with a positive combination of zero whose offsets sum to more than zero. */
static size_t make_contradiction(half_space *spaces) {
    vec3 sum = {0.0, 0.0, 0.0};
    double offsets = 0.0;
    for (int i = 0; i < 3; i++) {
        double const weight = draw(0.5, 1.0);
        spaces[i] = draw_space();
        sum = vec3_add_scaled(sum, spaces[i].normal, weight);
        offsets += weight * spaces[i].offset;
    }
    double const weight = vec3_norm(sum);
    if (weight < 0.05) return 0;
    spaces[3] = (half_space){vec3_scale(sum, -1.0 / weight), (draw(0.01, 1.0) - offsets) / weight};
    size_t const count = 4 + (size_t)draw(0.0, 10.0);
    for (size_t i = 4; i < count; i++) spaces[i] = draw_space();
    return count;
}

/* Length of the gradient of |x - v|^2 / 2 + 200 sum missed^2. */
static double find_soft_gradient(const half_space *spaces, size_t count, vec3 v, vec3 x) {
    vec3 gradient = vec3_sub(x, v);
    for (size_t i = 0; i < count; i++)
        gradient = vec3_add_scaled(gradient, spaces[i].normal,
                                   -400.0 * find_most_missed(&spaces[i], 1, x));
    return vec3_norm(gradient);
}

static void empty_sets_follow_the_rule(void **state) {
    (void)state;
    for (int k = 0; k < PROBLEMS; k++) {
        half_space spaces[MOST_SPACES], relaxed[MOST_SPACES];
        size_t const count = make_contradiction(spaces);
        vec3 const v = draw_vector(3.0), zero = {0.0, 0.0, 0.0};
        vec3 nearest;
        assert_false(count > 0 && find_nearest_point(spaces, count, OFFSETS_AS_GIVEN, v, &nearest));
        motion_space const space = motion_space_make(TULLE_MOTION_SPACE_POLYHEDRAL, spaces, count);
        vec3 const found = motion_space_project(&space, v);
        for (size_t i = 0; i < count; i++)
            relaxed[i] = (half_space){spaces[i].normal, fmin(spaces[i].offset, 0.0)};
        half_space_rules const rules = {-(double)INFINITY, (double)INFINITY, 1e-9};
        assert_true(find_nearest_point(relaxed, count, rules, v, &nearest));
        if (vec3_norm(vec3_sub(nearest, v)) > 20.0 * find_most_missed(relaxed, count, v)) {
            assert_true(find_soft_gradient(spaces, count, v, found) < 1e-8);
            continue;
        }
        assert_true(find_most_missed(relaxed, count, found) < 1e-12);
        assert_true(find_worst_angle(relaxed, count, zero, v, found) < 1e-11);
    }
}

static void assert_soft_point(const half_space *spaces, size_t count, vec3 v) {
    motion_space const space = motion_space_make(TULLE_MOTION_SPACE_POLYHEDRAL, spaces, count);
    vec3 const found = motion_space_project(&space, v);
    /* that far away from v one plane alone pulls with hundreds */
    assert_true(find_soft_gradient(spaces, count, v, found) < 1e-8);
}

/* Two planes that nearly face each other make a sharp wedge, far away from v. Others stand against
 * what the wedge asks for. */
static void soft_points_cost_least(void **state) {
    (void)state;
    for (int k = 0; k < PROBLEMS; k++) {
        half_space spaces[MOST_SPACES];
        vec3 const normal = draw_direction();
        vec3 const along = vec3_normalize(vec3_cross(normal, draw_direction()));
        double const tilt = pow(10.0, draw(-6.0, -3.0));
        spaces[0] = (half_space){normal, draw(0.01, 0.2)};
        spaces[1].normal = vec3_normalize(vec3_add_scaled(vec3_scale(along, tilt), normal, -1.0));
        spaces[1].offset = draw(0.01, 0.2);
        size_t const count = 2 + (size_t)draw(0.0, 7.0);
        for (size_t i = 2; i < count; i++) {
            do spaces[i] = draw_space();
            while (vec3_dot(spaces[i].normal, along) > -0.2); /* holds at v, far away it does not */
        }
        assert_soft_point(spaces, count, vec3_add_scaled(draw_vector(0.01), along, -1.0));
    }
    /* whole steps of Newton's method go round in a circle of three */
    half_space const circle[] = {
        {{-0.46146125652415509, -0.88480612586580643, -0.064588144093871674}, -0.51474028568450159},
        {{-0.7123925497452428, -0.32619282163148045, 0.62136551093826009}, 0.41929364024344484},
        {{-0.51748360833272278, 0.49121665516904894, 0.7006546316063833}, 0.25619000967498562},
        {{0.75955241060470313, 0.28328103155965939, -0.58551856734272689}, 0.23608333808738233},
        {{0.77358186932586981, -0.55840572824393453, -0.29958994328023419}, -0.82438541580514291},
        {{0.97362128709360241, 0.22165710370094516, -0.054126866684720089}, -0.062717777108161288},
        {{-0.333489256381171, 0.93908861195339088, 0.083051157594503308}, 0.91800878983260903}};
    assert_soft_point(circle, sizeof circle / sizeof *circle,
                      (vec3){-0.0083750149486875401, 0.058680220328904638, 0.019734483946686206});
}

/* Two layers that are tilted a little against each other and press from both sides: the vertex goes
 * on along them as if they were parallel, midway between what they ask for. */
static void tilted_layers_do_not_lock(void **state) {
    (void)state;
    for (int k = 0; k < PROBLEMS; k++) {
        double const tilt = pow(10.0, draw(-12.0, -3.0)), press = draw(0.0, 0.1);
        half_space const spaces[2] = {{{0.0, 0.0, 1.0}, press},
                                      {{-sin(tilt), 0.0, -cos(tilt)}, press + draw(0.0, 0.1)}};
        vec3 v;
        v.x = draw(0.1, 3.0);
        v.y = draw(-3.0, 3.0);
        v.z = draw(-0.004, 0.004);
        motion_space const space = motion_space_make(TULLE_MOTION_SPACE_POLYHEDRAL, spaces, 2);
        vec3 const found = motion_space_project(&space, v);
        double const missed = spaces[0].offset + spaces[1].offset + tilt * v.x;
        /* what the second plane misses, half of it all but for what v is nearer to one, pulls */
        double const pull = tilt * (200.0 * missed + 0.5 * fabs(found.z - v.z));
        assert_true(fabs(found.x - v.x) <= 1.000001 * pull + 2e-15); /* rounding of v */
        assert_true(fabs(found.y - v.y) < 1e-12);
    }
}

/* Two planes that nearly face each other meet far away: the rule for empty sets holds. */
static void sharp_wedges_count_as_empty(void **state) {
    (void)state;
    double const tilt = 1e-3;
    half_space const spaces[2] = {{{0.0, 0.0, 1.0}, 0.1}, {{sin(tilt), 0.0, -cos(tilt)}, 0.1}};
    vec3 far, v = {0.3, 0.2, 0.0};
    assert_true(find_nearest_point(spaces, 2, OFFSETS_AS_GIVEN, v, &far));
    assert_true(far.x > 100.0);
    motion_space const space = motion_space_make(TULLE_MOTION_SPACE_POLYHEDRAL, spaces, 2);
    vec3 const found = motion_space_project(&space, v);
    assert_true(vec3_norm(vec3_sub(found, v)) < 1e-3);
}

static canonical_cone draw_cone(void) {
    vec3 const axis = draw_direction();
    return (canonical_cone){axis, draw(0.0, 1.0) < 0.2 ? RIGHT_ANGLE : draw(0.05, RIGHT_ANGLE)};
}

/* The three cases of v . C: inside, on the boundary, the tip; always the nearest point. */
static void cone_projection_is_nearest(void **state) {
    (void)state;
    int cases[3] = {0};
    for (int k = 0; k < PROBLEMS; k++) {
        canonical_cone const cone = draw_cone();
        vec3 const v = draw_vector(2.0), x = canonical_cone_project(&cone, v);
        double const size = vec3_norm(x);
        bool const is_inside = angle_between(v, cone.axis) <= cone.angle;
        if (is_inside) assert_true(vec3_norm(vec3_sub(v, x)) < 1e-14);
        cases[is_inside ? 0 : size > 0.0 ? 1 : 2]++;
        if (size > 0.0) assert_true(angle_between(x, cone.axis) <= cone.angle + 1e-7);
        vec3 const again = canonical_cone_project(&cone, x);
        assert_true(vec3_norm(vec3_sub(again, x)) < 1e-14);
        for (int i = 0; i < SAMPLES; i++) {
            vec3 y = draw_vector(4.0);
            if (angle_between(y, cone.axis) > cone.angle) continue;
            assert_true(vec3_dot(vec3_sub(v, x), vec3_sub(y, x)) < 1e-12);
        }
    }
    assert_true(cases[0] > 1000 && cases[1] > 1000 && cases[2] > 1000);
    /* by hand: half-space and a right-angled cone */
    canonical_cone const up = {{0.0, 0.0, 1.0}, RIGHT_ANGLE};
    vec3 const slid = canonical_cone_project(&up, vec3_make(3.0, 4.0, -2.0));
    assert_true(fabs(slid.x - 3.0) < 1e-14 && fabs(slid.y - 4.0) < 1e-14 && fabs(slid.z) < 1e-14);
    canonical_cone const half = {{0.0, 0.0, 1.0}, 0.5 * RIGHT_ANGLE};
    vec3 const side = canonical_cone_project(&half, vec3_make(2.0, 0.0, 0.0));
    assert_true(fabs(side.x - 1.0) < 1e-14 && fabs(side.z - 1.0) < 1e-14);
    assert_true(vec3_norm(canonical_cone_project(&half, vec3_make(1.0, 0.0, -1.1))) == 0.0);
}

/* How wide a cone around `axis` fits into two others. */
static double find_room(const canonical_cone *a, const canonical_cone *b, vec3 axis) {
    return fmin(a->angle - angle_between(axis, a->axis), b->angle - angle_between(axis, b->axis));
}

static void intersection_is_the_widest_cone_inside(void **state) {
    (void)state;
    int empty = 0, contained = 0;
    for (int k = 0; k < PROBLEMS; k++) {
        canonical_cone const a = draw_cone(), b = draw_cone();
        canonical_cone const c = intersect_cones(&a, &b);
        canonical_cone const d = intersect_cones(&b, &a);
        assert_true(fabs(c.angle - d.angle) < 1e-12);
        bool const is_empty = vec3_norm2(c.axis) == 0.0;
        empty += is_empty;
        contained += c.angle == a.angle || c.angle == b.angle;
        if (!is_empty) assert_true(find_room(&a, &b, c.axis) >= c.angle - 1e-9);
        for (int i = 0; i < SAMPLES; i++) {
            vec3 const axis = is_empty || i % 2 == 0
                                  ? draw_direction()
                                  : vec3_normalize(vec3_add_scaled(c.axis, draw_direction(), 0.01));
            assert_true(find_room(&a, &b, axis) <= c.angle + 1e-9);
        }
    }
    assert_true(empty > 1000 && contained > 500);
}

static void inscribed_cone_is_the_widest(void **state) {
    (void)state;
    for (int k = 0; k < PROBLEMS / 4; k++) {
        half_space spaces[12];
        size_t const count = 1 + (size_t)draw(0.0, 11.99);
        vec3 const inside = draw_direction();
        for (size_t i = 0; i < count; i++) {
            do spaces[i] = draw_space();
            while (vec3_dot(spaces[i].normal, inside) < 0.1);
        }
        canonical_cone const cone = canonical_cone_inscribe(spaces, count);
        assert_true(cone.angle >= asin(0.1));
        canonical_cone fold = {spaces[0].normal, RIGHT_ANGLE};
        double room = RIGHT_ANGLE;
        for (size_t i = 0; i < count; i++) {
            canonical_cone const half = {spaces[i].normal, RIGHT_ANGLE};
            room = fmin(room, RIGHT_ANGLE - angle_between(cone.axis, spaces[i].normal));
            fold = intersect_cones(&fold, &half);
        }
        assert_true(fabs(room - cone.angle) < 1e-7);
        assert_true(fold.angle <= cone.angle + 1e-7);
        if (count <= 2) assert_true(fabs(fold.angle - cone.angle) < 1e-7);
        for (int i = 0; i < SAMPLES; i++) {
            vec3 const axis = vec3_normalize(
                vec3_add_scaled(cone.axis, draw_direction(), i % 2 == 0 ? 0.01 : 1.0));
            double least = RIGHT_ANGLE;
            for (size_t j = 0; j < count; j++)
                least = fmin(least, RIGHT_ANGLE - angle_between(axis, spaces[j].normal));
            assert_true(least <= cone.angle + 1e-7);
        }
    }
}

/* Folding the intersection over pairs is smaller than the set's: the corner of a room. */
static void folding_pairs_is_no_intersection_of_a_set(void **state) {
    (void)state;
    half_space const spaces[3] = {
        {{1.0, 0.0, 0.0}, 0.0}, {{0.0, 1.0, 0.0}, 0.0}, {{0.0, 0.0, 1.0}, 0.0}};
    canonical_cone const cone = canonical_cone_inscribe(spaces, 3);
    assert_true(fabs(cone.angle - asin(1.0 / sqrt(3.0))) < 1e-12);
    canonical_cone fold = {spaces[0].normal, RIGHT_ANGLE};
    for (int i = 1; i < 3; i++) {
        canonical_cone const half = {spaces[i].normal, RIGHT_ANGLE};
        fold = intersect_cones(&fold, &half);
    }
    assert_true(fabs(fold.angle - 0.25 * RIGHT_ANGLE) < 1e-12);
}

/* v . Z of a cone: v where all half-spaces hold it, even outside the inscribed cone. */
static void constraint_lets_pass_what_its_half_spaces_hold(void **state) {
    (void)state;
    half_space const spaces[2] = {{{1.0, 0.0, 0.0}, 0.0}, {{0.0, 1.0, 0.0}, 0.0}};
    motion_space const space = motion_space_make(TULLE_MOTION_SPACE_CONE, spaces, 2);
    assert_true(fabs(space.cone.angle - 0.5 * RIGHT_ANGLE) < 1e-12);
    vec3 const along = {0.0, 0.0, 1.0}; /* at right angles to the cone's axis */
    assert_true(vec3_norm(vec3_sub(motion_space_project(&space, along), along)) == 0.0);
    /* a little inwards, and the cone turns it by 45 degrees: the gap of the circular cone */
    vec3 const in = {-0.01, 0.0, 1.0}, turned = motion_space_project(&space, in);
    double const kept = vec3_norm(turned) / vec3_norm(in);
    assert_true(kept > 0.68 && kept < 0.72);
    motion_space const whole = motion_space_make(TULLE_MOTION_SPACE_POLYHEDRAL, spaces, 2);
    assert_true(vec3_norm(vec3_sub(motion_space_project(&whole, in), along)) < 1e-15);
}

/* A vertex between two layers: the cone is empty and locks it, the polyhedron is a plane. */
static void between_two_layers_only_the_polyhedron_slides(void **state) {
    (void)state;
    half_space const spaces[2] = {{{0.0, 0.0, 1.0}, 0.0}, {{0.0, 0.0, -1.0}, 0.0}};
    vec3 const v = {0.7, -0.2, -0.001};
    motion_space const cone = motion_space_make(TULLE_MOTION_SPACE_CONE, spaces, 2);
    motion_space const whole = motion_space_make(TULLE_MOTION_SPACE_POLYHEDRAL, spaces, 2);
    assert_true(vec3_norm2(cone.cone.axis) == 0.0);
    assert_true(vec3_norm(motion_space_project(&cone, v)) == 0.0);
    vec3 const slid = motion_space_project(&whole, v);
    assert_true(slid.x == v.x && slid.y == v.y && fabs(slid.z) < 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_known_optima),
        cmocka_unit_test(nothing_feasible_is_nearer),
        cmocka_unit_test(empty_sets_follow_the_rule),
        cmocka_unit_test(soft_points_cost_least),
        cmocka_unit_test(tilted_layers_do_not_lock),
        cmocka_unit_test(sharp_wedges_count_as_empty),
        cmocka_unit_test(cone_projection_is_nearest),
        cmocka_unit_test(intersection_is_the_widest_cone_inside),
        cmocka_unit_test(inscribed_cone_is_the_widest),
        cmocka_unit_test(folding_pairs_is_no_intersection_of_a_set),
        cmocka_unit_test(constraint_lets_pass_what_its_half_spaces_hold),
        cmocka_unit_test(between_two_layers_only_the_polyhedron_slides),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
