/* app/view/pick.c - see pick.h. */
#include "app/view/pick.h"

#include "app/view/overlays.h"
#include "base/error.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

enum { CONTACTS_MAX = 64 /* told of one triangle */ };

typedef struct pick_place {
    const view_object *object;
    const double *x; /* positions */
    uint32_t index, triangle, corners[3];
    uint32_t vertex;  /* the nearest corner */
    uint32_t edge[2]; /* the nearest edge */
} pick_place;

static double measure_length(const double *a, const double *b) {
    double const x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    return sqrt(x * x + y * y + z * z);
}

static double measure_area(const double *x, const uint32_t corners[3]) {
    const double *const a = x + 3 * (size_t)corners[0];
    const double *const b = x + 3 * (size_t)corners[1], *const c = x + 3 * (size_t)corners[2];
    double const u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    double const v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    double const n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    return 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* The corner with the largest weight; the edge opposite to the one with the smallest. */
static pick_place find_place(const pick_facts *facts, const view_request *request) {
    pick_place place = {.object = &facts->document->objects[request->object],
                        .x = facts->positions,
                        .index = request->object,
                        .triangle = request->triangle};
    memcpy(place.corners, place.object->mesh.triangles + 3 * (size_t)request->triangle,
           sizeof place.corners);
    int nearest = 0, farthest = 0;
    for (int k = 1; k < 3; k++) {
        if (request->weights[k] > request->weights[nearest]) nearest = k;
        if (request->weights[k] < request->weights[farthest]) farthest = k;
    }
    place.vertex = place.corners[nearest];
    place.edge[0] = place.corners[(farthest + 1) % 3];
    place.edge[1] = place.corners[(farthest + 2) % 3];
    return place;
}

/* A third of the triangles around, by their density; cloth only, as obstacles have none. */
static double measure_mass(const pick_facts *facts, const pick_place *place) {
    tulle_mesh_view const mesh = place->object->mesh;
    double area = 0.0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *const corners = mesh.triangles + 3 * t;
        if (corners[0] == place->vertex || corners[1] == place->vertex ||
            corners[2] == place->vertex)
            area += measure_area(mesh.positions, corners);
    }
    return area / 3.0 *
           scene_get_object_facts(facts->scene, place->index).cloth_material->area_density;
}

static void write_vertex(const pick_facts *facts, const pick_place *place, view_buffer *answer) {
    tulle_mesh_view const mesh = place->object->mesh;
    size_t const begin = 3 * (size_t)place->vertex;
    const char *separator = "";
    buffer_print(answer, ",\"vertex\":{\"index\":%u", place->vertex);
    buffer_json_doubles(answer, "position", place->x + begin, 3);
    if (facts->velocities) buffer_json_doubles(answer, "velocity", facts->velocities + begin, 3);
    if (facts->scene && place->object->role == ROLE_CLOTH) {
        buffer_json_double(answer, "mass", measure_mass(facts, place));
        buffer_json_bool(answer, "is_pinned",
                         scene_find_pin(facts->scene, place->index, place->vertex, SIZE_MAX) !=
                             SIZE_MAX);
    }
    buffer_print(answer, ",\"triangles\":[");
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const uint32_t *const corners = mesh.triangles + 3 * t;
        if (corners[0] != place->vertex && corners[1] != place->vertex &&
            corners[2] != place->vertex)
            continue;
        buffer_print(answer, "%s%zu", separator, t);
        separator = ",";
    }
    buffer_print(answer, "]}");
}

static void write_edge(const pick_place *place, view_buffer *answer) {
    size_t const a = 3 * (size_t)place->edge[0], b = 3 * (size_t)place->edge[1];
    const double *const start = place->object->mesh.positions;
    double const length = measure_length(place->x + a, place->x + b);
    double const rest = measure_length(start + a, start + b);
    buffer_print(answer, ",\"edge\":{\"vertices\":[%u,%u]", place->edge[0], place->edge[1]);
    buffer_json_double(answer, "length", length);
    if (place->object->role == ROLE_CLOTH) {
        buffer_json_double(answer, "rest_length", rest);
        buffer_json_double(answer, "strain", length / rest - 1.0);
    }
    buffer_print(answer, "}");
}

static void write_triangle(const pick_facts *facts, const pick_place *place, view_buffer *answer) {
    buffer_print(answer, ",\"triangle\":{\"index\":%u,\"vertices\":[%u,%u,%u]", place->triangle,
                 place->corners[0], place->corners[1], place->corners[2]);
    buffer_json_double(answer, "area", measure_area(place->x, place->corners));
    bool const is_flat = !facts->strains && facts->places && place->object->uv;
    if (facts->strains || is_flat) {
        double strain[3];
        if (is_flat)
            overlay_measure_flat_strain(place->object->uv, facts->places, place->corners, strain);
        else
            memcpy(strain, facts->strains + 3 * (size_t)place->triangle, sizeof strain);
        buffer_print(answer, ",\"strain\":{\"warp\":");
        buffer_json_double(answer, NULL, strain[0]);
        buffer_json_double(answer, "weft", strain[1]);
        buffer_json_double(answer, "shear", strain[2]);
        buffer_print(answer, "}");
    }
    if (facts->patches) buffer_json_whole(answer, "patch", facts->patches[place->triangle]);
    buffer_print(answer, "}");
}

static bool is_corner(const pick_place *place, uint32_t vertex) {
    return vertex == place->corners[0] || vertex == place->corners[1] ||
           vertex == place->corners[2];
}

static uint32_t get_number(const pick_facts *facts, uint32_t object) {
    return facts->numbers ? facts->numbers[object] : object;
}

/* Which side of the contact is a feature of the triangle: 0 a, 1 b, -1 none. */
static int find_side(const pick_facts *facts, const pick_place *place,
                     const tulle_contact *contact) {
    int const first = contact->kind == TULLE_CONTACT_VERTEX_FACE ? 1 : 2; /* vertices of a */
    for (int side = 0; side < 2; side++) {
        uint32_t const object = side == 0 ? contact->object_a : contact->object_b;
        if (get_number(facts, object) != place->index) continue;
        bool is_whole = true;
        for (int k = side == 0 ? 0 : first; k < (side == 0 ? first : 4); k++)
            is_whole &= is_corner(place, contact->vertices[k]);
        if (is_whole) return side;
    }
    return -1;
}

static void write_contacts(const pick_facts *facts, const pick_place *place, view_buffer *answer) {
    static const char *const states[] = {"open", "stick", "slip"};
    size_t written = 0;
    buffer_print(answer, ",\"contacts\":[");
    for (size_t i = 0; i < facts->contact_count && written < CONTACTS_MAX; i++) {
        const tulle_contact *const contact = &facts->contacts[i];
        int const side = find_side(facts, place, contact);
        if (side < 0) continue;
        double const sign = side == 0 ? 1.0 : -1.0;
        uint32_t const other = get_number(facts, side == 0 ? contact->object_b : contact->object_a);
        double normal[3], impulse[3];
        for (int k = 0; k < 3; k++) {
            normal[k] = sign * contact->normal[k];
            impulse[k] = sign * contact->impulse[k];
        }
        buffer_print(answer, "%s{\"kind\":\"%s\",\"features\":\"%s\"", written++ > 0 ? "," : "",
                     states[contact->state],
                     contact->kind == TULLE_CONTACT_VERTEX_FACE ? "vertex-face" : "edge-edge");
        buffer_json_whole(answer, "object", other);
        if (other < facts->document->object_count)
            buffer_json_text(answer, "name", facts->document->objects[other].name);
        buffer_print(answer, ",\"vertices\":[%u,%u,%u,%u]", contact->vertices[0],
                     contact->vertices[1], contact->vertices[2], contact->vertices[3]);
        buffer_json_doubles(answer, "position", contact->position, 3);
        buffer_json_double(answer, "gap", contact->gap);
        buffer_json_doubles(answer, "normal", normal, 3);
        buffer_json_doubles(answer, "impulse", impulse, 3);
        buffer_print(answer, "}");
    }
    buffer_print(answer, "]");
}

tulle_status pick_write(const pick_facts *facts, const view_request *request, view_buffer *answer,
                        tulle_error *error) {
    const view_document *const document = facts->document;
    if (request->object >= document->object_count ||
        request->triangle >= document->objects[request->object].mesh.triangle_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "there is no triangle %u of an object %u", request->triangle,
                         request->object);
    pick_place const place = find_place(facts, request);
    double position[3] = {0.0, 0.0, 0.0};
    for (int corner = 0; corner < 3; corner++)
        for (int k = 0; k < 3; k++)
            position[k] +=
                request->weights[corner] * place.x[3 * (size_t)place.corners[corner] + (size_t)k];
    buffer_json_whole(answer, "object", request->object);
    buffer_json_text(answer, "name", place.object->name);
    buffer_json_whole(answer, "frame", facts->frame);
    buffer_json_doubles(answer, "position", position, 3);
    write_vertex(facts, &place, answer);
    write_edge(&place, answer);
    write_triangle(facts, &place, answer);
    if (facts->contacts) write_contacts(facts, &place, answer);
    return TULLE_OK;
}
