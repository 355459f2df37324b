/* support/patch_rules.c - see patch_rules.h. */
#include "support/patch_rules.h"
#include "base/hash.h"
#include "detect/patches/certificate.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double DEGREE = 0.017453292519943295; /* [rad] */

void rule_begin(rule_state *state, memory *heap, const open_surface *of, patch_rule rule,
                uint64_t *seed) {
    static const double angles[] = {30.0, 45.0, 60.0, 75.0, 85.0, 89.0};
    double const angle = angles[random_next(seed) % 6];
    bool const has_reach =
        (random_next(seed) % 2 == 0 && rule != RULE_CONE) || rule == RULE_WITHOUT_REACH;
    double const reach = has_reach ? of->edge * pow(10.0, -4.0 + 3.0 * random_uniform(seed)) : 0.0;
    *state = (rule_state){
        .heap = heap,
        .rule = rule,
        .settings = {.cone = random_next(seed) % 4 == 0 ? CONE_PAPER : CONE_BERNSTEIN,
                     .max_angle = rule == RULE_CONE ? fmax(angle, 60.0) * DEGREE : angle * DEGREE,
                     .has_certificate = true,
                     .grows_anew = rule != RULE_KEPT,
                     .reach = reach,
                     .keeps_all = true}, /* the surfaces are small */
        .seed = random_next(seed)};
    if (rule >= RULE_KEPT)
        assert_int_equal(kept_patches_create(heap, &of->set, NULL, &state->kept), TULLE_OK);
}

void rule_end(rule_state *state) { kept_patches_destroy(state->kept); }

static void load_corners(const open_surface *of, uint32_t triangle, vec3 start[3], vec3 end[3]) {
    for (size_t k = 0; k < 3; k++) {
        start[k] = vec3_load(of->x0, of->triangles[3 * (size_t)triangle + k]);
        end[k] = vec3_load(of->x1, of->triangles[3 * (size_t)triangle + k]);
    }
}

/* The paper's growth, breadth-first over edges, whatever shape comes out. */
static void grow_by_cone(rule_state *state, const open_surface *of, const normal_cone *cones,
                         uint32_t first) {
    static uint32_t queue[OPEN_TRIANGLES];
    normal_cone cone = cones[first];
    size_t joined = 0;
    state->labels[first] = ++state->label_count;
    queue[joined++] = first;
    for (size_t next = 0; next < joined; next++)
        for (size_t k = 0; k < 6; k++) {
            uint32_t const edge = of->topo.triangle_edges[3 * (size_t)queue[next] + k / 2];
            uint32_t const other = of->topo.edge_triangles[2 * (size_t)edge + k % 2];
            if (other == TULLE_NONE || state->labels[other] != 0 ||
                !normal_cone_is_valid(cones[other]) ||
                !normal_cone_merge(&cone, &cones[other], state->settings.max_angle, &cone))
                continue;
            state->labels[other] = state->label_count;
            queue[joined++] = other;
        }
}

static void apply_cone(rule_state *state, const open_surface *of) {
    static normal_cone cones[OPEN_TRIANGLES];
    memset(state->labels, 0, sizeof state->labels);
    state->label_count = 0;
    for (uint32_t t = 0; t < of->triangle_count; t++) {
        vec3 start[3], end[3];
        load_corners(of, t, start, end);
        cones[t] = normal_cone_of_triangle(state->settings.cone, start, end);
    }
    for (uint32_t t = 0; t < of->triangle_count; t++)
        if (state->labels[t] == 0 && normal_cone_is_valid(cones[t]) &&
            cones[t].half_angle <= state->settings.max_angle)
            grow_by_cone(state, of, cones, t);
}

/* ---- discs ---- */

typedef struct disc {
    uint32_t loop[OPEN_TRIANGLES + 2]; /* the boundary, counterclockwise */
    size_t length;
    bool has_vertex[OPEN_VERTICES];
    size_t triangle_count;
} disc;

/* Where the loop goes from a to b; the length where it does not. */
static size_t find_on_loop(const disc *of, uint32_t a, uint32_t b) {
    size_t i = 0;
    while (i < of->length && !(of->loop[i] == a && of->loop[(i + 1) % of->length] == b)) i++;
    return i;
}

static void insert_in_loop(disc *of, size_t after, uint32_t vertex) {
    memmove(of->loop + after + 2, of->loop + after + 1,
            (of->length - after - 1) * sizeof of->loop[0]);
    of->loop[after + 1] = vertex;
    of->length++;
}

static void remove_from_loop(disc *of, uint32_t vertex) {
    size_t at = 0;
    while (of->loop[at] != vertex) at++;
    memmove(of->loop + at, of->loop + at + 1, (of->length - at - 1) * sizeof of->loop[0]);
    of->length--;
}

/* Joins a triangle when the disc stays one: one edge shared and a new vertex, or two edges. Shared
 * edges are passed the other way round. */
static bool join_disc(disc *to, const uint32_t corners[3]) {
    size_t at = 0, count = 0, shared = 0, open = 0; /* which edge is shared, which is not */
    for (size_t k = 0; k < 3; k++) {
        size_t const found = find_on_loop(to, corners[(k + 1) % 3], corners[k]);
        bool const is_shared = found < to->length;
        count += is_shared;
        if (is_shared)
            at = found, shared = k;
        else
            open = k;
    }
    if (count == 1) {
        uint32_t const opposite = corners[(shared + 2) % 3];
        if (to->has_vertex[opposite]) return false;
        to->has_vertex[opposite] = true;
        insert_in_loop(to, at, opposite);
    } else if (count == 2) {
        remove_from_loop(to, corners[(open + 2) % 3]);
    } else {
        return false;
    }
    to->triangle_count++;
    return true;
}

static double get_proven_reach(const rule_state *state) {
    return state->rule == RULE_WITHOUT_REACH ? 0.0 : state->settings.reach;
}

/* Triangles in random order, again and again, until `wanted` are in or none joins. */
static void grow_disc(rule_state *state, const open_surface *of, uint32_t first, vec3 axis,
                      size_t wanted, disc *to) {
    uint32_t const label = state->label_count + 1;
    const uint32_t *const corners = of->triangles + 3 * (size_t)first;
    memset(to, 0, sizeof *to);
    memcpy(to->loop, corners, 3 * sizeof *corners);
    for (int k = 0; k < 3; k++) to->has_vertex[corners[k]] = true;
    to->length = 3;
    to->triangle_count = 1;
    state->labels[first] = label;
    for (int idle = 0; idle < 3 && to->triangle_count < wanted; idle++) {
        uint32_t const count = (uint32_t)of->triangle_count;
        uint32_t const begin = (uint32_t)(random_next(&state->seed) % count);
        for (uint32_t i = 0; i < count && to->triangle_count < wanted; i++) {
            uint32_t const t = (begin + i) % count;
            vec3 start[3], end[3];
            load_corners(of, t, start, end);
            if (state->labels[t] != 0 ||
                !triangle_faces_axis(start, end, axis, 2.0, get_proven_reach(state)) ||
                !join_disc(to, of->triangles + 3 * (size_t)t))
                continue;
            state->labels[t] = label;
            idle = 0;
        }
    }
}

static bool is_path_proven(const rule_state *state, const disc *patch, vec3 axis, const double *x0,
                           const double *x1) {
    static double scratch[1 << 16];
    assert_true(contour_scratch_size(patch->length) <= sizeof scratch);
    contour const boundary = {.vertices = patch->loop,
                              .vertex_count = patch->length,
                              .x0 = x0,
                              .x1 = x1,
                              .axis = axis,
                              .reach = get_proven_reach(state)};
    return prove_contour(&boundary, 1000000, scratch) != CONTOUR_UNPROVEN;
}

static bool is_contour_proven(const rule_state *state, const open_surface *of, const disc *patch,
                              vec3 axis) {
    if (state->rule == RULE_ENDS_ONLY)
        return is_path_proven(state, patch, axis, of->x0, of->x0) &&
               is_path_proven(state, patch, axis, of->x1, of->x1);
    return is_path_proven(state, patch, axis, of->x0, of->x1);
}

/* Discs as large as the contour test accepts, by halving. */
static void apply_contours(rule_state *state, const open_surface *of) {
    static disc patch;
    memset(state->labels, 0, sizeof state->labels);
    state->label_count = 0;
    for (int tries = 0; tries < 6; tries++) {
        uint32_t const first = (uint32_t)(random_next(&state->seed) % of->triangle_count);
        if (state->labels[first] != 0) continue;
        vec3 start[3], end[3];
        load_corners(of, first, start, end);
        vec3 const tilt = vec3_make(random_uniform(&state->seed), random_uniform(&state->seed),
                                    random_uniform(&state->seed));
        vec3 axis =
            vec3_normalize(vec3_cross(vec3_sub(start[1], start[0]), vec3_sub(start[2], start[0])));
        if (random_next(&state->seed) % 2)
            axis = vec3_add_scaled(axis, vec3_sub(tilt, vec3_make(0.5, 0.5, 0.5)), 1.5);
        if (!triangle_faces_axis(start, end, axis, 2.0, get_proven_reach(state))) continue;
        for (size_t wanted = of->triangle_count; wanted > 1; wanted /= 2) {
            grow_disc(state, of, first, axis, wanted, &patch);
            bool const is_proven = is_contour_proven(state, of, &patch, axis);
            if (is_proven) state->label_count++;
            if (is_proven) break;
            for (size_t t = 0; t < of->triangle_count; t++)
                if (state->labels[t] > state->label_count) state->labels[t] = 0;
        }
    }
}

static void apply_kept(rule_state *state, const open_surface *of) {
    patch_counts counts;
    patch_step const step = {.set = &of->set, .x0 = of->x0, .x1 = of->x1, .threads = 1};
    if (state->rule == RULE_HELD && state->label_count > 0 &&
        patches_hold(state->kept, &step, &state->settings))
        return;
    assert_int_equal(update_patches(state->kept, &step, &state->settings, &counts), TULLE_OK);
    state->label_count = kept_patches_get_labels(state->kept).label_count;
    memcpy(state->labels, kept_patches_get_labels(state->kept).labels,
           of->triangle_count * sizeof state->labels[0]);
}

void rule_apply(rule_state *state, const open_surface *of) {
    switch (state->rule) {
    case RULE_CONE: apply_cone(state, of); break;
    case RULE_WITHOUT_REACH:
    case RULE_ENDS_ONLY:
    case RULE_CONTOURS: apply_contours(state, of); break;
    case RULE_KEPT:
    case RULE_KEPT_ANEW:
    case RULE_HELD: apply_kept(state, of); break;
    }
}
