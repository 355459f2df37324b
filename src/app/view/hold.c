/* app/view/hold.c - see hold.h.
 *
 * Cloth that is grabbed hangs on springs at the corners of its triangle. A spring gives its share
 * of the force limit when it is GRAB_REACH long; the point that holds it is never farther from the
 * vertex than that, however far away the hand is, so the limit holds. */
#include "app/view/hold.h"

#include "base/error.h"

#include "tulle/bodies.h"
#include "tulle/live.h"

#include <math.h>
#include <string.h>

static const double GRAB_REACH = 0.01;     /* [m] of a spring at its limit: hardly visible */
static const double BODY_REACH = 0.01;     /* [m] of a body's drive at its limit */
static const double BODY_TURN = 0.1;       /* [rad] the same of its turn */
static const double MOVE_SPEED = 0.5;      /* [m/s] of obstacles: cloth before them keeps pace */
static const double MOVE_TURN_SPEED = 1.5; /* [rad/s] the same of turns */

static size_t get_cloth_count(const hold_scene *held) { return held->built->cloth_count; }

static tulle_obstacle_id get_obstacle(const hold_scene *held, uint32_t object) {
    return held->built->obstacles[object - get_cloth_count(held)];
}

static tulle_status check_object(const hold_scene *held, uint32_t object, tulle_error *error) {
    if (object < held->document->object_count) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no object %u", object);
}

void hold_begin(hold_scene *held) {
    *held->hold = (live_hold){.next_grab = 1};
    scene_get_weather(held->scene, held->hold->gravity, &held->hold->wind);
}

/* ---- grabbing ---- */

static hold_grab *find_grab(live_hold *hold, uint32_t id) {
    for (size_t i = 0; i < hold->grab_count; i++)
        if (hold->grabs[i].id == id) return &hold->grabs[i];
    return NULL;
}

static void attach_corners(hold_scene *held, const view_request *request, const uint32_t *corners,
                           hold_grab *grab, tulle_error *error) {
    tulle_cloth_id const cloth = held->built->cloths[request->object];
    const double *const x = tulle_cloth_get_positions(held->built->world, cloth, NULL);
    double sum = 0.0;
    for (int k = 0; k < HOLD_CORNERS; k++) {
        double const share = fmax(request->weights[k], 0.0);
        if (share < 1e-6) continue;
        const double *const place = x + 3 * (size_t)corners[k];
        tulle_attachment_def def = tulle_attachment_def_default();
        def.cloth = cloth;
        def.vertices = &corners[k];
        def.vertex_count = 1;
        def.points = place;
        def.stiffness = share * request->force / GRAB_REACH;
        size_t const next = grab->corner_count;
        /* What is pinned, or held by someone else, is left out. */
        if (tulle_world_attach(held->built->world, &def, &grab->attachments[next], error) !=
            TULLE_OK)
            continue;
        grab->vertices[next] = corners[k];
        grab->shares[next] = share;
        sum += share;
        for (int c = 0; c < 3; c++) grab->offsets[next][c] = place[c] - request->point[c];
        grab->corner_count++;
    }
    for (size_t k = 0; k < grab->corner_count; k++) grab->shares[k] /= sum;
}

static void rotate(const double q[4], const double v[3], double result[3]) {
    double const t[3] = {2.0 * (q[2] * v[2] - q[3] * v[1]), 2.0 * (q[3] * v[0] - q[1] * v[2]),
                         2.0 * (q[1] * v[1] - q[2] * v[0])};
    double const turned[3] = {v[0] + q[0] * t[0] + q[2] * t[2] - q[3] * t[1],
                              v[1] + q[0] * t[1] + q[3] * t[0] - q[1] * t[2],
                              v[2] + q[0] * t[2] + q[1] * t[1] - q[2] * t[0]};
    memcpy(result, turned, sizeof turned);
}

static tulle_status grab_body(hold_scene *held, const view_request *request, hold_grab *grab,
                              tulle_error *error) {
    tulle_transform transform;
    tulle_status const status = tulle_obstacle_get_transform(
        held->built->world, get_obstacle(held, request->object), &transform, error);
    if (status != TULLE_OK) return status;
    const double *const q = transform.rotation;
    double const back[4] = {q[0], -q[1], -q[2], -q[3]};
    double arm[3];
    for (int c = 0; c < 3; c++) arm[c] = request->point[c] - transform.position[c];
    rotate(back, arm, grab->local);
    return TULLE_OK;
}

tulle_status hold_grab_object(hold_scene *held, view_request *request, tulle_error *error) {
    live_hold *const hold = held->hold;
    tulle_status status = check_object(held, request->object, error);
    if (status != TULLE_OK) return status;
    const view_object *const object = &held->document->objects[request->object];
    if (hold->grab_count == HOLD_GRAB_MAX)
        return error_set(error, TULLE_ERROR_LIMIT, "at most %d things are held at once",
                         HOLD_GRAB_MAX);
    if (request->triangle >= object->mesh.triangle_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "'%s' has no triangle %u",
                         object->name, request->triangle);
    if (object->role == ROLE_OBSTACLE)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "'%s' is an obstacle: it is moved, not grabbed", object->name);
    if (request->grab != 0 && request->grab < hold->next_grab)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the grab %u was there already",
                         request->grab);
    hold_grab grab = {.id = request->grab != 0 ? request->grab : hold->next_grab,
                      .object = request->object,
                      .force = request->force};
    memcpy(grab.target, request->point, sizeof grab.target);
    if (object->role == ROLE_CLOTH)
        attach_corners(held, request, object->mesh.triangles + 3 * (size_t)request->triangle, &grab,
                       error);
    else
        status = grab_body(held, request, &grab, error);
    if (status != TULLE_OK) return status;
    if (object->role == ROLE_CLOTH && grab.corner_count == 0)
        return error->status != TULLE_OK
                   ? error->status
                   : error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "nothing can be held there");
    request->grab = grab.id;
    hold->next_grab = grab.id + 1;
    hold->grabs[hold->grab_count++] = grab;
    return TULLE_OK;
}

static tulle_status refuse_grab(const view_request *request, tulle_error *error) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no grab %u", request->grab);
}

tulle_status hold_drag(hold_scene *held, const view_request *request, tulle_error *error) {
    hold_grab *const grab = find_grab(held->hold, request->grab);
    if (!grab) return refuse_grab(request, error);
    memcpy(grab->target, request->point, sizeof grab->target);
    return TULLE_OK;
}

tulle_status hold_let_go(hold_scene *held, const view_request *request, tulle_error *error) {
    live_hold *const hold = held->hold;
    hold_grab *const grab = find_grab(hold, request->grab);
    if (!grab) return refuse_grab(request, error);
    tulle_world *const world = held->built->world;
    tulle_status status = TULLE_OK;
    for (size_t k = 0; k < grab->corner_count && status == TULLE_OK; k++)
        status = tulle_attachment_release(world, grab->attachments[k], error);
    if (grab->corner_count == 0)
        status = tulle_obstacle_set_drive(world, get_obstacle(held, grab->object), NULL, error);
    if (status != TULLE_OK) return status;
    size_t const place = (size_t)(grab - hold->grabs);
    memmove(grab, grab + 1, (hold->grab_count - place - 1) * sizeof *grab);
    hold->grab_count--;
    return TULLE_OK;
}

/* ---- pins, obstacles ---- */

tulle_status hold_cut_pin(hold_scene *held, const view_request *request, tulle_error *error) {
    tulle_status status = check_object(held, request->object, error);
    if (status != TULLE_OK) return status;
    size_t pin = SIZE_MAX, count = 0;
    while ((pin = scene_find_pin(held->scene, request->object, request->vertex, pin)) != SIZE_MAX &&
           status == TULLE_OK) {
        status = tulle_cloth_release_pin(held->built->world, held->built->cloths[request->object],
                                         pin, error);
        count++;
    }
    if (status == TULLE_OK && count == 0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no pin holds vertex %u of '%s'",
                         request->vertex, held->document->objects[request->object].name);
    return status;
}

static hold_driven *find_driven(live_hold *hold, uint32_t object) {
    for (size_t i = 0; i < hold->driven_count; i++)
        if (hold->driven[i].object == object) return &hold->driven[i];
    return NULL;
}

static void find_middle(const view_object *object, double middle[3]) {
    double low[3] = {(double)INFINITY, (double)INFINITY, (double)INFINITY};
    double high[3] = {-low[0], -low[0], -low[0]};
    for (size_t i = 0; i < 3 * object->mesh.vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], object->mesh.positions[i]);
        high[i % 3] = fmax(high[i % 3], object->mesh.positions[i]);
    }
    for (int k = 0; k < 3; k++) middle[k] = 0.5 * (low[k] + high[k]);
}

tulle_status hold_move(hold_scene *held, const view_request *request, tulle_error *error) {
    tulle_status status = check_object(held, request->object, error);
    if (status != TULLE_OK) return status;
    live_hold *const hold = held->hold;
    const view_object *const object = &held->document->objects[request->object];
    hold_driven *driven = find_driven(hold, request->object);
    if (object->role == ROLE_CLOTH)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "'%s' is cloth: it is grabbed, not moved", object->name);
    if (!driven && hold->driven_count == HOLD_DRIVEN_MAX)
        return error_set(error, TULLE_ERROR_LIMIT, "at most %d things are moved by hand",
                         HOLD_DRIVEN_MAX);
    if (!driven) {
        if (object->role == ROLE_OBSTACLE)
            status = scene_drive_obstacle(held->scene, held->built,
                                          request->object - get_cloth_count(held), error);
        if (status != TULLE_OK) return status;
        driven = &hold->driven[hold->driven_count++];
        *driven = (hold_driven){.object = request->object,
                                .is_body = object->role == ROLE_BODY,
                                .rotation = {1.0, 0.0, 0.0, 0.0}};
        find_middle(object, driven->middle);
        memcpy(driven->position, driven->middle, sizeof driven->position);
    }
    double norm = 0.0;
    for (int k = 0; k < 4; k++) norm += request->rotation[k] * request->rotation[k];
    for (int k = 0; k < 4; k++) driven->aim[k] = request->rotation[k] / sqrt(norm);
    memcpy(driven->target, request->position, sizeof driven->target);
    driven->force = request->force;
    return TULLE_OK;
}

/* ---- settings ---- */

static tulle_status set_material(hold_scene *held, const view_request *request,
                                 tulle_error *error) {
    tulle_material material;
    if (request->object >= get_cloth_count(held))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "object %u is not a cloth",
                         request->object);
    if (tulle_material_preset(request->name, &material) != TULLE_OK)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no such preset");
    return tulle_cloth_set_material(held->built->world, held->built->cloths[request->object],
                                    &material, error);
}

/* Friction of a cloth with all else: laws that keep the restitution which both sides have. */
static tulle_status set_friction(hold_scene *held, const view_request *request,
                                 tulle_error *error) {
    const tulle_scene_world *const built = held->built;
    size_t const cloth = request->object;
    if (cloth >= built->cloth_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "object %u is not a cloth",
                         request->object);
    double const own = scene_get_object_facts(held->scene, cloth).restitution;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < held->document->object_count && status == TULLE_OK; i++) {
        double const other = scene_get_object_facts(held->scene, i).restitution;
        tulle_contact_law const law = {request->values[0], -1.0, sqrt(own * other)};
        if (i == cloth) continue;
        if (i < built->cloth_count)
            status = tulle_world_set_cloth_cloth_law(built->world, built->cloths[cloth],
                                                     built->cloths[i], &law, error);
        else
            status = tulle_world_set_cloth_obstacle_law(
                built->world, built->cloths[cloth], get_obstacle(held, (uint32_t)i), &law, error);
    }
    return status;
}

tulle_status hold_set(hold_scene *held, const view_request *request, tulle_error *error) {
    live_hold *const hold = held->hold;
    tulle_world *const world = held->built->world;
    tulle_wind wind = hold->wind;
    tulle_status status = TULLE_OK;
    switch (request->what) {
    case SETTING_GRAVITY:
        status = tulle_world_set_gravity(world, request->values, error);
        if (status == TULLE_OK) memcpy(hold->gravity, request->values, sizeof hold->gravity);
        return status;
    case SETTING_WIND: memcpy(wind.velocity, request->values, sizeof wind.velocity); break;
    case SETTING_GUSTS: wind.gust_strength = request->values[0]; break;
    case SETTING_MATERIAL: return set_material(held, request, error);
    case SETTING_FRICTION: return set_friction(held, request, error);
    case SETTING_COUNT: break;
    }
    status = tulle_world_set_wind(world, &wind, error);
    if (status == TULLE_OK) hold->wind = wind;
    return status;
}

/* ---- the step ---- */

/* Draws the points that hold a cloth to where the hand is, but no farther than springs may be. */
static void apply_grab(const hold_scene *held, const hold_grab *grab) {
    tulle_world *const world = held->built->world;
    const double *const x =
        tulle_cloth_get_positions(world, held->built->cloths[grab->object], NULL);
    for (size_t k = 0; k < grab->corner_count; k++) {
        const double *const place = x + 3 * (size_t)grab->vertices[k];
        double way[3], length = 0.0, point[3];
        for (int c = 0; c < 3; c++) {
            way[c] = grab->target[c] + grab->offsets[k][c] - place[c];
            length += way[c] * way[c];
        }
        length = sqrt(length);
        double const part = length > GRAB_REACH ? GRAB_REACH / length : 1.0;
        for (int c = 0; c < 3; c++) point[c] = place[c] + part * way[c];
        (void)tulle_attachment_set_points(world, grab->attachments[k], point, 1, NULL);
    }
}

/* Limits hold along each axis; by a third of the square of the force all together are below it. */
static void set_drive(const hold_scene *held, uint32_t object, const double position[3],
                      const double *rotation, double force) {
    tulle_world *const world = held->built->world;
    tulle_obstacle_id const id = get_obstacle(held, object);
    tulle_transform transform;
    if (tulle_obstacle_get_transform(world, id, &transform, NULL) != TULLE_OK) return;
    double const limit = force / sqrt(3.0), stiffness = limit / BODY_REACH;
    double const inertia =
        (transform.inertia[0] + transform.inertia[4] + transform.inertia[8]) / 3.0;
    double const radius = sqrt(inertia / transform.mass);
    double const torque = limit * radius, turn_stiffness = torque / BODY_TURN;
    tulle_body_drive drive = tulle_body_drive_default();
    for (int c = 0; c < 3; c++) {
        drive.position[c] = position[c];
        drive.stiffness[c] = stiffness;
        drive.damping[c] = 2.0 * sqrt(stiffness * transform.mass);
        drive.force_limit[c] = limit;
        if (!rotation) continue;
        drive.angular_stiffness[c] = turn_stiffness;
        drive.angular_damping[c] = 2.0 * sqrt(turn_stiffness * inertia);
        drive.torque_limit[c] = torque;
    }
    if (rotation) memcpy(drive.rotation, rotation, sizeof drive.rotation);
    (void)tulle_obstacle_set_drive(world, id, &drive, NULL);
}

static void apply_body_grab(const hold_scene *held, const hold_grab *grab) {
    tulle_transform transform;
    if (tulle_obstacle_get_transform(held->built->world, get_obstacle(held, grab->object),
                                     &transform, NULL) != TULLE_OK)
        return;
    double arm[3], position[3];
    rotate(transform.rotation, grab->local, arm);
    for (int c = 0; c < 3; c++) position[c] = grab->target[c] - arm[c];
    set_drive(held, grab->object, position, NULL, grab->force);
}

/* The pose of an obstacle at the end of a step that begins at its own. */
static void find_next_pose(const hold_driven *driven, double time_step, double position[3],
                           double rotation[4]) {
    double way[3], length = 0.0, cosine = 0.0;
    for (int c = 0; c < 3; c++) {
        way[c] = driven->target[c] - driven->position[c];
        length += way[c] * way[c];
    }
    length = sqrt(length);
    for (int c = 0; c < 4; c++) cosine += driven->rotation[c] * driven->aim[c];
    double const sign = cosine < 0.0 ? -1.0 : 1.0; /* the shorter way */
    double const angle = 2.0 * acos(fmin(fabs(cosine), 1.0));
    /* Both arrive together. */
    double const seconds = fmax(length / MOVE_SPEED, angle / MOVE_TURN_SPEED);
    double const part = seconds > time_step ? time_step / seconds : 1.0;
    double norm = 0.0;
    for (int c = 0; c < 3; c++) position[c] = driven->position[c] + part * way[c];
    double const half = 0.5 * angle;
    double const from = half > 1e-6 ? sin((1.0 - part) * half) / sin(half) : 1.0 - part;
    double const to = half > 1e-6 ? sin(part * half) / sin(half) : part;
    for (int c = 0; c < 4; c++) {
        rotation[c] = from * driven->rotation[c] + to * sign * driven->aim[c];
        norm += rotation[c] * rotation[c];
    }
    for (int c = 0; c < 4; c++) rotation[c] /= sqrt(norm);
    if (part == 1.0) {
        memcpy(position, driven->target, sizeof driven->target);
        memcpy(rotation, driven->aim, sizeof driven->aim);
    }
}

static bool is_at_target(const hold_driven *driven) {
    return memcmp(driven->position, driven->target, sizeof driven->position) == 0 &&
           memcmp(driven->rotation, driven->aim, sizeof driven->rotation) == 0;
}

static void apply_driven(const hold_scene *held, const hold_driven *driven, double time_step) {
    double position[3], rotation[4];
    if (driven->is_body) { /* its centre of mass goes along with the middle of its mesh */
        tulle_transform transform;
        double arm[3];
        if (tulle_obstacle_get_transform(held->built->world, get_obstacle(held, driven->object),
                                         &transform, NULL) != TULLE_OK)
            return;
        for (int c = 0; c < 3; c++) arm[c] = transform.centre[c] - driven->middle[c];
        rotate(driven->aim, arm, arm);
        for (int c = 0; c < 3; c++) position[c] = driven->target[c] + arm[c];
        set_drive(held, driven->object, position, driven->aim, driven->force);
        return;
    }
    if (is_at_target(driven)) return;
    find_next_pose(driven, time_step, position, rotation);
    /* A vertex x goes to translation + R x, as the scene's obstacle has no pivot. */
    double turned[3], translation[3];
    rotate(rotation, driven->middle, turned);
    for (int c = 0; c < 3; c++) translation[c] = position[c] - turned[c];
    (void)tulle_obstacle_set_next_transform(held->built->world, get_obstacle(held, driven->object),
                                            translation, rotation, TULLE_TRAVEL_MOVE, NULL);
}

void hold_apply(hold_scene *held, double time_step) {
    const live_hold *const hold = held->hold;
    for (size_t i = 0; i < hold->driven_count; i++) apply_driven(held, &hold->driven[i], time_step);
    for (size_t i = 0; i < hold->grab_count; i++)
        if (hold->grabs[i].corner_count > 0)
            apply_grab(held, &hold->grabs[i]);
        else
            apply_body_grab(held, &hold->grabs[i]);
}

void hold_accept(hold_scene *held, double time_step) {
    live_hold *const hold = held->hold;
    for (size_t i = 0; i < hold->driven_count; i++) {
        hold_driven *const driven = &hold->driven[i];
        double position[3], rotation[4];
        if (driven->is_body || is_at_target(driven)) continue;
        find_next_pose(driven, time_step, position, rotation);
        memcpy(driven->position, position, sizeof position);
        memcpy(driven->rotation, rotation, sizeof rotation);
    }
}

bool hold_stop_obstacles(hold_scene *held) {
    live_hold *const hold = held->hold;
    bool was_moving = false;
    for (size_t i = 0; i < hold->driven_count; i++) {
        hold_driven *const driven = &hold->driven[i];
        if (driven->is_body || is_at_target(driven)) continue;
        was_moving = true;
        memcpy(driven->target, driven->position, sizeof driven->target);
        memcpy(driven->aim, driven->rotation, sizeof driven->aim);
    }
    return was_moving;
}
