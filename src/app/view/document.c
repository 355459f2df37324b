/* app/view/document.c - see document.h. */
#include "app/view/document.h"

#include "app/view/overlays.h"
#include "app/view/series.h"
#include "base/error.h"
#include "render/rest_coordinates.h"

#include "tulle/world.h"

#include <math.h>
#include <string.h>

bool document_begin(view_document *document, size_t object_count) {
    *document = (view_document){.heap = memory_default()};
    document->storage = arena_make(&document->heap);
    document->objects = ARENA_NEW_ZEROED(&document->storage, view_object, object_count + 1);
    return document->objects != NULL;
}

void document_destroy(view_document *document) {
    arena_destroy(&document->storage);
    *document = (view_document){0};
}

const char *document_copy_text(view_document *document, const char *text) {
    size_t const size = text ? strlen(text) + 1 : 0;
    char *const copy = text ? ARENA_NEW(&document->storage, char, size) : NULL;
    return copy ? memcpy(copy, text, size) : NULL;
}

static bool copy_mesh(arena *storage, tulle_mesh_view mesh, view_object *object) {
    double *const positions = ARENA_NEW(storage, double, 3 * mesh.vertex_count + 1);
    uint32_t *const triangles = ARENA_NEW(storage, uint32_t, 3 * mesh.triangle_count + 1);
    object->positions = ARENA_NEW(storage, float, 3 * mesh.vertex_count + 1);
    if (!positions || !triangles || !object->positions) return false;
    if (mesh.vertex_count > 0)
        memcpy(positions, mesh.positions, 3 * mesh.vertex_count * sizeof *positions);
    if (mesh.triangle_count > 0)
        memcpy(triangles, mesh.triangles, 3 * mesh.triangle_count * sizeof *triangles);
    object->mesh = (tulle_mesh_view){positions, mesh.vertex_count, triangles, mesh.triangle_count};
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) object->positions[i] = (float)positions[i];
    return true;
}

/* Where cloth lies flat at rest, for checkers and weaves. */
static tulle_status lay_out(view_document *document, view_object *object, tulle_error *error) {
    size_t const count = 2 * object->mesh.vertex_count;
    double *const flat = memory_allocate(&document->heap, count * sizeof *flat);
    tulle_status status =
        flat ? render_make_rest_coordinates(&document->heap, object->mesh, flat, error)
             : TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) object->uv = ARENA_NEW(&document->storage, float, count + 1);
    for (size_t i = 0; object->uv && i < count; i++) object->uv[i] = (float)flat[i];
    memory_release(&document->heap, flat, count * sizeof *flat);
    return status;
}

tulle_status document_add(view_document *document, const char *name, view_role role,
                          tulle_mesh_view mesh, tulle_error *error) {
    view_object *const object = &document->objects[document->object_count];
    object->name = document_copy_text(document, name);
    object->role = role;
    object->vertex_begin = document->vertex_count;
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        if (mesh.triangles[i] >= mesh.vertex_count)
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "'%s': a triangle has vertex %u of %zu", name, mesh.triangles[i],
                             mesh.vertex_count);
    if (!copy_mesh(&document->storage, mesh, object))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the meshes");
    document->object_count++;
    document->vertex_count += mesh.vertex_count;
    if (role != ROLE_CLOTH) return TULLE_OK;
    document->cloth_count++;
    return lay_out(document, object, error);
}

void document_finish(view_document *document, const scene_picture *picture) {
    static const double cloth_colors[][3] = {{0.80, 0.33, 0.31}, {0.28, 0.53, 0.78},
                                             {0.90, 0.68, 0.32}, {0.38, 0.65, 0.47},
                                             {0.62, 0.45, 0.72}, {0.45, 0.68, 0.72}};
    static const double obstacle_color[3] = {0.66, 0.67, 0.69};
    size_t const color_count = sizeof cloth_colors / sizeof cloth_colors[0];
    for (int k = 0; k < 3; k++) {
        document->low[k] = (double)INFINITY;
        document->high[k] = -(double)INFINITY;
    }
    for (size_t i = 0; i < document->object_count; i++) {
        view_object *const object = &document->objects[i];
        bool const is_known = picture && picture->looks && i < picture->look_count;
        const double *color = obstacle_color;
        if (object->role == ROLE_CLOTH) color = cloth_colors[i % color_count];
        if (is_known && picture->looks[i].has_color) color = picture->looks[i].color;
        memcpy(object->color, color, sizeof object->color);
        for (size_t v = 0; v < 3 * object->mesh.vertex_count; v++) {
            document->low[v % 3] = fmin(document->low[v % 3], object->mesh.positions[v]);
            document->high[v % 3] = fmax(document->high[v % 3], object->mesh.positions[v]);
        }
    }
    for (int k = 0; k < 3; k++)
        if (document->low[k] > document->high[k]) document->low[k] = document->high[k] = 0.0;
    if (picture) document->camera = picture->camera;
}

static void write_object(const view_object *object, view_buffer *buffer) {
    static const char *const roles[] = {"cloth", "obstacle", "body"};
    buffer_print(buffer, "{\"name\":");
    buffer_json_text(buffer, NULL, object->name);
    buffer_json_text(buffer, "role", roles[object->role]);
    buffer_json_whole(buffer, "vertex_count", object->mesh.vertex_count);
    buffer_json_whole(buffer, "triangle_count", object->mesh.triangle_count);
    buffer_json_bool(buffer, "is_static", object->is_static);
    buffer_json_bool(buffer, "has_uv", object->uv != NULL);
    buffer_json_doubles(buffer, "color", object->color, 3);
    buffer_json_whole(buffer, "pins", object->pin_count);
    buffer_json_double(buffer, "thickness", object->thickness);
    buffer_json_text(buffer, "material", object->material);
    buffer_print(buffer, "}");
}

static void write_camera(const scene_camera *camera, view_buffer *buffer) {
    if (!camera->has_position && !camera->has_orbit && !camera->has_target) {
        buffer_print(buffer, ",\"camera\":null");
        return;
    }
    buffer_print(buffer, ",\"camera\":{\"up\":[0,0,1]");
    if (camera->has_position) buffer_json_doubles(buffer, "position", camera->position, 3);
    if (camera->has_target) buffer_json_doubles(buffer, "target", camera->target, 3);
    if (camera->has_orbit)
        buffer_json_doubles(buffer, "orbit", (double const[]){camera->azimuth, camera->elevation},
                            2);
    if (camera->has_distance) buffer_json_double(buffer, "distance", camera->distance);
    if (camera->has_field_of_view)
        buffer_json_double(buffer, "field_of_view", camera->field_of_view);
    buffer_print(buffer, "}");
}

static void write_settings(const view_document *document, view_buffer *buffer) {
    buffer_print(buffer, ",\"settings\":{\"presets\":[");
    const char *name;
    for (size_t i = 0; (name = tulle_material_preset_name(i)); i++)
        buffer_print(buffer, "%s\"%s\"", i > 0 ? "," : "", name);
    buffer_print(buffer, "]");
    if (document->is_live) {
        buffer_json_doubles(buffer, "gravity", document->gravity, 3);
        buffer_json_doubles(buffer, "wind", document->wind, 3);
        buffer_json_double(buffer, "gusts", document->gust_strength);
    }
    buffer_print(buffer, "}");
}

static void write_abilities(const view_document *document, view_buffer *buffer) {
    static const char *const live[] = {"control", "grab", "cut_pin", "move", "set", "record"};
    buffer_print(buffer, ",\"abilities\":[\"pick\"");
    for (size_t i = 0; document->is_live && i < sizeof live / sizeof live[0]; i++)
        buffer_print(buffer, ",\"%s\"", live[i]);
    if (document->is_editable) buffer_print(buffer, ",\"edit\"");
    if (document->kind == KIND_RUN) buffer_print(buffer, ",\"frames\"");
    buffer_print(buffer, "]");
}

void document_write(const view_document *document, view_progress progress, view_buffer *buffer) {
    static const char *const kinds[] = {"run", "mesh", "scene"};
    buffer_print(buffer, "{\"type\":\"document\",\"version\":%d", VIEW_PROTOCOL);
    buffer_json_text(buffer, "program", tulle_version());
    buffer_json_text(buffer, "kind", kinds[document->kind]);
    buffer_json_text(buffer, "title", document->title);
    buffer_json_text(buffer, "path", document->name);
    buffer_json_bool(buffer, "live", document->is_live);
    buffer_print(buffer, ",\"up\":[0,0,1],\"box\":{\"low\":");
    buffer_json_doubles(buffer, NULL, document->low, 3);
    buffer_json_doubles(buffer, "high", document->high, 3);
    buffer_print(buffer, "}");
    buffer_json_whole(buffer, "frame_count", progress.frame_count);
    buffer_json_double(buffer, "frame_seconds", document->frame_seconds);
    buffer_json_double(buffer, "step_seconds", document->step_seconds);
    buffer_json_bool(buffer, "is_under_way", progress.is_under_way);
    buffer_print(buffer, ",\"objects\":[");
    for (size_t i = 0; i < document->object_count; i++) {
        if (i > 0) buffer_put_u8(buffer, ',');
        write_object(&document->objects[i], buffer);
    }
    buffer_print(buffer, "]");
    overlays_write_names(document, buffer);
    series_write_names(document, buffer);
    write_abilities(document, buffer);
    write_settings(document, buffer);
    write_camera(&document->camera, buffer);
    buffer_print(buffer, ",\"problems\":%s}", document->problems ? document->problems : "[]");
}

void document_write_head(view_head head, view_buffer *buffer) {
    buffer_put_u8(buffer, head.kind);
    buffer_put_u8(buffer, VIEW_PROTOCOL);
    buffer_put_u16(buffer, head.object);
    buffer_put_u32(buffer, head.frame);
    buffer_put_f64(buffer, head.time);
    buffer_put_u32(buffer, head.sequence);
    buffer_put_u32(buffer, head.count);
}

void document_write_mesh(const view_document *document, size_t index, view_buffer *buffer) {
    const view_object *const object = &document->objects[index];
    size_t const vertices = object->mesh.vertex_count, triangles = object->mesh.triangle_count;
    document_write_head((view_head){.kind = 1, .object = (unsigned)index, .count = 1}, buffer);
    buffer_put_u32(buffer, (uint32_t)vertices);
    buffer_put_u32(buffer, (uint32_t)triangles);
    buffer_put_u32(buffer, object->uv ? 1 : 0);
    buffer_put_f32s(buffer, object->positions, 3 * vertices);
    buffer_put_u32s(buffer, object->mesh.triangles, 3 * triangles);
    if (object->uv) buffer_put_f32s(buffer, object->uv, 2 * vertices);
}
