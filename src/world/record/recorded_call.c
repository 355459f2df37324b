/* world/record/recorded_call.c - see recorded_call.h. Each visit_ function walks over one thing, in
 * one order, and writes or fills it by the stream's direction. What it fills is not trusted: it
 * goes through the same public calls that a host would make. */
#include "world/record/recorded_call.h"

#include "base/hash.h"
#include "tulle/bodies.h"
#include "world/world_state.h"

#include <string.h>

/* A field that is new in one of these is recorded below, too. Then the format has a new version,
 * unless the field comes last and may be missing. */
#if UINTPTR_MAX == UINT64_MAX
_Static_assert(sizeof(tulle_world_def) == 280, "record all fields of tulle_world_def");
_Static_assert(sizeof(tulle_material) == 216, "record all fields of tulle_material");
_Static_assert(sizeof(tulle_pin) == 80, "record all fields of tulle_pin");
_Static_assert(sizeof(tulle_cloth_def) == 408, "record all fields of tulle_cloth_def");
_Static_assert(sizeof(tulle_obstacle_def) == 344, "record all fields of tulle_obstacle_def");
_Static_assert(sizeof(tulle_attachment_def) == 104, "record all fields of tulle_attachment_def");
_Static_assert(offsetof(tulle_transform, centre) == RECORD_BODY_BYTES, "what a body begins with");
#endif

#define ANY RECORD_ANY_COUNT
enum { DRIVE_COUNT = sizeof(tulle_body_drive) / sizeof(double), WIND_COUNT = 7 };
#define RECORD_FACTS(kind, call, first, second) [RECORD_##kind] = {call, {first, second}},
const record_facts record_kinds[RECORD_KIND_COUNT] = {RECORD_KINDS(RECORD_FACTS)};

/* ---- numbers and arrays ---- */

void record_store(unsigned char *bytes, size_t byte_count, uint64_t value) {
    for (size_t i = 0; i < byte_count; i++) bytes[i] = (unsigned char)(value >> (8 * i));
}

uint64_t record_load(const unsigned char *bytes, size_t byte_count) {
    uint64_t value = 0;
    for (size_t i = 0; i < byte_count; i++) value |= (uint64_t)bytes[i] << (8 * i);
    return value;
}

static void fail(record_stream *stream, tulle_status status) {
    if (stream->status == TULLE_OK) stream->status = status;
}

/* `count` words of 1, 4 or 8 bytes each. */
static void visit_words(record_stream *stream, void *data, size_t count, size_t size) {
    unsigned char *words = data;
    if (stream->status != TULLE_OK) return;
    if (stream->is_reading) {
        if (count > (size_t)(stream->end - stream->at) / size) {
            fail(stream, TULLE_ERROR_PARSE);
            return;
        }
        for (size_t i = 0; i < count; i++, words += size, stream->at += size) {
            uint64_t const value = record_load(stream->at, size);
            uint32_t const half = (uint32_t)value;
            unsigned char const byte = (unsigned char)value;
            const void *const from = size == 8   ? (const void *)&value
                                     : size == 4 ? (const void *)&half
                                                 : &byte;
            memcpy(words, from, size);
        }
        return;
    }
    if (!ARRAY_RESERVE(stream->heap, &stream->bytes, count * size)) {
        fail(stream, TULLE_ERROR_OUT_OF_MEMORY);
        return;
    }
    unsigned char *to = stream->bytes.data + stream->bytes.count;
    for (size_t i = 0; i < count; i++, words += size, to += size) {
        uint64_t value = words[0];
        uint32_t half = 0;
        if (size == sizeof half) {
            memcpy(&half, words, sizeof half);
            value = half;
        } else if (size == sizeof value) {
            memcpy(&value, words, sizeof value);
        }
        record_store(to, size, value);
    }
    stream->bytes.count += count * size;
}

static void visit_doubles(record_stream *stream, double *numbers, size_t count) {
    visit_words(stream, numbers, count, sizeof(double));
}

static void visit_integer(record_stream *stream, int *number) {
    visit_words(stream, number, 1, sizeof(int32_t));
}

#define VISIT_ENUM(stream, field)                                                                  \
    do {                                                                                           \
        uint32_t word = (uint32_t)(field);                                                         \
        visit_words((stream), &word, 1, sizeof word);                                              \
        (field) = word;                                                                            \
    } while (0)

/* The most values that belong to a thing that is counted. */
enum { VALUES_MAX = 16 };

/* A count of things of which each takes a byte or more behind it. One that is read is so small that
 * no product with VALUES_MAX and a size of 8 bytes overflows. */
static void visit_count(record_stream *stream, size_t *count) {
    uint64_t word = *count;
    visit_words(stream, &word, 1, sizeof word);
    if (stream->is_reading && (word > (uint64_t)(stream->end - stream->at) ||
                               word > SIZE_MAX / (VALUES_MAX * sizeof(double))))
        fail(stream, TULLE_ERROR_PARSE);
    *count = stream->status == TULLE_OK ? (size_t)word : 0;
}

/* An array of `count` words, or null. */
static void visit_array(record_stream *stream, const void **data, size_t count, size_t size) {
    unsigned char is_there = *data != NULL;
    visit_words(stream, &is_there, 1, 1);
    if (stream->status != TULLE_OK || is_there == 0) {
        if (stream->is_reading) *data = NULL;
        return;
    }
    if (!stream->is_reading) {
        visit_words(stream, (void *)(uintptr_t)*data, count, size);
        return;
    }
    *data = NULL;
    if (count > (size_t)(stream->end - stream->at) / size) {
        fail(stream, TULLE_ERROR_PARSE);
        return;
    }
    void *const made = arena_allocate(stream->scratch, count, size);
    if (!made) fail(stream, TULLE_ERROR_OUT_OF_MEMORY);
    visit_words(stream, made, count, size);
    *data = made;
}

static void visit_double_array(record_stream *stream, const double **data, size_t count) {
    const void *array = *data;
    visit_array(stream, &array, count, sizeof(double));
    *data = array;
}

static void visit_index_array(record_stream *stream, const uint32_t **data, size_t count) {
    const void *array = *data;
    visit_array(stream, &array, count, sizeof(uint32_t));
    *data = array;
}

/* A text with its final zero, or null. */
static void visit_text(record_stream *stream, const char **text) {
    size_t count = *text ? strlen(*text) + 1 : 0;
    const void *array = *text;
    visit_count(stream, &count);
    visit_array(stream, &array, count, 1);
    *text = array;
    if (stream->is_reading && *text && (count == 0 || (*text)[count - 1] != '\0')) {
        fail(stream, TULLE_ERROR_PARSE);
        *text = NULL;
    }
}

/* ---- defs ---- */

static void visit_world_def(record_stream *stream, tulle_world_def *def) {
    tulle_wind *const wind = &def->wind;
    def->cookie = WORLD_DEF_COOKIE;
    visit_doubles(stream, def->gravity, 3);
    visit_doubles(stream, wind->velocity, 3);
    visit_doubles(stream, &wind->gust_strength, 1);
    visit_doubles(stream, &wind->gust_length, 1);
    visit_doubles(stream, &wind->gust_time, 1);
    visit_words(stream, &wind->seed, 1, sizeof wind->seed);
    visit_doubles(stream, &wind->drag_coefficient, 1);
    visit_doubles(stream, &def->contact_distance, 1);
    visit_doubles(stream, &def->separation_distance, 1);
    visit_doubles(stream, &def->minimum_gap, 1);
    VISIT_ENUM(stream, def->integrator);
    VISIT_ENUM(stream, def->detection.method);
    VISIT_ENUM(stream, def->detection.cone);
    visit_doubles(stream, &def->detection.max_angle, 1);
    visit_integer(stream, &def->detection.has_certificate);
    visit_integer(stream, &def->detection.grows_patches_anew);
    VISIT_ENUM(stream, def->response);
    VISIT_ENUM(stream, def->motion_space);
    VISIT_ENUM(stream, def->membrane);
    VISIT_ENUM(stream, def->on_overstretch);
    VISIT_ENUM(stream, def->quality);
    visit_doubles(stream, &def->cg_tolerance, 1);
    visit_integer(stream, &def->cg_max_iterations);
    visit_integer(stream, &def->solve_rounds);
    visit_integer(stream, &def->impulse_sweeps);
    visit_integer(stream, &def->impact_rounds);
    visit_doubles(stream, &def->friction_cloth_cloth, 1);
    visit_doubles(stream, &def->dynamic_friction_cloth_cloth, 1);
    VISIT_ENUM(stream, def->start_intersections);
    visit_integer(stream, &def->untangle_limit);
    VISIT_ENUM(stream, def->on_pinch);
    visit_doubles(stream, &def->sleep_speed, 1);
    visit_doubles(stream, &def->sleep_time, 1);
    visit_integer(stream, &def->threads);
}

static void visit_curve(record_stream *stream, tulle_curve *curve) {
    visit_doubles(stream, &curve->stiffness, 1);
    visit_doubles(stream, &curve->knee, 1);
    visit_doubles(stream, &curve->limit, 1);
}

static void visit_material(record_stream *stream, tulle_material *material) {
    visit_doubles(stream, &material->area_density, 1);
    visit_curve(stream, &material->warp);
    visit_curve(stream, &material->weft);
    visit_curve(stream, &material->shear);
    double *const numbers[] = {&material->poisson,
                               &material->bend_warp,
                               &material->bend_weft,
                               &material->bend_twist,
                               &material->bend_hysteresis_warp,
                               &material->bend_hysteresis_weft,
                               &material->shear_hysteresis,
                               &material->springs.stretch_stiffness,
                               &material->springs.bend_stiffness,
                               &material->springs.stiffening_strain,
                               &material->stretch_damping,
                               &material->bend_damping,
                               &material->air_damping,
                               &material->friction,
                               &material->dynamic_friction,
                               &material->restitution,
                               &material->friction_across};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        visit_doubles(stream, numbers[i], 1);
}

static void visit_mesh(record_stream *stream, tulle_mesh_view *mesh) {
    visit_count(stream, &mesh->vertex_count);
    visit_double_array(stream, &mesh->positions, 3 * mesh->vertex_count);
    visit_count(stream, &mesh->triangle_count);
    visit_index_array(stream, &mesh->triangles, 3 * mesh->triangle_count);
}

/* A keyframe is doubles throughout. */
static void visit_motion(record_stream *stream, tulle_motion *motion) {
    const void *keys = motion->keys;
    visit_count(stream, &motion->key_count);
    visit_array(stream, &keys, motion->key_count * (sizeof *motion->keys / sizeof(double)),
                sizeof(double));
    motion->keys = keys;
    visit_doubles(stream, motion->pivot, 3);
    visit_integer(stream, &motion->is_eased);
}

/* Place for things that are read one by one; null when nothing is to be read. */
static void *make_place(record_stream *stream, size_t count, size_t size) {
    if (!stream->is_reading || count == 0 || stream->status != TULLE_OK) return NULL;
    void *const made = arena_allocate_zeroed(stream->scratch, count, size);
    if (!made) fail(stream, TULLE_ERROR_OUT_OF_MEMORY);
    return made;
}

static void visit_pins_and_creases(record_stream *stream, tulle_cloth_def *def) {
    visit_count(stream, &def->crease_count);
    tulle_crease *const creases = make_place(stream, def->crease_count, sizeof *creases);
    for (size_t i = 0; i < def->crease_count && stream->status == TULLE_OK; i++) {
        tulle_crease crease = {0};
        if (!stream->is_reading) crease = def->creases[i];
        visit_words(stream, crease.vertices, 2, sizeof crease.vertices[0]);
        visit_doubles(stream, &crease.angle, 1);
        if (creases) creases[i] = crease;
    }
    visit_count(stream, &def->pin_count);
    tulle_pin *const pins = make_place(stream, def->pin_count, sizeof *pins);
    for (size_t i = 0; i < def->pin_count && stream->status == TULLE_OK; i++) {
        tulle_pin pin = tulle_pin_default();
        if (!stream->is_reading) pin = def->pins[i];
        visit_count(stream, &pin.vertex_count);
        visit_index_array(stream, &pin.vertices, pin.vertex_count);
        visit_motion(stream, &pin.motion);
        visit_doubles(stream, &pin.release_time, 1);
        if (pins) pins[i] = pin;
    }
    if (!stream->is_reading) return;
    def->creases = creases;
    def->pins = pins;
}

static void visit_cloth_def(record_stream *stream, tulle_cloth_def *def) {
    def->cookie = CLOTH_DEF_COOKIE;
    visit_text(stream, &def->name);
    visit_mesh(stream, &def->mesh);
    size_t const vertices = def->mesh.vertex_count, triangles = def->mesh.triangle_count;
    visit_double_array(stream, &def->rest_positions, 3 * vertices);
    visit_double_array(stream, &def->rest_corners, 9 * triangles);
    visit_integer(stream, &def->has_flat_rest);
    visit_pins_and_creases(stream, def);
    visit_material(stream, &def->material);
    visit_doubles(stream, def->grain, 3);
    visit_double_array(stream, &def->warps, 3 * triangles);
    visit_text(stream, &def->contact_material);
    visit_doubles(stream, &def->thickness, 1);
    visit_doubles(stream, def->velocity, 3);
    visit_double_array(stream, &def->velocities, 3 * vertices);
    /* A recording of cloth without factors ends here. */
    if (stream->is_reading) def->stiffness_factors = NULL;
    if (stream->is_reading ? stream->at != stream->end : def->stiffness_factors != NULL)
        visit_double_array(stream, &def->stiffness_factors, triangles);
}

static void visit_body(record_stream *stream, tulle_body *body) {
    visit_integer(stream, &body->is_dynamic);
    visit_doubles(stream, &body->mass, 1);
    visit_doubles(stream, &body->density, 1);
    visit_doubles(stream, &body->area_density, 1);
    visit_doubles(stream, body->velocity, 3);
    visit_doubles(stream, body->angular_velocity, 3);
    visit_doubles(stream, &body->linear_damping, 1);
    visit_doubles(stream, &body->angular_damping, 1);
    visit_doubles(stream, &body->start_time, 1);
    visit_doubles(stream, &body->sleep_speed, 1);
    visit_doubles(stream, &body->sleep_time, 1);
}

static tulle_status give_no_frame(void *context, uint32_t frame, double *positions,
                                  tulle_error *error) {
    (void)context, (void)frame, (void)positions, (void)error;
    return TULLE_ERROR_UNSUPPORTED;
}

static void visit_obstacle_def(record_stream *stream, tulle_obstacle_def *def) {
    int has_frames = def->read_frame != NULL;
    def->cookie = OBSTACLE_DEF_COOKIE;
    visit_text(stream, &def->name);
    visit_mesh(stream, &def->mesh);
    visit_doubles(stream, &def->friction, 1);
    visit_doubles(stream, &def->dynamic_friction, 1);
    visit_doubles(stream, &def->restitution, 1);
    visit_doubles(stream, &def->friction_across, 1);
    visit_doubles(stream, def->grain, 3);
    visit_text(stream, &def->contact_material);
    visit_motion(stream, &def->motion);
    VISIT_ENUM(stream, def->drive);
    visit_integer(stream, &has_frames);
    visit_words(stream, &def->frame_count, 1, sizeof def->frame_count);
    visit_doubles(stream, &def->frame_start_time, 1);
    visit_doubles(stream, &def->frame_interval, 1);
    visit_doubles(stream, &def->appear_time, 1);
    visit_doubles(stream, &def->disappear_time, 1);
    visit_body(stream, &def->body);
    if (stream->is_reading) def->read_frame = has_frames ? give_no_frame : NULL;
}

static void visit_attachment_def(record_stream *stream, tulle_attachment_def *def) {
    def->cookie = ATTACHMENT_DEF_COOKIE;
    visit_words(stream, &def->cloth.index, 1, sizeof(uint32_t));
    visit_words(stream, &def->cloth.generation, 1, sizeof(uint32_t));
    visit_words(stream, &def->obstacle.index, 1, sizeof(uint32_t));
    visit_words(stream, &def->obstacle.generation, 1, sizeof(uint32_t));
    visit_words(stream, &def->other_cloth.index, 1, sizeof(uint32_t));
    visit_words(stream, &def->other_cloth.generation, 1, sizeof(uint32_t));
    visit_count(stream, &def->vertex_count);
    size_t const count = def->vertex_count;
    visit_index_array(stream, &def->vertices, count);
    visit_double_array(stream, &def->points, 3 * count);
    visit_index_array(stream, &def->triangles, count);
    visit_double_array(stream, &def->weights, 3 * count);
    visit_doubles(stream, &def->max_distance, 1);
    visit_doubles(stream, &def->stiffness, 1);
    visit_doubles(stream, &def->break_force, 1);
    visit_doubles(stream, &def->release_time, 1);
}

/* ---- calls ---- */

static void visit_call(record_stream *stream, recorded_call *call) {
    visit_words(stream, call->ids, 2, sizeof call->ids[0]);
    visit_words(stream, call->generations, 2, sizeof call->generations[0]);
    visit_words(stream, call->numbers, 2, sizeof call->numbers[0]);
    for (int k = 0; k < 2; k++) {
        recorded_array *const array = &call->arrays[k];
        size_t const wanted = record_kinds[call->kind].counts[k];
        visit_count(stream, &array->count);
        visit_double_array(stream, &array->data, array->count);
        bool const fits = wanted == ANY ? array->count % 3 == 0 : array->count == wanted;
        if (array->data ? !fits : array->count > 0) fail(stream, TULLE_ERROR_PARSE);
    }
    switch (call->kind) {
    case RECORD_CREATE:
        visit_text(stream, &call->texts[0]);
        visit_world_def(stream, &call->def.world);
        break;
    case RECORD_CLOTH:
    case RECORD_ADD_CLOTH: visit_cloth_def(stream, &call->def.cloth); break;
    case RECORD_OBSTACLE:
    case RECORD_ADD_OBSTACLE: visit_obstacle_def(stream, &call->def.obstacle); break;
    case RECORD_MATERIAL: visit_material(stream, &call->def.material); break;
    case RECORD_ATTACH: visit_attachment_def(stream, &call->def.attachment); break;
    case RECORD_TARGETS:
    case RECORD_LOAD:
        visit_count(stream, &call->def.state.byte_count);
        visit_array(stream, &call->def.state.bytes, call->def.state.byte_count, 1);
        break;
    case RECORD_MATERIAL_LAW:
        for (int k = 0; k < 2; k++) visit_text(stream, &call->texts[k]);
        break;
    default: break;
    }
}

void record_seal(unsigned char *block, size_t byte_count) {
    size_t const payload = byte_count - RECORD_HEAD_BYTES - RECORD_HASH_BYTES;
    record_store(block, 8, payload);
    record_store(block + 12, 4, hash_block(block, 12));
    record_store(block + byte_count - RECORD_HASH_BYTES, 8,
                 hash_block(block + RECORD_HEAD_BYTES, payload));
}

tulle_status recorded_call_write(record_stream *stream, const recorded_call *call) {
    size_t const begin = stream->bytes.count;
    uint32_t head[4] = {0, 0, (uint32_t)call->kind, 0};
    uint64_t hash = 0;
    recorded_call copy = *call;
    visit_words(stream, head, 4, sizeof head[0]);
    visit_call(stream, &copy);
    visit_words(stream, &hash, 1, sizeof hash);
    if (stream->status == TULLE_OK)
        record_seal(stream->bytes.data + begin, stream->bytes.count - begin);
    return stream->status;
}

tulle_status recorded_call_read(record_stream *stream, recorded_call *call) {
    visit_call(stream, call);
    if (stream->at != stream->end) fail(stream, TULLE_ERROR_PARSE);
    return stream->status;
}
