/* Rays, nearest points and overlaps (tulle/query.h), against all triangles one by one.
 *
 * Most scenes are soups of triangles with small whole coordinates, some of them without area. There
 * every answer is known exactly by whole numbers, also for rays that run through corners, along
 * edges and within planes. */
#include "tulle/query.h"

#include "base/hash.h"
#include "support/paper_options.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "tulle/check.h"
#include "tulle/live.h"
#include "tulle/mesh.h"
#include "tulle/shapes.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { SOUP_TRIANGLES = 150, SOUPS = 2, ROUNDS = 6, FOUND_MAX = 20000 };

typedef int64_t whole3[3];

static const double STEP = 1.0 / 64.0; /* [s] */
static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

/* ---- a world of soups, each of which jumps to new places each round ---- */

typedef struct soup_world {
    tulle_world *world;
    tulle_obstacle_id soups[SOUPS];
    whole3 corners[SOUPS][SOUP_TRIANGLES][3];
    uint64_t seed;
} soup_world;

static int64_t pick(uint64_t *seed, int64_t low, int64_t high) {
    return low + (int64_t)(random_next(seed) % (uint64_t)(high - low + 1));
}

static bool is_flat(const whole3 corners[3]) {
    int64_t a[3], b[3];
    for (int k = 0; k < 3; k++) {
        a[k] = corners[1][k] - corners[0][k];
        b[k] = corners[2][k] - corners[0][k];
    }
    return a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2] && a[0] * b[1] == a[1] * b[0];
}

/* The last of `clean` triangles and all before have an area; the others may have none. */
static void shuffle(soup_world *made, size_t clean) {
    for (size_t s = 0; s < SOUPS; s++) {
        for (size_t t = 0; t < SOUP_TRIANGLES; t++) {
            whole3 *const corners = made->corners[s][t];
            do {
                for (int c = 0; c < 3; c++)
                    for (int k = 0; k < 3; k++)
                        corners[c][k] = c == 0 ? pick(&made->seed, -12, 12)
                                               : corners[0][k] + pick(&made->seed, -4, 4);
            } while (t < clean && is_flat((const whole3 *)corners));
        }
    }
}

static void copy_soup(const soup_world *made, size_t soup, double *positions) {
    for (size_t i = 0; i < 9 * SOUP_TRIANGLES; i++)
        positions[i] = (double)made->corners[soup][i / 9][i / 3 % 3][i % 3];
}

static soup_world make_soups(tulle_detect_method method, int threads) {
    soup_world made = {.seed = 11 + (uint64_t)method};
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->detection.method = method;
    def.threads = threads;
    def.gravity[2] = 0.0;
    def.start_intersections = TULLE_START_IGNORE;
    FINE(tulle_world_create(&def, &made.world, &error));
    tulle_mesh sheet = small_sheet(1.0, 3, 60.0);
    (void)small_add_cloth(made.world, &sheet);
    tulle_mesh_destroy(&sheet);
    shuffle(&made, SOUP_TRIANGLES);
    uint32_t triangles[3 * SOUP_TRIANGLES];
    for (uint32_t i = 0; i < 3 * SOUP_TRIANGLES; i++) triangles[i] = i;
    double positions[9 * SOUP_TRIANGLES];
    for (size_t s = 0; s < SOUPS; s++) {
        copy_soup(&made, s, positions);
        tulle_obstacle_def obstacle = tulle_obstacle_def_default();
        obstacle.mesh =
            (tulle_mesh_view){positions, 3 * (size_t)SOUP_TRIANGLES, triangles, SOUP_TRIANGLES};
        obstacle.drive = TULLE_DRIVE_DEFORMING;
        FINE(tulle_world_add_obstacle(made.world, &obstacle, &made.soups[s], &error));
        FINE(tulle_object_set_filter(made.world, tulle_object_from_obstacle(made.soups[s]),
                                     1U << (s + 1), UINT32_MAX, &error));
    }
    FINE(tulle_world_start(made.world, &error));
    return made;
}

static void jump(soup_world *made) {
    shuffle(made, SOUP_TRIANGLES - SOUP_TRIANGLES / 8);
    double positions[9 * SOUP_TRIANGLES];
    for (size_t s = 0; s < SOUPS; s++) {
        copy_soup(made, s, positions);
        FINE(tulle_obstacle_set_next_positions(made->world, made->soups[s], positions,
                                               3 * (size_t)SOUP_TRIANGLES, TULLE_TRAVEL_JUMP,
                                               &error));
    }
    FINE(tulle_world_step(made->world, STEP, NULL, &error));
}

/* ---- rays by whole numbers ---- */

static void subtract(const whole3 a, const whole3 b, whole3 result) {
    for (int k = 0; k < 3; k++) result[k] = a[k] - b[k];
}
static int64_t dot(const whole3 a, const whole3 b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static void cross(const whole3 a, const whole3 b, whole3 result) {
    for (int k = 0; k < 3; k++) {
        int const i = (k + 1) % 3, j = (k + 2) % 3;
        result[k] = a[i] * b[j] - a[j] * b[i];
    }
}

/* Where on its way, part[0] / part[1], a ray meets a triangle: it meets the plane there, and that
 * point, seen along an axis, lies in the triangle. */
static bool meets_exactly(const whole3 from, const whole3 to, const whole3 x[3], int skips_backs,
                          int64_t part[2]) {
    whole3 way, left, right, normal, back;
    subtract(to, from, way);
    subtract(x[1], x[0], left);
    subtract(x[2], x[0], right);
    cross(left, right, normal);
    subtract(x[0], from, back);
    int64_t slope = dot(normal, way), height = dot(normal, back);
    if (slope == 0 || (skips_backs && slope > 0)) return false;
    if (slope < 0) {
        slope = -slope;
        height = -height;
    }
    if (height < 0 || height > slope) return false;
    part[0] = height;
    part[1] = slope;
    int axis = 0; /* the longest side of the normal */
    for (int k = 1; k < 3; k++)
        if (llabs(normal[k]) > llabs(normal[axis])) axis = k;
    int const i = (axis + 1) % 3, j = (axis + 2) % 3;
    int64_t const u = from[i] * slope + way[i] * height, v = from[j] * slope + way[j] * height;
    bool has_left = false, has_right = false;
    for (int k = 0; k < 3; k++) {
        const int64_t *const a = x[k], *const b = x[(k + 1) % 3];
        int64_t const side =
            (b[i] - a[i]) * (v - slope * a[j]) - (b[j] - a[j]) * (u - slope * a[i]);
        has_left |= side > 0;
        has_right |= side < 0;
    }
    return !(has_left && has_right);
}

/* A ray that may pass the corner of a triangle, the middle of an edge, or run within its plane. */
static void choose_ray(soup_world *made, whole3 from, whole3 to) {
    uint64_t *const seed = &made->seed;
    const whole3 *const x =
        (const whole3 *)made->corners[pick(seed, 0, SOUPS - 1)][pick(seed, 0, SOUP_TRIANGLES - 1)];
    do {
        for (int k = 0; k < 3; k++) {
            from[k] = pick(seed, -16, 16);
            to[k] = pick(seed, -16, 16);
        }
        switch (pick(seed, 0, 5)) {
        case 0: /* through a corner */
            for (int k = 0; k < 3; k++) to[k] = 2 * x[0][k] - from[k];
            break;
        case 1: /* through the middle of an edge */
            for (int k = 0; k < 3; k++) to[k] = x[0][k] + x[1][k] - from[k];
            break;
        case 2: { /* within the plane */
            int64_t const n[4] = {pick(seed, -3, 3), pick(seed, -3, 3), pick(seed, -3, 3),
                                  pick(seed, -3, 3)};
            for (int k = 0; k < 3; k++) {
                int64_t const u = x[1][k] - x[0][k], v = x[2][k] - x[0][k];
                from[k] = x[0][k] + n[0] * u + n[1] * v;
                to[k] = x[0][k] + n[2] * u + n[3] * v;
            }
            break;
        }
        case 3: /* along an axis */
            for (int k = 1; k < 3; k++) to[k] = from[k];
            break;
        case 4: /* from or to a corner */ memcpy(from, x[1], sizeof(whole3)); break;
        default: break;
        }
    } while (memcmp(from, to, sizeof(whole3)) == 0);
}

static void compare_ray(soup_world *made) {
    whole3 from, to;
    choose_ray(made, from, to);
    tulle_ray ray = {.mask = (uint32_t)pick(&made->seed, 0, 3) * 2,
                     .skips_back_faces = (int)pick(&made->seed, 0, 1)};
    for (int k = 0; k < 3; k++) {
        ray.from[k] = (double)from[k];
        ray.to[k] = (double)to[k];
    }
    tulle_hit hit;
    FINE(tulle_world_cast_ray(made->world, &ray, &hit, &error));

    int64_t best[2] = {2, 1}, told[2] = {3, 1};
    for (size_t s = 0; s < SOUPS; s++) {
        if (ray.mask != 0 && !(ray.mask & (2U << s))) continue;
        for (size_t t = 0; t < SOUP_TRIANGLES; t++) {
            int64_t part[2];
            const whole3 *const x = (const whole3 *)made->corners[s][t];
            if (!meets_exactly(from, to, x, ray.skips_back_faces, part)) continue;
            if (part[0] * best[1] < best[0] * part[1]) memcpy(best, part, sizeof best);
            if (hit.object.kind == TULLE_OBJECT_OBSTACLE && hit.object.index == s &&
                hit.triangle == t)
                memcpy(told, part, sizeof told);
        }
    }
    if (best[0] > best[1]) {
        assert_int_equal(hit.object.kind, TULLE_OBJECT_NONE);
        return;
    }
    assert_int_equal(hit.object.kind, TULLE_OBJECT_OBSTACLE);
    assert_true(told[0] * best[1] == best[0] * told[1]);
    double const part = (double)best[0] / (double)best[1];
    double length2 = 0.0, sum = 0.0, square = 0.0, along = 0.0;
    const whole3 *const x = (const whole3 *)made->corners[hit.object.index][hit.triangle];
    for (int k = 0; k < 3; k++) {
        double const way = ray.to[k] - ray.from[k];
        length2 += way * way;
        assert_true(fabs(hit.position[k] - (ray.from[k] + part * way)) < 1e-11);
        double mean = 0.0;
        for (int c = 0; c < 3; c++) mean += hit.weights[c] * (double)x[c][k];
        assert_true(fabs(hit.position[k] - mean) < 1e-12);
        assert_true(hit.weights[k] >= 0.0 && hit.weights[k] <= 1.0);
        sum += hit.weights[k];
        square += hit.normal[k] * hit.normal[k];
        along += hit.normal[k] * way;
    }
    assert_true(fabs(sum - 1.0) < 1e-14 && fabs(square - 1.0) < 1e-14);
    assert_true(fabs(hit.distance - part * sqrt(length2)) < 1e-11);
    assert_true(!ray.skips_back_faces || along < 0.0);
}

/* ---- nearest points ---- */

static double measure_to_segment(const double *p, const double *a, const double *b) {
    double way2 = 0.0, along = 0.0, square = 0.0;
    for (int k = 0; k < 3; k++) {
        way2 += (b[k] - a[k]) * (b[k] - a[k]);
        along += (b[k] - a[k]) * (p[k] - a[k]);
    }
    double const part = way2 > 0.0 ? fmin(fmax(along / way2, 0.0), 1.0) : 0.0;
    for (int k = 0; k < 3; k++) {
        double const gap = a[k] + part * (b[k] - a[k]) - p[k];
        square += gap * gap;
    }
    return sqrt(square);
}

/* The distance to the nearest edge, or to the plane where the foot is within the triangle: there it
 * is on the inner side of each edge. */
static double measure_to_triangle(const double *p, const double x[3][3]) {
    double best = (double)INFINITY, normal[3], square = 0.0, height = 0.0;
    for (int c = 0; c < 3; c++) best = fmin(best, measure_to_segment(p, x[c], x[(c + 1) % 3]));
    for (int k = 0; k < 3; k++) {
        int const i = (k + 1) % 3, j = (k + 2) % 3;
        normal[k] =
            (x[1][i] - x[0][i]) * (x[2][j] - x[0][j]) - (x[1][j] - x[0][j]) * (x[2][i] - x[0][i]);
        square += normal[k] * normal[k];
        height += normal[k] * (p[k] - x[0][k]);
    }
    if (!(square > 0.0)) return best;
    for (int c = 0; c < 3; c++) {
        const double *const a = x[c], *const b = x[(c + 1) % 3];
        double side = 0.0;
        for (int k = 0; k < 3; k++) {
            int const i = (k + 1) % 3, j = (k + 2) % 3;
            side += normal[k] * ((b[i] - a[i]) * (p[j] - a[j]) - (b[j] - a[j]) * (p[i] - a[i]));
        }
        if (side < 0.0) return best;
    }
    return fabs(height) / sqrt(square);
}

static void compare_nearest(soup_world *made) {
    double point[3];
    for (int k = 0; k < 3; k++) {
        point[k] = (double)pick(&made->seed, -16, 16);
        if (pick(&made->seed, 0, 1)) point[k] += random_uniform(&made->seed);
    }
    double const most = pick(&made->seed, 0, 2) ? 1.5 : (double)INFINITY;
    uint32_t const mask = (uint32_t)pick(&made->seed, 0, 3) * 2;
    double best = (double)INFINITY, told = -1.0;
    tulle_hit hit;
    FINE(tulle_world_find_closest_point(made->world, point, most, mask, &hit, &error));
    for (size_t s = 0; s < SOUPS; s++) {
        if (mask != 0 && !(mask & (2U << s))) continue;
        for (size_t t = 0; t < SOUP_TRIANGLES; t++) {
            double x[3][3];
            for (int i = 0; i < 9; i++) x[i / 3][i % 3] = (double)made->corners[s][t][i / 3][i % 3];
            double const distance = measure_to_triangle(point, (const double(*)[3])x);
            best = fmin(best, distance);
            if (hit.object.kind == TULLE_OBJECT_OBSTACLE && hit.object.index == s &&
                hit.triangle == t)
                told = distance;
        }
    }
    if (mask == 0 && most > 100.0 && hit.object.kind == TULLE_OBJECT_CLOTH) fail();
    if (fabs(best - most) < 1e-9) return;
    if (!(best < most)) {
        assert_int_equal(hit.object.kind, TULLE_OBJECT_NONE);
        assert_true(hit.distance == 0.0);
        return;
    }
    double square = 0.0;
    for (int k = 0; k < 3; k++) square += pow(hit.position[k] - point[k], 2.0);
    assert_true(fabs(hit.distance - best) < 1e-11 && fabs(told - best) < 1e-11);
    assert_true(fabs(sqrt(square) - best) < 1e-11);
}

/* ---- boxes ---- */

/* Whether a plane at right angles to an axis parts two sets of points. */
static bool is_parted(const whole3 *a, int a_count, const whole3 *b, int b_count,
                      const whole3 axis) {
    int64_t low[2] = {INT64_MAX, INT64_MAX}, high[2] = {INT64_MIN, INT64_MIN};
    for (int i = 0; i < a_count + b_count; i++) {
        int const set = i >= a_count;
        int64_t const at = dot(set ? b[i - a_count] : a[i], axis);
        low[set] = at < low[set] ? at : low[set];
        high[set] = at > high[set] ? at : high[set];
    }
    return high[0] < low[1] || high[1] < low[0];
}

/* Convex sets meet unless one of these axes parts them: faces' normals, and normals of pairs of
 * edges, in space and within a plane that both lie in. */
static bool meets_box_exactly(const whole3 x[3], const whole3 low, const whole3 high) {
    whole3 corners[8], edges[3], axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, normal, test;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++) corners[i][k] = (i >> k) % 2 ? high[k] : low[k];
    for (int c = 0; c < 3; c++) subtract(x[(c + 1) % 3], x[c], edges[c]);
    cross(edges[0], edges[1], normal);
    if (is_parted(x, 3, (const whole3 *)corners, 8, normal)) return false;
    for (int i = 0; i < 3; i++) {
        if (is_parted(x, 3, (const whole3 *)corners, 8, axes[i])) return false;
        cross(normal, edges[i], test);
        if (is_parted(x, 3, (const whole3 *)corners, 8, test)) return false;
        cross(normal, axes[i], test);
        if (is_parted(x, 3, (const whole3 *)corners, 8, test)) return false;
        for (int j = 0; j < 3; j++) {
            cross(edges[i], axes[j], test);
            if (is_parted(x, 3, (const whole3 *)corners, 8, test)) return false;
        }
    }
    return true;
}

static void compare_box(soup_world *made) {
    static tulle_found_triangle found[FOUND_MAX];
    tulle_found all = {found, FOUND_MAX, 7};
    whole3 low, high;
    bool const is_thin = pick(&made->seed, 0, 2) == 0; /* then only triangles with area are sure */
    for (int k = 0; k < 3; k++) {
        low[k] = pick(&made->seed, -14, 14);
        high[k] = low[k] + pick(&made->seed, is_thin ? 0 : 1, 9);
    }
    double lows[3], highs[3];
    for (int k = 0; k < 3; k++) {
        lows[k] = (double)low[k];
        highs[k] = (double)high[k];
    }
    uint32_t const mask = (uint32_t)pick(&made->seed, 0, 3) * 2;
    size_t at = 0;
    FINE(tulle_world_find_box_overlaps(made->world, lows, highs, mask, &all, &error));
    size_t const count = all.count;
    for (uint32_t s = 0; s < SOUPS; s++) {
        for (uint32_t t = 0; t < SOUP_TRIANGLES; t++) {
            const whole3 *const x = (const whole3 *)made->corners[s][t];
            bool const is_found = at < count && found[at].object.kind == TULLE_OBJECT_OBSTACLE &&
                                  found[at].object.index == s && found[at].triangle == t;
            at += is_found;
            bool const is_seen = mask == 0 || (mask & (2U << s));
            if (is_thin && is_flat(x)) continue;
            if (is_found != (is_seen && meets_box_exactly(x, low, high)))
                fail_msg("soup %u, triangle %u: found %d", s, t, is_found);
        }
    }
    assert_int_equal(at, count);
    /* less room, and none */
    size_t const room = count / 2;
    tulle_found_triangle *const few = malloc((room + 1) * sizeof *few);
    assert_non_null(few);
    memset(few, 0x5a, (room + 1) * sizeof *few);
    tulle_found some = {few, room, 0}, none = {NULL, 0, 0};
    FINE(tulle_world_find_box_overlaps(made->world, lows, highs, mask, &some, &error));
    assert_int_equal(some.count, count);
    for (size_t i = 0; i < room; i++) {
        size_t k = 0;
        while (k < count && memcmp(&few[i], &found[k], sizeof *few) != 0) k++;
        assert_true(k < count);
    }
    assert_int_equal(few[room].triangle, 0x5a5a5a5a);
    FINE(tulle_world_find_box_overlaps(made->world, lows, highs, mask, &none, &error));
    assert_int_equal(none.count, count);
    free(few);
}

/* ---- meshes ---- */

/* The judge on the same triangles as two bodies says the same. */
static void compare_mesh(soup_world *made) {
    static tulle_found_triangle found[FOUND_MAX];
    tulle_found all = {found, FOUND_MAX, 7};
    enum { TRIANGLES = 40 };
    double positions[9 * TRIANGLES];
    uint32_t triangles[3 * TRIANGLES];
    for (int t = 0; t < TRIANGLES; t++)
        for (int i = 0; i < 9; i++)
            positions[9 * t + i] =
                i < 3 ? (double)pick(&made->seed, -12, 12)
                      : positions[9 * t + i % 3] + (double)pick(&made->seed, -6, 6);
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++) triangles[i] = i;
    tulle_mesh_view const mesh = {positions, 3 * (size_t)TRIANGLES, triangles, TRIANGLES};
    FINE(tulle_world_find_mesh_overlaps(made->world, mesh, 0, &all, &error));
    size_t const count = all.count;
    size_t expected = 0;
    assert_true(count > 0 && count <= FOUND_MAX);
    for (size_t i = 1; i < count; i++) {
        tulle_found_triangle const a = found[i - 1], b = found[i];
        assert_true(a.other < b.other ||
                    (a.other == b.other &&
                     (a.object.index < b.object.index ||
                      (a.object.index == b.object.index && a.triangle < b.triangle))));
    }
    for (uint32_t s = 0; s < SOUPS; s++) {
        tulle_object_id const object = tulle_object_from_obstacle(made->soups[s]);
        tulle_object_info const info = tulle_object_get_info(made->world, object);
        tulle_check_body bodies[2] = {{.mesh = mesh}, {.is_obstacle = 1}};
        bodies[1].mesh =
            (tulle_mesh_view){tulle_obstacle_get_positions(made->world, made->soups[s], NULL),
                              info.vertex_count, info.triangles, info.triangle_count};
        tulle_check_result result;
        FINE(tulle_check_intersections(bodies, 2, 1, &result, &error));
        for (size_t i = 0; i < result.pair_count; i++) {
            if (result.pairs[i].body_a == result.pairs[i].body_b) continue;
            expected++;
            bool is_found = false;
            for (size_t k = 0; k < count; k++)
                is_found |= found[k].object.kind == TULLE_OBJECT_OBSTACLE &&
                            found[k].object.index == s &&
                            found[k].triangle == result.pairs[i].triangle_b &&
                            found[k].other == result.pairs[i].triangle_a;
            assert_true(is_found);
        }
        tulle_check_result_destroy(&result);
    }
    assert_int_equal(count, expected);
}

/* ---- tests ---- */

static void compare_all(tulle_detect_method method, int threads) {
    soup_world made = make_soups(method, threads);
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < 600; i++) compare_ray(&made);
        for (int i = 0; i < 200; i++) compare_nearest(&made);
        for (int i = 0; i < 100; i++) compare_box(&made);
        compare_mesh(&made);
        jump(&made);
    }
    tulle_world_destroy(made.world);
}

static void queries_of_refitted_trees(void **state) {
    (void)state;
    compare_all(tulle_paper_options_default().detection.method, 2);
}

static void queries_beside_other_trees(void **state) {
    (void)state;
    compare_all(TULLE_DETECT_BVOX, 1);
    compare_all(TULLE_DETECT_PAPER, 1);
}

/* From within a closed surface no ray gets out, least of all through its corners and edges, whose
 * coordinates are not whole here; from outside none gets in and out with one crossing. */
static void no_ray_leaves_a_closed_surface(void **state) {
    (void)state;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.7;
    tulle_mesh ball = small_shape(shape, 0.1, -0.3, 0.2), sheet = small_sheet(1.0, 3, 9.0);
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    FINE(tulle_world_create(&def, &world, &error));
    (void)small_add_cloth(world, &sheet);
    (void)small_add_obstacle(world, &ball);
    FINE(tulle_world_start(world, &error));
    uint64_t seed = 5;
    for (int i = 0; i < 20000; i++) {
        const uint32_t *const corners =
            ball.triangles + 3 * (random_next(&seed) % ball.triangle_count);
        const double *const a = ball.positions + 3 * (size_t)corners[0];
        const double *const b = ball.positions + 3 * (size_t)corners[1];
        double const part = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 0.5 : random_uniform(&seed);
        tulle_ray ray = {.skips_back_faces = 0};
        for (int k = 0; k < 3; k++) {
            ray.from[k] = (k == 0   ? 0.1
                           : k == 1 ? -0.3
                                    : 0.2) +
                          0.4 * (random_uniform(&seed) - 0.5);
            double const through = a[k] + part * (b[k] - a[k]);
            ray.to[k] = ray.from[k] + 3.0 * (through - ray.from[k]);
        }
        tulle_hit hit;
        FINE(tulle_world_cast_ray(world, &ray, &hit, &error));
        assert_int_equal(hit.object.kind, TULLE_OBJECT_OBSTACLE);
        double miss = 0.0;
        for (int k = 0; k < 3; k++)
            miss = fmax(miss, fabs(hit.position[k] - (a[k] + part * (b[k] - a[k]))));
        assert_true(miss < 1e-12);
        /* from within only backs are seen */
        ray.skips_back_faces = 1;
        FINE(tulle_world_cast_ray(world, &ray, &hit, &error));
        assert_int_equal(hit.object.kind, TULLE_OBJECT_NONE);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&sheet);
}

/* A ray that grazes a plane at some 1e-15 crosses it, by exact signs, where rounded numbers say
 * nothing of the place. It is told on the surface and beside the ray. */
static void a_grazing_ray_is_told_beside_the_ray(void **state) {
    (void)state;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    for (int k = 0; k < 3; k++) shape.size[k] = 1.0;
    tulle_mesh box = small_shape(shape, 0.0, 0.0, 0.0), sheet = small_sheet(1.0, 3, 9.0);
    double top = -1.0;
    for (size_t v = 0; v < box.vertex_count; v++) top = fmax(top, box.positions[3 * v + 2]);
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    FINE(tulle_world_create(&def, &world, &error));
    (void)small_add_cloth(world, &sheet);
    (void)small_add_obstacle(world, &box);
    FINE(tulle_world_start(world, &error));
    /* as far below as above, as doubles are finer there: it crosses the plane in its middle */
    double const above = nextafter(top, 9.0), below = top - (above - top);
    for (int i = 0; i < 200; i++) {
        double const y = -0.4 + 0.004 * i;
        tulle_ray const ray = {.from = {-2.0, y, above}, .to = {2.0, 0.7 * y, below}};
        tulle_hit hit;
        FINE(tulle_world_cast_ray(world, &ray, &hit, &error));
        assert_int_equal(hit.object.kind, TULLE_OBJECT_OBSTACLE);
        assert_true(fabs(hit.position[0]) <= 0.5 + 1e-15);
        double const part = (hit.position[0] + 2.0) / 4.0;
        assert_true(fabs(hit.position[1] - (y - part * 0.3 * y)) < 1e-11);
        assert_true(fabs(hit.position[2] - top) < 1e-15);
    }
    /* what is less flat is told where it crosses */
    for (double height = 0.1; height > 1e-9; height *= 0.1) {
        tulle_ray const ray = {.from = {-1.0, 0.11, top + height}, .to = {1.0, 0.11, top - height}};
        tulle_hit hit;
        FINE(tulle_world_cast_ray(world, &ray, &hit, &error));
        assert_int_equal(hit.object.kind, TULLE_OBJECT_OBSTACLE);
        assert_true(fabs(hit.position[0]) < 1e-15 / height && fabs(hit.position[1] - 0.11) < 1e-15);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&sheet);
}

/* Rays within planes but for rounding: many cross them by exact signs, where rounded numbers say
 * little of the place. What is told lies on the triangle and beside the ray. */
static void rays_within_planes_are_told_beside_the_ray(void **state) {
    (void)state;
    enum { TRIANGLES = 40 };
    double x[9 * TRIANGLES];
    uint32_t corners[3 * TRIANGLES];
    uint64_t seed = 3;
    for (int i = 0; i < 9 * TRIANGLES; i++)
        x[i] = random_uniform(&seed) + 3.0 * (i / 9 % 4) * (i % 3 == 0) +
               3.0 * (i / 36) * (i % 3 == 1); /* each apart from the others */
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++) corners[i] = i;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_mesh sheet = small_sheet(1.0, 3, 90.0);
    (void)small_add_cloth(world, &sheet);
    tulle_mesh_destroy(&sheet);
    tulle_obstacle_def soup = tulle_obstacle_def_default();
    soup.mesh = (tulle_mesh_view){x, 3 * (size_t)TRIANGLES, corners, TRIANGLES};
    FINE(tulle_world_add_obstacle(world, &soup, NULL, &error));
    FINE(tulle_world_start(world, &error));
    int hits = 0;
    for (int i = 0; i < 20000; i++) {
        const double *const own = x + 9 * (i % TRIANGLES);
        double const along = random_uniform(&seed) - 0.5, up = 0.3 + random_uniform(&seed);
        tulle_ray ray = {.mask = 0};
        double way2 = 0.0, off2 = 0.0, part = 0.0;
        for (int k = 0; k < 3; k++) { /* through the middle, between sides of the triangle */
            double const middle = (own[k] + own[3 + k] + own[6 + k]) / 3.0;
            double const way = along * (own[3 + k] - own[k]) + up * (own[6 + k] - own[k]);
            ray.from[k] = middle - 1.5 * way;
            ray.to[k] = middle + 1.5 * way;
        }
        tulle_hit hit;
        FINE(tulle_world_cast_ray(world, &ray, &hit, &error));
        if (hit.object.kind != TULLE_OBJECT_OBSTACLE || hit.triangle != (uint32_t)(i % TRIANGLES))
            continue;
        hits++;
        for (int k = 0; k < 3; k++) {
            double const way = ray.to[k] - ray.from[k];
            way2 += way * way;
            part += way * (hit.position[k] - ray.from[k]);
        }
        for (int k = 0; k < 3; k++)
            off2 +=
                pow(hit.position[k] - ray.from[k] - part / way2 * (ray.to[k] - ray.from[k]), 2.0);
        assert_true(sqrt(off2) < 1e-11);
        assert_true(fabs(hit.distance - part / sqrt(way2)) < 1e-11);
    }
    assert_true(hits > 1000);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queries_of_refitted_trees),
        cmocka_unit_test(queries_beside_other_trees),
        cmocka_unit_test(no_ray_leaves_a_closed_surface),
        cmocka_unit_test(a_grazing_ray_is_told_beside_the_ray),
        cmocka_unit_test(rays_within_planes_are_told_beside_the_ray),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
