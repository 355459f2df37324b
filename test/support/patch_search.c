/* support/patch_search.c - see patch_search.h. */
#include "support/patch_search.h"
#include "base/hash.h"
#include "support/patch_rules.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

typedef struct patch_search {
    const search_plan *plan;
    search_outcome *outcome;
    open_surface *of;
    uint64_t seed;
    rule_state rule;
    patch_verdict verdict; /* of the last motion judged */
    double score;          /* smaller is better */
    patch_pair held;       /* the pair that goes on touching, when driven to acceptance */
    vec3 axis;             /* along which the contour is to be simple then */
} patch_search;

static double random_between(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

static uint32_t random_below(uint64_t *seed, size_t count) {
    return (uint32_t)(random_next(seed) % count);
}

static vec3 random_direction(uint64_t *seed) {
    double const x = random_between(seed, -1, 1), y = random_between(seed, -1, 1);
    return vec3_normalize(vec3_make(x, y, random_between(seed, -1, 1)));
}

/* ---- how good a motion is ---- */

/* Nearness of parts that are far apart on the surface, and how much is in patches at all. */
static double score_contact(const patch_search *search) {
    const open_surface *const of = search->of;
    size_t patched = 0;
    for (size_t t = 0; t < of->triangle_count; t++) patched += search->rule.labels[t] != 0;
    double const share = (double)patched / (double)of->triangle_count;
    double const nearest = fmin(search->verdict.nearest_distance / of->edge, 100.0);
    return nearest + 0.5 * (1.0 - share);
}

/* Twice the area of a projected triangle at a time. */
static double find_turn(const open_surface *of, vec3 axis, const uint32_t corners[3], double t) {
    vec3 p[3];
    for (int k = 0; k < 3; k++)
        p[k] = vec3_lerp(vec3_load(of->x0, corners[k]), vec3_load(of->x1, corners[k]), t);
    return vec3_dot(axis, vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
}

/* How far two projected edges reach over one another; 0 when they do not cross. */
static double find_crossing(const open_surface *of, vec3 axis, const uint32_t a[2],
                            const uint32_t b[2], double t) {
    const uint32_t triples[4][3] = {
        {a[0], a[1], b[0]}, {a[0], a[1], b[1]}, {b[0], b[1], a[0]}, {b[0], b[1], a[1]}};
    double turns[4], least = 1e300;
    for (int i = 0; i < 4; i++) {
        turns[i] = find_turn(of, axis, triples[i], t);
        least = fmin(least, fabs(turns[i]));
    }
    bool const crosses = turns[0] * turns[1] < 0.0 && turns[2] * turns[3] < 0.0;
    return crosses ? least : 0.0;
}

/* What keeps the certificate from accepting the whole surface: triangles that do not face the axis,
 * boundary edges that cross in projection. */
static double score_acceptance(const patch_search *search) {
    enum { TIMES = 4 };
    const open_surface *const of = search->of;
    static uint32_t edges[2 * OPEN_TRIANGLES * 3];
    size_t edge_count = 0;
    double const area = of->edge * of->edge;
    double score = 0.0;
    for (size_t t = 0; t < of->triangle_count; t++)
        for (int i = 0; i <= TIMES; i++) {
            double const turn =
                find_turn(of, search->axis, of->triangles + 3 * t, (double)i / (double)TIMES);
            score += fmax(0.02 - turn / area, 0.0);
        }
    for (size_t e = 0; e < of->topo.edge_count; e++)
        if (of->topo.edge_triangles[2 * e + 1] == TULLE_NONE)
            memcpy(edges + 2 * edge_count++, of->topo.edges + 2 * e, 2 * sizeof *edges);
    for (size_t a = 0; a < edge_count; a++)
        for (size_t b = a + 1; b < edge_count; b++)
            for (int i = 0; i <= TIMES; i++) {
                double const crossing = find_crossing(of, search->axis, edges + 2 * a,
                                                      edges + 2 * b, (double)i / (double)TIMES);
                if (crossing > 0.0) score += 0.01 + crossing / area;
            }
    return score;
}

/* Labels, verdict and score of the motion as it stands; true when a patch touches itself. */
static bool judge_motion(patch_search *search) {
    search_outcome *const outcome = search->outcome;
    const open_surface *const of = search->of;
    rule_apply(&search->rule, of);
    search->verdict = judge_patches(of, search->rule.labels, search->rule.label_count,
                                    search->rule.settings.reach);
    outcome->motion_count++;
    outcome->pair_count += search->verdict.pair_count;
    outcome->exact_count += search->verdict.exact_count;
    outcome->triangle_count += of->triangle_count;
    for (size_t t = 0; t < of->triangle_count; t++)
        outcome->patched_count += search->rule.labels[t] != 0;
    outcome->nearest = fmin(outcome->nearest, search->verdict.nearest_distance / of->edge);
    outcome->is_found = search->verdict.violation_count > 0;
    outcome->pair = search->verdict.violation;
    search->score =
        search->plan->drive == DRIVE_TO_CONTACT ? score_contact(search) : score_acceptance(search);
    return outcome->is_found;
}

/* ---- moves ---- */

static void shift_vertex(open_surface *of, size_t vertex, vec3 by, int ends) {
    if (ends & 1) vec3_store(of->x0, vertex, vec3_add(vec3_load(of->x0, vertex), by));
    if (ends & 2) vec3_store(of->x1, vertex, vec3_add(vec3_load(of->x1, vertex), by));
}

static double fall_off(int hops, double radius) {
    double const x = (double)hops / radius;
    return hops == 255 ? 0.0 : exp(-x * x);
}

static void shift_bump(patch_search *search, double size, int ends) {
    open_surface *const of = search->of;
    size_t const count = of->vertex_count, centre = random_below(&search->seed, count);
    double const radius = random_between(&search->seed, 0.3, 6.0);
    vec3 const by = vec3_scale(random_direction(&search->seed), size);
    for (size_t i = 0; i < count; i++)
        shift_vertex(of, i, vec3_scale(by, fall_off(of->hops[centre * count + i], radius)), ends);
}

static int find_least_hops(const open_surface *of, size_t vertex, const uint32_t *from,
                           int from_count) {
    int least = 255;
    for (int i = 0; i < from_count; i++) {
        int const hops = of->hops[from[i] * of->vertex_count + vertex];
        if (hops < least) least = hops;
    }
    return least;
}

/* The nearest pair is brought nearer, or further on, with what is around it. */
static void close_gap(patch_search *search, int ends) {
    open_surface *const of = search->of;
    const patch_pair *const near = &search->verdict.nearest;
    if (near->label == 0) return;
    moving_pair pair;
    vec3 points[4];
    load_moving_pair(of, near->vertices, &pair);
    for (int i = 0; i < 4; i++)
        points[i] = vec3_lerp(pair.start[i], pair.end[i], search->verdict.nearest_time);
    vec3 const apart = closest_of_pair(near->kind, points).difference;
    double const part = random_between(&search->seed, 0.05, 1.2);
    double const radius = random_between(&search->seed, 0.3, 5.0);
    int const first_count = near->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    for (size_t i = 0; i < of->vertex_count; i++) {
        double const a = fall_off(find_least_hops(of, i, near->vertices, first_count), radius);
        double const b =
            fall_off(find_least_hops(of, i, near->vertices + first_count, 4 - first_count), radius);
        shift_vertex(of, i, vec3_scale(apart, 0.5 * part * (b - a)), ends);
    }
}

/* The whole end is stretched along one direction, about a vertex. */
static void stretch_end(patch_search *search, int ends) {
    open_surface *const of = search->of;
    vec3 const along = random_direction(&search->seed);
    double const by = random_between(&search->seed, -0.1, 0.1);
    size_t const fixed = random_below(&search->seed, of->vertex_count);
    vec3 const centre = vec3_load(ends & 1 ? of->x0 : of->x1, fixed);
    for (size_t i = 0; i < of->vertex_count; i++) {
        vec3 const from = vec3_load(ends & 1 ? of->x0 : of->x1, i);
        double const height = vec3_dot(along, vec3_sub(from, centre));
        shift_vertex(of, i, vec3_scale(along, by * height), ends);
    }
}

/* Some coordinates are rounded to a lattice: exact coincidences. */
static void snap_some(patch_search *search) {
    open_surface *const of = search->of;
    double const spacing = exp2(floor(log2(of->edge)) - (double)random_below(&search->seed, 8));
    uint64_t const part = 1 + random_below(&search->seed, 4);
    for (size_t i = 0; i < of->vertex_count; i++) {
        if (random_next(&search->seed) % part != 0) continue;
        for (size_t k = 3 * i; k < 3 * i + 3; k++) {
            of->x0[k] = rint(of->x0[k] / spacing) * spacing;
            of->x1[k] = rint(of->x1[k] / spacing) * spacing;
        }
    }
}

static void move_at_random(patch_search *search, double heat) {
    open_surface *const of = search->of;
    uint64_t *const seed = &search->seed;
    double const size = of->edge * heat * pow(10.0, random_between(seed, -2.0, 0.0));
    int const ends = 1 + (int)random_below(seed, 3);
    uint32_t const choice = random_below(seed, 16);
    if (choice < 4)
        shift_vertex(of, random_below(seed, of->vertex_count),
                     vec3_scale(random_direction(seed), size), ends);
    else if (choice < 9)
        shift_bump(search, size, ends);
    else if (choice < 14 && search->plan->drive == DRIVE_TO_CONTACT)
        close_gap(search, ends);
    else if (choice < 15)
        stretch_end(search, ends);
    else if (!search->plan->wishes.is_plain)
        snap_some(search);
}

/* ---- the search ---- */

static bool is_pair_touching(const patch_search *search) {
    moving_pair pair;
    load_moving_pair(search->of, search->held.vertices, &pair);
    return exact_pair_touches(search->held.kind, &pair, 1.0);
}

/* A pair that touches, among all; false when there is none. The axis is the mean normal. */
static bool choose_held_pair(patch_search *search) {
    static uint32_t all[OPEN_TRIANGLES];
    const open_surface *const of = search->of;
    for (size_t t = 0; t < of->triangle_count; t++) all[t] = 1;
    search->held = judge_patches(of, all, 1, 0.0).violation;
    vec3 sum = {0.0, 0.0, 0.0};
    for (size_t t = 0; t < of->triangle_count; t++) {
        const uint32_t *const c = of->triangles + 3 * t;
        vec3 const a = vec3_load(of->x0, c[0]);
        sum = vec3_add(sum, vec3_cross(vec3_sub(vec3_load(of->x0, c[1]), a),
                                       vec3_sub(vec3_load(of->x0, c[2]), a)));
    }
    search->axis = vec3_normalize(sum);
    return search->held.label != 0;
}

static bool is_acceptable(patch_search *search, double old_score, double heat) {
    double const worse = (search->score - old_score) / (0.1 * heat);
    return worse <= 0.0 || random_uniform(&search->seed) < exp(-worse);
}

/* Whether all is finite and not so far away that doubles have no room for it. */
static bool is_sane(const open_surface *of) {
    for (size_t i = 0; i < 3 * of->vertex_count; i++)
        if (!(fabs(of->x0[i]) < 1e15 && fabs(of->x1[i]) < 1e15)) return false;
    return true;
}

static void anneal(patch_search *search) {
    static double x0[3 * OPEN_VERTICES], x1[3 * OPEN_VERTICES];
    open_surface *const of = search->of;
    int *const step = &search->outcome->step, steps = search->plan->steps;
    if (judge_motion(search)) return;
    if (search->plan->drive == DRIVE_TO_ACCEPTANCE && !choose_held_pair(search)) return;
    for (*step = 1; *step <= steps; ++*step) {
        double const heat = pow(10.0, -2.0 * (double)*step / (double)steps);
        double const old_score = search->score;
        patch_verdict const old_verdict = search->verdict;
        memcpy(x0, of->x0, sizeof x0);
        memcpy(x1, of->x1, sizeof x1);
        move_at_random(search, heat);
        bool const is_allowed =
            is_sane(of) && (search->plan->drive == DRIVE_TO_CONTACT || is_pair_touching(search));
        if (is_allowed && judge_motion(search)) return;
        if (is_allowed && is_acceptable(search, old_score, heat)) continue;
        memcpy(of->x0, x0, sizeof x0);
        memcpy(of->x1, x1, sizeof x1);
        search->score = old_score;
        search->verdict = old_verdict;
    }
}

search_outcome search_patches(memory *heap, const search_plan *plan, open_surface *of) {
    search_outcome outcome = {.nearest = 1e300};
    static patch_search search;
    search =
        (patch_search){.plan = plan, .outcome = &outcome, .of = of, .seed = hash_mix(plan->seed)};
    make_open_surface(heap, plan->family, plan->wishes, &search.seed, of);
    rule_begin(&search.rule, heap, of, plan->rule, &search.seed);
    outcome.reach = search.rule.settings.reach;
    anneal(&search);
    rule_end(&search.rule);
    return outcome;
}
