/* app/view/frame.h - the state of a document at one moment, and how it goes over the wire: exact,
 * or rounded to a grid, whole or as the difference to the frame that a client had before.
 * web/PROTOCOL.md describes the bytes. */
#ifndef TULLE_APP_VIEW_FRAME_H
#define TULLE_APP_VIEW_FRAME_H

#include "app/view/document.h"
#include "app/view/overlays.h"

/* Room for one moment; made for a document. */
typedef struct view_frame {
    uint32_t number; /* of a run's frame, or the step of a live scene */
    uint64_t step;
    double time;                          /* [s] */
    float *positions;                     /* 3 a vertex of all objects */
    uint8_t *is_absent;                   /* of each object */
    view_overlay overlays[OVERLAY_COUNT]; /* those that were asked for */
    memory heap;
    size_t vertex_count, object_count;
} view_frame;

/* False without memory; then it is to be released all the same. */
bool frame_prepare(view_frame *frame, const view_document *document);
void frame_release(view_frame *frame);

/* How an object is coded. */
enum { CODING_UNCHANGED, CODING_EXACT, CODING_KEY, CODING_DELTA };
enum { FRAME_ABSENT = 1 /* flag of an object */, FRAME_BLOCK = 64 /* vertices of a delta block */ };

/* What a client has: the grid of each object and its places there. */
typedef struct frame_grid {
    float low[3], step; /* [m] x = low + step * q; step 0: there is no grid */
} frame_grid;
typedef struct frame_coder {
    memory heap;
    frame_grid *grids;  /* of each object */
    uint8_t *has_state; /* of each object: 0: as its mesh, 1: on its grid, 2: exact */
    uint16_t *places;   /* 3 a vertex of all objects */
    size_t vertex_count, object_count;
} frame_coder;

bool frame_coder_prepare(frame_coder *coder, const view_document *document);
void frame_coder_release(frame_coder *coder);
/* Adds the message of kind 2 to the buffer. Places that are not exact are off by at most half a
 * step of the grid along each axis, and the grid is as fine as 65535 steps over one and a half of
 * the object's length. */
void frame_encode(frame_coder *coder, const view_document *document, const view_frame *frame,
                  bool is_exact, uint32_t sequence, view_buffer *buffer);

#endif
