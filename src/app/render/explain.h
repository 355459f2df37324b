/* app/render/explain.h - colors and marks that explain a frame: patches, contacts, gaps,
 * velocities, strains, with their legend. */
#ifndef TULLE_APP_RENDER_EXPLAIN_H
#define TULLE_APP_RENDER_EXPLAIN_H

#include "app/render/run.h"
#include "render/overlay.h"

typedef struct picture_explanation {
    memory heap;
    picture_color color;
    double **values;         /* of each body: a number a vertex; null of obstacles */
    double **scratch;        /* the same */
    double **drawn_values;   /* of the subdivided vertices */
    float **vertex_colors;   /* of each body, of the drawn vertices */
    float **triangle_colors; /* of each body, of the drawn triangles */
    float **patch_colors;    /* of each body, of the simulated triangles */
    uint32_t **pieces;       /* of each cloth's triangles */
    size_t *piece_counts;
    tick_scale scale;   /* the same in all frames */
    render_mark *marks; /* contacts */
    size_t mark_count, mark_capacity;
    overlay_swatch swatches[OVERLAY_SWATCH_MAX];
    bool has_legend;
    overlay_legend legend;
    char note[80];
} picture_explanation;

/* Prepares it and finds the scale by looking at some of the chosen frames. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (a run without debug records, and what to do),
 * TULLE_ERROR_OUT_OF_MEMORY, those of reading frames. Close it in any case. */
tulle_status picture_explanation_open(picture_explanation *explanation, picture_run *run,
                                      tulle_error *error);
void picture_explanation_close(picture_explanation *explanation);

/* Sets the colors of the bodies' surfaces and the marks for the frame that was read last. */
tulle_status picture_explain_frame(picture_explanation *explanation, picture_run *run,
                                   tulle_error *error);

/* Adds to a hash what the legend shows. */
uint64_t picture_explanation_hash(const picture_explanation *explanation, uint64_t hash);

#endif
