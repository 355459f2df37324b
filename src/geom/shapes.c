/* geom/shapes.c - names, defaults and the way from a def to a mesh: check, derive, generate,
 * jitter. A failed call leaves an empty mesh. */
#include "geom/shapes.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/words.h"
#include "geom/mesh.h"

/* Any value that a def not made by tulle_shape_def_default is unlikely to hold. */
static const uint32_t SHAPE_COOKIE = 0x7368a9e5;

static const shape_generator generators[TULLE_SHAPE_COUNT] = {
    [TULLE_SHAPE_RECTANGLE] = shape_make_sheet,
    [TULLE_SHAPE_RIBBON] = shape_make_sheet,
    [TULLE_SHAPE_DISC] = shape_make_rings,
    [TULLE_SHAPE_TUBE] = shape_make_rings,
    [TULLE_SHAPE_CAPE] = shape_make_rings,
    [TULLE_SHAPE_NET] = shape_make_net,
    [TULLE_SHAPE_PLANE] = shape_make_sheet,
    [TULLE_SHAPE_BOX] = shape_make_slab,
    [TULLE_SHAPE_SPHERE] = shape_make_sphere,
    [TULLE_SHAPE_HEMISPHERE] = shape_make_rings,
    [TULLE_SHAPE_CYLINDER] = shape_make_rings,
    [TULLE_SHAPE_CONE] = shape_make_rings,
    [TULLE_SHAPE_NEEDLE] = shape_make_rings,
    [TULLE_SHAPE_TETRAHEDRON] = shape_make_tetrahedron,
    [TULLE_SHAPE_TORUS] = shape_make_rings,
    [TULLE_SHAPE_NAIL] = shape_make_rings,
    [TULLE_SHAPE_BUMPY_GROUND] = shape_make_sheet,
    [TULLE_SHAPE_CRESTED_GROUND] = shape_make_sheet,
    [TULLE_SHAPE_TILE] = shape_make_slab,
    [TULLE_SHAPE_SCEPTRE] = shape_make_rings,
};

static bool is_known_shape(tulle_shape shape) {
    return (int)shape >= 0 && (int)shape < TULLE_SHAPE_COUNT;
}

const char *tulle_shape_name(tulle_shape shape) {
    return is_known_shape(shape) ? shape_words[shape] : NULL;
}

int tulle_shape_is_cloth(tulle_shape shape) {
    return is_known_shape(shape) && shape <= TULLE_SHAPE_NET;
}

/* [m] The main sizes; zero leaves a value to shape_derive_def. */
tulle_shape_def tulle_shape_def_default(tulle_shape shape) {
    tulle_shape_def def = {.cookie = SHAPE_COOKIE,
                           .shape = shape,
                           .size = {1.0, 1.0, 1.0},
                           .radius = 0.5,
                           .height = 1.0,
                           .angle = 4.71238898038469, /* three quarters of a turn */
                           .cells = {8, 8},
                           .strand_resolution = 2,
                           .seed = 1};
    switch (shape) {
    case TULLE_SHAPE_RIBBON:
        def.size[0] = 2.0;
        def.size[1] = 0.1;
        break;
    case TULLE_SHAPE_TUBE: def.radius = 0.2; break;
    case TULLE_SHAPE_CAPE: def.radius = 0.8; break;
    case TULLE_SHAPE_PLANE: def.size[0] = def.size[1] = 10.0; break;
    case TULLE_SHAPE_CYLINDER: def.radius = 0.2; break;
    case TULLE_SHAPE_CONE: def.radius = 0.3, def.height = 0.6; break;
    case TULLE_SHAPE_NEEDLE: def.radius = 0.004, def.height = 0.2; break;
    case TULLE_SHAPE_TETRAHEDRON: def.radius = 0.15, def.height = 0.5; break;
    case TULLE_SHAPE_TORUS: def.radius = 0.4; break;
    case TULLE_SHAPE_NAIL: def.radius = 0.015, def.height = 0.3; break;
    case TULLE_SHAPE_SCEPTRE: def.radius = 0.02, def.height = 0.8; break;
    case TULLE_SHAPE_BUMPY_GROUND:
    case TULLE_SHAPE_CRESTED_GROUND:
        def.size[0] = def.size[1] = 4.0;
        def.height = 0.15;
        break;
    case TULLE_SHAPE_TILE:
        def.size[2] = 0.1;
        def.height = 0.05;
        break;
    default: break;
    }
    if (is_known_shape(shape)) shape_clear_unused(&def);
    return def;
}

uint64_t shape_hash(uint64_t seed, uint64_t a, uint64_t b) {
    return hash_mix(seed + hash_mix(a + hash_mix(b)));
}

bool shape_get_cut(const tulle_shape_def *def, size_t i, size_t j) {
    if (def->is_irregular && tulle_shape_is_cloth(def->shape))
        return (shape_hash(def->seed, i, j) & 1) != 0;
    return ((i + j) & 1) != 0;
}

tulle_status shape_writer_start(shape_writer *writer, double vertex_count, double triangle_count,
                                tulle_mesh *mesh, tulle_error *error) {
    *writer = (shape_writer){.mesh = mesh};
    if (!(vertex_count <= SHAPE_VERTEX_LIMIT))
        return error_set(error, TULLE_ERROR_LIMIT,
                         "the shape would have %.15g vertices; the limit is %d: choose a lower "
                         "resolution, or, if it is derived, lengths that differ less",
                         vertex_count, SHAPE_VERTEX_LIMIT);
    return tulle_mesh_create((size_t)vertex_count, (size_t)triangle_count, mesh, error);
}

void shape_write_vertex(shape_writer *writer, double x, double y, double z) {
    vec3_store(writer->mesh->positions, writer->vertex_count++, vec3_make(x, y, z));
}

void shape_write_triangle(shape_writer *writer, size_t a, size_t b, size_t c) {
    uint32_t *const corner = writer->mesh->triangles + 3 * writer->triangle_count++;
    corner[0] = (uint32_t)a;
    corner[1] = (uint32_t)b;
    corner[2] = (uint32_t)c;
}

void shape_write_quad(shape_writer *writer, const size_t corners[4], bool is_cut_along_ac) {
    int const start = is_cut_along_ac ? 0 : 1;
    for (int half = 0; half < 2; half++) {
        int const k = start + 2 * half;
        shape_write_triangle(writer, corners[k & 3], corners[(k + 1) & 3], corners[(k + 2) & 3]);
    }
}

/* Extreme but admissible lengths can make triangles that no simulation can use. */
static tulle_status check_heights(const tulle_shape_def *def, const tulle_mesh *mesh,
                                  tulle_error *error) {
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double const ratio = triangle_get_height_ratio(mesh->positions, mesh->triangles + 3 * t);
        if (ratio >= THIN_TRIANGLE_RATIO) continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: these lengths and resolutions make triangles whose height is %.3g of "
                         "their longest edge, at least %g is needed; choose lengths that differ "
                         "less",
                         tulle_shape_name(def->shape), ratio, THIN_TRIANGLE_RATIO);
    }
    return TULLE_OK;
}

tulle_status tulle_shape_generate(const tulle_shape_def *def, tulle_mesh *mesh,
                                  tulle_error *error) {
    if (!def || !mesh)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the def or the mesh is null");
    *mesh = (tulle_mesh){0};
    if (def->cookie != SHAPE_COOKIE || !is_known_shape(def->shape))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the shape def does not come from tulle_shape_def_default, or its shape "
                         "%d is unknown",
                         (int)def->shape);
    tulle_status status = shape_check_def(def, error);
    if (status != TULLE_OK) return status;
    tulle_shape_def derived = *def;
    shape_derive_def(&derived);
    status = shape_check_fit(&derived, error);
    if (status == TULLE_OK) status = generators[def->shape](&derived, mesh, error);
    if (status == TULLE_OK && def->is_irregular && tulle_shape_is_cloth(def->shape)) {
        memory heap = memory_default();
        status = shape_jitter(&heap, &derived, mesh, error);
    }
    if (status == TULLE_OK) status = check_heights(&derived, mesh, error);
    if (status != TULLE_OK) tulle_mesh_destroy(mesh);
    return status;
}
