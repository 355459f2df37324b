/* io/run/run_record.c - run.json: what is known of a run from its beginning, and how it ended. */
#include "io/run/run_record.h"

#include "base/error.h"
#include "base/hash.h"
#include "io/file_data.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const format_name = "tulle run";
enum { FORMAT_VERSION = 3 };
static const char *const record_names[] = {"plain", "debug", "velocities"}; /* by run_kept */
static const size_t record_size_limit = (size_t)1 << 28; /* [bytes] far above RUN_BODY_MAX bodies */

const char *tulle_run_state_name(tulle_run_state state) {
    static const char *const names[] = {"running", "finished", "interrupted", "failed"};
    return (unsigned)state < 4 ? names[state] : NULL;
}

run_record run_record_make(memory *heap) { return (run_record){.heap = heap}; }

void run_record_destroy(run_record *record) {
    if (!record->heap) return;
    ARRAY_FREE(record->heap, &record->pool);
    ARRAY_FREE(record->heap, &record->bodies);
}

const char *run_record_text(const run_record *record, size_t text) {
    return record->pool.data ? record->pool.data + text : "";
}

bool run_record_keep(run_record *record, const char *text, size_t *kept) {
    size_t const size = strlen(text) + 1;
    if (!ARRAY_RESERVE(record->heap, &record->pool, size + 1)) return false;
    if (record->pool.count == 0) record->pool.data[record->pool.count++] = '\0';
    *kept = size == 1 ? 0 : record->pool.count;
    if (size == 1) return true;
    memcpy(record->pool.data + record->pool.count, text, size);
    record->pool.count += size;
    return true;
}

static tulle_status fail_memory(const char *path, tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                        "out of memory for the description of the run");
}

/* ---- from a def ---- */

/* The length up to the first point of a name that means a device on Windows, as "con" and "aux.1";
 * else 0. */
static size_t find_device(const char *stem) {
    static const char *const devices[] = {"con", "prn", "aux", "nul", "com?", "lpt?"};
    size_t const length = strcspn(stem, ".");
    for (size_t i = 0; i < sizeof devices / sizeof devices[0]; i++) {
        const char *const device = devices[i];
        size_t k = 0;
        while (k < length && device[k] &&
               (device[k] == '?' ? stem[k] >= '0' && stem[k] <= '9' : (stem[k] | 32) == device[k]))
            k++;
        if (k == length && !device[k]) return length;
    }
    return 0;
}

/* A name that every file system takes: of ASCII, no blanks, no slashes, no leading point, no device
 * of Windows. */
static void make_stem(const char *name, char stem[RUN_STEM_SIZE]) {
    size_t length = 0;
    for (; *name && length < RUN_STEM_SIZE - 20; name++) {
        char const c = *name;
        if (((unsigned char)c & 0xc0) == 0x80) continue; /* a character goes on */
        int const is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                             (c >= '0' && c <= '9') || c == '-' || c == '_' ||
                             (c == '.' && length > 0);
        stem[length++] = is_plain ? c : '_';
    }
    if (length == 0) length = (size_t)snprintf(stem, RUN_STEM_SIZE, "body");
    stem[length] = '\0';
    size_t const device = find_device(stem);
    if (device == 0) return;
    memmove(stem + device + 1, stem + device, length + 1 - device);
    stem[device] = '_';
}

static uint64_t hash_stem(const char *stem) {
    uint64_t hash = HASH_SEED;
    for (; *stem; stem++) {
        char const lower = *stem >= 'A' && *stem <= 'Z' ? (char)(*stem + 32) : *stem;
        hash = hash_bytes(hash, &lower, 1);
    }
    return hash_mix(hash);
}

/* Stems in use, as hashes in an open-addressed table at most half full. Two stems with one hash
 * only cost a needless number. */
typedef struct stem_table {
    uint64_t *slots;
    size_t slot_count;
} stem_table;

/* False when the stem was there. */
static bool claim_stem(stem_table *table, const char *stem) {
    uint64_t const hash = hash_stem(stem) | 1;
    size_t slot = (size_t)hash & (table->slot_count - 1);
    for (; table->slots[slot]; slot = (slot + 1) & (table->slot_count - 1))
        if (table->slots[slot] == hash) return false;
    table->slots[slot] = hash;
    return true;
}

static void make_unique(stem_table *table, char stem[RUN_STEM_SIZE], size_t body) {
    if (claim_stem(table, stem)) return;
    size_t const length = strlen(stem);
    for (size_t number = body;; number += RUN_BODY_MAX) {
        snprintf(stem + length, RUN_STEM_SIZE - length, "-%zu", number);
        if (claim_stem(table, stem)) return;
    }
}

static bool describe_body(run_record *record, const tulle_run_body *body, stem_table *table) {
    if (!ARRAY_RESERVE(record->heap, &record->bodies, 1)) return false;
    char stem[RUN_STEM_SIZE], file[RUN_STEM_SIZE + 8];
    make_stem(body->name, stem);
    make_unique(table, stem, record->bodies.count);
    run_body_record described = {.is_obstacle = body->is_obstacle != 0,
                                 .is_static = body->is_static != 0,
                                 .is_dynamic = body->is_obstacle && body->is_dynamic,
                                 .vertex_count = (uint32_t)body->mesh.vertex_count,
                                 .triangle_count = (uint32_t)body->mesh.triangle_count};
    snprintf(file, sizeof file, "%s.obj", stem);
    if (!run_record_keep(record, body->name, &described.name) ||
        !run_record_keep(record, file, &described.mesh_file))
        return false;
    snprintf(file, sizeof file, "%s.pc2", stem);
    if (!run_record_keep(record, body->is_static ? "" : file, &described.cache_file)) return false;
    record->bodies.data[record->bodies.count++] = described;
    return true;
}

tulle_status run_record_describe(run_record *record, const tulle_run_def *def, tulle_error *error) {
    char version[48];
    snprintf(version, sizeof version, "%d.%d.%d", TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR,
             TULLE_VERSION_PATCH);
    record->scene_hash = def->scene_hash;
    record->seed = def->seed;
    record->time_step = def->time_step;
    record->steps_per_frame = def->steps_per_frame;
    record->wanted_frame_count = def->frame_count;
    record->threads = (uint32_t)def->threads;
    record->has_scene_text = def->scene_text != NULL;
    record->writes_vtp = def->writes_vtp != 0;
    record->kept = def->records_debug        ? RUN_KEEPS_DEBUG
                   : def->records_velocities ? RUN_KEEPS_VELOCITIES
                                             : RUN_KEEPS_NOTHING;
    record->state = TULLE_RUN_RUNNING;
    record->has_detection = def->detection != NULL;
    if (def->detection) record->detection = *def->detection;
    record->has_response = def->has_response != 0;
    record->response = def->response;
    record->motion_space = def->motion_space;
    record->has_untangle = def->untangle != NULL;
    if (def->untangle) record->untangle = *def->untangle;
    bool fits =
        run_record_keep(record, version, &record->version) &&
        run_record_keep(record, def->scene_path ? def->scene_path : "", &record->scene_path);
    stem_table table = {.slot_count = 16};
    while (table.slot_count < 2 * def->body_count) table.slot_count *= 2;
    table.slots = memory_allocate_zeroed(record->heap, table.slot_count, sizeof(uint64_t));
    fits = fits && table.slots;
    for (size_t i = 0; i < def->body_count && fits; i++)
        fits = describe_body(record, &def->bodies[i], &table);
    memory_release(record->heap, table.slots, table.slot_count * sizeof(uint64_t));
    return fits ? TULLE_OK : fail_memory(def->directory, error);
}

static bool is_same_body(const run_record *old, const run_record *new, size_t body) {
    const run_body_record *const a = &old->bodies.data[body];
    const run_body_record *const b = &new->bodies.data[body];
    return strcmp(run_record_text(old, a->name), run_record_text(new, b->name)) == 0 &&
           strcmp(run_record_text(old, a->mesh_file), run_record_text(new, b->mesh_file)) == 0 &&
           a->is_obstacle == b->is_obstacle && a->is_static == b->is_static &&
           a->is_dynamic == b->is_dynamic && a->vertex_count == b->vertex_count &&
           a->triangle_count == b->triangle_count;
}

tulle_status run_record_compare(const run_record *old, const run_record *new, const char *path,
                                tulle_error *error) {
    const char *difference = NULL;
    if (old->scene_hash != new->scene_hash)
        difference = "its scene has another hash: the scene was changed since, or an earlier build "
                     "of tulle began the run";
    if (old->time_step < new->time_step || old->time_step > new->time_step ||
        old->steps_per_frame != new->steps_per_frame)
        difference = "it had another time step";
    if (old->bodies.count != new->bodies.count) difference = "it had another number of bodies";
    for (size_t i = 0; i < old->bodies.count && !difference; i++)
        if (!is_same_body(old, new, i)) difference = "its bodies were others";
    if (!difference && old->writes_vtp != new->writes_vtp)
        difference = "only one of the two writes VTP files";
    if (!difference && old->kept != new->kept)
        difference =
            old->kept == RUN_KEEPS_DEBUG ? "it keeps debug records, and the new options do not"
            : old->kept == RUN_KEEPS_VELOCITIES
                ? "it keeps velocities alone, and the new options do not"
                : "it keeps no debug records or velocities, and the new options ask for them";
    if (!difference) return TULLE_OK;
    int const length = (int)(strlen(path) - strlen("/" RUN_FILE_RECORD));
    if (old->scene_hash != new->scene_hash && old->has_scene_text)
        return error_set_at(
            error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
            "the run here cannot be resumed: %s, or another --set was given; to continue with the "
            "scene as it was: tulle run '%.*s/" RUN_FILE_SCENE
            "' -o '%.*s' --resume; or run into another directory, or replace this run (--force)",
            difference, length, path, length, path);
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                        "the run here cannot be resumed: %s; run into another directory, or "
                        "replace this run (--force)",
                        difference);
}

/* ---- to and from run.json ---- */

static const json_field fields[] = {
    {"scene_hash", JSON_HASH, offsetof(run_record, scene_hash)},
    {"time_step", JSON_DOUBLE, offsetof(run_record, time_step)},
    {"steps_per_frame", JSON_WHOLE, offsetof(run_record, steps_per_frame)},
    {"wanted_frames", JSON_WHOLE, offsetof(run_record, wanted_frame_count)},
    {"threads", JSON_WHOLE, offsetof(run_record, threads)},
    {"vtp", JSON_FLAG, offsetof(run_record, writes_vtp)}};
static const json_field body_fields[] = {
    {"static", JSON_FLAG, offsetof(run_body_record, is_static)},
    {"vertices", JSON_WHOLE, offsetof(run_body_record, vertex_count)},
    {"triangles", JSON_WHOLE, offsetof(run_body_record, triangle_count)}};

static const char *name_role(const run_body_record *body) {
    if (body->is_dynamic) return "body";
    return body->is_obstacle ? "obstacle" : "cloth";
}

static void write_body(json_writer *writer, const run_record *record, const run_body_record *body) {
    json_begin(writer, NULL, '{');
    json_put_string(writer, "name", run_record_text(record, body->name));
    json_put_string(writer, "role", name_role(body));
    json_put_fields(writer, body_fields, 3, body);
    json_put_string(writer, "mesh", run_record_text(record, body->mesh_file));
    json_put_string(writer, "cache",
                    body->cache_file ? run_record_text(record, body->cache_file) : NULL);
    json_end(writer, '}');
}

tulle_status run_record_write(const run_record *record, const char *path, tulle_error *error) {
    output_file *output = NULL;
    tulle_status const status = output_open_inside(path, &output, error);
    if (status) return status;
    char seed[24];
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)record->seed);
    json_writer writer = json_writer_make(output);
    json_begin(&writer, NULL, '{');
    json_put_string(&writer, "format", format_name);
    json_put_unsigned(&writer, "format_version", FORMAT_VERSION);
    json_put_string(&writer, "tulle_version", run_record_text(record, record->version));
    json_put_string(&writer, "state", tulle_run_state_name(record->state));
    json_put_string(&writer, "message", run_record_text(record, record->message));
    json_put_string(&writer, "scene_path", run_record_text(record, record->scene_path));
    json_put_string(&writer, "scene_file", record->has_scene_text ? RUN_FILE_SCENE : NULL);
    json_put_string(&writer, "seed", seed);
    json_put_fields(&writer, fields, sizeof fields / sizeof fields[0], record);
    json_put_double(&writer, "frame_interval", record->time_step * record->steps_per_frame);
    json_put_string(&writer, "record", record_names[record->kept]);
    run_detection_write(&writer, record);
    run_response_write(&writer, record);
    run_untangle_write(&writer, record);
    run_outcome_write(&writer, record);
    json_begin(&writer, "bodies", '[');
    for (size_t i = 0; i < record->bodies.count; i++)
        write_body(&writer, record, &record->bodies.data[i]);
    json_end(&writer, ']');
    run_end_write(&writer, record);
    json_put_hash(&writer, "checksum", output_get_hash(output));
    json_end(&writer, '}');
    return output_commit(output, error);
}

/* A file name within the directory: no way out of it. */
static bool is_file_name(const char *text) {
    return *text && *text != '.' && !strchr(text, '/') && strlen(text) < RUN_STEM_SIZE + 8;
}

static tulle_status read_body(run_record *record, const json_document *document,
                              const json_value *item, tulle_error *error) {
    const char *name = "", *role = "", *mesh = "", *cache = "";
    run_body_record body = {0};
    tulle_status status = json_take_string(document, item, "name", &name, error);
    if (!status) status = json_take_string(document, item, "role", &role, error);
    if (!status) status = json_take_fields(document, item, body_fields, 3, &body, error);
    if (!status) status = json_take_string(document, item, "mesh", &mesh, error);
    if (!status && !body.is_static)
        status = json_take_string(document, item, "cache", &cache, error);
    if (status) return status;
    body.is_dynamic = strcmp(role, "body") == 0;
    body.is_obstacle = body.is_dynamic || strcmp(role, "obstacle") == 0;
    if (!body.is_obstacle && strcmp(role, "cloth") != 0)
        return json_fail(document, item, error,
                         "\"role\" should be \"cloth\", \"obstacle\" or \"body\"");
    if (!is_file_name(mesh) || (!body.is_static && !is_file_name(cache)))
        return json_fail(document, item, error,
                         "\"mesh\" and \"cache\" should be file names in this directory");
    if (body.vertex_count < 1 || body.vertex_count > INT32_MAX || body.triangle_count > INT32_MAX)
        return json_fail(document, item, error,
                         "a body has 1 to 2^31 - 1 vertices and at most so many triangles");
    if (!ARRAY_RESERVE(record->heap, &record->bodies, 1) ||
        !run_record_keep(record, name, &body.name) ||
        !run_record_keep(record, mesh, &body.mesh_file) ||
        !run_record_keep(record, cache, &body.cache_file))
        return fail_memory(document->path, error);
    record->bodies.data[record->bodies.count++] = body;
    return TULLE_OK;
}

static tulle_status read_bodies(run_record *record, const json_document *document,
                                const json_value *root, tulle_error *error) {
    const json_value *bodies = NULL;
    tulle_status status = json_take_member(document, root, "bodies", JSON_ARRAY, &bodies, error);
    if (!status && bodies->count > RUN_BODY_MAX)
        status = json_fail(document, bodies, error, "there are more than %d bodies", RUN_BODY_MAX);
    if (status) return status;
    for (const json_value *item = json_get_first(document, bodies); item && !status;
         item = json_get_next(document, item))
        status = read_body(record, document, item, error);
    return status;
}

static tulle_status read_format(const json_document *document, const json_value *root,
                                bool has_seal, tulle_error *error) {
    const char *name = "";
    uint32_t version = 0;
    tulle_status status = json_take_string(document, root, "format", &name, error);
    if (!status && strcmp(name, format_name) != 0)
        status = json_fail(document, root, error, "\"format\" should be \"%s\"", format_name);
    if (!status) status = json_take_whole(document, root, "format_version", &version, error);
    if (!status && version != FORMAT_VERSION)
        status = json_fail(document, root, error,
                           "format version %u, of another version of tulle; only %d can be read: "
                           "run the scene again",
                           version, FORMAT_VERSION);
    if (!status && !has_seal)
        status = json_fail(document, root, error,
                           "damaged: the file does not end with its \"checksum\"");
    return status;
}

static tulle_status read_state(run_record *record, const json_document *document,
                               const json_value *root, tulle_error *error) {
    const char *name = "";
    tulle_status const status = json_take_string(document, root, "state", &name, error);
    if (status) return status;
    for (int state = 0; tulle_run_state_name((tulle_run_state)state); state++) {
        if (strcmp(name, tulle_run_state_name((tulle_run_state)state)) == 0) {
            record->state = (tulle_run_state)state;
            return TULLE_OK;
        }
    }
    return json_fail(document, root, error, "\"state\" is not known: \"%.40s\"", name);
}

static tulle_status read_numbers(run_record *record, const json_document *document,
                                 const json_value *root, tulle_error *error) {
    tulle_status const status =
        json_take_fields(document, root, fields, sizeof fields / sizeof fields[0], record, error);
    if (status || (record->time_step > 0.0 && record->steps_per_frame > 0)) return status;
    return json_fail(document, root, error,
                     "\"time_step\" and \"steps_per_frame\" should be above 0");
}

/* "record" is not in every run.json: plain then. */
static tulle_status read_record_kind(run_record *record, const json_document *document,
                                     const json_value *root, tulle_error *error) {
    const char *name = record_names[0];
    if (!json_find(document, root, "record")) return TULLE_OK;
    tulle_status const status = json_take_string(document, root, "record", &name, error);
    if (status) return status;
    for (int kept = RUN_KEEPS_NOTHING; kept <= RUN_KEEPS_VELOCITIES; kept++) {
        if (strcmp(name, record_names[kept]) != 0) continue;
        record->kept = (run_kept)kept;
        return TULLE_OK;
    }
    return json_fail(document, root, error,
                     "\"record\" should be \"plain\", \"velocities\" or \"debug\"");
}

static tulle_status read_texts(run_record *record, const json_document *document,
                               const json_value *root, tulle_error *error) {
    const char *version = "", *message = "", *path = "", *seed = "";
    tulle_status status = json_take_string(document, root, "tulle_version", &version, error);
    if (!status) status = json_take_string(document, root, "message", &message, error);
    if (!status) status = json_take_string(document, root, "scene_path", &path, error);
    if (!status) status = json_take_string(document, root, "seed", &seed, error);
    if (status) return status;
    const json_value *const scene = json_find(document, root, "scene_file");
    record->has_scene_text = scene && scene->type == JSON_STRING;
    char *end = NULL;
    record->seed = strtoull(seed, &end, 10);
    if (*seed < '0' || *seed > '9' || *end)
        return json_fail(document, root, error, "\"seed\" should be a whole number as a text");
    if (!run_record_keep(record, version, &record->version) ||
        !run_record_keep(record, message, &record->message) ||
        !run_record_keep(record, path, &record->scene_path))
        return fail_memory(document->path, error);
    return TULLE_OK;
}

tulle_status run_record_read(run_record *record, const char *path, tulle_error *error) {
    file_data data;
    tulle_status status = file_load(record->heap, path, record_size_limit, &data, error);
    if (status) return status;
    json_document document = {0};
    bool has_seal = false;
    status = run_seal_check(path, &data, &has_seal, error);
    if (!status)
        status = json_read(record->heap, path, data.bytes, data.byte_count, &document, error);
    file_release(record->heap, &data);
    if (status) return status;
    const json_value *const root = json_get_root(&document);
    status = read_format(&document, root, has_seal, error);
    if (!status) status = read_state(record, &document, root, error);
    if (!status) status = read_texts(record, &document, root, error);
    if (!status) status = read_numbers(record, &document, root, error);
    if (!status) status = read_record_kind(record, &document, root, error);
    if (!status) status = run_detection_read(record, &document, root, error);
    if (!status) status = run_response_read(record, &document, root, error);
    if (!status) status = run_untangle_read(record, &document, root, error);
    if (!status) status = read_bodies(record, &document, root, error);
    if (!status) status = run_outcome_read(record, &document, root, error);
    if (!status) status = run_end_read(record, &document, root, error);
    json_destroy(&document);
    return status;
}
