#include "support/patch_scene.h"

#include "support/exact_ccd.h"
#include "support/test_support.h"
#include "support/wide_normals.h"

#include <stdlib.h>
#include <string.h>

static const double TURN = 6.283185307179586; /* [rad] */

/* Place of parameters (u, v) in [0, 1]^2. */
static vec3 find_place(patch_shape shape, double u, double v, double phase) {
    double const angle = TURN * u;
    switch (shape) {
    case PATCH_RAMP: {
        double const a = 1.6 * angle, radius = 1.0 + v;
        return vec3_make(radius * cos(a), radius * sin(a), 0.12 * a);
    }
    case PATCH_SPIRAL: {
        double const a = 1.6 * angle, radius = 1.0 + 0.3 * v + 0.35 * a / TURN;
        return vec3_make(radius * cos(a), radius * sin(a), 0.02 * sin(7.0 * u + phase));
    }
    case PATCH_ANNULUS: {
        double const radius = 1.0 + v;
        return vec3_make(radius * cos(angle), radius * sin(angle), 0.1 * sin(3.0 * angle + phase));
    }
    case PATCH_SPHERE: {
        double const polar = 0.5 * TURN * (0.02 + 0.96 * v);
        return vec3_make(sin(polar) * cos(angle), sin(polar) * sin(angle), -cos(polar));
    }
    case PATCH_MOEBIUS: {
        double const across = 0.6 * (v - 0.5), half = 0.5 * angle;
        double const radius = 1.0 + across * cos(half);
        return vec3_make(radius * cos(angle), radius * sin(angle), across * sin(half));
    }
    case PATCH_CYLINDER: return vec3_make(cos(angle), sin(angle), 2.0 * v);
    case PATCH_FOLDED: {
        double const s = 2.0 * u - 1.0;
        return vec3_make(fabs(s) + 0.05 * cos(12.0 * v), v, 0.15 * s + 0.02 * sin(9.0 * v + phase));
    }
    default:
        return vec3_make(u, v, 0.08 * sin(7.0 * u + phase) * cos(5.0 * v) + 0.03 * sin(11.0 * v));
    }
}

static bool is_closed_around(patch_shape shape) {
    return shape == PATCH_ANNULUS || shape == PATCH_SPHERE || shape == PATCH_MOEBIUS ||
           shape == PATCH_CYLINDER;
}

static void finish(patch_scene *scene) {
    assert_int_equal(topology_build(&scene->heap, scene->triangles, scene->triangle_count,
                                    scene->vertex_count, &scene->topo),
                     TULLE_OK);
    scene->range = (surface_range){.vertex_end = (uint32_t)scene->vertex_count,
                                   .edge_end = (uint32_t)scene->topo.edge_count,
                                   .triangle_end = (uint32_t)scene->triangle_count,
                                   .is_present = true};
    scene->set = (surface_set){&scene->topo, &scene->range, 1, NULL};
}

static void allocate(patch_scene *scene, size_t vertex_count, size_t triangle_count) {
    *scene = (patch_scene){.heap = memory_default(), .vertex_count = vertex_count};
    scene->triangles = calloc(3 * triangle_count + 1, sizeof(uint32_t));
    scene->x0 = calloc(3 * vertex_count + 1, sizeof(double));
    scene->x1 = calloc(3 * vertex_count + 1, sizeof(double));
    assert_true(scene->triangles && scene->x0 && scene->x1);
}

static void make_soup(patch_scene *scene, size_t n, uint64_t *seed) {
    size_t const vertex_count = n * n + 3;
    allocate(scene, vertex_count, 2 * n * n);
    for (size_t i = 0; i < vertex_count; i++) {
        vec3 place = random_vector(seed, 1.0);
        if (i % 3 == 0) place.z *= 1e-3;
        vec3_store(scene->x0, i, place);
    }
    for (size_t i = 0; i < 2 * n * n; i++) {
        uint32_t corner[3];
        do { /* near in number, so that edges are shared, some by many */
            size_t const base = (size_t)(random_uniform(seed) * (double)(vertex_count - 3));
            for (size_t k = 0; k < 3; k++)
                corner[k] =
                    (uint32_t)(base + (size_t)(random_uniform(seed) * 3.999) % vertex_count);
        } while (corner[0] == corner[1] || corner[1] == corner[2] || corner[0] == corner[2] ||
                 corner[0] >= vertex_count || corner[1] >= vertex_count ||
                 corner[2] >= vertex_count);
        memcpy(scene->triangles + 3 * i, corner, sizeof corner);
    }
    scene->triangle_count = 2 * n * n;
}

static void make_grid(patch_scene *scene, patch_shape shape, size_t n, uint64_t *seed) {
    size_t const long_side = shape == PATCH_SHEET || shape == PATCH_SLIT ? n : 4 * n;
    size_t const rows = shape == PATCH_SHEET || shape == PATCH_SLIT ? n : n / 2 + 1;
    bool const closes = is_closed_around(shape);
    size_t const columns = closes ? long_side : long_side + 1;
    allocate(scene, columns * (rows + 1), 2 * long_side * rows);
    double const phase = random_between(seed, 0.0, TURN);
    for (size_t i = 0; i < columns; i++) {
        for (size_t j = 0; j <= rows; j++) {
            double const u = (double)i / (double)long_side, v = (double)j / (double)rows;
            vec3_store(scene->x0, i * (rows + 1) + j, find_place(shape, u, v, phase));
        }
    }
    for (size_t i = 0; i < long_side; i++) {
        for (size_t j = 0; j < rows; j++) {
            /* the slit: a row of squares is left out */
            if (shape == PATCH_SLIT && j == rows / 2 && 3 * i < 2 * long_side) continue;
            size_t const right = (i + 1) % columns;
            bool const is_twisted = shape == PATCH_MOEBIUS && right == 0;
            uint32_t const a = (uint32_t)(i * (rows + 1) + j), b = a + 1;
            uint32_t const c = (uint32_t)(right * (rows + 1) + (is_twisted ? rows - j : j));
            uint32_t const d = is_twisted ? c - 1 : c + 1;
            uint32_t const corners[6] = {a, c, b, b, c, d};
            memcpy(scene->triangles + 3 * scene->triangle_count, corners, sizeof corners);
            scene->triangle_count += 2;
        }
    }
}

void patch_scene_make(patch_scene *scene, patch_shape shape, size_t n, uint64_t *seed) {
    if (shape == PATCH_SOUP) {
        make_soup(scene, n, seed);
    } else {
        make_grid(scene, shape, n, seed);
    }
    memcpy(scene->x1, scene->x0, 3 * scene->vertex_count * sizeof(double));
    finish(scene);
}

void patch_scene_make_of(patch_scene *scene, const double *x0, const double *x1,
                         size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
    allocate(scene, vertex_count, triangle_count);
    scene->triangle_count = triangle_count;
    memcpy(scene->x0, x0, 3 * vertex_count * sizeof(double));
    memcpy(scene->x1, x1, 3 * vertex_count * sizeof(double));
    memcpy(scene->triangles, triangles, 3 * triangle_count * sizeof(uint32_t));
    finish(scene);
}

void patch_scene_destroy(patch_scene *scene) {
    topology_destroy(&scene->heap, &scene->topo);
    free(scene->triangles);
    free(scene->x0);
    free(scene->x1);
}

void patch_scene_move(patch_scene *scene, double flow, double noise, uint64_t *seed) {
    vec3 const waves = random_vector(seed, 4.0), way = random_vector(seed, flow);
    vec3 const turn = random_vector(seed, flow);
    for (size_t i = 0; i < scene->vertex_count; i++) {
        vec3 const x = vec3_load(scene->x0, i);
        vec3 moved = vec3_add_scaled(x, way, sin(vec3_dot(waves, x)));
        moved = vec3_add(moved, vec3_cross(turn, x));
        vec3_store(scene->x1, i, vec3_add(moved, random_vector(seed, noise)));
    }
}

/* ---- discs ---- */

static uint32_t find_root(uint32_t *parents, uint32_t i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

/* Of one patch: its triangles are joined over edges that exactly two triangles of the whole surface
 * share, and vertices - edges + triangles = 1 with every vertex in one fan: a disc. */
static void assert_is_disc(const patch_scene *scene, const uint32_t *labels, uint32_t label,
                           uint32_t *parents) {
    const topology *const topo = &scene->topo;
    size_t triangles = 0, edges = 0, vertices = 0, joined = 0;
    for (uint32_t i = 0; i < topo->triangle_count; i++) {
        parents[i] = i;
        triangles += labels[i] == label;
    }
    for (size_t e = 0; e < topo->edge_count; e++) {
        uint32_t sides[2], count = 0;
        uint32_t const vertex = topo->edges[2 * e];
        for (size_t i = topo->vertex_triangles.begin[vertex];
             i < topo->vertex_triangles.begin[vertex + 1]; i++) {
            uint32_t const triangle = topo->vertex_triangles.items[i];
            for (uint32_t k = 0; k < 3 && labels[triangle] == label; k++) {
                if (topo->triangle_edges[3 * triangle + k] != e) continue;
                assert_true(count < 2);
                sides[count++] = 3 * triangle + k;
            }
        }
        edges += count > 0;
        if (count < 2) continue;
        assert_true(topo->triangles[sides[0]] != topo->triangles[sides[1]]); /* opposite ways */
        uint32_t const a = find_root(parents, sides[0] / 3), b = find_root(parents, sides[1] / 3);
        if (a != b) joined++;
        parents[a] = b;
    }
    assert_int_equal(joined + 1, triangles);
    for (size_t v = 0; v < topo->vertex_count; v++) {
        size_t corners = 0, rims = 0;
        for (size_t k = topo->vertex_triangles.begin[v]; k < topo->vertex_triangles.begin[v + 1];
             k++) {
            uint32_t const triangle = topo->vertex_triangles.items[k];
            if (labels[triangle] != label) continue;
            corners++;
            for (size_t e = 0; e < 3; e++) {
                uint32_t const edge = topo->triangle_edges[3 * triangle + e];
                if (topo->edges[2 * edge] != v && topo->edges[2 * edge + 1] != v) continue;
                const uint32_t *const both = topo->edge_triangles + 2 * (size_t)edge;
                uint32_t const other = both[0] == triangle ? both[1] : both[0];
                rims += other == TULLE_NONE || labels[other] != label;
            }
        }
        vertices += corners > 0;
        assert_true(rims == 0 || rims == 2); /* one fan, open or closed */
    }
    assert_int_equal((long)vertices - (long)edges + (long)triangles, 1);
}

void assert_patches_are_discs(const patch_scene *scene, const uint32_t *labels) {
    uint32_t *const parents = calloc(scene->triangle_count + 1, sizeof *parents);
    uint8_t *const is_done = calloc(scene->triangle_count + 2, 1);
    assert_true(parents && is_done);
    for (size_t i = 0; i < scene->triangle_count; i++) {
        assert_true(labels[i] <= scene->triangle_count);
        if (labels[i] == PATCH_ISOLATED || is_done[labels[i]]) continue;
        is_done[labels[i]] = 1;
        assert_is_disc(scene, labels, labels[i], parents);
    }
    free(parents);
    free(is_done);
}

/* ---- apart ---- */

static bool boxes_meet(const moving_pair *pair, int split, double margin) {
    for (int axis = 0; axis < 3; axis++) {
        double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
        for (int i = 0; i < 4; i++) {
            for (int end = 0; end < 2; end++) {
                const vec3 *const p = end ? &pair->end[i] : &pair->start[i];
                double const x = axis == 0 ? p->x : axis == 1 ? p->y : p->z;
                low[i >= split] = fmin(low[i >= split], x);
                high[i >= split] = fmax(high[i >= split], x);
            }
        }
        if (low[0] > high[1] + margin || low[1] > high[0] + margin) return false;
    }
    return true;
}

static size_t assert_apart(const patch_scene *scene, feature_kind kind, const uint32_t four[4],
                           double separation, uint64_t *seed) {
    moving_pair pair;
    for (int i = 0; i < 4; i++) {
        pair.start[i] = vec3_load(scene->x0, four[i]);
        pair.end[i] = vec3_load(scene->x1, four[i]);
    }
    if (!boxes_meet(&pair, kind == FEATURE_EDGE_EDGE ? 2 : 1, separation)) return 0;
    assert_false(exact_pair_touches(kind, &pair, 1.0));
    for (int sample = 0; sample < 4 && separation > 0.0; sample++)
        assert_true(exact_pair_is_farther(
            kind, &pair, sample == 3 ? random_uniform(seed) : 0.5 * sample, separation));
    return 1;
}

static bool share_corner(const uint32_t *a, size_t a_count, const uint32_t *b, size_t b_count) {
    for (size_t i = 0; i < a_count; i++) {
        for (size_t k = 0; k < b_count; k++) {
            if (a[i] == b[k]) return true;
        }
    }
    return false;
}

static size_t assert_triangles_are_apart(const patch_scene *scene, uint32_t first, uint32_t second,
                                         double separation, uint64_t *seed) {
    const uint32_t *const a = scene->triangles + 3 * (size_t)first;
    const uint32_t *const b = scene->triangles + 3 * (size_t)second;
    size_t count = 0;
    for (size_t i = 0; i < 3; i++) {
        if (!share_corner(&a[i], 1, b, 3)) {
            uint32_t const four[4] = {a[i], b[0], b[1], b[2]};
            count += assert_apart(scene, FEATURE_VERTEX_TRIANGLE, four, separation, seed);
        }
        if (!share_corner(&b[i], 1, a, 3)) {
            uint32_t const four[4] = {b[i], a[0], a[1], a[2]};
            count += assert_apart(scene, FEATURE_VERTEX_TRIANGLE, four, separation, seed);
        }
        for (size_t k = 0; k < 3; k++) {
            uint32_t const four[4] = {a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]};
            if (share_corner(four, 2, four + 2, 2)) continue;
            count += assert_apart(scene, FEATURE_EDGE_EDGE, four, separation, seed);
        }
    }
    return count;
}

size_t assert_patches_are_apart(const patch_scene *scene, const uint32_t *labels, double separation,
                                uint64_t *seed) {
    size_t count = 0;
    for (uint32_t i = 0; i < scene->triangle_count; i++) {
        if (labels[i] == PATCH_ISOLATED) continue;
        for (uint32_t k = i + 1; k < scene->triangle_count; k++) {
            if (labels[k] == labels[i])
                count += assert_triangles_are_apart(scene, i, k, separation, seed);
        }
    }
    return count;
}
