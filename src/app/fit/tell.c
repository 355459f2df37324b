/* app/fit/tell.c - what `tulle fit` found, in words and as JSON. */
#include "app/cli/json_text.h"
#include "app/commands.h"
#include "app/fit/fit.h"

#include <math.h>
#include <string.h>

static const double MILLIMETRES_PER_METRE = 1e3;

/* [mm] Bending length that goes with a rigidity of the fabric. */
static double measure_length(const fit_found *found, double rigidity) {
    return MILLIMETRES_PER_METRE *
           fit_compute_bending_length(rigidity, found->material.area_density);
}

static void tell_bending(const fit_story *story, const char *mark, FILE *stream) {
    const fit_found *const found = story->found;
    const tulle_material *const material = &found->material;
    const fit_measures *const measures = story->measures;
    const double rigidities[2] = {material->bend_warp, material->bend_weft};
    for (int i = 0; i < 2; i++) {
        fprintf(stream, "%sbending along the %s %.3g N m", mark, i == 0 ? "warp" : "weft",
                rigidities[i]);
        if (found->bend_errors[i] > 0.0)
            fprintf(stream, " +- %.0f %%", 1e2 * found->bend_errors[i]);
        fprintf(stream, ", bending length %.3g mm: ", measure_length(found, rigidities[i]));
        if (isfinite(measures->lengths[i]))
            fputs("measured\n", stream);
        else if (isfinite(measures->lengths[1 - i]))
            fputs("not measured, in proportion to the other direction\n", stream);
        else if (found->unknown == FIT_BENDING && found->search.verdict == SEARCH_VAGUE)
            fputs("the best fit to the drape coefficient, which no value gives exactly\n", stream);
        else if (found->unknown == FIT_BENDING)
            fputs("found by the drape coefficient\n", stream);
        else
            app_print_names(stream, "taken from %s\n", story->start);
    }
}

static void tell_drape(const fit_story *story, const char *mark, FILE *stream) {
    const fit_found *const found = story->found;
    if (found->unknown == FIT_NOTHING) return;
    fprintf(stream,
            "%sdrape coefficient %.3g +- %.2g %% measured; with the noise of samples and meshes",
            mark, story->measures->drape, story->measures->drape_error);
    if (found->unknown != FIT_BENDING)
        fprintf(stream, " and bending (+- %.2g %%)", found->bend_influence);
    fprintf(stream, " +- %.2g %%; %u drape tests were simulated\n", found->search.error,
            found->tests);
    if (found->unknown == FIT_DRAPE)
        fprintf(stream, "%swith this bending and shear the fabric drapes at %.1f %%\n", mark,
                found->search.points[0].mean);
    if (found->is_coarse)
        fprintf(stream,
                "%sedges of the samples were longer than a third of the bending length, "
                "which holds cloth up: it may well drape lower\n",
                mark);
    if (found->restless > 0)
        fprintf(stream, "%s%u of them still moved after 6 s\n", mark, found->restless);
}

/* Least and most mean of the points. */
static void find_range(const search_result *search, double *least, double *most) {
    *least = INFINITY, *most = -INFINITY;
    for (size_t i = 0; i < search->point_count; i++) {
        *least = fmin(*least, search->points[i].mean);
        *most = fmax(*most, search->points[i].mean);
    }
}

static void tell_shear(const fit_story *story, const char *mark, FILE *stream) {
    const fit_found *const found = story->found;
    const search_result *const search = &found->search;
    double const value = found->material.shear.stiffness;
    fprintf(stream, "%sshear %.3g N/m: ", mark, value);
    if (isfinite(story->measures->shear)) {
        fputs("measured\n", stream);
    } else if (found->unknown != FIT_SHEAR) {
        app_print_names(stream, "taken from %s\n", story->start);
    } else if (search->verdict == SEARCH_FOUND) {
        fprintf(stream,
                "found by the drape coefficient, %.3g to %.3g N/m fit; %.2g %% for each doubling\n",
                search->low, search->high, search->slope * log(2.0));
    } else {
        double least = 0.0, most = 0.0;
        find_range(search, &least, &most);
        fprintf(
            stream,
            "the drape coefficient cannot decide it: all from %.3g to %.3g N/m fit. From %.3g to "
            "%.3g N/m the fabric drapes at %.1f to %.1f %%, %.2g %% for each doubling\n",
            search->low, search->high, search->points[0].unknown,
            search->points[search->point_count - 1].unknown, least, most, search->slope * log(2.0));
        if (found->keeps_shear)
            app_print_names(stream, "%sit is taken from %s; measure it, as KES-F does\n", mark,
                            story->start);
        else
            fprintf(stream, "%sit is the best fit; no value fits exactly\n", mark);
    }
}

static void tell_bending_search(const fit_story *story, const char *mark, FILE *stream) {
    const fit_found *const found = story->found;
    const search_result *const search = &found->search;
    if (found->unknown != FIT_BENDING) return;
    fprintf(stream, "%sbending lengths of %.3g to %.3g mm fit%s; %.2g %% for each mm\n", mark,
            measure_length(found, search->low), measure_length(found, search->high),
            search->is_high_open  ? " and more, which were not tried"
            : search->is_low_open ? " and less, which were not tried"
                                  : "",
            /* B ~ c^3 */
            3.0 * search->slope / measure_length(found, search->unknown));
    app_print_names(stream, "%sthe ratio of warp to weft is taken from %s\n", mark, story->start);
    if (search->verdict == SEARCH_VAGUE)
        fprintf(stream,
                "%sthe drape coefficient says little about so stiff or so soft a fabric; measure "
                "bending lengths\n",
                mark);
}

/* Why no material agrees with the measures, and which bending would. */
static void tell_conflict(const fit_story *story, const char *mark, FILE *stream) {
    const fit_found *const found = story->found;
    const search_result *const advice = &found->advice;
    double least = 0.0, most = 0.0;
    find_range(&found->search, &least, &most);
    if (found->unknown == FIT_SHEAR)
        fprintf(stream,
                "%sno shear from %.3g to %.3g N/m gives that drape coefficient: with these bending "
                "lengths the fabric drapes at %.1f to %.1f %%\n",
                mark, found->search.points[0].unknown,
                found->search.points[found->search.point_count - 1].unknown, least, most);
    else if (found->unknown == FIT_BENDING)
        fprintf(stream,
                "%sno bending gives that drape coefficient: bending lengths from %.3g to %.3g mm "
                "drape at %.1f to %.1f %%\n",
                mark, measure_length(found, found->search.points[0].unknown),
                measure_length(found, found->search.points[found->search.point_count - 1].unknown),
                least, most);
    if (advice->point_count == 0 || advice->low > advice->high) return;
    fprintf(stream,
            "%sa bending length of %.3g mm (%.3g to %.3g mm), the geometric mean of warp and "
            "weft, would fit with a shear of %.3g N/m; it is %.3g mm. Bending or drape must be "
            "measured again\n",
            mark, measure_length(found, advice->unknown), measure_length(found, advice->low),
            measure_length(found, advice->high), found->material.shear.stiffness,
            measure_length(found, sqrt(found->material.bend_warp * found->material.bend_weft)));
}

void fit_tell(const fit_story *story, const char *mark, FILE *stream) {
    if (isfinite(story->measures->density))
        fprintf(stream, "%sarea density %.4g kg/m^2: measured\n", mark, story->measures->density);
    tell_drape(story, mark, stream);
    if (!fit_is_possible(story->found)) {
        tell_conflict(story, mark, stream);
        return;
    }
    tell_bending(story, mark, stream);
    tell_bending_search(story, mark, stream);
    tell_shear(story, mark, stream);
}

/* ---- JSON ---- */

/* `,"KEY":VALUE` */
static void print_number(FILE *stream, const char *key, double value) {
    fprintf(stream, ",\"%s\":", key);
    json_print_double(stream, value);
}

/* `,"KEY":{...}`: what a search found, with all of its points. */
static void print_search(FILE *stream, const char *key, const search_result *search) {
    static const char *const verdicts[] = {"found", "vague", "too low", "too high"};
    fprintf(stream, ",\"%s\":{\"verdict\":\"%s\"", key, verdicts[search->verdict]);
    print_number(stream, "value", search->unknown);
    bool const has_interval = search->low <= search->high;
    print_number(stream, "low", has_interval ? search->low : (double)NAN);
    print_number(stream, "high", has_interval ? search->high : (double)NAN);
    print_number(stream, "drape_error", search->error);
    print_number(stream, "slope", search->slope);
    fputs(",\"points\":[", stream);
    for (size_t i = 0; i < search->point_count; i++) {
        const search_point *const point = &search->points[i];
        fputs(i > 0 ? ",{\"value\":" : "{\"value\":", stream);
        json_print_double(stream, point->unknown);
        print_number(stream, "drape", point->mean);
        print_number(stream, "least", point->least);
        print_number(stream, "most", point->most);
        fputc('}', stream);
    }
    fputs("]}", stream);
}

void fit_tell_json(const fit_story *story, FILE *stream) {
    static const char *const unknowns[] = {"nothing", "shear", "bending", "drape"};
    const fit_found *const found = story->found;
    const tulle_material *const material = &found->material;
    fputs("{\"file\":", stream);
    if (fit_is_possible(found))
        json_print_text(stream, story->path);
    else
        fputs("null", stream);
    fputs(",\"start\":", stream);
    json_print_text(stream, story->start);
    fprintf(stream, ",\"searched\":\"%s\"", unknowns[found->unknown]);
    print_number(stream, "drape", story->measures->drape);
    print_number(stream, "area_density", material->area_density);
    print_number(stream, "bend_warp", material->bend_warp);
    print_number(stream, "bend_weft", material->bend_weft);
    print_number(stream, "bend_error_warp", found->bend_errors[0]);
    print_number(stream, "bend_error_weft", found->bend_errors[1]);
    print_number(stream, "bend_influence", found->bend_influence);
    print_number(stream, "shear", material->shear.stiffness);
    if (found->unknown != FIT_NOTHING) print_search(stream, "search", &found->search);
    if (found->advice.point_count > 0) print_search(stream, "bending_that_fits", &found->advice);
    fprintf(stream, ",\"is_coarse\":%s,\"tests\":%u,\"restless\":%u}\n",
            found->is_coarse ? "true" : "false", found->tests, found->restless);
}
