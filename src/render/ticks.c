/* render/ticks.c - see ticks.h. */
#include "render/ticks.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A tick this near to an end of the scale, as a part of it, is on it: rounding must not drop it. */
static double const end_slack = 1e-9;

double tick_scale_get_part(const tick_scale *scale, double value) {
    if (!scale->is_logarithmic) return (value - scale->low) / (scale->high - scale->low);
    return log(value / scale->low) / log(scale->high / scale->low);
}

static const char *const prefixes[] = {"p", "n", "\xC2\xB5", "m", "", "k", "M", "G"};
enum { PREFIX_COUNT = sizeof prefixes / sizeof prefixes[0], PREFIX_NONE = 4 };

/* Index of the prefix that brings the size of a number into 1 .. 1000. */
static int choose_prefix(double size) {
    int const thousands = size > 0.0 ? (int)floor(log10(size) / 3.0 + end_slack) : 0;
    int const index = PREFIX_NONE + thousands;
    return index < 0 ? 0 : index >= PREFIX_COUNT ? PREFIX_COUNT - 1 : index;
}

static bool has_unit(const tick_scale *scale) { return scale->unit && scale->unit[0]; }

static tick *add_tick(const tick_scale *scale, double value, tick_list *list) {
    double const part = tick_scale_get_part(scale, value);
    if (!(part >= -end_slack && part <= 1.0 + end_slack) || list->count == TICK_MAX) return NULL;
    tick *const added = &list->ticks[list->count++];
    *added = (tick){.part = part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part, .value = value};
    return added;
}

/* The step of 1, 2 or 5 times a power of ten that gives at most label_max ticks. */
static double choose_step(double range, size_t label_max) {
    static double const factors[] = {1.0, 2.0, 5.0};
    double const least = range / (double)label_max;
    for (int exponent = (int)floor(log10(least));; exponent++)
        for (int i = 0; i < 3; i++) {
            double const step = factors[i] * pow(10.0, exponent);
            if (floor(range / step + end_slack) + 1.0 <= (double)label_max) return step;
        }
}

static void make_linear(const tick_scale *scale, size_t label_max, tick_list *list) {
    double const step = choose_step(scale->high - scale->low, label_max);
    double const size = fmax(fabs(scale->low), fabs(scale->high));
    bool const is_prefixed = scale->has_prefixes && has_unit(scale);
    int const prefix = is_prefixed ? choose_prefix(size) : PREFIX_NONE;
    double const divisor = pow(10.0, 3 * (prefix - PREFIX_NONE));
    double const digits = -floor(log10(step / divisor) + end_slack);
    bool const is_plain = size / divisor < 1e6 && digits <= 4.0;
    for (double index = ceil(scale->low / step - end_slack); list->count < label_max; index++) {
        tick *const added = add_tick(scale, index * step, list);
        if (!added) break;
        double const shown = index == 0.0 ? 0.0 : index * step / divisor;
        if (is_plain)
            snprintf(added->label, sizeof added->label, "%.*f", digits > 0.0 ? (int)digits : 0,
                     shown);
        else
            snprintf(added->label, sizeof added->label, "%.4g", shown);
    }
    if (has_unit(scale))
        snprintf(list->unit, sizeof list->unit, "%s%s", prefixes[prefix], scale->unit);
}

static void label_power(const tick_scale *scale, tick *labelled) {
    double const value = labelled->value;
    if (scale->has_prefixes && has_unit(scale)) {
        int const prefix = choose_prefix(value);
        snprintf(labelled->label, sizeof labelled->label, "%.3g %s%s",
                 value / pow(10.0, 3 * (prefix - PREFIX_NONE)), prefixes[prefix], scale->unit);
    } else {
        snprintf(labelled->label, sizeof labelled->label, "%.3g", value);
    }
}

static void make_logarithmic(const tick_scale *scale, size_t label_max, tick_list *list) {
    int const first = (int)floor(log10(scale->low)), last = (int)floor(log10(scale->high));
    int const stride = 1 + (last - first) / (int)label_max;
    bool const has_middle = 3 * (size_t)(last - first + 1) <= label_max;
    bool const has_small = stride == 1 && 9 * (last - first + 1) <= TICK_MAX;
    for (int exponent = first; exponent <= last; exponent++) {
        for (int factor = 1; factor <= 9; factor++) {
            bool const is_middle = factor == 2 || factor == 5;
            bool const is_labelled =
                factor == 1 ? (exponent - last) % stride == 0 : is_middle && has_middle;
            if (!is_labelled && !has_small) continue;
            tick *const added = add_tick(scale, factor * pow(10.0, exponent), list);
            if (added && is_labelled) label_power(scale, added);
        }
    }
    if (has_unit(scale) && !scale->has_prefixes)
        snprintf(list->unit, sizeof list->unit, "%s", scale->unit);
}

void tick_list_make(const tick_scale *scale, size_t label_max, tick_list *list) {
    memset(list, 0, sizeof *list);
    double const range = scale->high - scale->low;
    if (!(range > 0.0) || !isfinite(range) || (scale->is_logarithmic && !(scale->low > 0.0)))
        return;
    if (scale->is_logarithmic)
        make_logarithmic(scale, label_max, list);
    else
        make_linear(scale, label_max, list);
}
