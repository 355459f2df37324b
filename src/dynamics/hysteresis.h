/* dynamics/hysteresis.h - hysteresis of woven cloth: sliders added to the elastic laws.
 *
 * Yarns rub on each other where cloth bends and shears. So each triangle has three sliders, of its
 * curvature along the warp, along the weft, and of its shear s. A slider is a spring K in series
 * with dry friction: with q the strain and p its plastic part it pulls with
 *
 *     t = min(max(K (q - p), -Y), Y).
 *
 * Once the motion of a step is accepted, p follows q so far that |K (q - p)| <= Y. Within a step p
 * is constant; then t is the slope of
 *
 *     K/2 (q - p)^2 up to |q - p| = Y/K, and Y (|q - p| - Y / (2 K)) beyond,
 *
 * which is what the slider stores and what it will have lost.
 *
 * Y is half the width of the measured loop, 2HB / 2 and 2HG / 2. K is a multiple of the elastic
 * stiffness. The loop closes within a strain of 2 Y / K after the motion turns. In measured loops
 * that is a small part of the range; a stiffer slider would only make the system stiffer.
 *
 * Based on: Prandtl, Ein Gedankenmodell zur kinetischen Theorie der festen Koerper, 1928 (the
 * element); Kawabata, The Standardization and Analysis of Hand Evaluation, 1980 (2HB and 2HG). */
#ifndef TULLE_DYNAMICS_HYSTERESIS_H
#define TULLE_DYNAMICS_HYSTERESIS_H

#include "base/arena.h"
#include "dynamics/cloth_model.h"

#include <stdbool.h>

/* Sliders of a triangle: of curvature, by yarn, then of shear. */
enum { SLIDER_SHEAR = YARN_COUNT, SLIDER_COUNT };

typedef struct slider_law {
    double stiffness; /* K: [N m] of curvature, [N/m] of shear */
    double most;      /* Y: [N] of curvature, [N/m] of shear; 0: there is no slider */
} slider_law;

typedef struct slider_fabric {
    slider_law laws[SLIDER_COUNT];
} slider_fabric;

/* The curvature [1/m] of a triangle along each yarn is the sum of weights times kinks, n . c of a
 * hinge (cloth_model.h), n its normal. It is that of the bending energy (bending_couplings.c). */
typedef struct curvature_part {
    uint32_t hinge, triangle;
    double weights[YARN_COUNT]; /* [1/m^2] */
} curvature_part;
/* Its own hinges and two of each triangle beside it. */
enum { CURVATURE_PARTS = 9 };

/* The same as a sum over vertices where all hinges had one normal. */
typedef struct curvature_corner {
    uint32_t vertex, triangle;
    double weights[YARN_COUNT]; /* [1/m^2] */
} curvature_corner;

typedef struct cloth_sliders {
    size_t fabric_count, triangle_count, hinge_count, vertex_count;
    slider_fabric *fabrics; /* as those of the elements */
    bool has_bend, has_shear;
    /* All that follows is null where nothing has hysteresis of bending. */
    double *inv_double_areas; /* [1/m^2] by triangle: 1 / (2 rest area) */
    uint32_t *part_begin;     /* by triangle, into parts */
    curvature_part *parts;
    uint32_t *hinge_begin, *hinge_parts; /* by hinge: its parts */
    uint32_t *corner_begin;              /* by triangle, into corners */
    curvature_corner *corners;
    uint32_t *vertex_begin, *vertex_corners; /* by vertex: its corners */
    /* Where two corners of a triangle stand in the system's matrix: a block, or a scalar plus
     * PLACE_IS_SCALAR. Of corner i and j: places[place_begin + i * count + j]. */
    size_t *place_begin;
    uint32_t *places;
} cloth_sliders;
#define PLACE_IS_SCALAR UINT32_C(0x80000000)

/* Parts of cloth_model_build: laws, before hinges are built, and what the bending of hinges fills;
 * the rest once the matrix has its pattern. Nothing is made where no fabric has hysteresis. False:
 * no memory. */
bool hysteresis_begin(memory *heap, const cloth_model_def *def, const double *areas,
                      cloth_model *model);
bool hysteresis_finish(memory *heap, cloth_model *model);
void hysteresis_destroy(memory *heap, cloth_model *model);

static inline bool hysteresis_bends(const cloth_sliders *sliders, uint32_t fabric) {
    const slider_law *const laws = sliders->fabrics[fabric].laws;
    return laws[YARN_WARP].most > 0.0 || laws[YARN_WEFT].most > 0.0;
}

/* How many plastic parts a model has, SLIDER_COUNT a triangle; 0 without hysteresis. */
static inline size_t hysteresis_count(const cloth_model *model) {
    return model->sliders ? SLIDER_COUNT * model->triangle_count : 0;
}

/* A state of the cloth, and where its scratch comes from. */
typedef struct slider_state {
    const double *positions;
    int threads;
    arena *scratch;
} slider_state;

/* Sets plastic parts (hysteresis_count) for cloth that was brought from its rest shape to these
 * positions. TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status hysteresis_start(const cloth_model *model, slider_state state, double *plastic);
/* Lets them follow to these positions; null: sets them to the strains at rest. The same errors;
 * then nothing has changed. */
tulle_status hysteresis_follow(const cloth_model *model, slider_state state, double *plastic);
/* [J] what sliders store, and would lose if plastic parts followed: bending, shear. */
tulle_status hysteresis_measure(const cloth_model *model, slider_state state, const double *plastic,
                                double energies[2]);

/* What sliders of bending bring to the linear system. */
typedef struct slider_slots {
    double *blocks; /* [N/m] times the identity, by block of the system */
    vec3 *sources;  /* [N] 4 a hinge: f - D w of the linear system */
} slider_slots;

/* ---- what the files of hysteresis share ---- */

/* The kink of a hinge and its gradient: normal times weight plus turning, by corner. */
typedef struct hinge_kink {
    double value; /* [m] */
    vec3 normal, turning[4];
} hinge_kink;
hinge_kink hysteresis_measure_kink(const cloth_model *model, size_t hinge, const double *positions);

/* Curvatures of a triangle, from the kinks of all hinges. */
static inline void hysteresis_sum_curvature(const cloth_sliders *sliders, size_t triangle,
                                            const double *kinks, double curvatures[YARN_COUNT]) {
    for (int yarn = 0; yarn < YARN_COUNT; yarn++) curvatures[yarn] = 0.0;
    for (size_t k = sliders->part_begin[triangle]; k < sliders->part_begin[triangle + 1]; k++)
        for (int yarn = 0; yarn < YARN_COUNT; yarn++)
            curvatures[yarn] += sliders->parts[k].weights[yarn] * kinks[sliders->parts[k].hinge];
}

/* F_u and F_v of membrane.h. */
typedef struct yarn_pair {
    vec3 along[YARN_COUNT];
} yarn_pair;
static inline yarn_pair hysteresis_measure_yarns(const membrane_element *element,
                                                 const double *values) {
    vec3 const origin = vec3_load(values, element->corners[0]);
    yarn_pair pair = {0};
    for (int i = 0; i < 2; i++) {
        vec3 const edge = vec3_sub(vec3_load(values, element->corners[i + 1]), origin);
        for (int yarn = 0; yarn < YARN_COUNT; yarn++)
            pair.along[yarn] = vec3_add_scaled(pair.along[yarn], edge, element->gradients[i][yarn]);
    }
    return pair;
}

static inline double slider_clamp(const slider_law *law, double tension) {
    return tension > law->most ? law->most : tension < -law->most ? -law->most : tension;
}

#endif
