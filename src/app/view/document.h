/* app/view/document.h - what is looked at: its objects with their meshes, and what the page is told
 * of it. A document does not change; a scene that is loaded anew is a new document. */
#ifndef TULLE_APP_VIEW_DOCUMENT_H
#define TULLE_APP_VIEW_DOCUMENT_H

#include "app/view/buffer.h"
#include "base/arena.h"
#include "scene/picture.h"

#include "tulle/base.h"

enum { VIEW_PROTOCOL = 1, VIEW_OBJECT_MAX = 8192 };

typedef enum view_role { ROLE_CLOTH, ROLE_OBSTACLE, ROLE_BODY } view_role;
typedef enum view_kind { KIND_RUN, KIND_MESH, KIND_SCENE } view_kind;

typedef struct view_object {
    const char *name;
    view_role role;
    tulle_mesh_view mesh; /* as the document opens; `rest` of cloth */
    float *positions;     /* the same, 3 a vertex */
    float *uv;            /* 2 a vertex [m]; null: none */
    size_t vertex_begin;  /* among the vertices of all objects */
    bool is_static;       /* its vertices stay where they are, unless it is moved by hand */
    double color[3];      /* sRGB */
    size_t pin_count;
    double thickness;     /* [m]; 0: not said */
    const char *material; /* null: not known */
} view_object;

typedef struct view_document {
    memory heap;
    arena storage; /* of all that the document holds */
    view_kind kind;
    const char *title, *name; /* what is shown; the file's name without its folder */
    bool is_live, is_editable, has_debug;
    view_object *objects; /* cloths first */
    size_t object_count, cloth_count, vertex_count;
    double low[3], high[3]; /* [m] of everything at the start */
    double frame_seconds, step_seconds;
    scene_camera camera;
    double gravity[3], wind[3], gust_strength;
    const char *problems; /* JSON list of what is wrong with the scene, or null */
} view_document;

/* An empty document with room for so many objects. False without memory. */
bool document_begin(view_document *document, size_t object_count);
/* Fills the next object: copies name and mesh (single precision, and uv of cloth). */
tulle_status document_add(view_document *document, const char *name, view_role role,
                          tulle_mesh_view mesh, tulle_error *error);
/* A copy that lives as long as the document; null for null and without memory. */
const char *document_copy_text(view_document *document, const char *text);
/* After the last object: colors, ranges, box. `picture` says how they look; null: not known. */
void document_finish(view_document *document, const scene_picture *picture);
void document_destroy(view_document *document);

/* What changes while a document is looked at. */
typedef struct view_progress {
    uint32_t frame_count;
    bool is_under_way;
} view_progress;
/* The message `document`. */
void document_write(const view_document *document, view_progress progress, view_buffer *buffer);
/* The message of kind 1 of an object. */
void document_write_mesh(const view_document *document, size_t object, view_buffer *buffer);

/* Begins a binary message: its head of 24 bytes. */
typedef struct view_head {
    unsigned kind, object;
    uint32_t frame;
    double time; /* [s] */
    uint32_t sequence, count;
} view_head;
void document_write_head(view_head head, view_buffer *buffer);

#endif
