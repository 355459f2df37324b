/* app/view/pick.h - all that is known of a place on a surface: vertex, edge, triangle, contacts. */
#ifndef TULLE_APP_VIEW_PICK_H
#define TULLE_APP_VIEW_PICK_H

#include "app/view/document.h"
#include "app/view/message.h"

#include "tulle/world.h"
#include "tulle_io/scene.h"

/* Of the object that was picked; what is null is not known and left out. */
typedef struct pick_facts {
    const view_document *document;
    uint32_t frame;
    const double *positions, *velocities; /* 3 a vertex */
    const double *strains;                /* 3 a triangle */
    const float *places; /* 3 a vertex: where strains are measured beside the flat shape instead */
    const uint32_t *patches;       /* a label a triangle */
    const tulle_contact *contacts; /* of all objects */
    size_t contact_count;
    const uint32_t *numbers; /* the document's number of each of the contacts' objects */
    const tulle_scene *scene;
} pick_facts;

/* Members of the answer. Errors: TULLE_ERROR_INVALID_ARGUMENT (no such object or triangle). */
tulle_status pick_write(const pick_facts *facts, const view_request *request, view_buffer *answer,
                        tulle_error *error);

#endif
