/* app/view/hold.h - what hands do in a live scene: cloth and bodies that are held by a limited
 * force, obstacles that are moved. What is held is told before each step, so a step depends on
 * nothing but the state and this struct, and the same commands lead to the same bits. */
#ifndef TULLE_APP_VIEW_HOLD_H
#define TULLE_APP_VIEW_HOLD_H

#include "app/view/document.h"
#include "app/view/message.h"
#include "scene/scene.h"

#include "tulle/attach.h"

enum { HOLD_GRAB_MAX = 32, HOLD_DRIVEN_MAX = 64, HOLD_CORNERS = 3 };

/* Cloth: corners of a triangle, each held by a spring at a point of its own. A body: by its drive.
 */
typedef struct hold_grab {
    uint32_t id, object;
    size_t corner_count; /* 0: a body */
    tulle_attachment_id attachments[HOLD_CORNERS];
    uint32_t vertices[HOLD_CORNERS];
    double offsets[HOLD_CORNERS][3]; /* [m] of the corners from the point that was grabbed */
    double shares[HOLD_CORNERS];     /* of the force */
    double local[3];  /* [m] of a body: the point, from its centre, without its turn */
    double target[3]; /* [m] where the point is to go */
    double force;     /* [N] most that all corners get together */
} hold_grab;

/* An obstacle that is driven by hand, or a body. */
typedef struct hold_driven {
    uint32_t object;
    bool is_body;
    double middle[3];              /* [m] of its mesh's box: turns are about it */
    double position[3], target[3]; /* [m] of the middle */
    double rotation[4], aim[4];    /* w, x, y, z */
    double force;                  /* [N] of a body */
} hold_driven;

typedef struct live_hold {
    hold_grab grabs[HOLD_GRAB_MAX];
    size_t grab_count;
    uint32_t next_grab;
    hold_driven
        driven[HOLD_DRIVEN_MAX]; /* obstacles in the order in which they were taken in hand */
    size_t driven_count;
    double gravity[3];
    tulle_wind wind;
} live_hold;

typedef struct hold_scene {
    tulle_scene *scene;
    tulle_scene_world *built;
    const view_document *document;
    live_hold *hold;
} hold_scene;

void hold_begin(hold_scene *held);
/* Commands; `request` as read. hold_grab_object writes the grab's number to request->grab. */
tulle_status hold_grab_object(hold_scene *held, view_request *request, tulle_error *error);
tulle_status hold_drag(hold_scene *held, const view_request *request, tulle_error *error);
tulle_status hold_let_go(hold_scene *held, const view_request *request, tulle_error *error);
tulle_status hold_cut_pin(hold_scene *held, const view_request *request, tulle_error *error);
tulle_status hold_move(hold_scene *held, const view_request *request, tulle_error *error);
tulle_status hold_set(hold_scene *held, const view_request *request, tulle_error *error);
/* Before a step of so many seconds: tells the world what hands do during it. */
void hold_apply(hold_scene *held, double time_step);
/* After a step that did not fail. */
void hold_accept(hold_scene *held, double time_step);
/* Obstacles stay where they are. Whether one was on its way. */
bool hold_stop_obstacles(hold_scene *held);

#endif
