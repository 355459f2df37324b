/* app/mend/output.h - one surface as `tulle mend` writes it, the cloth as OUT or a body: by what
 * `tulle convert` writes with, from frames that were kept (store.h). */
#ifndef TULLE_APP_MEND_OUTPUT_H
#define TULLE_APP_MEND_OUTPUT_H

#include "app/convert/scene.h"
#include "app/convert/target.h"
#include "app/mend/input.h"
#include "app/mend/store.h"

typedef struct mend_output {
    mend_input *input;
    const mend_store *store;
    size_t surface; /* of input->surfaces */
    convert_target target;
    convert_scene scene;
    axes_change change;             /* from z up to what the target has */
    double *positions, *given;      /* scratch: of the surface */
    bool is_double, has_departures; /* of .npz */
} mend_output;

typedef struct mend_output_options {
    const char *path, *fps;
    const char *up; /* of what is written; null: y in glTF and Alembic, else z */
    bool is_double;
} mend_output_options;

/* Takes the name apart; before the input is opened. */
tulle_status mend_output_name(const mend_output_options *options, mend_output *output,
                              tulle_error *error);
/* Looks whether all can be written; `input` stays the caller's. Release with mend_output_close,
 * also after a failure of either. */
tulle_status mend_output_open(const mend_output_options *options, mend_input *input, size_t surface,
                              mend_output *output, tulle_error *error);
void mend_output_close(mend_output *output);
/* Whether what is written is rounded to float. */
bool mend_output_is_float(const mend_output *output);

/* Leaves frame `index`, from 0, in output->positions, in the axes of the input, and how far each
 * vertex is from where it is given in output->given. */
tulle_status mend_output_measure(mend_output *output, uint32_t index, tulle_error *error);
/* Writes the surface from all frames, which output->store has. */
tulle_status mend_output_write(mend_output *output, tulle_error *error);

#endif
