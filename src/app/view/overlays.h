/* app/view/overlays.h - what explains a frame beyond positions, as the bytes that go over the wire
 * behind the head of a message of kind 3. */
#ifndef TULLE_APP_VIEW_OVERLAYS_H
#define TULLE_APP_VIEW_OVERLAYS_H

#include "app/view/buffer.h"

#include "tulle/check.h"
#include "tulle/world.h"

typedef struct view_document view_document;

/* Number on the wire less one. */
typedef enum view_overlay_kind {
    OVERLAY_CONTACTS,
    OVERLAY_VELOCITIES,
    OVERLAY_PATCHES,
    OVERLAY_STRAIN,
    OVERLAY_GAPS,
    OVERLAY_CROSSINGS,
    OVERLAY_COUNT
} view_overlay_kind;

/* Those that take long are made beside the network, and come when they are ready. */
static const unsigned OVERLAYS_LATE = 1u << OVERLAY_GAPS | 1u << OVERLAY_CROSSINGS;

typedef struct view_overlay {
    bool is_filled;
    uint32_t count; /* items: of contacts and crossings their number, else objects */
    view_buffer bytes;
} view_overlay;

/* OVERLAY_COUNT for a name that is none. */
view_overlay_kind overlays_find(const char *name);
/* Set of overlays, as bits, that a document can give. */
unsigned overlays_get_possible(const view_document *document);
void overlays_write_names(const view_document *document, view_buffer *buffer);

/* Empties an overlay and marks it as filled. */
void overlay_begin(view_overlay *overlay);
void overlay_put_contacts(view_overlay *overlay, const tulle_contact *contacts, size_t count);
/* Begins the values of an object: `count` vertices or triangles. */
void overlay_put_object(view_overlay *overlay, size_t object, size_t count);
void overlay_put_doubles(view_overlay *overlay, const double *values, size_t count);
void overlay_put_pairs(view_overlay *overlay, const tulle_check_pair *pairs, size_t count);
/* Strain of a triangle beside its flat shape at rest: along u, along v, shear. */
void overlay_measure_flat_strain(const float *uv, const float *positions, const uint32_t corners[3],
                                 double strain[3]);
/* The same of the triangles of all cloth. */
void overlay_put_flat_strains(view_overlay *overlay, const view_document *document,
                              const float *positions);

/* The message of kind 3. */
void overlay_write(const view_overlay *overlay, view_overlay_kind kind, uint32_t frame, double time,
                   view_buffer *buffer);

#endif
