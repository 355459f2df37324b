/* fuzz/support/mesh_file.c - reads mesh files and uses the meshes, see mesh_file.h. */
#include "support/mesh_file.h"

#include "tulle/shapes.h"
#include "tulle_io/mesh_files.h"

#include <string.h>

static void check_read_again(const char *name, tulle_mesh_view mesh) {
    tulle_mesh again = {0};
    tulle_error error = {0};
    const char *const path = fuzz_path(name);
    FUZZ_CHECK_OK(tulle_mesh_write(path, mesh, &error), &error);
    FUZZ_CHECK_OK(tulle_mesh_read(path, &again, &error), &error);
    FUZZ_CHECK(again.vertex_count == mesh.vertex_count);
    FUZZ_CHECK(again.triangle_count == mesh.triangle_count);
    FUZZ_CHECK(memcmp(again.positions, mesh.positions,
                      3 * mesh.vertex_count * sizeof *mesh.positions) == 0);
    FUZZ_CHECK(mesh.triangle_count == 0 ||
               memcmp(again.triangles, mesh.triangles,
                      3 * mesh.triangle_count * sizeof *mesh.triangles) == 0);
    tulle_mesh_destroy(&again);
}

void fuzz_use_mesh(tulle_mesh *mesh) {
    tulle_mesh_view const view = tulle_mesh_get_view(mesh);
    tulle_error error = {0};
    FUZZ_CHECK(view.vertex_count > 0);
    fuzz_check_mesh(view);
    tulle_mesh_info info;
    FUZZ_CHECK_OK(tulle_mesh_get_info(view, &info, &error), &error);
    FUZZ_CHECK(info.triangle_count == view.triangle_count);
    bool is_valid[2];
    for (int role = 0; role < 2; role++) {
        tulle_status const status = tulle_mesh_validate(view, (tulle_mesh_role)role, &error);
        if (status) fuzz_check_error(status, &error);
        is_valid[role] = status == TULLE_OK;
    }
    /* Whatever is cloth may be an obstacle, and has no border or edge that only soups have. */
    FUZZ_CHECK(!is_valid[TULLE_MESH_ROLE_CLOTH] || is_valid[TULLE_MESH_ROLE_OBSTACLE]);
    if (is_valid[TULLE_MESH_ROLE_CLOTH])
        FUZZ_CHECK(info.nonmanifold_edge_count == 0 && info.unreferenced_vertex_count == 0);
    check_read_again("again.obj", view);
    check_read_again("again.ply", view);
    tulle_mesh_duplicates duplicates;
    FUZZ_CHECK_OK(tulle_mesh_drop_duplicates(mesh, NULL, &duplicates, &error), &error);
    FUZZ_CHECK(mesh->triangle_count + duplicates.count == info.triangle_count);
    tulle_mesh_destroy(mesh);
}

void fuzz_read_mesh_file(const char *name, const uint8_t *data, size_t size) {
    const char *const path = fuzz_put_file(name, data, size);
    tulle_mesh mesh = {0};
    tulle_mesh_source source;
    tulle_error error = {0};
    tulle_status const status = tulle_mesh_read_source(path, &mesh, &source, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(strcmp(error.file, path) == 0);
        FUZZ_CHECK(!mesh.positions && !mesh.triangles && !mesh.vertex_count);
        FUZZ_CHECK(!source.vertex_lines && !source.triangle_lines && !source.corner_uvs &&
                   !source.parts && !source.part_names && !source.note[0]);
        return;
    }
    double sum = 0.0; /* of texture coordinates: all of the array can be read */
    for (size_t i = 0; source.corner_uvs && i < 6 * mesh.triangle_count; i++)
        sum += source.corner_uvs[i];
    FUZZ_CHECK(source.corner_uvs || sum == 0.0);
    for (size_t i = 0; source.triangle_lines && i < mesh.triangle_count; i++)
        FUZZ_CHECK(source.triangle_lines[i] > 0);
    for (size_t i = 0; source.vertex_lines && i < mesh.vertex_count; i++)
        FUZZ_CHECK(source.vertex_lines[i] > 0);
    for (size_t i = 0; i < source.part_count; i++) {
        const tulle_mesh_part *const part = &source.parts[i];
        size_t const begin = (size_t)(part->name - source.part_names);
        FUZZ_CHECK(part->count > 0 && part->first < mesh.triangle_count &&
                   part->count <= mesh.triangle_count - part->first);
        FUZZ_CHECK(begin < source.part_bytes && begin + strlen(part->name) < source.part_bytes);
    }
    tulle_mesh_lines const lines = {source.vertex_lines, source.triangle_lines};
    tulle_status const validity =
        tulle_mesh_validate_lines(tulle_mesh_get_view(&mesh), TULLE_MESH_ROLE_CLOTH, lines, &error);
    if (validity) fuzz_check_error(validity, &error);
    tulle_mesh_source_destroy(&source);
    fuzz_use_mesh(&mesh);
}

tulle_mesh fuzz_make_mesh(size_t kind) {
    static const tulle_shape shapes[FUZZ_MESH_COUNT] = {TULLE_SHAPE_RECTANGLE, TULLE_SHAPE_BOX,
                                                        TULLE_SHAPE_CAPE};
    tulle_shape_def def = tulle_shape_def_default(shapes[kind]);
    def.resolution[0] = kind == 1 ? 2 : 5;
    if (kind != 1) def.resolution[1] = 3;
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_shape_generate(&def, &mesh, &error), &error);
    return mesh;
}

tulle_status fuzz_read_mesh(const char *path, tulle_mesh *mesh) {
    return tulle_mesh_read(path, mesh, NULL);
}

tulle_status fuzz_write_mesh(const char *path, tulle_mesh_view mesh) {
    return tulle_mesh_write(path, mesh, NULL);
}

void fuzz_put_mesh_seeds(const fuzz_mesh_format *format) {
    static const char *const names[FUZZ_MESH_COUNT] = {"sheet", "box", "cape"};
    for (size_t i = 0; i < FUZZ_MESH_COUNT; i++) {
        tulle_mesh mesh = fuzz_make_mesh(i);
        const char *const path = fuzz_path(format->name);
        FUZZ_CHECK(format->write(path, tulle_mesh_get_view(&mesh)) == TULLE_OK);
        fuzz_put_file_seed(names[i], path);
        tulle_mesh_destroy(&mesh);
    }
}
