/* experiments.c - the groups of experiments in the order of the table. A new file of experiments
 * needs two lines here. */
#include "validation/validation.h"

extern const experiment incline_experiments[];

const experiment *const validation_groups[] = {
    incline_experiments,
    NULL,
};
