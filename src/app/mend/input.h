/* app/mend/input.h - what `tulle mend` reads: the cloth and the bodies that it meets, frame by
 * frame, as one array of vertices: those of the cloth, then those of each body. z points up. */
#ifndef TULLE_APP_MEND_INPUT_H
#define TULLE_APP_MEND_INPUT_H

#include "app/cli/axes.h"
#include "app/cli/options.h"
#include "app/convert/source.h"

/* The cloth, or a body. */
typedef struct mend_surface {
    convert_source source;
    axes_change change, back; /* of what is read to z up and the one unit, and back */
    bool is_float;            /* of a body: what is made of it is rounded to float in its file */
    uint32_t vertex_begin, vertex_end, triangle_begin, triangle_end;
    bool is_still; /* it has one frame */
} mend_surface;

typedef struct mend_input {
    mend_surface *surfaces; /* the cloth first */
    size_t surface_count;
    uint32_t frame_count;
    size_t vertex_count, triangle_count; /* of all surfaces */
    uint32_t *triangles;                 /* 3 * triangle_count, in the one numbering */
    uint32_t *local_triangles;           /* the same, each surface numbered from 0 */
    const char *unit;                    /* of all positions: that of OUT */
    bool is_float;                       /* what is read of the cloth is rounded to float */
} mend_input;

typedef struct mend_input_options {
    const char *path, *mesh_path;    /* the animation; --mesh, or null */
    const option_list *bodies;       /* --body */
    const option_list *body_meshes;  /* --body-mesh: of those that are point caches, in order */
    const char *from_up, *from_unit; /* or null; of bodies where their files do not say */
    const char *unit;                /* of OUT; null: as the animation has it */
} mend_input_options;

/* Opens all; release with mend_input_close, also after a failure. */
tulle_status mend_input_open(const mend_input_options *options, mend_input *input,
                             tulle_error *error);
void mend_input_close(mend_input *input);

/* Whether the path names a file that is read. */
bool mend_input_reads(const mend_input *input, const char *path);
/* Number of frame `index`, from 0, in the cloth's file. */
uint32_t mend_input_get_number(const mend_input *input, uint32_t index);
/* Positions of frame `index`, from 0: 3 * vertex_count. */
tulle_status mend_input_read(mend_input *input, uint32_t index, double *positions,
                             tulle_error *error);
/* The same of one surface. */
tulle_status mend_input_read_surface(mend_input *input, size_t surface, uint32_t index,
                                     double *positions, tulle_error *error);
/* Of the cloth alone, and not rounded to float. */
tulle_status mend_input_read_exact(mend_input *input, uint32_t index, double *positions,
                                   tulle_error *error);
/* Rounds positions of a body as its file would. */
void mend_input_round_body(const mend_input *input, size_t surface, double *positions);
/* Vertices of the cloth. */
static inline size_t mend_get_cloth_count(const mend_input *input) {
    return input->surfaces[0].vertex_end;
}

#endif
