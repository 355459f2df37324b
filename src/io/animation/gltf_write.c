/* io/animation/gltf_write.c - writes an animation as glTF 2.0, .glb or .gltf and .bin.
 *
 * Based on: Khronos Group, glTF 2.0 Specification, 2021.
 *
 * A surface that deforms has a morph target for each frame. The mesh that targets are added to has
 * all its vertices in the origin, and the targets are the positions of the frames. So what comes
 * out at a frame, 0 plus 1 times the position, is the position to the last bit; of differences to a
 * frame it would be so to a rounding only. The default weights show the first frame. Normals are
 * stored as the standard has them, as differences to those of the first frame.
 *
 * Frames are read twice: for the bounds that the JSON text names, then for the buffer behind it. */
#include "base/error.h"
#include "io/animation/gltf_plan.h"
#include "io/bytes.h"
#include "io/file_data.h"
#include "io/text/json_quote.h"
#include "io/text/number.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum {
    GLB_HEADER_SIZE = 20,      /* [bytes] of the file and of the first chunk */
    GLB_CHUNK_SIZE = 8,        /* [bytes] of the second chunk's header */
    PIECE_SIZE = 1024,         /* [bytes] of a piece of JSON but for texts */
    SPARSE_TARGETS_MAX = 65535 /* the square is the largest number of weights that indices reach */
};

typedef struct gltf_writer {
    animation_job *job;
    gltf_plan plan;
    ARRAY(char) json;
    bool lacks_memory;
    output_file *buffer;
    float *base_normals; /* of the first frame, 3 * job->vertex_limit */
} gltf_writer;

/* ---- JSON ---- */

static void put_bytes(gltf_writer *writer, const char *text, size_t length) {
    if (writer->lacks_memory || !ARRAY_RESERVE(&writer->job->heap, &writer->json, length)) {
        writer->lacks_memory = true;
        return;
    }
    memcpy(writer->json.data + writer->json.count, text, length);
    writer->json.count += length;
}

static void put(gltf_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(gltf_writer *writer, const char *format, ...) {
    char piece[PIECE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    int const length = vsnprintf(piece, sizeof piece, format, arguments);
    va_end(arguments);
    if (length > 0 && length < PIECE_SIZE) put_bytes(writer, piece, (size_t)length);
}

static void put_quoted(gltf_writer *writer, const char *text) {
    char piece[JSON_PIECE_SIZE];
    put(writer, "\"");
    for (size_t length; (length = json_take_piece(&text, piece)) > 0;)
        put_bytes(writer, piece, length);
    put(writer, "\"");
}

/* An array of numbers behind its key. */
static void put_numbers(gltf_writer *writer, const char *key, const double *values, size_t count) {
    put(writer, "\"%s\":[", key);
    for (size_t i = 0; i < count; i++) {
        char text[NUMBER_TEXT_SIZE];
        number_format_double(values[i], text);
        put(writer, "%s%s", i > 0 ? "," : "", text);
    }
    put(writer, "]");
}

static void put_bounds(gltf_writer *writer, const float *low, const float *high, size_t count) {
    double values[2][3];
    for (size_t i = 0; i < count; i++) {
        values[0][i] = (double)low[i];
        values[1][i] = (double)high[i];
    }
    put(writer, ",");
    put_numbers(writer, "min", values[0], count);
    put(writer, ",");
    put_numbers(writer, "max", values[1], count);
}

/* An accessor up to its bounds; commas separate it from the one before. */
static void begin_accessor(gltf_writer *writer, gltf_view view, uint64_t place, const char *type,
                           uint64_t count) {
    put(writer,
        "%s{\"bufferView\":%d,\"byteOffset\":%llu,\"componentType\":%d,\"count\":%llu,"
        "\"type\":\"%s\"",
        writer->json.data[writer->json.count - 1] == '[' ? "" : ",",
        gltf_plan_get_view(&writer->plan, view), (unsigned long long)place,
        view == GLTF_VIEW_INDICES ? 5125 : 5126, (unsigned long long)count, type);
}

/* Positions and normals of the frame that has been read; is_zero: all in the origin. */
static void put_vectors(gltf_writer *writer, size_t surface, uint64_t *place, bool is_zero) {
    static const float zero[3] = {0};
    const gltf_part *const part = &writer->plan.parts[surface];
    float low[3], high[3];
    animation_measure_bounds(writer->job, surface, low, high);
    begin_accessor(writer, GLTF_VIEW_VECTORS, *place, "VEC3", part->vertex_count);
    put_bounds(writer, is_zero ? zero : low, is_zero ? zero : high, 3);
    put(writer, "}");
    *place += 12 * (uint64_t)part->vertex_count;
    if (writer->job->def->surfaces[surface].mesh.triangle_count == 0) return;
    begin_accessor(writer, GLTF_VIEW_VECTORS, *place, "VEC3", part->vertex_count);
    put(writer, "}");
    *place += 12 * (uint64_t)part->vertex_count;
}

static tulle_status put_mesh_accessors(gltf_writer *writer, size_t surface, tulle_error *error) {
    const gltf_part *const part = &writer->plan.parts[surface];
    size_t const triangle_count = writer->job->def->surfaces[surface].mesh.triangle_count;
    tulle_status status = animation_read(writer->job, surface, 0, error);
    if (status) return status;
    if (triangle_count > 0) {
        begin_accessor(writer, GLTF_VIEW_INDICES, part->index_place, "SCALAR", 3 * triangle_count);
        put(writer, "}");
    }
    uint64_t place = part->vector_place;
    put_vectors(writer, surface, &place, part->target_count > 0);
    if (part->uvs) {
        begin_accessor(writer, GLTF_VIEW_UVS, part->uv_place, "VEC2", part->vertex_count);
        put(writer, "}");
    }
    for (uint32_t frame = 0; frame < part->target_count && status == TULLE_OK; frame++) {
        status = animation_read(writer->job, surface, frame, error);
        if (status == TULLE_OK) put_vectors(writer, surface, &place, false);
    }
    return status;
}

static void put_weights_accessor(gltf_writer *writer) {
    const gltf_plan *const plan = &writer->plan;
    uint64_t const count = writer->job->def->frame_count;
    if (count <= GLTF_DENSE_TARGETS) {
        begin_accessor(writer, GLTF_VIEW_DRIVES, plan->weight_place, "SCALAR", count * count);
        put(writer, "}");
        return;
    }
    int const view = gltf_plan_get_view(plan, GLTF_VIEW_DRIVES);
    put(writer,
        ",{\"componentType\":5126,\"count\":%llu,\"type\":\"SCALAR\",\"sparse\":{\"count\":%llu,"
        "\"indices\":{\"bufferView\":%d,\"byteOffset\":%llu,\"componentType\":5125},"
        "\"values\":{\"bufferView\":%d,\"byteOffset\":%llu}}}",
        (unsigned long long)(count * count), (unsigned long long)count, view,
        (unsigned long long)plan->weight_place, view,
        (unsigned long long)(plan->weight_place + 4 * count));
}

static void put_drive_accessors(gltf_writer *writer) {
    const tulle_animation_def *const def = writer->job->def;
    const gltf_plan *const plan = &writer->plan;
    if (plan->sizes[GLTF_VIEW_DRIVES] == 0) return;
    float const first = (float)def->times[0], last = (float)def->times[def->frame_count - 1];
    begin_accessor(writer, GLTF_VIEW_DRIVES, 0, "SCALAR", def->frame_count);
    put_bounds(writer, &first, &last, 1);
    put(writer, "}");
    if (plan->has_weights) put_weights_accessor(writer);
    for (size_t i = 0; i < def->surface_count; i++) {
        if (def->surfaces[i].motion != TULLE_ANIMATION_RIGID) continue;
        uint64_t const place = plan->parts[i].drive_place;
        begin_accessor(writer, GLTF_VIEW_DRIVES, place, "VEC3", def->frame_count);
        put(writer, "}");
        begin_accessor(writer, GLTF_VIEW_DRIVES, place + 12 * (uint64_t)def->frame_count, "VEC4",
                       def->frame_count);
        put(writer, "}");
    }
}

static void put_mesh(gltf_writer *writer, size_t surface) {
    const gltf_part *const part = &writer->plan.parts[surface];
    const tulle_animation_surface *const s = &writer->job->def->surfaces[surface];
    bool const has_triangles = s->mesh.triangle_count > 0;
    size_t accessor = part->first_accessor;
    put(writer, "%s{\"name\":", part->mesh > 0 ? "," : "");
    put_quoted(writer, s->name);
    put(writer, ",\"primitives\":[{\"material\":%zu,\"mode\":%d", part->mesh,
        has_triangles ? 4 : 0);
    if (has_triangles) put(writer, ",\"indices\":%zu", accessor++);
    put(writer, ",\"attributes\":{\"POSITION\":%zu", accessor++);
    if (has_triangles) put(writer, ",\"NORMAL\":%zu", accessor++);
    if (part->uvs) put(writer, ",\"TEXCOORD_0\":%zu", accessor++);
    put(writer, "}");
    for (size_t i = 0; i < part->target_count; i++) {
        put(writer, "%s{\"POSITION\":%zu", i > 0 ? "," : ",\"targets\":[", accessor++);
        if (has_triangles) put(writer, ",\"NORMAL\":%zu", accessor++);
        put(writer, "}");
    }
    put(writer, "%s}]", part->target_count > 0 ? "]" : "");
    for (size_t i = 0; i < part->target_count; i++)
        put(writer, "%s", i > 0 ? ",0" : ",\"weights\":[1");
    put(writer, "%s}", part->target_count > 0 ? "]" : "");
}

static void put_material(gltf_writer *writer, size_t surface) {
    const double *const color = writer->job->def->surfaces[surface].color;
    double const factor[4] = {color[0], color[1], color[2], 1.0};
    put(writer, "%s{\"doubleSided\":true,\"pbrMetallicRoughness\":{\"metallicFactor\":0,",
        writer->plan.parts[surface].mesh > 0 ? "," : "");
    put_numbers(writer, "baseColorFactor", factor, 4);
    put(writer, "}}");
}

/* A pose as nodes have it: the quaternion is x, y, z, w. */
static void make_node_pose(const double pose[7], float values[7]) {
    for (int i = 0; i < 3; i++) values[i] = (float)pose[i];
    for (int i = 0; i < 4; i++) values[3 + i] = (float)pose[3 + (i + 1) % 4];
}

static tulle_status put_nodes(gltf_writer *writer, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < def->surface_count && status == TULLE_OK; i++) {
        put(writer, "%s{\"name\":", i > 0 ? "," : "");
        put_quoted(writer, def->surfaces[i].name);
        put(writer, ",\"mesh\":%zu", writer->plan.parts[i].mesh);
        if (def->surfaces[i].motion == TULLE_ANIMATION_RIGID) {
            double pose[7], values[7];
            float rounded[7];
            status = animation_read_pose(writer->job, i, 0, pose, error);
            if (status) break;
            make_node_pose(pose, rounded);
            for (int k = 0; k < 7; k++) values[k] = (double)rounded[k];
            put(writer, ",");
            put_numbers(writer, "translation", values, 3);
            put(writer, ",");
            put_numbers(writer, "rotation", values + 3, 4);
        }
        put(writer, "}");
    }
    return status;
}

static void put_channel(gltf_writer *writer, int *count, size_t node, const char *path,
                        size_t sampler) {
    put(writer, "%s{\"sampler\":%zu,\"target\":{\"node\":%zu,\"path\":\"%s\"}}",
        (*count)++ > 0 ? "," : "", sampler, node, path);
}

/* Samplers follow the accessors of what drives nodes, one each. */
static void put_animation(gltf_writer *writer) {
    const tulle_animation_def *const def = writer->job->def;
    const gltf_plan *const plan = &writer->plan;
    if (plan->sizes[GLTF_VIEW_DRIVES] == 0) return;
    size_t const first = plan->time_accessor + 1;
    put(writer, ",\n\"animations\":[{\"name\":\"frames\",\"samplers\":[");
    for (size_t i = first; i < plan->accessor_count; i++)
        put(writer, "%s{\"input\":%zu,\"output\":%zu,\"interpolation\":\"%s\"}",
            i > first ? "," : "", plan->time_accessor, i, def->is_stepped ? "STEP" : "LINEAR");
    put(writer, "],\"channels\":[");
    int count = 0;
    for (size_t i = 0; i < def->surface_count; i++) {
        size_t const drive = plan->parts[i].drive_accessor - first;
        if (plan->parts[i].target_count > 0)
            put_channel(writer, &count, i, "weights", plan->weight_accessor - first);
        if (def->surfaces[i].motion != TULLE_ANIMATION_RIGID) continue;
        put_channel(writer, &count, i, "translation", drive);
        put_channel(writer, &count, i, "rotation", drive + 1);
    }
    put(writer, "]}]");
}

static void put_views(gltf_writer *writer) {
    static const char *const facts[GLTF_VIEW_COUNT] = {",\"target\":34963",
                                                       ",\"byteStride\":8,\"target\":34962",
                                                       ",\"byteStride\":12,\"target\":34962", ""};
    int count = 0;
    for (int i = 0; i < GLTF_VIEW_COUNT; i++)
        if (writer->plan.sizes[i] > 0)
            put(writer, "%s{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%llu%s}",
                count++ > 0 ? "," : "",
                (unsigned long long)gltf_plan_get_offset(&writer->plan, (gltf_view)i),
                (unsigned long long)writer->plan.sizes[i], facts[i]);
}

/* The name of the buffer's file as a URI beside the .gltf: all bytes but the plainest as %XX. */
static void put_uri(gltf_writer *writer, const char *bin_path) {
    const char *const slash = strrchr(bin_path, '/');
    put(writer, ",\"uri\":\"");
    for (const char *c = slash ? slash + 1 : bin_path; *c; c++) {
        bool const is_plain = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') ||
                              (*c >= '0' && *c <= '9') || strchr("-._~", *c);
        if (is_plain)
            put_bytes(writer, c, 1);
        else
            put(writer, "%%%02X", (unsigned)(unsigned char)*c);
    }
    put(writer, "\"");
}

/* bin_path: null for a .glb. */
static tulle_status make_json(gltf_writer *writer, const char *bin_path, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    put(writer, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Tulle\"},\n\"scene\":0,"
                "\"scenes\":[{\"nodes\":[");
    for (size_t i = 0; i < def->surface_count; i++) put(writer, "%s%zu", i > 0 ? "," : "", i);
    put(writer, "]}],\n\"nodes\":[");
    tulle_status status = put_nodes(writer, error);
    put(writer, "],\n\"meshes\":[");
    for (size_t i = 0; i < def->surface_count; i++)
        if (writer->plan.parts[i].is_own) put_mesh(writer, i);
    put(writer, "],\n\"materials\":[");
    for (size_t i = 0; i < def->surface_count; i++)
        if (writer->plan.parts[i].is_own) put_material(writer, i);
    put(writer, "]");
    put_animation(writer);
    put(writer, ",\n\"accessors\":[");
    for (size_t i = 0; i < def->surface_count && status == TULLE_OK && !writer->lacks_memory; i++)
        if (writer->plan.parts[i].is_own) status = put_mesh_accessors(writer, i, error);
    if (status == TULLE_OK && !writer->lacks_memory) put_drive_accessors(writer);
    put(writer, "],\n\"bufferViews\":[");
    put_views(writer);
    put(writer, "],\n\"buffers\":[{\"byteLength\":%llu", (unsigned long long)writer->plan.total);
    if (bin_path) put_uri(writer, bin_path);
    put(writer, "}]}\n");
    while (!writer->lacks_memory && writer->json.count % 4 != 0) put(writer, " ");
    if (status == TULLE_OK && writer->lacks_memory)
        status = file_fail(error, writer->job->path, ENOMEM, "cannot be written");
    return status;
}

/* ---- the buffer ---- */

static void put_word(gltf_writer *writer, uint32_t value) {
    unsigned char bytes[4];
    bytes_store(bytes, sizeof bytes, value);
    output_write(writer->buffer, bytes, sizeof bytes);
}

static void put_floats(gltf_writer *writer, const float *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        unsigned char bytes[4];
        bytes_store_float(bytes, values[i]);
        output_write(writer->buffer, bytes, sizeof bytes);
    }
}

/* Vectors of written vertices, less those of `base` where that is given. */
static void write_vectors(gltf_writer *writer, size_t surface, const float *vectors,
                          const float *base) {
    const gltf_part *const part = &writer->plan.parts[surface];
    size_t const vertex_count = writer->job->def->surfaces[surface].mesh.vertex_count;
    for (size_t i = 0; i < part->vertex_count; i++) {
        size_t const source = 3 * gltf_part_get_source(part, vertex_count, i);
        float vector[3];
        for (size_t k = 0; k < 3; k++)
            vector[k] = vectors[source + k] - (base ? base[source + k] : 0.0f);
        put_floats(writer, base ? vector : vectors + source, 3);
    }
}

static tulle_status write_mesh_vectors(gltf_writer *writer, size_t surface, tulle_error *error) {
    animation_job *const job = writer->job;
    const gltf_part *const part = &writer->plan.parts[surface];
    tulle_mesh_view const mesh = job->def->surfaces[surface].mesh;
    tulle_status status = animation_read(job, surface, 0, error);
    if (status) return status;
    if (mesh.triangle_count > 0) {
        animation_compute_normals(job, surface);
        memcpy(writer->base_normals, job->normals, 3 * mesh.vertex_count * sizeof(float));
    }
    if (part->target_count > 0)
        for (size_t i = 0; i < 3 * part->vertex_count; i++) put_word(writer, 0);
    else
        write_vectors(writer, surface, job->points, NULL);
    if (mesh.triangle_count > 0) write_vectors(writer, surface, job->normals, NULL);
    for (uint32_t frame = 0; frame < part->target_count; frame++) {
        status = animation_read(job, surface, frame, error);
        if (status) return status;
        write_vectors(writer, surface, job->points, NULL);
        if (mesh.triangle_count == 0) continue;
        animation_compute_normals(job, surface);
        write_vectors(writer, surface, job->normals, writer->base_normals);
    }
    return TULLE_OK;
}

static void write_weights(gltf_writer *writer) {
    uint32_t const count = writer->job->def->frame_count;
    static const float weights[2] = {0.0f, 1.0f};
    if (count <= GLTF_DENSE_TARGETS) {
        for (uint32_t frame = 0; frame < count; frame++)
            for (uint32_t i = 0; i < count; i++) put_floats(writer, &weights[i == frame], 1);
        return;
    }
    for (uint32_t i = 0; i < count; i++) put_word(writer, i * count + i);
    for (uint32_t i = 0; i < count; i++) put_floats(writer, &weights[1], 1);
}

/* Translations of all frames, then rotations, each on the side of the one before: q and -q are the
 * same rotation, but the way between two of them is not. */
static tulle_status write_poses(gltf_writer *writer, size_t surface, tulle_error *error) {
    float before[4] = {0};
    for (int part = 0; part < 2; part++)
        for (uint32_t frame = 0; frame < writer->job->def->frame_count; frame++) {
            double pose[7];
            float values[7];
            tulle_status const status =
                animation_read_pose(writer->job, surface, frame, pose, error);
            if (status) return status;
            make_node_pose(pose, values);
            float *const q = values + 3;
            if (part == 1) {
                float const product =
                    q[0] * before[0] + q[1] * before[1] + q[2] * before[2] + q[3] * before[3];
                for (int i = 0; i < 4; i++) q[i] = product < 0.0f ? -q[i] : q[i];
                memcpy(before, q, sizeof before);
            }
            put_floats(writer, part == 0 ? values : q, part == 0 ? 3 : 4);
        }
    return TULLE_OK;
}

static tulle_status write_buffer(gltf_writer *writer, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    const gltf_part *const parts = writer->plan.parts;
    for (size_t i = 0; i < def->surface_count; i++)
        for (size_t k = 0; parts[i].is_own && k < 3 * def->surfaces[i].mesh.triangle_count; k++)
            put_word(writer, parts[i].triangles[k]);
    for (size_t i = 0; i < def->surface_count; i++)
        if (parts[i].uvs) put_floats(writer, parts[i].uvs, 2 * parts[i].vertex_count);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < def->surface_count && status == TULLE_OK; i++)
        if (parts[i].is_own) status = write_mesh_vectors(writer, i, error);
    if (status || writer->plan.sizes[GLTF_VIEW_DRIVES] == 0) return status;
    for (uint32_t i = 0; i < def->frame_count; i++) {
        float const time = (float)def->times[i];
        put_floats(writer, &time, 1);
    }
    if (writer->plan.has_weights) write_weights(writer);
    for (size_t i = 0; i < def->surface_count && status == TULLE_OK; i++)
        if (def->surfaces[i].motion == TULLE_ANIMATION_RIGID)
            status = write_poses(writer, i, error);
    return status;
}

/* ---- the files ---- */

static tulle_status check_size(const gltf_writer *writer, uint64_t size, tulle_error *error) {
    if (size <= UINT32_MAX) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_LIMIT, writer->job->path, 0, 0,
                        "would be of more than %llu bytes, but a .glb holds at most 4294967295; "
                        "write a .gltf, or fewer frames",
                        (unsigned long long)size - 1);
}

/* What can be known before frames are read. */
static tulle_status check_limits(const gltf_writer *writer, bool is_binary, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    const char *const path = writer->job->path;
    if (writer->plan.has_weights && def->frame_count > SPARSE_TARGETS_MAX)
        return error_set_at(error, TULLE_ERROR_LIMIT, path, 0, 0,
                            "%u frames are more morph targets than glTF can number, which are %d; "
                            "take fewer",
                            def->frame_count, SPARSE_TARGETS_MAX);
    for (uint32_t i = 1; i < def->frame_count; i++)
        if (!((float)def->times[i] > (float)def->times[i - 1]))
            return error_set_at(error, TULLE_ERROR_LIMIT, path, 0, 0,
                                "frames %u and %u have the same time as floats, which glTF has", i,
                                i - 1);
    return is_binary ? check_size(writer, writer->plan.total, error) : TULLE_OK;
}

static tulle_status write_binary(gltf_writer *writer, tulle_error *error) {
    uint64_t const size =
        GLB_HEADER_SIZE + writer->json.count + GLB_CHUNK_SIZE + writer->plan.total;
    tulle_status status = check_size(writer, size, error);
    if (status == TULLE_OK) status = output_open(writer->job->path, &writer->buffer, error);
    if (status) return status;
    output_text(writer->buffer, "glTF");
    put_word(writer, 2);
    put_word(writer, (uint32_t)size);
    put_word(writer, (uint32_t)writer->json.count);
    output_text(writer->buffer, "JSON");
    output_write(writer->buffer, writer->json.data, writer->json.count);
    put_word(writer, (uint32_t)writer->plan.total);
    output_write(writer->buffer, "BIN", 4);
    status = write_buffer(writer, error);
    if (status == TULLE_OK) return output_commit(writer->buffer, error);
    output_discard(writer->buffer);
    return status;
}

/* The buffer appears first, so that whoever finds a new .gltf finds it, too. */
static tulle_status write_pair(gltf_writer *writer, const char *bin_path, tulle_error *error) {
    tulle_status status = output_open(bin_path, &writer->buffer, error);
    if (status) return status;
    output_file *text = NULL;
    status = write_buffer(writer, error);
    if (status == TULLE_OK) status = output_open(writer->job->path, &text, error);
    if (status == TULLE_OK) {
        output_write(text, writer->json.data, writer->json.count);
        status = output_flush(text, error);
    }
    if (status == TULLE_OK) {
        status = output_commit(writer->buffer, error);
        writer->buffer = NULL;
    }
    output_discard(writer->buffer);
    if (status == TULLE_OK) return output_commit(text, error);
    output_discard(text);
    return status;
}

tulle_status gltf_write(animation_job *job, bool is_binary, tulle_error *error) {
    gltf_writer writer = {.job = job};
    size_t const normals_size = 3 * job->vertex_limit * sizeof(float);
    size_t const path_size = strlen(job->path) + 1;
    char *const bin_path = memory_allocate(&job->heap, path_size);
    writer.base_normals = memory_allocate(&job->heap, normals_size);
    tulle_status status = writer.base_normals && bin_path
                              ? gltf_plan_make(job, &writer.plan, error)
                              : file_fail(error, job->path, ENOMEM, "cannot be written");
    if (status == TULLE_OK) {
        memcpy(bin_path, job->path, path_size);
        memcpy(bin_path + path_size - 5, "bin", 4); /* for gltf */
        status = check_limits(&writer, is_binary, error);
    }
    if (status == TULLE_OK) status = make_json(&writer, is_binary ? NULL : bin_path, error);
    if (status == TULLE_OK)
        status = is_binary ? write_binary(&writer, error) : write_pair(&writer, bin_path, error);
    gltf_plan_destroy(job, &writer.plan);
    ARRAY_FREE(&job->heap, &writer.json);
    memory_release(&job->heap, writer.base_normals, normals_size);
    memory_release(&job->heap, bin_path, path_size);
    return status;
}
