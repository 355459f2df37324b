/* app/fit/find.c - finds bending and shear of a fabric from what was measured on it.
 *
 * Bending follows from Peirce's bending lengths in closed form. Cusick's drape coefficient is
 * simulated: for shear where bending is known, else for bending, on which it mostly depends. */
#include "app/fit/fit.h"

#include "app/cli/progress_bar.h"
#include "base/error.h"
#include "base/timer.h"

#include <math.h>
#include <stdlib.h>

static const double GRAVITY = 9.81; /* [m/s^2] of the default world */
/* [N/m] From a tenth of what soft woven cloth has by KES-F to several times of what firm denim has.
 */
static const double SHEAR_LEAST = 5.0, SHEAR_MOST = 500.0;
/* [m] Cloth with shorter bending lengths needs finer meshes than CELL_LEAST, with longer ones it
 * does not hang. */
static const double LENGTH_LEAST = 6e-3, LENGTH_MOST = 60e-3;
/* Edges in a bending length: fewer hold cloth up that curves in two directions. */
static const double CELLS = 3.5, CELLS_LEAST = 3.0;
static const double CELL_LEAST = 2.5e-3, CELL_MOST = 7.5e-3; /* [m] */
/* [%] How far apart the means on three kinds of meshes lie: 0.7 to 1.8, half of it to either side.
 */
static const double MESH_ERROR = 1.0;
/* First values of bending over the one that is guessed, to either side. */
static const double BEND_STEP = 1.5;

double fit_compute_rigidity(double bending_length, double area_density) {
    return area_density * GRAVITY * pow(bending_length, 3.0);
}

double fit_compute_bending_length(double rigidity, double area_density) {
    return cbrt(rigidity / (area_density * GRAVITY));
}

typedef struct fit_work {
    const fit_measures *measures;
    const fit_method *method;
    fit_found *found;
    tulle_material material; /* with what is known */
    fit_unknown unknown;     /* what the points are values of */
    double begin;            /* [s] of the clock */
} fit_work;

/* ---- materials ---- */

/* Scales bending rigidities; loops of hysteresis keep their width over the rigidity. */
static void scale_bending(tulle_material *material, double warp, double weft) {
    material->bend_warp *= warp;
    material->bend_weft *= weft;
    material->bend_twist *= sqrt(warp * weft);
    material->bend_hysteresis_warp *= warp;
    material->bend_hysteresis_weft *= weft;
    material->springs.bend_stiffness = 0.5 * (material->bend_warp + material->bend_weft);
}

/* Springs whose shear modulus, 3/8 of their stretch stiffness, is that of the fabric. */
static void set_shear(tulle_material *material, double stiffness) {
    material->shear_hysteresis *= stiffness / material->shear.stiffness;
    material->shear.stiffness = stiffness;
    material->springs.stretch_stiffness = 8.0 / 3.0 * stiffness;
}

static double get_bending(const tulle_material *material) {
    return sqrt(material->bend_warp * material->bend_weft);
}

static void set_unknown(tulle_material *material, fit_unknown unknown, double value) {
    double const factor = value / get_bending(material);
    if (unknown == FIT_SHEAR) set_shear(material, value);
    if (unknown == FIT_BENDING) scale_bending(material, factor, factor);
}

static double get_unknown(const tulle_material *material, fit_unknown unknown) {
    return unknown == FIT_SHEAR ? material->shear.stiffness : get_bending(material);
}

/* What was measured directly. One bending length alone stands for both directions: the other keeps
 * its ratio to it. */
static void apply_measures(const fit_measures *measures, tulle_material *material) {
    if (isfinite(measures->density)) material->area_density = measures->density;
    if (isfinite(measures->shear)) set_shear(material, measures->shear);
    double factors[2] = {NAN, NAN};
    const double rigidities[2] = {material->bend_warp, material->bend_weft};
    for (int i = 0; i < 2; i++)
        factors[i] =
            fit_compute_rigidity(measures->lengths[i], material->area_density) / rigidities[i];
    if (isnan(factors[0])) factors[0] = factors[1];
    if (isnan(factors[1])) factors[1] = factors[0];
    if (isfinite(factors[0])) scale_bending(material, factors[0], factors[1]);
}

/* ---- drape tests ---- */

/* [m] In the direction in which it is shorter. */
static double get_bending_length(const tulle_material *material) {
    return fit_compute_bending_length(fmin(material->bend_warp, material->bend_weft),
                                      material->area_density);
}

static double choose_cell(const fit_method *method, const tulle_material *material) {
    if (method->cell > 0.0) return method->cell;
    return fmin(fmax(get_bending_length(material) / CELLS, CELL_LEAST), CELL_MOST);
}

/* A line on the tests of a point: its samples. */
static void tell_point(const fit_work *work, const search_point *point, const drape_test *tests) {
    FILE *const stream = work->method->progress;
    if (!stream) return;
    const tulle_material *const material = &tests->material;
    uint32_t const done = work->found->tests;
    uint32_t const planned = fit_count_tests(work->measures, work->method);
    double const pace = (timer_now() - work->begin) / done;
    char rest[PROGRESS_DURATION_SIZE];
    progress_format_duration(pace * (planned - done), rest);
    int least = tests->folds, most = tests->folds;
    for (uint32_t i = 1; i < work->method->samples; i++) {
        if (tests[i].folds < least) least = tests[i].folds;
        if (tests[i].folds > most) most = tests[i].folds;
    }
    fprintf(stream,
            "%u of at most %u drape tests: bending length %.3g mm, shear %.3g N/m: %.1f %% (%.1f "
            "to %.1f), %d to %d folds; at most %s more\n",
            done, planned,
            1e3 * fit_compute_bending_length(get_bending(material), material->area_density),
            material->shear.stiffness, point->mean, point->least, point->most, least, most, rest);
    fflush(stream);
}

static void sum_up(const fit_work *work, const drape_test *tests, search_point *point) {
    double const count = work->method->samples;
    double squares = 0.0;
    point->mean = 0.0, point->least = INFINITY, point->most = -INFINITY;
    for (uint32_t i = 0; i < work->method->samples; i++) {
        double const value = tests[i].coefficient;
        point->mean += value / count;
        point->least = fmin(point->least, value), point->most = fmax(point->most, value);
        work->found->restless += !tests[i].is_at_rest;
    }
    for (uint32_t i = 0; i < work->method->samples; i++)
        squares += pow(tests[i].coefficient - point->mean, 2.0);
    point->deviation = count > 1.0 ? sqrt(squares / (count - 1.0)) : 0.0;
}

/* Simulates the tests of all points at once. */
static tulle_status measure_points(void *context, search_point *points, size_t count,
                                   tulle_error *error) {
    const fit_work *const work = context;
    uint32_t const samples = work->method->samples;
    drape_test *const tests = calloc(count * samples, sizeof *tests);
    if (!tests) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for drape tests");
    for (size_t i = 0; i < count * samples; i++) {
        drape_test *const test = &tests[i];
        test->material = work->material;
        set_unknown(&test->material, work->unknown, points[i / samples].unknown);
        test->pattern = work->method->pattern;
        test->cell = choose_cell(work->method, &test->material);
        test->seed = 1 + (uint32_t)(i % samples);
    }
    tulle_status const status =
        drape_test_run(tests, count * samples, work->method->threads, error);
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        work->found->tests += samples;
        sum_up(work, tests + i * samples, &points[i]);
        tell_point(work, &points[i], &tests[i * samples]);
    }
    free(tests);
    return status;
}

/* ---- searches ---- */

static search_goal make_goal(const fit_work *work, double error) {
    return (search_goal){.measure = work->measures->drape,
                         .error = hypot(error, MESH_ERROR),
                         .samples = work->method->samples};
}

/* Bending length [m] of woven cloth that drapes so, whatever its weight: measured on cotton with
 * rigidities from a quarter to eight times of the preset's. It only says where to begin. */
static double guess_length(double drape) {
    static const double known[][2] = {{0.0, 6e-3},   {34.0, 12e-3}, {46.0, 15e-3}, {65.0, 19e-3},
                                      {78.0, 24e-3}, {89.0, 30e-3}, {94.0, 38e-3}, {100.0, 60e-3}};
    size_t i = 0;
    while (drape > known[i + 1][0]) i++;
    double const part = (drape - known[i][0]) / (known[i + 1][0] - known[i][0]);
    return known[i][1] + part * (known[i + 1][1] - known[i][1]);
}

static tulle_status find_bending(fit_work *work, search_result *result, tulle_error *error) {
    double const density = work->material.area_density;
    search_goal goal = make_goal(work, work->measures->drape_error);
    goal.least = fit_compute_rigidity(LENGTH_LEAST, density);
    goal.most = fit_compute_rigidity(LENGTH_MOST, density);
    double const guess = fit_compute_rigidity(guess_length(work->measures->drape), density);
    double const middle = fmin(fmax(guess, goal.least * BEND_STEP), goal.most / BEND_STEP);
    goal.first_count = 3;
    for (int i = 0; i < 3; i++) goal.first[i] = middle * pow(BEND_STEP, i - 1);
    work->unknown = FIT_BENDING;
    return search_find(&goal, measure_points, work, result, error);
}

/* How much the drape coefficient changes when bending is off by its error. */
static tulle_status measure_influence(fit_work *work, tulle_error *error) {
    fit_found *const found = work->found;
    double const bending = get_bending(&work->material), part = 1.0 + found->bend_error;
    search_point points[2] = {{.unknown = bending / part}, {.unknown = bending * part}};
    if (!(found->bend_error > 0.0)) return TULLE_OK;
    work->unknown = FIT_BENDING;
    tulle_status const status = measure_points(work, points, 2, error);
    found->bend_influence = 0.5 * fabs(points[1].mean - points[0].mean);
    return status;
}

static tulle_status find_shear(fit_work *work, tulle_error *error) {
    const tulle_material *const material = &work->material;
    tulle_status status = measure_influence(work, error);
    if (status != TULLE_OK) return status;
    search_goal goal =
        make_goal(work, hypot(work->measures->drape_error, work->found->bend_influence));
    goal.least = SHEAR_LEAST;
    goal.most = fmin(SHEAR_MOST, sqrt(material->warp.stiffness * material->weft.stiffness));
    goal.first_count = SEARCH_FIRST_MAX;
    for (int i = 0; i < SEARCH_FIRST_MAX; i++)
        goal.first[i] = goal.least * pow(goal.most / goal.least, i / (SEARCH_FIRST_MAX - 1.0));
    goal.first[SEARCH_FIRST_MAX - 1] = goal.most;
    work->unknown = FIT_SHEAR;
    return search_find(&goal, measure_points, work, &work->found->search, error);
}

/* Both are known: is the drape coefficient theirs? */
static tulle_status compare_drape(fit_work *work, tulle_error *error) {
    search_result *const result = &work->found->search;
    tulle_status status = measure_influence(work, error);
    search_point point = {.unknown = get_bending(&work->material)};
    work->unknown = FIT_BENDING;
    if (status == TULLE_OK) status = measure_points(work, &point, 1, error);
    if (status != TULLE_OK) return status;
    search_goal const goal =
        make_goal(work, hypot(work->measures->drape_error, work->found->bend_influence));
    double const excess = point.mean - goal.measure;
    *result = (search_result){.unknown = NAN,
                              .low = NAN,
                              .high = NAN,
                              .slope = NAN,
                              .points = {point},
                              .point_count = 1,
                              .error = goal.error};
    if (fabs(excess) > goal.error)
        result->verdict = excess > 0.0 ? SEARCH_TOO_LOW : SEARCH_TOO_HIGH;
    return TULLE_OK;
}

static fit_unknown choose_unknown(const fit_measures *measures) {
    if (isnan(measures->drape)) return FIT_NOTHING;
    if (isnan(measures->lengths[0]) && isnan(measures->lengths[1])) return FIT_BENDING;
    return isnan(measures->shear) ? FIT_SHEAR : FIT_DRAPE;
}

bool fit_is_possible(const fit_found *found) {
    return found->search.verdict != SEARCH_TOO_LOW && found->search.verdict != SEARCH_TOO_HIGH;
}

/* Cubes of bending lengths: thrice the relative error. */
static void set_bend_errors(const fit_measures *measures, fit_found *found) {
    for (int i = 0; i < 2; i++) {
        if (isfinite(measures->lengths[i]))
            found->bend_errors[i] = 3.0 * measures->length_error / measures->lengths[i];
        found->bend_error = fmax(found->bend_error, found->bend_errors[i]);
    }
}

/* Sets what the search found. A vague search of shear leaves the start's where that will do. */
static void apply_search(fit_found *found) {
    const search_result *const search = &found->search;
    double const known = get_unknown(&found->material, found->unknown);
    found->keeps_shear = found->unknown == FIT_SHEAR && search->verdict == SEARCH_VAGUE &&
                         known >= search->low && known <= search->high;
    if (!found->keeps_shear) set_unknown(&found->material, found->unknown, search->unknown);
    if (found->unknown != FIT_BENDING || search->verdict != SEARCH_FOUND) return;
    found->bend_error = sqrt(search->high / search->low) - 1.0;
    found->bend_errors[0] = found->bend_errors[1] = found->bend_error;
}

tulle_status fit_find(const tulle_material *start, const fit_measures *measures,
                      const fit_method *method, fit_found *found, tulle_error *error) {
    *found = (fit_found){.unknown = choose_unknown(measures), .material = *start};
    set_bend_errors(measures, found);
    apply_measures(measures, &found->material);
    fit_work work = {.measures = measures,
                     .method = method,
                     .found = found,
                     .material = found->material,
                     .begin = timer_now()};
    tulle_status status = TULLE_OK;
    switch (found->unknown) {
    case FIT_NOTHING: return TULLE_OK;
    case FIT_BENDING: status = find_bending(&work, &found->search, error); break;
    case FIT_SHEAR: status = find_shear(&work, error); break;
    case FIT_DRAPE: status = compare_drape(&work, error); break;
    }
    if (status != TULLE_OK) return status;
    if (fit_is_possible(found) && found->unknown != FIT_DRAPE) apply_search(found);
    found->is_coarse = choose_cell(method, &found->material) * CELLS_LEAST >
                       get_bending_length(&found->material) * (1.0 + 1e-9);
    if (!fit_is_possible(found) && found->unknown != FIT_BENDING)
        return find_bending(&work, &found->advice, error);
    return TULLE_OK;
}

uint32_t fit_count_tests(const fit_measures *measures, const fit_method *method) {
    enum { INFLUENCE = 2, SHEAR = SEARCH_FIRST_MAX + 2, BENDING = 3 + 6 + 2 };
    static const uint32_t points[] = {[FIT_NOTHING] = 0,
                                      [FIT_SHEAR] = INFLUENCE + SHEAR + BENDING,
                                      [FIT_BENDING] = BENDING,
                                      [FIT_DRAPE] = INFLUENCE + 1 + BENDING};
    return points[choose_unknown(measures)] * method->samples;
}
