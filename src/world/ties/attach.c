/* world/ties/attach.c - the calls of tulle/attach.h: attachments come, move and go between steps.
 *
 * An attachment is the ties of its number in the state; nothing else knows of it. */
#include "tulle/attach.h"

#include "base/error.h"
#include "step/sleep/cloth_sleep.h"
#include "step/ties/ties.h"
#include "world/defs.h"
#include "world/fields/fields.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

static const double POINT_MAX = 1e100;    /* [m] as for meshes */
static const double STIFFNESS_MAX = 1e12; /* [N/m] */
static const double SUM_TOLERANCE = 1e-6; /* of their sum */

tulle_attachment_def tulle_attachment_def_default(void) {
    tulle_attachment_def def;
    fields_set_defaults(&attachment_def_fields, &def);
    return def;
}

/* ---- attachments that were made before the start, kept until then ---- */

/* A copy of an array, or null: of nothing, or without memory. */
static void *copy_array(memory *heap, const void *source, size_t byte_count) {
    void *const copy = source ? memory_allocate(heap, byte_count) : NULL;
    if (copy) memcpy(copy, source, byte_count);
    return copy;
}

static void release_def(memory *heap, tulle_attachment_def *def) {
    size_t const count = def->vertex_count;
    memory_release(heap, (void *)(uintptr_t)def->vertices, count * sizeof(uint32_t));
    memory_release(heap, (void *)(uintptr_t)def->points, 3 * count * sizeof(double));
    memory_release(heap, (void *)(uintptr_t)def->triangles, count * sizeof(uint32_t));
    memory_release(heap, (void *)(uintptr_t)def->weights, 3 * count * sizeof(double));
}

/* Keeps a def until the start; releases all that were kept. */
static tulle_status keep_attachment(tulle_world *world, const tulle_attachment_def *def,
                                    tulle_error *error) {
    memory *const heap = &world->heap;
    size_t const count = def->vertex_count;
    tulle_attachment_def copy = *def;
    bool const has_room = ARRAY_RESERVE(heap, &world->attachments, 1);
    copy.vertices = copy_array(heap, def->vertices, count * sizeof(uint32_t));
    copy.points = copy_array(heap, def->points, 3 * count * sizeof(double));
    copy.triangles = copy_array(heap, def->triangles, count * sizeof(uint32_t));
    copy.weights = copy_array(heap, def->weights, 3 * count * sizeof(double));
    if (!has_room || !copy.vertices || (def->points && !copy.points) ||
        (def->triangles && !copy.triangles) || (def->weights && !copy.weights)) {
        release_def(heap, &copy);
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for an attachment");
    }
    world->attachments.data[world->attachments.count++] = copy;
    return TULLE_OK;
}

void world_release_attachments(tulle_world *world) {
    for (size_t i = 0; i < world->attachments.count; i++)
        release_def(&world->heap, &world->attachments.data[i]);
    ARRAY_FREE(&world->heap, &world->attachments);
}

/* ---- checks ---- */

static tulle_status refuse(tulle_error *error, const char *reason) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "an attachment %s", reason);
}

static tulle_status check_holder(const tulle_world *world, const tulle_attachment_def *def,
                                 tulle_error *error) {
    bool const is_obstacle = def->obstacle.generation != 0;
    bool const is_cloth = def->other_cloth.generation != 0;
    if (is_obstacle + is_cloth + (def->points != NULL) != 1)
        return refuse(error, "needs exactly one holder: an obstacle, another cloth or points");
    if (is_obstacle && world_find_obstacle(world, def->obstacle) == SIZE_MAX)
        return refuse(error, "names an obstacle that the world does not have");
    if (is_cloth && world_find_cloth(world, def->other_cloth) == SIZE_MAX)
        return refuse(error, "names another cloth that the world does not have");
    return TULLE_OK;
}

static tulle_status check_points(const double *points, size_t count, tulle_error *error) {
    for (size_t i = 0; i < 3 * count; i++)
        if (!(fabs(points[i]) <= POINT_MAX))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "coordinate %zu of point %zu is %g; it must be a number of at most %g "
                             "m",
                             i % 3, i / 3, points[i], POINT_MAX);
    return TULLE_OK;
}

/* The places that the def gives: triangles of the surface, without the vertex itself, and weights.
 */
static tulle_status check_places(const tulle_world *world, const tulle_attachment_def *def,
                                 uint32_t surface, tulle_error *error) {
    if (!def->triangles) return TULLE_OK;
    if (surface == TULLE_NONE) return refuse(error, "to points has no triangles");
    const surface_range *const range = &world->work.surfaces[surface];
    size_t const triangle_count = range->triangle_end - range->triangle_begin;
    uint32_t const begin = world->work.surfaces[world_find_cloth(world, def->cloth)].vertex_begin;
    for (size_t i = 0; i < def->vertex_count; i++) {
        if (def->triangles[i] >= triangle_count)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "an attachment names triangle %u of '%s', which has %zu",
                             def->triangles[i], world_surface_name(&world->model, surface),
                             triangle_count);
        const uint32_t *const corners =
            world->model.topo.triangles + 3 * ((size_t)range->triangle_begin + def->triangles[i]);
        double sum = 0.0;
        for (size_t k = 0; k < 3; k++) {
            sum += def->weights[3 * i + k];
            if (corners[k] == begin + def->vertices[i])
                return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                                 "an attachment holds vertex %u at a triangle of its own",
                                 def->vertices[i]);
        }
        if (!(fabs(sum - 1.0) <= SUM_TOLERANCE))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the weights number %zu of an attachment have the sum %g; it must be "
                             "1",
                             i, sum);
    }
    return TULLE_OK;
}

/* Marks the vertices that the def names in `marks`, one a vertex of the cloth; refuses those that
 * it may not name. */
static tulle_status check_vertices(const tulle_world *world, const tulle_attachment_def *def,
                                   uint8_t *marks, tulle_error *error) {
    size_t const index = world_find_cloth(world, def->cloth);
    const world_cloth *const cloth = &world->model.cloths.data[index];
    size_t const count = cloth->mesh.vertex_count;
    enum { PINNED = 1, TIED = 2, NAMED = 4 };
    for (size_t p = 0; p < cloth->pin_count; p++) {
        const world_pin *const pin = &cloth->pins[p];
        if (world->now.time >= pin->release_time) continue;
        for (size_t k = 0; k < pin->vertex_count; k++) marks[pin->vertices[k]] |= PINNED;
    }
    for (size_t i = 0; i < world->now.ties.count; i++) {
        const world_tie *const tie = &world->now.ties.data[i];
        if (isfinite(tie->stiffness) || world->model.vertex_surface[tie->vertex] != index) continue;
        marks[tie->vertex - cloth->vertex_begin] |= TIED;
    }
    bool const is_rigid = !isfinite(def->stiffness);
    for (size_t i = 0; i < def->vertex_count; i++) {
        uint32_t const vertex = def->vertices[i];
        const char *reason = NULL;
        if (vertex >= count)
            reason = "is not there";
        else if (marks[vertex] & NAMED)
            reason = "is named twice";
        else if (marks[vertex] & PINNED)
            reason = "is held by a pin";
        else if (is_rigid && (marks[vertex] & TIED))
            reason = "is held rigidly by another attachment";
        if (reason)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: an attachment names vertex %u, which %s", cloth->name, vertex,
                             reason);
        marks[vertex] |= NAMED;
    }
    return TULLE_OK;
}

/* ---- calls ---- */

/* Adds the ties of the def, of which there is room for, and returns how many. */
static size_t add_ties(tulle_world *world, const tulle_attachment_def *def, uint32_t surface) {
    motion_state *const now = &world->now;
    uint32_t const begin = world->work.surfaces[world_find_cloth(world, def->cloth)].vertex_begin;
    size_t const before = now->ties.count;
    for (size_t i = 0; i < def->vertex_count; i++) {
        world_tie tie = {.number = now->attachment_count + 1,
                         .order = (uint32_t)i,
                         .order_count = (uint32_t)def->vertex_count,
                         .vertex = begin + def->vertices[i],
                         .corners = {TULLE_NONE, TULLE_NONE, TULLE_NONE},
                         .stiffness = def->stiffness,
                         .break_force = def->break_force,
                         .release_time = def->release_time};
        if (surface == TULLE_NONE)
            memcpy(tie.point, def->points + 3 * i, sizeof tie.point);
        else if (def->triangles)
            step_set_tie_place(&world->model, &world->work, tie.vertex,
                               world->work.surfaces[surface].triangle_begin + def->triangles[i],
                               def->weights + 3 * i, &tie);
        else if (!step_find_tie_place(&world->model, &world->work, tie.vertex, surface,
                                      def->max_distance, &tie))
            continue;
        now->ties.data[now->ties.count++] = tie;
    }
    return now->ties.count - before;
}

/* What can be said of a def before the start, too. */
static tulle_status check_def(const tulle_world *world, const tulle_attachment_def *def,
                              tulle_error *error) {
    if (def->cookie != attachment_def_fields.cookie)
        return refuse(error, "needs a def made by tulle_attachment_def_default");
    if (world->model.paper.response != TULLE_RESPONSE_COUPLED)
        return refuse(error, "needs TULLE_RESPONSE_COUPLED");
    size_t const index = world_find_cloth(world, def->cloth);
    if (index == SIZE_MAX) return refuse(error, "names a cloth that the world does not have");
    if (!def->vertices || def->vertex_count == 0) return refuse(error, "needs vertices");
    size_t const count = world->model.cloths.data[index].mesh.vertex_count;
    if (def->vertex_count > count) return refuse(error, "names more vertices than the cloth has");
    if ((def->triangles != NULL) != (def->weights != NULL))
        return refuse(error, "gives triangles and weights together, or none of them");
    tulle_status status = check_holder(world, def, error);
    if (status == TULLE_OK)
        status = fields_check(&attachment_def_fields, def, "an attachment", NULL, error);
    if (status == TULLE_OK && isfinite(def->stiffness) && def->stiffness > STIFFNESS_MAX)
        return refuse(error, "has a stiffness that is neither at most 1e12 N/m nor INFINITY");
    return status;
}

/* Attaches to the world as it is; `def` has passed check_def. */
static tulle_status attach_now(tulle_world *world, const tulle_attachment_def *def,
                               tulle_error *error) {
    uint32_t surface = TULLE_NONE; /* of what holds; none for points */
    if (def->other_cloth.generation != 0)
        surface = (uint32_t)world_find_cloth(world, def->other_cloth);
    else if (!def->points)
        surface = (uint32_t)(world->model.cloths.count + world_find_obstacle(world, def->obstacle));
    const world_cloth *const cloth = &world->model.cloths.data[world_find_cloth(world, def->cloth)];
    size_t const count = cloth->mesh.vertex_count;
    tulle_status status = TULLE_OK;
    if (def->obstacle.generation != 0 &&
        !world->now.is_present[world_find_obstacle(world, def->obstacle)])
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "an attachment is to '%s', which is not in the scene now",
                         world_surface_name(&world->model, surface));
    uint8_t *const marks = memory_allocate_zeroed(&world->heap, count, 1);
    if (!marks || world->now.attachment_count == UINT32_MAX ||
        !ARRAY_RESERVE(&world->heap, &world->now.ties, def->vertex_count) ||
        !ARRAY_MATCH(&world->heap, &world->now.ties, &world->next.ties))
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for an attachment");
    if (status == TULLE_OK) status = check_vertices(world, def, marks, error);
    memory_release(&world->heap, marks, count);
    if (status == TULLE_OK) status = check_places(world, def, surface, error);
    if (status != TULLE_OK) return status;
    if (add_ties(world, def, surface) == 0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "no vertex that '%s' attaches is within %g m of '%s'", cloth->name,
                         def->max_distance,
                         surface == TULLE_NONE ? "" : world_surface_name(&world->model, surface));
    world->now.attachment_count++;
    step_wake_cloth(&world->model, &world->now, world_find_cloth(world, def->cloth));
    if (surface != TULLE_NONE) step_wake_cloth(&world->model, &world->now, surface);
    return TULLE_OK;
}

tulle_status tulle_world_attach(tulle_world *world, const tulle_attachment_def *def,
                                tulle_attachment_id *id, tulle_error *error) {
    if (!world || !def || !id) return refuse(error, "needs a world, a def and an id");
    tulle_status status = check_def(world, def, error);
    if (status == TULLE_OK)
        status =
            world->is_started ? attach_now(world, def, error) : keep_attachment(world, def, error);
    if (status != TULLE_OK) return status;
    *id = world->is_started ? world->now.attachment_count : (uint32_t)world->attachments.count;
    WORLD_RECORD(world, .kind = RECORD_ATTACH, .def.attachment = *def);
    return TULLE_OK;
}

tulle_status world_begin_attachments(tulle_world *world, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; status == TULLE_OK && i < world->attachments.count; i++) {
        const tulle_attachment_def *const def = &world->attachments.data[i];
        bool const names_removed = world_find_cloth(world, def->cloth) == SIZE_MAX ||
                                   (def->obstacle.generation != 0 &&
                                    world_find_obstacle(world, def->obstacle) == SIZE_MAX) ||
                                   (def->other_cloth.generation != 0 &&
                                    world_find_cloth(world, def->other_cloth) == SIZE_MAX);
        if (names_removed)
            world->now.attachment_count++;
        else
            status = attach_now(world, def, error);
    }
    return status;
}

/* Whether the world ever gave this id. */
static bool is_known(const tulle_world *world, tulle_attachment_id id) {
    return world && world->is_started && id >= 1 && id <= world->now.attachment_count;
}

tulle_status tulle_attachment_set_points(tulle_world *world, tulle_attachment_id id,
                                         const double *points, size_t point_count,
                                         tulle_error *error) {
    if (!points || !is_known(world, id)) return refuse(error, "does not exist, or has null points");
    motion_state *const now = &world->now;
    bool holds_any = false;
    for (size_t i = 0; i < now->ties.count; i++) {
        const world_tie *const tie = &now->ties.data[i];
        if (tie->number != id) continue;
        holds_any = true;
        if (tie->corners[0] != TULLE_NONE) return refuse(error, "is to no points");
        if (point_count != tie->order_count)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "attachment %u has %u points and was given %zu", id, tie->order_count,
                             point_count);
    }
    if (!holds_any) return TULLE_OK; /* nothing knows how many points there are */
    tulle_status const status = check_points(points, point_count, error);
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < now->ties.count; i++) {
        world_tie *const tie = &now->ties.data[i];
        if (tie->number != id) continue;
        memcpy(tie->point, points + 3 * (size_t)tie->order, sizeof tie->point);
        step_wake_cloth_at(&world->model, now, tie->vertex);
    }
    WORLD_RECORD(world, .kind = RECORD_POINTS, .ids = {id}, .arrays = {{points, 3 * point_count}});
    return TULLE_OK;
}

tulle_status tulle_attachment_release(tulle_world *world, tulle_attachment_id id,
                                      tulle_error *error) {
    if (!is_known(world, id)) return refuse(error, "is not there");
    motion_state *const now = &world->now;
    size_t kept = 0;
    for (size_t i = 0; i < now->ties.count; i++) {
        world_tie const tie = now->ties.data[i];
        if (tie.number != id) {
            now->ties.data[kept++] = tie;
            continue;
        }
        step_wake_cloth_at(&world->model, now, tie.vertex);
        step_wake_cloth_at(&world->model, now, tie.corners[0]);
    }
    now->ties.count = kept;
    WORLD_RECORD(world, .kind = RECORD_RELEASE, .ids = {id});
    return TULLE_OK;
}

tulle_attachment_report tulle_attachment_get_report(const tulle_world *world,
                                                    tulle_attachment_id id) {
    tulle_attachment_report report = {0};
    if (!is_known(world, id)) return report;
    for (size_t i = 0; i < world->now.ties.count; i++) {
        const world_tie *const tie = &world->now.ties.data[i];
        if (tie->number != id) continue;
        report.held_count++;
        for (int k = 0; k < 3; k++) report.force[k] += tie->force[k];
        report.largest_force = fmax(report.largest_force, vec3_norm(vec3_load(tie->force, 0)));
    }
    return report;
}

int tulle_attachment_holds(const tulle_world *world, tulle_attachment_id id, uint32_t vertex) {
    if (!is_known(world, id)) return 0;
    for (size_t i = 0; i < world->now.ties.count; i++) {
        const world_tie *const tie = &world->now.ties.data[i];
        uint32_t const cloth = world->model.vertex_surface[tie->vertex];
        if (tie->number == id && tie->vertex - world->work.surfaces[cloth].vertex_begin == vertex)
            return 1;
    }
    return 0;
}

/* ---- a state that was read ---- */

bool world_ties_are_valid(const tulle_world *world, const motion_state *state) {
    for (size_t i = 0; i < state->ties.count; i++) {
        const world_tie *const tie = &state->ties.data[i];
        if (tie->number < 1 || tie->number > state->attachment_count ||
            tie->order >= tie->order_count || tie->vertex >= world->model.cloth_vertex_count)
            return false;
        bool is_point = true;
        for (int k = 0; k < 3; k++) is_point &= tie->corners[k] == TULLE_NONE;
        for (int k = 0; k < 3; k++) {
            bool const is_corner = !is_point && tie->corners[k] < world->model.vertex_count &&
                                   (tie->corners[k] < world->model.cloth_vertex_count ||
                                    tie->corners[k] >= world->model.cloth_vertex_count +
                                                           2 * world->model.body_count) &&
                                   world->model.vertex_surface[tie->corners[k]] ==
                                       world->model.vertex_surface[tie->corners[0]] &&
                                   tie->corners[k] != tie->vertex;
            if (!is_point && !is_corner) return false;
            if (!(fabs(tie->weights[k]) <= 2.0 * POINT_MAX) ||
                !(fabs(tie->point[k]) <= POINT_MAX) || !isfinite(tie->force[k]))
                return false;
        }
        if (!isfinite(tie->height) || isnan(tie->release_time) || !(tie->stiffness > 0.0) ||
            !(tie->break_force > 0.0) ||
            (isfinite(tie->stiffness) && tie->stiffness > STIFFNESS_MAX))
            return false;
    }
    return true;
}
