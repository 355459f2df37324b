/* experiments.c - the groups of experiments in the order of the table. A new file of experiments
 * needs two lines here. */
#include "validation/validation.h"

extern const experiment fabric_experiments[];
extern const experiment laws_experiments[];
extern const experiment bends_experiments[];
extern const experiment shears_experiments[];
extern const experiment drape_experiments[];
extern const experiment incline_experiments[];
extern const experiment capstan_experiments[];
extern const experiment layers_experiments[];
extern const experiment tablecloth_experiments[];
extern const experiment pinched_experiments[];
extern const experiment carried_experiments[];
extern const experiment impact_experiments[];
extern const experiment settling_experiments[];
extern const experiment turning_experiments[];
extern const experiment between_experiments[];
extern const experiment tips_experiments[];
extern const experiment untangle_experiments[];
extern const experiment scenes_experiments[];

const experiment *const validation_groups[] = {
    fabric_experiments,     /* strips of woven cloth */
    laws_experiments,       /* woven cloth and closed forms */
    bends_experiments,      /* loops and struts */
    shears_experiments,     /* frames that shear woven cloth */
    drape_experiments,      /* round samples over a disc */
    incline_experiments,    /* Coulomb's law on a slope */
    capstan_experiments,    /* a ribbon around a cylinder */
    layers_experiments,     /* sheets on sheets */
    tablecloth_experiments, /* a cloth pulled from under another */
    pinched_experiments,    /* a sheet held at one point */
    carried_experiments,    /* on moving obstacles */
    impact_experiments,     /* restitution, momentum and energy of impacts */
    settling_experiments,   /* energy */
    turning_experiments,    /* edges that turn in contact */
    between_experiments,    /* a sheet between two layers */
    tips_experiments,       /* cloth on sharp tips */
    untangle_experiments,   /* starts that intersect */
    scenes_experiments,     /* the scenes of the repository */
    NULL,
};
