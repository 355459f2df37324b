/* scene/build_world.c - a world made from a loaded scene, through the public headers. */
#include "scene/scene.h"
#include "scene/scene_data.h"

#include "tulle/attach.h"
#include "tulle/objects.h"
#include "tulle/paper.h"
#include "tulle/record.h"

#include "base/error.h"

#include <string.h>

static void set_vector(double to[3], const schema_vector *from) {
    memcpy(to, from->value, 3 * sizeof(double));
}

static tulle_paper_options make_paper_options(const scene_keys *keys) {
    tulle_paper_options paper = tulle_paper_options_default();
    paper.detection = (tulle_world_detection){.method = (tulle_detect_method)keys->contact.method,
                                              .cone = (tulle_detect_cone)keys->contact.cone,
                                              .max_angle = keys->contact.alpha_max,
                                              .has_certificate = keys->contact.certificate,
                                              .grows_patches_anew = keys->contact.patches};
    paper.response = (tulle_response)keys->contact.response;
    paper.motion_space = (tulle_motion_space)keys->contact.motion_space;
    paper.cg_tolerance = keys->solver.cg_tolerance;
    paper.cg_max_iterations = (int)keys->solver.cg_iterations;
    paper.solve_rounds = (int)keys->solver.rounds;
    paper.impulse_sweeps = (int)keys->solver.sweeps;
    paper.impact_rounds = (int)keys->contact.impact_rounds;
    return paper;
}

static tulle_world_def make_world_def(const tulle_scene *loaded) {
    const scene_keys *keys = &loaded->keys;
    tulle_world_def def = tulle_world_def_default();
    set_vector(def.gravity, &keys->gravity);
    set_vector(def.wind.velocity, &keys->wind.velocity);
    def.wind.gust_strength = keys->wind.gust_strength;
    def.wind.gust_length = keys->wind.gust_length;
    def.wind.gust_time = keys->wind.gust_time;
    def.wind.seed = resolve_seed(loaded, keys->wind.seed);
    def.wind.drag_coefficient = keys->wind.drag;
    def.contact_distance = keys->contact.delta_c;
    def.separation_distance = keys->contact.delta_s;
    def.minimum_gap = keys->contact.xi;
    def.friction_cloth_cloth = keys->contact.friction;
    def.dynamic_friction_cloth_cloth = keys->contact.dynamic_friction;
    def.membrane = (tulle_membrane)keys->membrane;
    def.on_overstretch = (tulle_on_overstretch)keys->on_overstretch;
    def.start_intersections = (tulle_start_intersections)keys->contact.start_intersections;
    def.untangle_limit = (int)keys->contact.untangle_limit;
    def.on_pinch = (tulle_on_pinch)keys->contact.on_pinch;
    def.integrator = (tulle_integrator)keys->solver.integrator;
    def.quality = (tulle_quality)keys->solver.quality;
    def.sleep_speed = keys->solver.sleep_speed;
    def.sleep_time = keys->solver.sleep_time;
    return def;
}

/* Gives a failure the place of the object in the scene file. */
static tulle_status add_place(const schema_head *head, tulle_status status, tulle_error *error) {
    if (!error || error->file[0]) return status;
    char message[sizeof error->message];
    memcpy(message, error->message, sizeof message);
    return error_set_at(error, status, head->place.file, head->place.line, head->place.column,
                        "%.200s: %.1800s", head->path, message);
}

static tulle_status add_cloth(const scene_cloth *cloth, tulle_world *world, tulle_cloth_id *id,
                              tulle_error *error) {
    tulle_cloth_def def = tulle_cloth_def_default();
    def.name = cloth->name;
    def.mesh = tulle_mesh_get_view(&cloth->mesh);
    def.rest_positions = cloth->rest_positions;
    def.rest_corners = cloth->rest_corners;
    def.has_flat_rest = cloth->has_flat_rest;
    def.warps = cloth->warps;
    def.stiffness_factors = cloth->stiffness_factors;
    def.creases = cloth->creases;
    def.crease_count = cloth->crease_count;
    def.material = cloth->material;
    def.thickness = cloth->keys->thickness;
    set_vector(def.grain, &cloth->keys->grain);
    def.contact_material = cloth->contact_material;
    def.pins = cloth->pins;
    def.pin_count = cloth->pin_count;
    set_vector(def.velocity, &cloth->keys->velocity);
    tulle_status status = tulle_world_add_cloth(world, &def, id, error);
    return status == TULLE_OK ? TULLE_OK : add_place(&cloth->keys->head, status, error);
}

/* [kg/m^3] of bodies whose scene gives no mass; the table of keys documents it. */
static const double DENSITY_DEFAULT = 1000.0;

/* No body where the scene does not say so: all zero. */
static tulle_body get_body(const dynamic_keys *keys) {
    tulle_body body = {.is_dynamic = keys->head.node != NULL};
    if (!body.is_dynamic) return body;
    body.mass = keys->mass;
    body.density = keys->density;
    body.area_density = keys->area_density;
    bool const has_mass = body.mass > 0.0 || body.density > 0.0 || body.area_density > 0.0;
    if (!has_mass) body.density = DENSITY_DEFAULT;
    body.linear_damping = keys->linear_damping;
    body.angular_damping = keys->angular_damping;
    body.start_time = keys->start;
    body.sleep_speed = keys->sleep_speed;
    body.sleep_time = keys->sleep_time;
    set_vector(body.velocity, &keys->velocity);
    set_vector(body.angular_velocity, &keys->spin);
    return body;
}

static tulle_status add_obstacle(const scene_obstacle *obstacle, tulle_drive drive,
                                 tulle_world *world, tulle_obstacle_id *id, tulle_error *error) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.name = obstacle->name;
    def.mesh = tulle_mesh_get_view(&obstacle->mesh);
    def.friction = obstacle->keys->friction;
    def.dynamic_friction = obstacle->keys->dynamic_friction;
    def.restitution = obstacle->keys->restitution;
    if (schema_is_given(&obstacle_map, obstacle->keys, "friction_across"))
        def.friction_across = obstacle->keys->friction_across;
    memcpy(def.grain, obstacle->grain, sizeof def.grain);
    def.contact_material = obstacle->contact_material;
    def.motion = obstacle->motion;
    def.drive = drive;
    def.appear_time = obstacle->appears;
    def.disappear_time = obstacle->disappears;
    def.body = get_body(&obstacle->keys->dynamic);
    if (obstacle->sequence) {
        def.read_frame = sequence_read;
        def.frame_context = obstacle->sequence;
        def.frame_count = sequence_get_frame_count(obstacle->sequence);
        def.frame_start_time = sequence_get_start(obstacle->sequence);
        def.frame_interval = sequence_get_interval(obstacle->sequence);
    }
    tulle_status status = tulle_world_add_obstacle(world, &def, id, error);
    return status == TULLE_OK ? TULLE_OK : add_place(&obstacle->keys->head, status, error);
}

static tulle_status set_law(const tulle_scene *loaded, const tulle_scene_world *built, size_t first,
                            size_t second, const tulle_contact_law *law, tulle_error *error) {
    size_t const cloth_count = loaded->cloth_count;
    if (first >= cloth_count)
        return tulle_world_set_obstacle_obstacle_law(
            built->world, built->obstacles[first - cloth_count],
            built->obstacles[second - cloth_count], law, error);
    tulle_cloth_id const cloth = built->cloths[first];
    if (second < cloth_count)
        return tulle_world_set_cloth_cloth_law(built->world, cloth, built->cloths[second], law,
                                               error);
    return tulle_world_set_cloth_obstacle_law(built->world, cloth,
                                              built->obstacles[second - cloth_count], law, error);
}

static tulle_contact_law get_law(const pair_keys *keys) {
    return (tulle_contact_law){keys->friction, keys->dynamic_friction, keys->restitution};
}

static tulle_status set_material_laws(const tulle_scene *loaded, tulle_world *world,
                                      tulle_error *error) {
    const schema_list *list = &loaded->keys.contact.materials;
    for (size_t i = 0; i < list->count; i++) {
        const pair_keys *keys = (const pair_keys *)list->items + i;
        const char *const *names = keys->between.value;
        tulle_contact_law const law = get_law(keys);
        tulle_status status = tulle_world_set_material_law(world, names[0], names[1], &law, error);
        if (status != TULLE_OK) return add_place(&keys->head, status, error);
    }
    return TULLE_OK;
}

static tulle_status set_laws(const tulle_scene *loaded, const tulle_scene_world *built,
                             tulle_error *error) {
    for (size_t p = 0; p < loaded->pair_count; p++) {
        const scene_pair *pair = &loaded->pairs[p];
        tulle_contact_law const law = get_law(pair->keys);
        for (size_t a = pair->first_begin; a < pair->first_end; a++)
            for (size_t b = pair->second_begin; b < pair->second_end; b++) {
                if (a == b) continue; /* copies among themselves */
                tulle_status status = set_law(loaded, built, a, b, &law, error);
                if (status != TULLE_OK) return add_place(&pair->keys->head, status, error);
            }
    }
    return TULLE_OK;
}

static tulle_status attach(const tulle_scene *loaded, const tulle_scene_world *built, size_t cloth,
                           const scene_attachment *attachment, tulle_error *error) {
    const attach_keys *const keys = attachment->keys;
    tulle_attachment_def def = tulle_attachment_def_default();
    def.cloth = built->cloths[cloth];
    def.vertices = attachment->vertices;
    def.vertex_count = attachment->vertex_count;
    if (attachment->object < loaded->cloth_count)
        def.other_cloth = built->cloths[attachment->object];
    else
        def.obstacle = built->obstacles[attachment->object - loaded->cloth_count];
    def.max_distance = keys->within;
    def.stiffness = keys->stiffness;
    def.break_force = keys->breaks_at;
    def.release_time = keys->release;
    tulle_attachment_id id;
    tulle_status const status = tulle_world_attach(built->world, &def, &id, error);
    return status == TULLE_OK ? TULLE_OK : add_place(&keys->head, status, error);
}

static tulle_status add_attachments(const tulle_scene *loaded, const tulle_scene_world *built,
                                    size_t index, tulle_error *error) {
    const scene_cloth *const cloth = &loaded->cloths[index];
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < cloth->attachment_count && status == TULLE_OK; i++)
        status = attach(loaded, built, index, &cloth->attachments[i], error);
    return status;
}

static tulle_status add_objects(const tulle_scene *loaded, tulle_scene_world *built,
                                tulle_error *error) {
    memory heap = memory_default();
    built->cloth_count = loaded->cloth_count;
    built->obstacle_count = loaded->obstacle_count;
    built->cloths = memory_allocate_zeroed(&heap, built->cloth_count, sizeof *built->cloths);
    built->obstacles =
        memory_allocate_zeroed(&heap, built->obstacle_count, sizeof *built->obstacles);
    if (!built->cloths || !built->obstacles)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory while building a world");
    tulle_status status = TULLE_OK;
    for (size_t i = 0; status == TULLE_OK && i < loaded->cloth_count; i++)
        status = add_cloth(&loaded->cloths[i], built->world, &built->cloths[i], error);
    for (size_t i = 0; status == TULLE_OK && i < loaded->obstacle_count; i++)
        status = add_obstacle(&loaded->obstacles[i], TULLE_DRIVE_NONE, built->world,
                              &built->obstacles[i], error);
    for (size_t i = 0; status == TULLE_OK && i < loaded->cloth_count; i++)
        status = add_attachments(loaded, built, i, error);
    if (status == TULLE_OK) status = set_material_laws(loaded, built->world, error);
    return status == TULLE_OK ? set_laws(loaded, built, error) : status;
}

/* `writer`: null for a world that is not recorded. */
static tulle_status build_world(const tulle_scene *loaded, int threads,
                                const tulle_allocator *allocator, const tulle_record_writer *writer,
                                tulle_scene_world *result, tulle_error *error) {
    tulle_world_def def = make_world_def(loaded);
    tulle_paper_options const paper = make_paper_options(&loaded->keys);
    def.paper = &paper;
    def.threads = threads;
    if (allocator) def.allocator = *allocator;
    *result = (tulle_scene_world){0};
    tulle_status status = tulle_world_create(&def, &result->world, error);
    if (status != TULLE_OK) return add_place(&loaded->keys.contact.head, status, error);
    if (writer) status = tulle_world_record(result->world, writer, error);
    if (status == TULLE_OK) status = add_objects(loaded, result, error);
    if (status != TULLE_OK) tulle_scene_destroy_world(result);
    return status;
}

tulle_status tulle_scene_build_world(tulle_scene *loaded, int threads,
                                     const tulle_allocator *allocator, tulle_scene_world *result,
                                     tulle_error *error) {
    if (result) *result = (tulle_scene_world){0};
    if (!loaded || !result)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "scene and result may not be null");
    return build_world(loaded, threads, allocator, NULL, result, error);
}

tulle_status scene_build_recorded_world(tulle_scene *loaded, int threads,
                                        const tulle_record_writer *writer,
                                        tulle_scene_world *result, tulle_error *error) {
    return build_world(loaded, threads, NULL, writer, result, error);
}

/* ---- an obstacle that is taken in hand ---- */

/* Attachments of the scene are the first of its world, counted from 1 in the order of cloths. Moves
 * the vertices that the one with this id holds to the front of its list; how many these are. */
static size_t sort_held(const tulle_world *world, tulle_attachment_id id,
                        const scene_attachment *attachment) {
    size_t held = 0;
    for (size_t k = 0; k < attachment->vertex_count; k++) {
        uint32_t const vertex = attachment->vertices[k];
        if (!tulle_attachment_holds(world, id, vertex)) continue;
        attachment->vertices[k] = attachment->vertices[held];
        attachment->vertices[held++] = vertex;
    }
    return held;
}

/* Laws between two objects, of which `object` is one. */
static tulle_status set_laws_of(const tulle_scene *loaded, const tulle_scene_world *built,
                                size_t object, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t p = 0; p < loaded->pair_count; p++) {
        const scene_pair *const pair = &loaded->pairs[p];
        tulle_contact_law const law = get_law(pair->keys);
        for (size_t a = pair->first_begin; a < pair->first_end; a++)
            for (size_t b = pair->second_begin; b < pair->second_end && status == TULLE_OK; b++)
                if (a != b && (a == object || b == object))
                    status = set_law(loaded, built, a, b, &law, error);
    }
    return status;
}

tulle_status scene_drive_obstacle(const tulle_scene *loaded, tulle_scene_world *built, size_t index,
                                  tulle_error *error) {
    const scene_obstacle *const obstacle = &loaded->obstacles[index];
    if (tulle_scene_is_obstacle_moving(loaded, index))
        return error_set(error, TULLE_ERROR_UNSUPPORTED,
                         "'%s' follows the script of the scene; only static obstacles and rigid "
                         "bodies can be moved by hand",
                         obstacle->name);
    memory heap = memory_default();
    size_t attachment_count = 0;
    for (size_t c = 0; c < loaded->cloth_count; c++)
        attachment_count += loaded->cloths[c].attachment_count;
    size_t *const held = memory_allocate_zeroed(&heap, attachment_count + 1, sizeof *held);
    if (!held) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    size_t const object = loaded->cloth_count + index;
    size_t next = 0;
    for (size_t c = 0; c < loaded->cloth_count; c++)
        for (size_t i = 0; i < loaded->cloths[c].attachment_count; i++, next++)
            if (loaded->cloths[c].attachments[i].object == object)
                held[next] = sort_held(built->world, (tulle_attachment_id)(next + 1),
                                       &loaded->cloths[c].attachments[i]);
    tulle_status status = tulle_world_remove_obstacle(built->world, built->obstacles[index], error);
    if (status == TULLE_OK)
        status = add_obstacle(obstacle, TULLE_DRIVE_RIGID, built->world, &built->obstacles[index],
                              error);
    next = 0;
    for (size_t c = 0; c < loaded->cloth_count; c++)
        for (size_t i = 0; i < loaded->cloths[c].attachment_count; i++, next++)
            if (held[next] > 0 && status == TULLE_OK) {
                scene_attachment rest = loaded->cloths[c].attachments[i];
                rest.vertex_count = held[next];
                status = attach(loaded, built, c, &rest, error);
            }
    if (status == TULLE_OK) status = set_laws_of(loaded, built, object, error);
    memory_release(&heap, held, (attachment_count + 1) * sizeof *held);
    return status;
}

void tulle_scene_destroy_world(tulle_scene_world *built) {
    if (!built) return;
    memory heap = memory_default();
    tulle_world_destroy(built->world);
    memory_release(&heap, built->cloths, built->cloth_count * sizeof *built->cloths);
    memory_release(&heap, built->obstacles, built->obstacle_count * sizeof *built->obstacles);
    *built = (tulle_scene_world){0};
}
