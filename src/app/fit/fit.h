/* app/fit/fit.h - for the files of `tulle fit`: what was measured, what is found. */
#ifndef TULLE_APP_FIT_FIT_H
#define TULLE_APP_FIT_FIT_H

#include "app/fit/drape_test.h"
#include "app/fit/search.h"

#include "tulle/world.h"

#include <stdio.h>

enum { FIT_SAMPLES_MAX = 20, FIT_NAME_SIZE = 65, FIT_START_SIZE = 512 };

/* What was measured on the fabric. Not a number: it was not. */
typedef struct fit_measures {
    double drape, drape_error; /* [%] */
    double lengths[2];         /* [m] bending lengths along warp and weft */
    double length_error;       /* [m] */
    double density;            /* [kg/m^2] */
    double shear;              /* [N/m] */
} fit_measures;

/* How drape tests are simulated. */
typedef struct fit_method {
    double cell; /* [m] edges of the meshes; 0: by the bending length */
    uint32_t samples;
    drape_pattern pattern;
    int threads;
    FILE *progress; /* gets a line for each point; null: none */
} fit_method;

/* Which value the drape coefficient was asked for. */
typedef enum fit_unknown {
    FIT_NOTHING, /* no drape coefficient: bending is all there is to find */
    FIT_SHEAR,   /* bending is known */
    FIT_BENDING, /* bending is not known */
    FIT_DRAPE    /* bending and shear are: what they give is compared */
} fit_unknown;

typedef struct fit_found {
    fit_unknown unknown;
    tulle_material material;
    double bend_errors[2]; /* part of bend_warp and bend_weft that they may be off; 0: not known */
    double bend_error;     /* the larger one */
    /* By the drape coefficient. What a search finds of bending is the geometric mean of warp and
     * weft [N m]. */
    search_result search;
    bool keeps_shear;      /* the start's shear fits as well as any other */
    double bend_influence; /* [%] by which the drape coefficient may be off for bend_error */
    search_result advice;  /* where no shear gives the drape coefficient: which bending does */
    uint32_t tests;        /* drape tests that were simulated */
    bool is_coarse;        /* edges were longer than a third of the bending length */
    uint32_t restless;     /* of these, such that still moved at their end */
} fit_found;

/* [N m] Rigidity of a fabric that bends by that length [m]: half of the overhang at which a strip
 * hangs by 41.5 degrees. */
double fit_compute_rigidity(double bending_length, double area_density);
double fit_compute_bending_length(double rigidity, double area_density);

/* Finds what the measures do not say directly, beginning with the material `start`. Which bending
 * length the material has is told by bend_warp and bend_weft of the result. The same bits for any
 * number of threads. Errors: those of drape_test_run. */
tulle_status fit_find(const tulle_material *start, const fit_measures *measures,
                      const fit_method *method, fit_found *found, tulle_error *error);
/* Most drape tests that fit_find may simulate. */
uint32_t fit_count_tests(const fit_measures *measures, const fit_method *method);

/* Whether the measures agree with each other, so that there is a material to write. */
bool fit_is_possible(const fit_found *found);

/* ---- what is told and written ---- */

typedef struct fit_story {
    const fit_measures *measures;
    const fit_found *found;
    const char *start; /* "the preset cotton", "the file x.yaml" */
    const char *path;  /* of the material file */
} fit_story;

/* What was found in words, a fact a line; each line begins with `mark`. */
void fit_tell(const fit_story *story, const char *mark, FILE *stream);
void fit_tell_json(const fit_story *story, FILE *stream);
/* Rounds what was found to four digits; shear down, where the yarns allow no more. */
void fit_round_material(tulle_material *material);
/* Writes the material file, whole or not at all. */
tulle_status fit_write_material(const fit_story *story, tulle_error *error);

#endif
