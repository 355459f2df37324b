/* app/mend/output.h - what `tulle mend` writes. Frames are kept in a file without a name beside OUT
 * until all are there; then OUT is written, by what `tulle convert` writes with. So OUT is absent
 * or whole. */
#ifndef TULLE_APP_MEND_OUTPUT_H
#define TULLE_APP_MEND_OUTPUT_H

#include "app/convert/scene.h"
#include "app/convert/target.h"
#include "app/mend/input.h"

typedef struct mend_output {
    mend_input *input;
    convert_target target;
    convert_scene scene;
    axes_change change; /* from z up to what the target has */
    int store;          /* the file without a name, or -1 */
    double *positions;  /* scratch: of the cloth */
    bool is_double;
} mend_output;

typedef struct mend_output_options {
    const char *path, *fps;
    bool is_double;
} mend_output_options;

/* Takes the name apart; before the input is opened. */
tulle_status mend_output_name(const mend_output_options *options, mend_output *output,
                              tulle_error *error);
/* Looks whether all can be written, and makes the file without a name. Release with
 * mend_output_close, also after a failure of either. */
tulle_status mend_output_open(const mend_output_options *options, mend_input *input,
                              mend_output *output, tulle_error *error);
void mend_output_close(mend_output *output);
/* Whether what is written is rounded to float. */
bool mend_output_is_float(const mend_output *output);

/* Keeps positions of the cloth, z up, of frame `index`, from 0; gives them back. */
tulle_status mend_output_keep(mend_output *output, uint32_t index, const double *positions,
                              tulle_error *error);
tulle_status mend_output_read(const mend_output *output, uint32_t index, double *positions,
                              tulle_error *error);
/* Writes OUT from all frames that were kept. */
tulle_status mend_output_write(mend_output *output, tulle_error *error);

#endif
