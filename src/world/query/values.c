/* world/query/values.c - copies of what vertices, triangles and contacts of an object have
 * (tulle/query.h).
 *
 * Values of vertices and triangles are made one at a time, each from the state alone, and put
 * straight into the caller's memory; only forces are gathered beforehand. */
#include "base/error.h"
#include "dynamics/hysteresis.h"
#include "step/energy_balance.h"
#include "step/lag/lag.h"
#include "tulle/paper.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

/* Puts three numbers where the caller wants those of an item. */
static void put(const tulle_target *target, size_t stride, size_t item, vec3 value) {
    unsigned char *const to = (unsigned char *)target->data + item * stride;
    double const numbers[3] = {value.x, value.y, value.z};
    if (target->type == TULLE_NUMBER_DOUBLE) {
        memcpy(to, numbers, sizeof numbers);
    } else {
        float const short_numbers[3] = {(float)value.x, (float)value.y, (float)value.z};
        memcpy(to, short_numbers, sizeof short_numbers);
    }
}

static vec3 compute_normal(const tulle_world *world, size_t vertex) {
    const adjacency *const around = &world->model.topo.vertex_triangles;
    const double *const positions = world->now.positions;
    vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
        const uint32_t *const corners = world->model.topo.triangles + 3 * (size_t)around->items[i];
        vec3 const x = vec3_load(positions, corners[0]);
        sum = vec3_add(sum, vec3_cross(vec3_sub(vec3_load(positions, corners[1]), x),
                                       vec3_sub(vec3_load(positions, corners[2]), x)));
    }
    return vec3_normalize(sum);
}

static vec3 compute_strain(const tulle_world *world, size_t triangle) {
    yarn_pair const yarns = hysteresis_measure_yarns(&world->model.cloth_model->elements[triangle],
                                                     world->now.positions);
    return (vec3){vec3_norm(yarns.along[YARN_WARP]) - 1.0, vec3_norm(yarns.along[YARN_WEFT]) - 1.0,
                  vec3_dot(yarns.along[YARN_WARP], yarns.along[YARN_WEFT])};
}

/* The target's stride, or 0 with an error where it cannot take so many items. */
static size_t check_target(const tulle_target *target, size_t count, tulle_error *error) {
    if (!target || (count > 0 && !target->data)) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the target or its memory is null");
        return 0;
    }
    if (target->type != TULLE_NUMBER_DOUBLE && target->type != TULLE_NUMBER_FLOAT) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no type of number %d",
                  (int)target->type);
        return 0;
    }
    size_t const item = 3 * (target->type == TULLE_NUMBER_DOUBLE ? sizeof(double) : sizeof(float));
    size_t const stride = target->stride == 0 ? item : target->stride;
    if (stride < item) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "the stride is %zu bytes; three numbers take %zu", stride, item);
        return 0;
    }
    /* the last one needs no gap behind it */
    if (count > 0 && (target->size < item || (target->size - item) / stride < count - 1)) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "%zu bytes cannot take %zu times three numbers %zu bytes apart", target->size,
                  count, stride);
        return 0;
    }
    return stride;
}

/* Adds to the forces on the vertices of an object, which are zero before, in the rows' order. */
static void add_contact_forces(const tulle_world *world, const surface_range *range,
                               const tulle_target *target, size_t stride) {
    double const time = world->now.contacts.time_step;
    const row_list *const list = &world->accepted_rows;
    for (size_t i = 0; i < list->rows.count && time > 0.0; i++) {
        const contact_row *const row = &list->rows.data[i];
        for (int k = 0; k < 4; k++) {
            uint32_t const vertex = row->frame.vertices[k];
            if (vertex < range->vertex_begin || vertex >= range->vertex_end) continue;
            size_t const item = vertex - range->vertex_begin;
            unsigned char *const at = (unsigned char *)target->data + item * stride;
            vec3 force = {0.0, 0.0, 0.0};
            if (target->type == TULLE_NUMBER_DOUBLE) {
                memcpy(&force, at, sizeof force);
            } else {
                float numbers[3];
                memcpy(numbers, at, sizeof numbers);
                force = (vec3){(double)numbers[0], (double)numbers[1], (double)numbers[2]};
            }
            put(target, stride, item,
                vec3_add_scaled(force, row->solve.impulse, row->frame.weights[k] / time));
        }
    }
}

tulle_status tulle_object_copy_values(const tulle_world *world, tulle_object_id id,
                                      tulle_values values, const tulle_target *target,
                                      tulle_error *error) {
    size_t const object = world_find_object(world, id, error);
    if (object == SIZE_MAX) return TULLE_ERROR_INVALID_ARGUMENT;
    const char *const name = world_surface_name(&world->model, object);
    if (!world->is_started)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: call tulle_world_start before its values are copied", name);
    if ((int)values < TULLE_VALUES_POSITIONS || (int)values > TULLE_VALUES_DRAWN_POSITIONS)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s: there are no values number %d",
                         name, (int)values);
    bool const has_strains =
        object < world->model.cloths.count && world->model.cloth_model->elements;
    if (values == TULLE_VALUES_STRAINS && !has_strains)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: has no strains of yarns; only woven cloth has", name);
    const surface_range *const range = &world->work.surfaces[object];
    size_t const begin =
        values == TULLE_VALUES_STRAINS ? range->triangle_begin : range->vertex_begin;
    size_t const count =
        (values == TULLE_VALUES_STRAINS ? range->triangle_end : range->vertex_end) - begin;
    size_t const stride = check_target(target, count, error);
    if (stride == 0) return TULLE_ERROR_INVALID_ARGUMENT;
    for (size_t i = 0; i < count; i++) {
        vec3 value = {0.0, 0.0, 0.0};
        if (values == TULLE_VALUES_POSITIONS)
            value = vec3_load(world->now.positions, begin + i);
        else if (values == TULLE_VALUES_VELOCITIES)
            value = vec3_load(world->now.velocities, begin + i);
        else if (values == TULLE_VALUES_NORMALS)
            value = compute_normal(world, begin + i);
        else if (values == TULLE_VALUES_STRAINS)
            value = compute_strain(world, begin + i);
        else if (values == TULLE_VALUES_DRAWN_POSITIONS)
            value = vec3_sub(vec3_load(world->now.positions, begin + i),
                             step_get_lag(&world->model, &world->now, begin + i));
        put(target, stride, i, value);
    }
    if (values == TULLE_VALUES_CONTACT_FORCES) add_contact_forces(world, range, target, stride);
    return TULLE_OK;
}

tulle_status tulle_object_copy_contacts(tulle_world *world, tulle_object_id id,
                                        tulle_contact *contacts, size_t capacity, size_t *count,
                                        tulle_error *error) {
    if (count) *count = 0;
    if (!count || (!contacts && capacity > 0))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the memory for the contacts, or for their number, is null");
    size_t const object = world_find_object(world, id, error);
    if (object == SIZE_MAX) return TULLE_ERROR_INVALID_ARGUMENT;
    const tulle_contact *all;
    size_t all_count;
    tulle_status const status = tulle_world_get_contacts(world, &all, &all_count, error);
    for (size_t i = 0; status == TULLE_OK && i < all_count; i++) {
        if (all[i].object_a != object && all[i].object_b != object) continue;
        if (*count < capacity) contacts[*count] = all[i];
        ++*count;
    }
    return status;
}

double tulle_world_get_numerical_damping(const tulle_world *world, double time_step,
                                         double period) {
    bool const is_given =
        isfinite(time_step) && isfinite(period) && time_step > 0.0 && period > 0.0;
    if (!world || !is_given) return 0.0;
    return measure_numerical_damping(world->model.def.integrator, time_step, period);
}
