/* world/start/explain.c - contacts, stretch, fineness, patches: asked for, no step needs them. */
#include "base/error.h"
#include "base/parallel.h"
#include "detect/patches/patches.h"
#include "geom/distance.h"
#include "tulle/paper.h"
#include "world/world_state.h"

#include <string.h>

/* ---- contacts ---- */

static tulle_contact_state name_state(row_state state) {
    if (state == ROW_STICKS) return TULLE_CONTACT_STICK;
    return state == ROW_SLIDES ? TULLE_CONTACT_SLIP : TULLE_CONTACT_OPEN;
}

/* The row as it is at the end of the step, in the objects' own numberings. */
static tulle_contact describe_row(const tulle_world *world, const contact_row *row) {
    bool const is_edges = row->frame.kind == FEATURE_EDGE_EDGE;
    tulle_contact contact = {.kind = is_edges ? TULLE_CONTACT_EDGE_EDGE : TULLE_CONTACT_VERTEX_FACE,
                             .state = name_state(row->solve.state),
                             .is_new = !row->law.is_old,
                             .is_hard = row->solve.is_hard};
    contact.object_a = world->model.vertex_surface[row->frame.vertices[0]];
    contact.object_b = world->model.vertex_surface[row->frame.vertices[is_edges ? 2 : 1]];
    vec3 points[4], middle = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++) points[k] = vec3_load(world->now.positions, row->frame.vertices[k]);
    closest_points const closest = closest_of_pair(row->frame.kind, points);
    for (int k = 0; k < 4; k++) {
        uint32_t const object = world->model.vertex_surface[row->frame.vertices[k]];
        contact.vertices[k] = row->frame.vertices[k] - world->work.surfaces[object].vertex_begin;
        contact.weights[k] = closest.weights[k];
        middle = vec3_add_scaled(middle, points[k], 0.5 * fabs(closest.weights[k]));
    }
    contact.gap = sqrt(closest.distance2);
    vec3 const normal =
        contact.gap > 0.0 ? vec3_scale(closest.difference, 1.0 / contact.gap) : row->frame.normal;
    vec3_store(contact.position, 0, middle);
    vec3_store(contact.normal, 0, normal);
    vec3_store(contact.impulse, 0, row->solve.impulse);
    return contact;
}

tulle_status tulle_world_get_contacts(tulle_world *world, const tulle_contact **contacts,
                                      size_t *count, tulle_error *error) {
    if (!world || !contacts || !count) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "contacts need a world and a place for array and count");
    }
    size_t const row_count = world->accepted_rows.rows.count;
    if (!world->has_contacts) {
        world->contacts.count = 0;
        if (!ARRAY_RESERVE(&world->heap, &world->contacts, row_count)) {
            return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for %zu contacts",
                             row_count);
        }
        for (size_t i = 0; i < row_count; i++) {
            world->contacts.data[i] = describe_row(world, &world->accepted_rows.rows.data[i]);
        }
        world->contacts.count = row_count;
        world->has_contacts = true;
    }
    *contacts = world->contacts.data;
    *count = world->contacts.count;
    return TULLE_OK;
}

/* ---- stretch ---- */

static tulle_stretch describe_edge(const tulle_world *world, double stretch, size_t edge) {
    const uint32_t *const ends = world->model.topo.edges + 2 * edge;
    tulle_stretch described = {.stretch = stretch, .cloth = world->model.vertex_surface[ends[0]]};
    for (size_t k = 0; k < 2; k++)
        described.vertices[k] = ends[k] - world->work.surfaces[described.cloth].vertex_begin;
    vec3_store(described.position, 0,
               vec3_lerp(vec3_load(world->now.positions, ends[0]),
                         vec3_load(world->now.positions, ends[1]), 0.5));
    return described;
}

static vec3 get_rest_edge(const tulle_world *world, size_t edge) {
    const uint32_t *const ends = world->model.topo.edges + 2 * edge;
    return vec3_sub(vec3_load(world->model.rest, ends[1]), vec3_load(world->model.rest, ends[0]));
}

static tulle_stretch find_longest_edge(const tulle_world *world) {
    double largest = 0.0;
    size_t found = 0;
    for (size_t e = 0; e < world->model.cloth_edge_count; e++) {
        const uint32_t *const ends = world->model.topo.edges + 2 * e;
        vec3 const edge = vec3_sub(vec3_load(world->now.positions, ends[1]),
                                   vec3_load(world->now.positions, ends[0]));
        double const stretch = vec3_norm(edge) / vec3_norm(get_rest_edge(world, e));
        if (stretch > largest) largest = stretch, found = e;
    }
    return describe_edge(world, largest, found);
}

static tulle_stretch find_longest_yarn(const tulle_world *world) {
    yarn_stretch const longest =
        cloth_find_longest_yarn(world->model.cloth_model, world->now.positions, false);
    size_t const place = 3 * (size_t)longest.triangle + (size_t)longest.edge;
    return describe_edge(world, 1.0 + longest.strain, world->model.topo.triangle_edges[place]);
}

tulle_stretch tulle_world_find_largest_stretch(const tulle_world *world) {
    if (!world || !world->is_started || world->model.cloth_edge_count == 0)
        return (tulle_stretch){0};
    return world->model.def.membrane == TULLE_MEMBRANE_WOVEN ? find_longest_yarn(world)
                                                             : find_longest_edge(world);
}

/* ---- fineness ---- */

tulle_fineness tulle_cloth_get_fineness(const tulle_world *world, tulle_cloth_id id) {
    tulle_fineness fineness = {0};
    size_t const index = world_find_cloth(world, id);
    if (index == SIZE_MAX || !world->is_started) return fineness;
    const surface_range *const range = &world->work.surfaces[index];
    size_t count = 0;
    for (size_t e = 0; e < world->model.cloth_edge_count; e++) {
        uint32_t const end = world->model.topo.edges[2 * e];
        if (end < range->vertex_begin || end >= range->vertex_end) continue;
        fineness.mean_edge += vec3_norm(get_rest_edge(world, e));
        count++;
    }
    fineness.mean_edge /= (double)count;
    const tulle_material *const material = &world->model.cloths.data[index].material;
    bool const is_woven = world->model.def.membrane == TULLE_MEMBRANE_WOVEN;
    double const rigidity = is_woven ? fmin(material->bend_warp, material->bend_weft)
                                     : material->springs.bend_stiffness;
    double least = INFINITY; /* of the factors */
    const double *const factors = world->model.cloths.data[index].factors;
    for (size_t t = 0; factors && t < world->model.cloths.data[index].mesh.triangle_count; t++)
        least = fmin(least, factors[t]);
    double const weight =
        material->area_density * vec3_norm(vec3_load(world->model.def.gravity, 0));
    if (weight > 0.0) fineness.bending_length = cbrt((factors ? least : 1.0) * rigidity / weight);
    return fineness;
}

/* ---- patches ---- */

/* [rad] 60 degrees. Wider patches hold valleys whose walls come nearer than contact reaches. */
static const double MAX_ANGLE_DEFAULT = 1.0471975511965976;
static const double RIGHT_ANGLE = 1.5707963267948966;
static const double PATCH_TIME_STEP_MAX = 1.0; /* [s] the longest step of a world */

static tulle_status check_patch_call(const tulle_world *world, tulle_cloth_id id,
                                     const tulle_patch_options *options, bool has_places,
                                     tulle_error *error) {
    if (world_find_cloth(world, id) == SIZE_MAX || !options || !has_places) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "patches need a world, a cloth of it, options, and a place for labels and "
                         "count");
    }
    if (!world->is_started) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "patches can be found once the world has started");
    }
    if (!(options->time_step >= 0.0 && options->time_step <= PATCH_TIME_STEP_MAX)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the time step for patches is %g s; it must be 0 to %g s",
                         options->time_step, PATCH_TIME_STEP_MAX);
    }
    if (!(options->max_angle >= 0.0 && options->max_angle < RIGHT_ANGLE)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the angle of patches is %g; it must be greater than 0 (0: the default) "
                         "and less than pi/2",
                         options->max_angle);
    }
    return TULLE_OK;
}

/* Patches of surface `index` along the paths that its velocities predict. */
static tulle_status find_patches(tulle_world *world, size_t index,
                                 const tulle_patch_options *options, uint32_t *labels,
                                 size_t *patch_count) {
    const surface_range *const range = &world->work.surfaces[index];
    double *const end = ARENA_NEW(&world->work.scratch, double, 3 * (size_t)range->vertex_end);
    if (!end) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 3 * (size_t)range->vertex_begin; i < 3 * (size_t)range->vertex_end; i++) {
        end[i] = world->now.positions[i] + options->time_step * world->now.velocities[i];
    }
    patch_surface const surface = {&world->model.topo, range->triangle_begin, range->triangle_end,
                                   world->now.positions, end};
    patch_settings const settings = {
        options->max_angle > 0.0 ? options->max_angle : MAX_ANGLE_DEFAULT, world->work.threads};
    patch_list list;
    const tulle_tasks *const before = parallel_use(world->work.tasks);
    tulle_status const status =
        grow_patches(&surface, &settings, &world->work.scratch, labels, &list);
    (void)parallel_use(before);
    if (status == TULLE_OK) *patch_count = list.count;
    return status;
}

/* Labels of the patches in use, counted through the cloth's own in the order of their first
 * triangles. */
static tulle_status name_patches_in_use(tulle_world *world, size_t index, uint32_t *labels,
                                        size_t *patch_count) {
    const surface_range *const range = &world->work.surfaces[index];
    size_t const count = range->triangle_end - range->triangle_begin;
    *patch_count = 0;
    if (!world->work.patches) {
        memset(labels, 0, count * sizeof *labels);
        return TULLE_OK;
    }
    patch_labels const all = kept_patches_get_labels(world->work.patches);
    const uint32_t *const used = all.labels + range->triangle_begin;
    uint32_t *const names =
        ARENA_NEW_ZEROED(&world->work.scratch, uint32_t, (size_t)all.label_count + 1);
    if (!names) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t t = 0; t < count; t++) {
        uint32_t const label = used[t];
        if (label != PATCH_ISOLATED && names[label] == 0) names[label] = (uint32_t)++ * patch_count;
        labels[t] = names[label];
    }
    return TULLE_OK;
}

tulle_status tulle_cloth_get_patches(tulle_world *world, tulle_cloth_id id,
                                     const tulle_patch_options *options, uint32_t *labels,
                                     size_t *patch_count, tulle_error *error) {
    tulle_status status = check_patch_call(world, id, options, labels && patch_count, error);
    if (status != TULLE_OK) return status;
    size_t const index = world_find_cloth(world, id);
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    status = options->is_in_use ? name_patches_in_use(world, index, labels, patch_count)
                                : find_patches(world, index, options, labels, patch_count);
    arena_release(&world->work.scratch, mark);
    if (status != TULLE_OK) return error_set(error, status, "no memory left for patches");
    return TULLE_OK;
}
