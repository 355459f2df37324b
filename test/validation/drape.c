/* drape.c - a round sample of woven cloth drapes over a disc, as on Cusick's drapemeter: how much
 * of the ring around the disc its shadow covers, and its folds, beside what is published. */
#include "app/fit/drape_sample.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What is published of a fabric's drape coefficient; the mesh on which it is measured. */
typedef struct band {
    const char *fabric;
    double low, high; /* [%] */
    const char *source, *plot;
    double cell; /* [m] at most a third of the bending length: with longer edges yarns that hardly
                    stretch hinder folds, the more the stiffer they are */
} band;

typedef struct drape {
    double coefficient; /* [%] */
    int folds;
} drape;

static void release_sample(void *sample) { drape_sample_destroy(sample); }

static drape measure_drape(validation_run *run, const band *wanted, drape_pattern pattern,
                           uint32_t seed) {
    double const cell = validate_options(run)->is_quick ? 0.015 : wanted->cell;
    drape_sample *const sample = validate_allocate(run, sizeof *sample);
    tulle_error error = {0};
    tulle_status const status = drape_sample_make(pattern, cell, seed, sample, &error);
    validate_own(run, sample, release_sample);
    if (status != TULLE_OK) validate_give_up(run, "sample: %s", error.message);
    tulle_material const material = stage_take_fabric(run, wanted->fabric);
    tulle_cloth_def const def = drape_sample_get_cloth(sample, &material);
    tulle_world *const world = stage_make_woven_world(run);
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    bool is_at_rest = false; /* which takes some 2 s */
    for (int i = 0; i < 12 && (i < 3 || !is_at_rest); i++) {
        validate_simulate(run, world, 0.5);
        size_t count = 0;
        const double *const velocities = tulle_cloth_get_velocities(world, id, &count);
        is_at_rest = drape_is_at_rest(velocities, count);
    }
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    return (drape){drape_measure_coefficient(sample, x), drape_count_folds(sample, x)};
}

static void drapes_as_fabric_does(validation_run *run) {
    static const band bands[] = {
        {"cotton", 60.0, 76.0, "Gan, Ly, Steven 1991, as quoted by others", "drape_cotton", 5e-3},
        {"silk", 20.0, 40.0, "Matsudaira & Yang 2003, as quoted by others", "drape_silk", 3.75e-3},
        {"wool", 40.0, 70.0, "loosely sourced", "drape_wool", 5e-3},
        {"denim", 70.0, 90.0, "loosely sourced", "drape_denim", 7.5e-3},
    };
    static const char *const mesh_names[] = {"rings", "irregular rings", "lattice"};
    const char *const fabric = validate_subject(run);
    const band *wanted = bands;
    while (strcmp(wanted->fabric, fabric) != 0) wanted++;
    bool const is_quick = validate_options(run)->is_quick;
    uint32_t const seeds = is_quick ? 1 : 5;
    int within_count = 0, all = 0;
    validate_start_plot(run, &(validation_plot){.name = wanted->plot,
                                                .title = "Drape of round samples",
                                                .x_label = "sample",
                                                .y_label = "drape coefficient [%]"});
    for (uint32_t seed = 1; seed <= seeds; seed++) {
        validate_plot_point(run, "published, from", seed, wanted->low);
        validate_plot_point(run, "published, to", seed, wanted->high);
    }
    for (int kind = 0; kind < (is_quick ? 1 : DRAPE_PATTERNS); kind++) {
        double sum = 0.0, least = 100.0, most = 0.0, folds = 0.0;
        for (uint32_t seed = 1; seed <= seeds; seed++, all++) {
            drape const found = measure_drape(run, wanted, (drape_pattern)kind, seed);
            char series[48];
            snprintf(series, sizeof series, "*%s", mesh_names[kind]);
            validate_plot_point(run, series, seed, found.coefficient);
            sum += found.coefficient / seeds;
            folds += (double)found.folds / seeds;
            least = fmin(least, found.coefficient), most = fmax(most, found.coefficient);
            within_count += found.coefficient >= wanted->low && found.coefficient <= wanted->high;
        }
        char what[128];
        snprintf(what, sizeof what, "drape coefficient of %s on %s, mean (%.1f to %.1f)", fabric,
                 mesh_names[kind], least, most);
        validate_row(run, what, sum, "%", nothing(), wanted->source);
        snprintf(what, sizeof what, "its folds on %s", mesh_names[kind]);
        validate_row(run, what, folds, "", nothing(), "");
    }
    char what[96];
    snprintf(what, sizeof what, "samples of %d within %.0f to %.0f %%", all, wanted->low,
             wanted->high);
    validate_row(run, what, within_count, "", is_quick ? nothing() : at_least(0.9 * all),
                 wanted->source);
}

const experiment drape_experiments[] = {
    {"drape.cotton", "a round sample drapes over a disc", drapes_as_fabric_does, false},
    {"drape.silk", "the same of silk", drapes_as_fabric_does, true},
    {"drape.wool", "the same of wool", drapes_as_fabric_does, true},
    {"drape.denim", "the same of denim", drapes_as_fabric_does, true},
    {0},
};
