/* scene/make_obstacle.c - obstacles of a scene: mesh, copies, motion. */
#include "scene/frame_cache.h"
#include "scene/scene_data.h"

#include <math.h>
#include <string.h>

/* One entry of the list of obstacles while its copies are made. */
typedef struct obstacle_work {
    const scene_work *scene;
    const obstacle_keys *keys;
    const char *name;
    size_t copy_count;
    pose *poses;              /* of the copies */
    placement place;          /* of each, before its layout */
    tulle_mesh mesh;          /* unplaced */
    source_mesh made;         /* the same */
    scene_sequence *sequence; /* unplaced; null: none */
} obstacle_work;

static bool is_copied(const obstacle_keys *keys) { return keys->copies.head.node != NULL; }

static bool copy_mesh(const tulle_mesh *mesh, tulle_mesh *copy, tulle_error *error) {
    if (tulle_mesh_create(mesh->vertex_count, mesh->triangle_count, copy, error) != TULLE_OK)
        return false;
    memcpy(copy->positions, mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    memcpy(copy->triangles, mesh->triangles, 3 * mesh->triangle_count * sizeof(uint32_t));
    return true;
}

/* Keyframes act along the axes of the scene, turned with the copy by the layout. */
static bool move_copy(const obstacle_work *work, const pose *layout, scene_obstacle *obstacle) {
    const motion_keys *motion = &work->keys->motion;
    if (!motion->head.node) return true;
    if (work->sequence) {
        obstacle->sequence =
            sequence_place(work->scene, work->sequence, &obstacle->place, obstacle->delay);
        return obstacle->sequence != NULL;
    }
    double *pivot = obstacle->motion.pivot;
    memcpy(pivot, layout->translation, 3 * sizeof(double));
    if (schema_is_given(&motion_map, motion, "pivot")) {
        if (is_copied(work->keys))
            pose_apply(layout, motion->pivot.value, pivot);
        else
            memcpy(pivot, motion->pivot.value, 3 * sizeof(double));
    }
    obstacle->motion.is_eased = motion->eased;
    return make_motion(work->scene, &motion->keyframes, layout, obstacle->delay, &obstacle->motion);
}

static bool make_copy(const obstacle_work *work, size_t index, scene_obstacle *obstacle) {
    const obstacle_keys *keys = work->keys;
    const scene_work *into = work->scene;
    bool is_reversed = keys->copies.order == STAGGER_LAST_TO_FIRST;
    size_t rank = is_reversed ? work->copy_count - 1 - index : index;
    obstacle->keys = keys;
    obstacle->name = is_copied(keys) ? store_text(into, "%s.%03zu", work->name, index) : work->name;
    obstacle->delay = keys->copies.stagger * (double)rank;
    obstacle->appears = keys->appears + obstacle->delay;
    obstacle->disappears = keys->disappears + obstacle->delay;
    obstacle->contact_material = keys->material;
    if (!obstacle->name) return false;
    tulle_error error = {0};
    if (!copy_mesh(&work->mesh, &obstacle->mesh, &error)) {
        problem_add_error(into->problems, keys->head.place, keys->head.path, &error);
        return false;
    }
    pose layout = work->poses[index];
    for (int k = 0; k < 3; k++) layout.translation[k] += keys->translate.value[k];
    const pose whole = pose_compose(&layout, &work->place.turn);
    obstacle->place = work->place;
    obstacle->place.turn = whole;
    tulle_mesh_transform(&obstacle->mesh, work->place.scale, whole.rotation, whole.translation);
    const double grain[3] = {1.0, 0.0, 0.0};
    const bool has_grain = schema_is_given(&obstacle_map, keys, "grain");
    rotate_vector(layout.rotation, has_grain ? keys->grain.value : grain, obstacle->grain);
    return count_mesh(into, &obstacle->mesh, keys->head.place, keys->head.path) &&
           move_copy(work, &layout, obstacle);
}

/* The mesh of the entry, from its own key or from its sequence. */
static bool make_source(obstacle_work *work) {
    const obstacle_keys *keys = work->keys;
    bool has_mesh = keys->mesh.head.node != NULL;
    bool has_sequence =
        keys->motion.head.node && schema_is_given(&motion_map, &keys->motion, "sequence");
    const sequence_keys *const sequence = &keys->motion.sequence;
    bool gives_mesh =
        has_sequence && (schema_is_given(&sequence_map, sequence, "files") ||
                         (sequence->cache && frame_cache_is_animation(sequence->cache)));
    if (!has_mesh && !gives_mesh) {
        problem_add(work->scene->problems, TULLE_ERROR_PARSE, keys->head.place,
                    "%s: the key 'mesh' is missing: file or shape, unless motion.sequence.files "
                    "or an animation gives the mesh",
                    keys->head.path);
        return false;
    }
    tulle_mesh_role const role =
        has_sequence ? TULLE_MESH_ROLE_DEFORMING : TULLE_MESH_ROLE_OBSTACLE;
    if (has_mesh && !make_mesh(work->scene, &keys->mesh, role, &work->made, NULL)) return false;
    if (!has_sequence) return true;
    work->sequence = sequence_open(work->scene, keys, &work->made);
    return work->sequence != NULL;
}

bool make_obstacles(const scene_work *work, const obstacle_keys *keys, size_t index,
                    scene_obstacle *obstacles) {
    placement_keys const where = {&keys->scale, &keys->rotate, &keys->place};
    obstacle_work entry = {.scene = work, .keys = keys, .copy_count = count_copies(keys)};
    entry.name = keys->name ? keys->name : store_text(work, "obstacle%zu", index);
    entry.made = (source_mesh){&entry.mesh, {false, 1.0}, false, 0, 0.0};
    entry.poses = ARENA_NEW(&work->scene->storage, pose, entry.copy_count);
    if (!entry.name || !entry.poses) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    bool const comes_or_goes = isfinite(keys->appears) || isfinite(keys->disappears);
    if (keys->copies.stagger > 0.0 && !keys->motion.head.node && !comes_or_goes) {
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(&keys->copies, "stagger"),
                    "%s.stagger: does nothing without motion, appears or disappears; give one of "
                    "these, or leave it out",
                    keys->copies.head.path);
        return false;
    }
    const schema_list *const moves = &keys->motion.keyframes;
    const dynamic_keys *const body = &keys->dynamic;
    if (body->head.node && keys->motion.head.node && moves->count > 1) {
        double const begin = ((const keyframe_keys *)moves->items)[0].time;
        const char *idle = body->start <= begin ? "start" : NULL;
        for (int k = 0; k < 3 && !idle; k++)
            idle = body->velocity.value[k] != 0.0 ? "velocity"
                   : body->spin.value[k] != 0.0   ? "spin"
                                                  : NULL;
        if (idle) {
            problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(body, idle),
                        body->start <= begin
                            ? "%s.%s: is %g s, and the motion begins at %g s: the body never "
                              "follows it. Give a later start, or leave out the motion"
                            : "%s.%s: does nothing: at its start (%g s) the body keeps the "
                              "velocity of its motion, which begins at %g s; leave this out",
                        body->head.path, idle, body->start, begin);
            return false;
        }
    }
    place_copies(&keys->copies, entry.copy_count, entry.poses);
    bool is_good = check_dynamic_friction(work, keys, keys->dynamic_friction, keys->friction) &&
                   make_source(&entry) &&
                   find_placement(work, &where, &entry.made, entry.name, &entry.place);
    for (size_t i = 0; is_good && i < entry.copy_count; i++)
        is_good = make_copy(&entry, i, &obstacles[i]);
    tulle_mesh_destroy(&entry.mesh);
    if (!(keys->appears < keys->disappears)) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "disappears"),
                    "%s.disappears: must be later than appears", keys->head.path);
        return false;
    }
    return is_good;
}
