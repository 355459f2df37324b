/* support/changed_world.c - see changed_world.h. */
#include "support/changed_world.h"
#include "support/paper_options.h"
#include "support/pins.h"

#include "base/hash.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

void plain_scene_destroy(plain_scene *scene) {
    for (size_t i = 0; i < scene->object_count; i++) tulle_mesh_destroy(&scene->objects[i].mesh);
}

/* ---- the change of each quantity ---- */

/* value in the new units, of m^length s^time kg^mass */
static double convert(const change *how, double value, int length, int time, int mass) {
    return ldexp(value, length * how->length + time * how->time + mass * how->mass);
}

static void turn(const change *how, const double from[3], double to[3]) {
    for (int i = 0; i < 3; i++) {
        const double *const row = how->matrix + 3 * i;
        to[i] = row[0] * from[0] + row[1] * from[1] + row[2] * from[2];
    }
}

static void convert_vector(const change *how, const double from[3], int length, int time,
                           double to[3]) {
    turn(how, from, to);
    for (int i = 0; i < 3; i++) to[i] = convert(how, to[i], length, time, 0);
}

static void convert_place(const change *how, const double from[3], double to[3]) {
    turn(how, from, to);
    for (int i = 0; i < 3; i++) to[i] = convert(how, to[i] + how->shift[i], 1, 0, 0);
}

/* The rotation vector of M R M^T: its axis turns along, and in a mirror the angle goes the other
 * way. */
static void convert_rotation(const change *how, const double from[3], double to[3]) {
    const double *const m = how->matrix;
    double const determinant = m[0] * (m[4] * m[8] - m[5] * m[7]) -
                               m[1] * (m[3] * m[8] - m[5] * m[6]) +
                               m[2] * (m[3] * m[7] - m[4] * m[6]);
    turn(how, from, to);
    for (int i = 0; i < 3; i++) to[i] *= determinant < 0.0 ? -1.0 : 1.0;
}

static tulle_material convert_material(const change *how, tulle_material material) {
    material.area_density = convert(how, material.area_density, -2, 0, 1);
    double *const forces[] = {&material.warp.stiffness, &material.weft.stiffness,
                              &material.shear.stiffness, &material.springs.stretch_stiffness};
    for (size_t i = 0; i < 4; i++) *forces[i] = convert(how, *forces[i], 0, -2, 1);
    double *const moments[] = {&material.bend_warp, &material.bend_weft, &material.bend_twist,
                               &material.springs.bend_stiffness};
    for (size_t i = 0; i < 4; i++) *moments[i] = convert(how, *moments[i], 2, -2, 1);
    material.stretch_damping = convert(how, material.stretch_damping, 0, 1, 0);
    material.bend_damping = convert(how, material.bend_damping, 0, 1, 0);
    material.air_damping = convert(how, material.air_damping, 0, -1, 0);
    return material;
}

/* ---- numbering ---- */

static void shuffle(uint32_t *order, size_t count, uint64_t *seed) {
    for (size_t i = 0; i < count; i++) order[i] = (uint32_t)i;
    for (size_t i = count; *seed != 0 && i > 1; i--) {
        size_t const k = random_next(seed) % i;
        uint32_t const swapped = order[i - 1];
        order[i - 1] = order[k];
        order[k] = swapped;
    }
}

static void *allocate(size_t count, size_t size) {
    void *const block = calloc(count, size);
    assert_non_null(block);
    return block;
}

static void move_a_little(const change *how, double *positions, size_t vertex_count) {
    uint64_t seed = how->jitter_seed;
    for (size_t i = 0; i < 3 * vertex_count; i++)
        positions[i] += convert(how, how->jitter * (2.0 * random_uniform(&seed) - 1.0), 1, 0, 0);
}

/* The mesh in its new place, order and size; positions and triangles are the caller's. */
static tulle_mesh_view convert_mesh(const change *how, const tulle_mesh *mesh,
                                    const uint32_t *places, double **positions,
                                    uint32_t **triangles) {
    uint64_t seed = how->seed;
    uint32_t *const order = allocate(mesh->triangle_count, sizeof *order);
    *positions = allocate(3 * mesh->vertex_count, sizeof **positions);
    *triangles = allocate(3 * mesh->triangle_count, sizeof **triangles);
    for (size_t v = 0; v < mesh->vertex_count; v++)
        convert_place(how, mesh->positions + 3 * v, *positions + 3 * (size_t)places[v]);
    shuffle(order, mesh->triangle_count, &seed);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        size_t const first = how->seed ? random_next(&seed) % 3 : 0;
        for (size_t k = 0; k < 3; k++) {
            size_t const from = (first + (how->turns_over ? 3 - k : k)) % 3;
            (*triangles)[3 * (size_t)order[t] + k] = places[mesh->triangles[3 * t + from]];
        }
    }
    free(order);
    return (tulle_mesh_view){*positions, mesh->vertex_count, *triangles, mesh->triangle_count};
}

/* ---- the world ---- */

static void convert_keys(const change *how, const plain_object *object, tulle_keyframe *keys,
                         tulle_motion *motion) {
    for (size_t i = 0; i < object->key_count; i++) {
        const tulle_keyframe *const from = &object->keys[i];
        keys[i].time = convert(how, from->time + how->start_time, 0, 1, 0);
        convert_vector(how, from->translation, 1, 0, keys[i].translation);
        convert_rotation(how, from->rotation_vector, keys[i].rotation_vector);
    }
    *motion =
        (tulle_motion){.keys = object->key_count > 0 ? keys : NULL, .key_count = object->key_count};
    convert_place(how, (const double[]){0.0, 0.0, 0.0}, motion->pivot);
}

static void add_object(changed_world *own, size_t index) {
    const plain_object *const object = &own->scene->objects[index];
    const change *const how = &own->how;
    uint64_t seed = how->seed;
    own->places[index] = allocate(object->mesh.vertex_count, sizeof(uint32_t));
    shuffle(own->places[index], object->mesh.vertex_count, &seed);
    double *positions = NULL;
    uint32_t *triangles = NULL;
    tulle_mesh_view const mesh =
        convert_mesh(how, &object->mesh, own->places[index], &positions, &triangles);
    tulle_keyframe keys[CHANGED_KEYS_MAX];
    tulle_motion motion;
    convert_keys(how, object, keys, &motion);
    tulle_status status;
    tulle_error error = {0};
    if (object->is_obstacle) {
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = mesh;
        def.motion = motion;
        def.friction = own->scene->friction;
        def.body.is_dynamic = object->density > 0.0;
        def.body.density = convert(how, object->density, -3, 0, 1);
        convert_vector(how, object->velocity, 1, -1, def.body.velocity);
        tulle_obstacle_id id = {0};
        status = tulle_world_add_obstacle(own->world, &def, &id, &error);
        own->ids[index] = id.index;
    } else {
        if (how->jitter > 0.0) move_a_little(how, positions, mesh.vertex_count);
        tulle_cloth_def def = tulle_cloth_def_default();
        uint32_t pinned[CHANGED_PINS_MAX];
        for (size_t i = 0; i < object->pin_count; i++)
            pinned[i] = own->places[index][object->pins[i]];
        tulle_pin pin = make_pin(pinned, object->pin_count, INFINITY);
        pin.motion = motion;
        def.mesh = mesh;
        double const warp[3] = {def.grain[0], def.grain[1], def.grain[2]};
        turn(how, warp, def.grain);
        def.material = convert_material(how, def.material);
        def.material.friction = own->scene->friction;
        def.pins = object->pin_count > 0 ? &pin : NULL;
        def.pin_count = object->pin_count > 0 ? 1 : 0;
        convert_vector(how, object->velocity, 1, -1, def.velocity);
        tulle_cloth_id id = {0};
        status = tulle_world_add_cloth(own->world, &def, &id, &error);
        own->ids[index] = id.index;
    }
    if (status != TULLE_OK) fail_msg("%s: %s", how->name, error.message);
    free(positions);
    free(triangles);
}

changed_world changed_world_make(const plain_scene *scene, const change *how) {
    changed_world own = {.scene = scene, .how = *how};
    tulle_world_def def = tulle_world_def_default();
    tulle_error error = {0};
    convert_vector(how, (const double[]){0.0, 0.0, -9.75}, 1, -2, def.gravity);
    double const air[3] = {3.0 * scene->air_speed, 2.0 * scene->air_speed, scene->air_speed};
    convert_vector(how, air, 1, -1, def.wind.velocity);
    def.wind.drag_coefficient = scene->air_speed != 0.0 ? convert(how, 0.75, -3, 0, 1) : 0.0;
    /* derived ones depend on the unit, and far from the origin on the place */
    def.contact_distance = convert(how, 0x1p-8, 1, 0, 0);
    def.minimum_gap = convert(how, 0x1p-13, 1, 0, 0);
    def.friction_cloth_cloth = scene->friction;
    def.integrator = scene->integrator;
    def.membrane = scene->membrane;
    def.threads = 1;
    if (scene->cg_tolerance > 0.0) change_paper(&def)->cg_tolerance = scene->cg_tolerance;
    if (tulle_world_create(&def, &own.world, &error) != TULLE_OK) fail_msg("%s", error.message);
    for (size_t i = 0; i < scene->object_count; i++)
        add_object(&own, how->is_reversed ? scene->object_count - 1 - i : i);
    if (tulle_world_start(own.world, &error) != TULLE_OK)
        fail_msg("%s: %s", how->name, error.message);
    own.world->now.time = convert(how, how->start_time, 0, 1, 0);
    return own;
}

void changed_world_destroy(changed_world *own) {
    tulle_world_destroy(own->world);
    for (size_t i = 0; i < own->scene->object_count; i++) free(own->places[i]);
}

void changed_world_step(changed_world *own, double time_step) {
    tulle_error error = {0};
    if (tulle_world_step(own->world, convert(&own->how, time_step, 0, 1, 0), &own->report,
                         &error) != TULLE_OK)
        fail_msg("%s: %s", own->how.name, error.message);
}

/* ---- what came of it ---- */

static const double *get_vectors(const changed_world *own, size_t object, bool are_velocities) {
    if (own->scene->objects[object].is_obstacle) {
        tulle_obstacle_id const id = {own->ids[object], 1};
        return are_velocities ? tulle_obstacle_get_velocities(own->world, id, NULL)
                              : tulle_obstacle_get_positions(own->world, id, NULL);
    }
    tulle_cloth_id const id = {own->ids[object], 1};
    return are_velocities ? tulle_cloth_get_velocities(own->world, id, NULL)
                          : tulle_cloth_get_positions(own->world, id, NULL);
}

/* A vector as the scene itself has it. */
static void take_back(const change *how, const double from[3], bool is_velocity, double to[3]) {
    double own[3];
    for (int i = 0; i < 3; i++)
        own[i] = is_velocity ? convert(how, from[i], -1, 1, 0)
                             : convert(how, from[i], -1, 0, 0) - how->shift[i];
    for (int i = 0; i < 3; i++)
        to[i] = how->matrix[i] * own[0] + how->matrix[3 + i] * own[1] + how->matrix[6 + i] * own[2];
}

static double compare_vectors(const changed_world *a, const changed_world *b, bool are_velocities) {
    double most = 0.0;
    for (size_t i = 0; i < a->scene->object_count; i++) {
        const double *const first = get_vectors(a, i, are_velocities);
        const double *const second = get_vectors(b, i, are_velocities);
        for (size_t v = 0; v < a->scene->objects[i].mesh.vertex_count; v++) {
            double x[3], y[3];
            take_back(&a->how, first + 3 * (size_t)a->places[i][v], are_velocities, x);
            take_back(&b->how, second + 3 * (size_t)b->places[i][v], are_velocities, y);
            for (int k = 0; k < 3; k++) most = fmax(most, fabs(x[k] - y[k]));
        }
    }
    return most;
}

difference changed_world_compare(const changed_world *a, const changed_world *b) {
    return (difference){compare_vectors(a, b, false), compare_vectors(a, b, true)};
}

size_t changed_world_judge(const changed_world *own) {
    tulle_error error = {0};
    if (world_find_intersections(own->world, own->world->now.positions, &own->world->intersections,
                                 &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return own->world->intersections.count;
}

double changed_world_get_energy(const changed_world *own) {
    return convert(&own->how, own->report.kinetic_energy + own->report.elastic_energy, -2, 2, -1);
}
