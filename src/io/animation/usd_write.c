/* io/animation/usd_write.c - writes an animation as USD in its text form (.usda): a Mesh or Points
 * prim for each surface, with time samples where it moves; a rigid surface is an Xform that moves
 * and an instance of its mesh.
 *
 * Based on: Pixar, Universal Scene Description, schemas UsdGeomMesh, UsdGeomPoints,
 * UsdGeomXformable; the text of Usda is as Pixar's usdcat prints it.
 *
 * An attribute has all its time samples in one place, so frames are read once for each of them. */
#include "base/error.h"
#include "io/animation/animation.h"
#include "io/file_data.h"
#include "io/text/json_quote.h"
#include "io/text/number.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    NAME_SIZE = 96,  /* [bytes] of a prim's name */
    NAME_STEM = 64,  /* [bytes] of it that come from the surface's name */
    INDENT_SIZE = 4, /* [blanks] of a level */
    PER_LINE = 24    /* indices or vertices of a line */
};

/* A frame this near to a whole time code is at it. */
static const double CODE_TOLERANCE = 1e-6;

typedef char prim_name[NAME_SIZE];

typedef struct usd_writer {
    animation_job *job;
    output_file *output;
    int depth;
    prim_name *names; /* of each surface; unique */
    float *next;      /* points of the following frame, 3 * job->vertex_limit */
} usd_writer;

/* ---- text ---- */

static void put(usd_writer *writer, const char *text) { output_text(writer->output, text); }

static void start_line(usd_writer *writer) {
    for (int i = 0; i < INDENT_SIZE * writer->depth; i++) put(writer, " ");
}

static void put_line(usd_writer *writer, const char *text) {
    start_line(writer);
    put(writer, text);
    put(writer, "\n");
}

static void put_float(usd_writer *writer, float value) {
    char text[NUMBER_TEXT_SIZE];
    output_write(writer->output, text, number_format_float(value, text));
}

/* In quotes. What may stand in a JSON text may stand here, but \u. */
static void put_quoted(usd_writer *writer, const char *text) {
    char piece[JSON_PIECE_SIZE];
    put(writer, "\"");
    while (json_take_piece(&text, piece) > 0) {
        unsigned code = 0;
        if (strncmp(piece, "\\u", 2) != 0)
            put(writer, piece);
        else if (sscanf(piece + 2, "%4x", &code) == 1 && code < 0x80) {
            char escaped[8];
            snprintf(escaped, sizeof escaped, "\\x%02x", code);
            put(writer, escaped);
        } else {
            put(writer, "\xef\xbf\xbd"); /* U+FFFD */
        }
    }
    put(writer, "\"");
}

static void open_block(usd_writer *writer, char bracket) {
    char const text[2] = {bracket, '\0'};
    put_line(writer, text);
    writer->depth++;
}

static void close_block(usd_writer *writer, const char *bracket) {
    writer->depth--;
    put_line(writer, bracket);
}

/* "(x, y, z)" */
static void put_tuple(usd_writer *writer, const float *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        put(writer, i > 0 ? ", " : "(");
        put_float(writer, values[i]);
    }
    put(writer, ")");
}

static void put_separator(usd_writer *writer, size_t i) {
    if (i == 0) return;
    put(writer, ",");
    if (i % PER_LINE != 0) {
        put(writer, " ");
        return;
    }
    put(writer, "\n");
    start_line(writer);
}

static void put_tuples(usd_writer *writer, const float *values, size_t count) {
    put(writer, "[");
    for (size_t i = 0; i < count; i++) {
        put_separator(writer, i);
        put_tuple(writer, values + 3 * i, 3);
    }
    put(writer, "]");
}

/* ---- names ---- */

static bool is_taken(const usd_writer *writer, size_t surface) {
    if (strcmp(writer->names[surface], "Prototypes") == 0) return true;
    for (size_t i = 0; i < surface; i++)
        if (strcmp(writer->names[i], writer->names[surface]) == 0) return true;
    return false;
}

/* A surface's name with what may stand in an identifier, and a number if another has that name. */
static void make_name(usd_writer *writer, size_t surface) {
    const char *const name = writer->job->def->surfaces[surface].name;
    char *const made = writer->names[surface];
    size_t length = 0;
    if (name[0] >= '0' && name[0] <= '9') made[length++] = '_';
    for (const char *c = name; *c && length < NAME_STEM; c++) {
        if (((unsigned char)*c & 0xc0) == 0x80) continue; /* a character of UTF-8 goes on */
        bool const is_plain =
            (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9');
        made[length++] = is_plain ? *c : '_';
    }
    made[length] = '\0';
    for (size_t number = surface; is_taken(writer, surface); number++)
        snprintf(made + length, NAME_SIZE - length, "__%zu__", number);
}

/* ---- time samples ---- */

static double get_code(const usd_writer *writer, uint32_t frame) {
    return writer->job->def->times[frame] * writer->job->def->frame_rate;
}

static bool is_at(const usd_writer *writer, uint32_t frame, double code) {
    return fabs(get_code(writer, frame) - code) <= CODE_TOLERANCE;
}

/* Frames that are nearer to each other than the tolerance keep codes of their own. */
static double choose_code(const usd_writer *writer, uint32_t frame) {
    double const code = get_code(writer, frame), whole = round(code);
    bool const has_neighbor =
        (frame > 0 && is_at(writer, frame - 1, whole)) ||
        (frame + 1 < writer->job->def->frame_count && is_at(writer, frame + 1, whole));
    bool const is_whole = is_at(writer, frame, whole) && !has_neighbor;
    return is_whole ? whole + 0.0 : code;
}

static void put_code(usd_writer *writer, uint32_t frame) {
    output_double(writer->output, choose_code(writer, frame));
}

/* The times of the frames, where their codes give others: by a rounding, or because a code is a
 * whole number. Other readers pass over them. */
static void put_times(usd_writer *writer) {
    const tulle_animation_def *const def = writer->job->def;
    bool is_exact = true;
    for (uint32_t i = 0; i < def->frame_count; i++)
        is_exact = is_exact && choose_code(writer, i) / def->frame_rate == def->times[i];
    if (is_exact) return;
    start_line(writer);
    put(writer, "custom uniform double[] tulle:times = [");
    for (uint32_t i = 0; i < def->frame_count; i++) {
        put_separator(writer, i);
        output_double(writer->output, def->times[i]);
    }
    put(writer, "]\n");
}

static void begin_samples(usd_writer *writer, const char *name) {
    start_line(writer);
    put(writer, name);
    put(writer, ".timeSamples = {\n");
    writer->depth++;
}

static void begin_sample(usd_writer *writer, uint32_t frame) {
    start_line(writer);
    put_code(writer, frame);
    put(writer, ": ");
}

typedef enum usd_attribute { USD_EXTENT, USD_POINTS, USD_NORMALS, USD_VELOCITIES } usd_attribute;
static const char *const attribute_names[] = {"float3[] extent", "point3f[] points",
                                              "normal3f[] normals", "vector3f[] velocities"};

/* Velocities over the interval after the frame, after the last one over that before. They lead from
 * each frame to the next one evenly, as USD's readers do without them. */
static tulle_status read_velocities(usd_writer *writer, size_t surface, uint32_t frame,
                                    tulle_error *error) {
    animation_job *const job = writer->job;
    uint32_t const first = frame + 1 < job->def->frame_count ? frame : frame - 1;
    size_t const count = 3 * job->def->surfaces[surface].mesh.vertex_count;
    tulle_status status = animation_read(job, surface, first + 1, error);
    if (status) return status;
    memcpy(writer->next, job->points, count * sizeof(float));
    status = animation_read(job, surface, first, error);
    double const interval = job->def->times[first + 1] - job->def->times[first];
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        float const value = (float)(((double)writer->next[i] - (double)job->points[i]) / interval);
        writer->next[i] = isfinite(value) ? value : 0.0f;
    }
    return status;
}

static tulle_status put_sample(usd_writer *writer, size_t surface, usd_attribute attribute,
                               uint32_t frame, tulle_error *error) {
    animation_job *const job = writer->job;
    size_t const vertex_count = job->def->surfaces[surface].mesh.vertex_count;
    float bounds[6];
    tulle_status const status = attribute == USD_VELOCITIES
                                    ? read_velocities(writer, surface, frame, error)
                                    : animation_read(job, surface, frame, error);
    if (status) return status;
    switch (attribute) {
    case USD_EXTENT:
        animation_measure_bounds(job, surface, bounds, bounds + 3);
        put_tuples(writer, bounds, 2);
        break;
    case USD_POINTS: put_tuples(writer, job->points, vertex_count); break;
    case USD_NORMALS:
        animation_compute_normals(job, surface);
        put_tuples(writer, job->normals, vertex_count);
        break;
    case USD_VELOCITIES: put_tuples(writer, writer->next, vertex_count); break;
    }
    return TULLE_OK;
}

static tulle_status put_attribute(usd_writer *writer, size_t surface, usd_attribute attribute,
                                  tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    const char *const end = attribute == USD_NORMALS ? " (\n" : "\n";
    tulle_status status = TULLE_OK;
    if (def->frame_count > 1 && def->surfaces[surface].motion == TULLE_ANIMATION_DEFORMS) {
        if (attribute == USD_NORMALS) { /* metadata stands with the value that holds at no time */
            start_line(writer);
            put(writer, attribute_names[attribute]);
            put(writer, " (\n");
            start_line(writer);
            put(writer, "    interpolation = \"vertex\"\n");
            put_line(writer, ")");
        }
        begin_samples(writer, attribute_names[attribute]);
        for (uint32_t frame = 0; frame < def->frame_count && status == TULLE_OK; frame++) {
            begin_sample(writer, frame);
            status = put_sample(writer, surface, attribute, frame, error);
            put(writer, ",\n");
        }
        close_block(writer, "}");
        return status;
    }
    if (attribute == USD_VELOCITIES) return TULLE_OK;
    start_line(writer);
    put(writer, attribute_names[attribute]);
    put(writer, " = ");
    status = put_sample(writer, surface, attribute, 0, error);
    put(writer, end);
    if (attribute == USD_NORMALS) {
        start_line(writer);
        put(writer, "    interpolation = \"vertex\"\n");
        put_line(writer, ")");
    }
    return status;
}

/* ---- prims ---- */

static void put_faces(usd_writer *writer, const tulle_animation_surface *surface) {
    start_line(writer);
    put(writer, "int[] faceVertexCounts = [");
    for (size_t i = 0; i < surface->mesh.triangle_count; i++) {
        put_separator(writer, i);
        put(writer, "3");
    }
    put(writer, "]\n");
    start_line(writer);
    put(writer, "int[] faceVertexIndices = [");
    for (size_t i = 0; i < 3 * surface->mesh.triangle_count; i++) {
        put_separator(writer, i);
        output_unsigned(writer->output, surface->mesh.triangles[i]);
    }
    put(writer, "]\n");
    put_line(writer, "uniform token subdivisionScheme = \"none\"");
    put_line(writer, "uniform bool doubleSided = 1");
}

/* Corners without texture coordinates get 0. */
static void put_uvs(usd_writer *writer, const tulle_animation_surface *surface) {
    start_line(writer);
    put(writer, "texCoord2f[] primvars:st = [");
    for (size_t i = 0; i < 3 * surface->mesh.triangle_count; i++) {
        float uv[2] = {(float)surface->corner_uvs[2 * i], (float)surface->corner_uvs[2 * i + 1]};
        if (!isfinite(uv[0]) || !isfinite(uv[1])) uv[0] = uv[1] = 0.0f;
        put_separator(writer, i);
        put_tuple(writer, uv, 2);
    }
    put(writer, "] (\n");
    start_line(writer);
    put(writer, "    interpolation = \"faceVarying\"\n");
    put_line(writer, ")");
}

/* What stands in a Mesh or Points prim. */
static tulle_status put_shape(usd_writer *writer, size_t number, tulle_error *error) {
    const tulle_animation_surface *const surface = &writer->job->def->surfaces[number];
    bool const has_triangles = surface->mesh.triangle_count > 0;
    if (has_triangles) put_faces(writer, surface);
    if (has_triangles && surface->corner_uvs) put_uvs(writer, surface);
    start_line(writer);
    float const color[3] = {(float)surface->color[0], (float)surface->color[1],
                            (float)surface->color[2]};
    put(writer, "color3f[] primvars:displayColor = [");
    put_tuple(writer, color, 3);
    put(writer, "]\n");
    tulle_status status = put_attribute(writer, number, USD_EXTENT, error);
    if (status == TULLE_OK) status = put_attribute(writer, number, USD_POINTS, error);
    if (status == TULLE_OK && has_triangles)
        status = put_attribute(writer, number, USD_NORMALS, error);
    if (status == TULLE_OK) status = put_attribute(writer, number, USD_VELOCITIES, error);
    return status;
}

static const char *get_type(const tulle_animation_surface *surface) {
    return surface->mesh.triangle_count > 0 ? "Mesh" : "Points";
}

/* "def Mesh "name"" up to its metadata; the caller ends it. */
static void begin_prim(usd_writer *writer, const char *type, const char *name) {
    start_line(writer);
    put(writer, "def ");
    put(writer, type);
    put(writer, " \"");
    put(writer, name);
    put(writer, "\"");
}

/* The name as the user gave it. */
static void put_display_name(usd_writer *writer, size_t surface) {
    start_line(writer);
    put(writer, "displayName = ");
    put_quoted(writer, writer->job->def->surfaces[surface].name);
    put(writer, "\n");
}

static void put_visibility(usd_writer *writer, size_t surface) {
    const tulle_animation_def *const def = writer->job->def;
    bool is_ever_absent = false;
    for (uint32_t i = 0; i < def->frame_count && def->is_present; i++)
        is_ever_absent = is_ever_absent || !def->is_present(def->context, surface, i);
    if (!is_ever_absent) return;
    begin_samples(writer, "token visibility");
    for (uint32_t i = 0; i < def->frame_count; i++) {
        begin_sample(writer, i);
        put(writer,
            def->is_present(def->context, surface, i) ? "\"inherited\",\n" : "\"invisible\",\n");
    }
    close_block(writer, "}");
}

/* One of the two parts of the poses: 3 numbers from 0 on, or 4 from 3 on. */
static tulle_status put_poses(usd_writer *writer, size_t surface, int first, int count,
                              tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    double before[4] = {0};
    bool const is_moving = animation_is_moving(def, surface);
    const char *const name = first == 0 ? "double3 xformOp:translate" : "quatd xformOp:orient";
    if (is_moving) {
        begin_samples(writer, name);
    } else {
        start_line(writer);
        put(writer, name);
        put(writer, " = ");
    }
    for (uint32_t frame = 0; frame < def->frame_count; frame++) {
        double pose[7], product = 0.0;
        tulle_status const status = animation_read_pose(writer->job, surface, frame, pose, error);
        if (status) return status;
        /* q and -q are the same rotation; the way from one frame to the next is short on one side.
         */
        for (int i = 0; i < 4; i++) product += pose[3 + i] * before[i];
        for (int i = 0; i < 4; i++) before[i] = product < 0.0 ? -pose[3 + i] : pose[3 + i];
        memcpy(pose + 3, before, sizeof before);
        if (is_moving) begin_sample(writer, frame);
        for (int i = 0; i < count; i++) {
            put(writer, i > 0 ? ", " : "(");
            output_double(writer->output, pose[first + i]);
        }
        put(writer, is_moving ? "),\n" : ")\n");
    }
    if (is_moving) close_block(writer, "}");
    return TULLE_OK;
}

static tulle_status put_rigid(usd_writer *writer, size_t number, tulle_error *error) {
    size_t const prototype = writer->job->def->surfaces[number].prototype;
    begin_prim(writer, "Xform", writer->names[number]);
    put(writer, " (\n");
    writer->depth++;
    put_display_name(writer, number);
    put_line(writer, "instanceable = true");
    start_line(writer);
    put(writer, "prepend references = </Prototypes/");
    put(writer, writer->names[prototype]);
    put(writer, ">\n");
    close_block(writer, ")");
    open_block(writer, '{');
    put_visibility(writer, number);
    tulle_status status = put_poses(writer, number, 0, 3, error);
    if (status == TULLE_OK) status = put_poses(writer, number, 3, 4, error);
    put_line(writer, "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]");
    close_block(writer, "}");
    return status;
}

static tulle_status put_surface(usd_writer *writer, size_t number, tulle_error *error) {
    const tulle_animation_surface *const surface = &writer->job->def->surfaces[number];
    if (surface->motion == TULLE_ANIMATION_RIGID) return put_rigid(writer, number, error);
    begin_prim(writer, get_type(surface), writer->names[number]);
    put(writer, " (\n");
    writer->depth++;
    put_display_name(writer, number);
    close_block(writer, ")");
    open_block(writer, '{');
    put_visibility(writer, number);
    tulle_status const status = put_shape(writer, number, error);
    close_block(writer, "}");
    return status;
}

/* Meshes of rigid surfaces: a class, so that they are not seen where they stand. */
static tulle_status put_prototypes(usd_writer *writer, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    tulle_status status = TULLE_OK;
    bool has_begun = false;
    for (size_t i = 0; i < def->surface_count && status == TULLE_OK; i++) {
        const tulle_animation_surface *const surface = &def->surfaces[i];
        if (surface->motion != TULLE_ANIMATION_RIGID || surface->prototype != i) continue;
        if (!has_begun) {
            put(writer, "\nclass \"Prototypes\"\n");
            open_block(writer, '{');
        }
        has_begun = true;
        begin_prim(writer, "Xform", writer->names[i]);
        put(writer, "\n");
        open_block(writer, '{');
        begin_prim(writer, get_type(surface), "shape");
        put(writer, "\n");
        open_block(writer, '{');
        status = put_shape(writer, i, error);
        close_block(writer, "}");
        close_block(writer, "}");
    }
    if (has_begun) close_block(writer, "}");
    return status;
}

static void put_header(usd_writer *writer) {
    const tulle_animation_def *const def = writer->job->def;
    put(writer, "#usda 1.0\n(\n    defaultPrim = \"World\"\n    doc = \"Tulle\"\n"
                "    endTimeCode = ");
    put_code(writer, def->frame_count - 1);
    put(writer, "\n    framesPerSecond = ");
    output_double(writer->output, def->frame_rate);
    put(writer, "\n    metersPerUnit = ");
    output_double(writer->output, def->meters_per_unit);
    put(writer, "\n    startTimeCode = ");
    put_code(writer, 0);
    put(writer, "\n    timeCodesPerSecond = ");
    output_double(writer->output, def->frame_rate);
    put(writer, def->is_y_up ? "\n    upAxis = \"Y\"\n)\n" : "\n    upAxis = \"Z\"\n)\n");
}

static tulle_status write_all(usd_writer *writer, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    tulle_status status = TULLE_OK;
    put_header(writer);
    put(writer, "\ndef Xform \"World\"\n");
    open_block(writer, '{');
    put_times(writer);
    for (size_t i = 0; i < def->surface_count && status == TULLE_OK; i++)
        status = put_surface(writer, i, error);
    close_block(writer, "}");
    return status == TULLE_OK ? put_prototypes(writer, error) : status;
}

tulle_status usd_write(animation_job *job, tulle_error *error) {
    usd_writer writer = {.job = job};
    size_t const names_size = job->def->surface_count * sizeof(prim_name);
    size_t const next_size = 3 * job->vertex_limit * sizeof(float);
    writer.names = memory_allocate(&job->heap, names_size);
    writer.next = memory_allocate(&job->heap, next_size);
    tulle_status status = writer.names && writer.next
                              ? output_open(job->path, &writer.output, error)
                              : file_fail(error, job->path, ENOMEM, "cannot be written");
    if (status == TULLE_OK) {
        for (size_t i = 0; i < job->def->surface_count; i++) make_name(&writer, i);
        status = write_all(&writer, error);
        if (status == TULLE_OK)
            status = output_commit(writer.output, error);
        else
            output_discard(writer.output);
    }
    memory_release(&job->heap, writer.names, names_size);
    memory_release(&job->heap, writer.next, next_size);
    return status;
}
