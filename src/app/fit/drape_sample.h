/* app/fit/drape_sample.h - a round sample of cloth on the disc of Cusick's drapemeter: its mesh,
 * how it starts, when it hangs still, how much of the ring around the disc its shadow covers. The
 * sample has a radius of 0.15 m, the disc one of 0.09 m. */
#ifndef TULLE_APP_FIT_DRAPE_SAMPLE_H
#define TULLE_APP_FIT_DRAPE_SAMPLE_H

#include "tulle/mesh.h"
#include "tulle/world.h"

#include <stdbool.h>

typedef enum drape_pattern {
    DRAPE_RINGS,
    DRAPE_IRREGULAR_RINGS,
    DRAPE_LATTICE,
    DRAPE_PATTERNS
} drape_pattern;

typedef struct drape_sample {
    tulle_mesh mesh; /* as it starts: uneven around the disc */
    uint32_t *held;  /* vertices on the disc */
    size_t held_count;
    double area; /* [m^2] of the flat sample */
    tulle_pin pin;
} drape_sample;

/* Makes a sample whose edges are about `cell` [m] long. What is uneven about its start follows from
 * the seed, and so does an irregular mesh. Release with drape_sample_destroy, also after an
 * error. */
tulle_status drape_sample_make(drape_pattern pattern, double cell, uint32_t seed,
                               drape_sample *sample, tulle_error *error);
void drape_sample_destroy(drape_sample *sample);

/* The sample as a cloth that wants to lie flat and is held on the disc. The sample must stay where
 * it is until the cloth is added. Air slows it, so that it comes to rest. */
tulle_cloth_def drape_sample_get_cloth(drape_sample *sample, const tulle_material *material);

/* Whether nothing moves faster than 2 mm/s. */
bool drape_is_at_rest(const double *velocities, size_t vertex_count);

/* [%] Part of the ring around the disc that the shadow covers. */
double drape_measure_coefficient(const drape_sample *sample, const double *positions);
/* Times that the height of the rim goes above its mean, once round. */
int drape_count_folds(const drape_sample *sample, const double *positions);

#endif
