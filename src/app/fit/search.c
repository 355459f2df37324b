/* app/fit/search.c - see search.h. The measure mostly grows with the unknown; no step needs that,
 * for noise may hide it. */
#include "app/fit/search.h"

#include <math.h>
#include <string.h>

enum { STEPS_BEYOND = 6, DIVISIONS = 2 };
/* A gap whose ends differ by less is not divided: noise is then larger than what would be learnt.
 */
static const double NARROW = 1.08;
/* What is known no better than to this factor is not known. */
static const double VAGUE = 10.0;
/* Least standard deviation of a sample, for few samples may agree by chance: of the simulated drape
 * coefficients [%] of a fabric it is 0.5 to 1.5. */
static const double NOISE_LEAST = 0.5;

typedef struct search_work {
    const search_goal *goal;
    search_measure measure;
    void *context;
    search_result *result;
} search_work;

/* Measures at these values and sorts the points in. */
static tulle_status add_points(const search_work *work, const double *values, size_t count,
                               tulle_error *error) {
    search_result *const found = work->result;
    search_point added[SEARCH_FIRST_MAX];
    for (size_t i = 0; i < count; i++) added[i] = (search_point){.unknown = values[i]};
    tulle_status const status = work->measure(work->context, added, count, error);
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        size_t place = found->point_count++;
        for (; place > 0 && found->points[place - 1].unknown > added[i].unknown; place--)
            found->points[place] = found->points[place - 1];
        found->points[place] = added[i];
    }
    return status;
}

static double measure_excess(const search_work *work, size_t point) {
    return work->result->points[point].mean - work->goal->measure;
}

/* First point after which the curve crosses the goal; the last point: it does not. */
static size_t find_crossing(const search_work *work) {
    size_t const last = work->result->point_count - 1;
    for (size_t i = 0; i < last; i++)
        if (measure_excess(work, i) * measure_excess(work, i + 1) <= 0.0) return i;
    return last;
}

/* Where the straight line from point i to the next one has this excess; they differ in it. */
static double find_between(const search_work *work, size_t i, double excess) {
    const search_point *const a = &work->result->points[i], *const b = a + 1;
    double const begin = measure_excess(work, i), end = measure_excess(work, i + 1);
    double const part = (excess - begin) / (end - begin);
    return a->unknown * pow(b->unknown / a->unknown, fmin(fmax(part, 0.0), 1.0));
}

/* Goes on beyond the end on whose side the goal lies, by longer steps each time. */
static tulle_status go_beyond(const search_work *work, tulle_error *error) {
    const search_goal *const goal = work->goal;
    const search_point *const points = work->result->points;
    tulle_status status = TULLE_OK;
    for (int step = 0; step < STEPS_BEYOND && status == TULLE_OK; step++) {
        size_t const last = work->result->point_count - 1;
        if (find_crossing(work) != last) break;
        bool const is_upwards = measure_excess(work, last) < 0.0;
        double const end = points[is_upwards ? last : 0].unknown;
        double const next = is_upwards ? fmin(goal->most, end * end / points[last - 1].unknown)
                                       : fmax(goal->least, end * end / points[1].unknown);
        if (next == end) break;
        status = add_points(work, &next, 1, error);
    }
    return status;
}

static tulle_status divide_gap(const search_work *work, tulle_error *error) {
    const search_point *const points = work->result->points;
    tulle_status status = TULLE_OK;
    for (int i = 0; i < DIVISIONS && status == TULLE_OK; i++) {
        size_t const at = find_crossing(work);
        if (at + 1 == work->result->point_count ||
            points[at + 1].unknown < NARROW * points[at].unknown ||
            fabs(points[at + 1].mean - points[at].mean) < NOISE_LEAST)
            break;
        double const nearest =
            fmin(fabs(measure_excess(work, at)), fabs(measure_excess(work, at + 1)));
        if (nearest < 0.5 * NOISE_LEAST) break;
        double const next = find_between(work, at, 0.0);
        if (!(next > points[at].unknown && next < points[at + 1].unknown)) break;
        status = add_points(work, &next, 1, error);
    }
    return status;
}

static double measure_noise(const search_work *work) {
    const search_result *const found = work->result;
    double sum = 0.0;
    for (size_t i = 0; i < found->point_count; i++)
        sum += found->points[i].deviation * found->points[i].deviation;
    double const sample = fmax(sqrt(sum / (double)found->point_count), NOISE_LEAST);
    return sample / sqrt((double)work->goal->samples);
}

/* The values between which all lie whose measure is within the error. */
static void find_interval(const search_work *work) {
    search_result *const found = work->result;
    double low = INFINITY, high = 0.0;
    for (size_t i = 0; i < found->point_count; i++) {
        double const here = measure_excess(work, i);
        if (fabs(here) <= found->error) {
            low = fmin(low, found->points[i].unknown);
            high = fmax(high, found->points[i].unknown);
        }
        for (int side = -1; side <= 1 && i + 1 < found->point_count; side += 2) {
            double const edge = side * found->error;
            if ((here - edge) * (measure_excess(work, i + 1) - edge) >= 0.0) continue;
            double const place = find_between(work, i, edge);
            low = fmin(low, place);
            high = fmax(high, place);
        }
    }
    found->low = low;
    found->high = high;
    found->is_low_open = low <= work->goal->least * (1.0 + 1e-9);
    found->is_high_open = high >= work->goal->most * (1.0 - 1e-9);
}

static void choose_value(const search_work *work) {
    search_result *const found = work->result;
    size_t const crossing = find_crossing(work);
    if (crossing + 1 < found->point_count) {
        double const rise = measure_excess(work, crossing + 1) - measure_excess(work, crossing);
        found->unknown =
            fabs(rise) > 0.0 ? find_between(work, crossing, 0.0) : found->points[crossing].unknown;
        return;
    }
    size_t nearest = 0;
    for (size_t i = 1; i < found->point_count; i++)
        if (fabs(measure_excess(work, i)) < fabs(measure_excess(work, nearest))) nearest = i;
    found->unknown = found->points[nearest].unknown;
}

/* Least squares over the points within a factor of e; over all where these are fewer than three. */
static double fit_slope(const search_result *found) {
    for (double reach = 1.0;; reach = INFINITY) {
        double count = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
        for (size_t i = 0; i < found->point_count; i++) {
            double const away = log(found->points[i].unknown / found->unknown);
            if (fabs(away) > reach) continue;
            count += 1.0, x += away, y += found->points[i].mean;
            xx += away * away, xy += away * found->points[i].mean;
        }
        if (count > 2.5 || isinf(reach)) return (count * xy - x * y) / (count * xx - x * x);
    }
}

tulle_status search_find(const search_goal *goal, search_measure measure, void *context,
                         search_result *result, tulle_error *error) {
    *result = (search_result){0};
    search_work const work = {goal, measure, context, result};
    tulle_status status = add_points(&work, goal->first, goal->first_count, error);
    if (status == TULLE_OK) status = go_beyond(&work, error);
    if (status == TULLE_OK) status = divide_gap(&work, error);
    if (status != TULLE_OK) return status;
    result->error = hypot(goal->error, measure_noise(&work));
    choose_value(&work);
    result->slope = fit_slope(result);
    find_interval(&work);
    bool is_above = true;
    for (size_t i = 0; i < result->point_count; i++) is_above &= measure_excess(&work, i) < 0.0;
    if (result->low > result->high)
        result->verdict = is_above ? SEARCH_TOO_HIGH : SEARCH_TOO_LOW;
    else if (result->is_low_open || result->is_high_open || result->high > VAGUE * result->low)
        result->verdict = SEARCH_VAGUE;
    return TULLE_OK;
}
