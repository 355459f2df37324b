/* fuzz/support/mesh_mutator.c - changes meshes as meshes, see mesh_file.h.
 *
 * Changes of bytes rarely lead from one mesh to another. These do: a vertex moves or falls on
 * another one, a triangle is split, turned over, dropped or doubled, an edge is flipped, the whole
 * is scaled. Of a mesh that is valid cloth, a change that would make it invalid is undone. */
#define _XOPEN_SOURCE 700
#include "support/mesh_file.h"

#include "base/hash.h"
#include "io/io_support.h"

enum {
    CHANGES_MAX = 4,   /* of one mutation */
    VERTEX_MAX = 2000, /* a larger mesh grows no more */
    BYTES_ONE_IN = 4   /* mutations that change bytes */
};

/* libFuzzer's own mutator; it is not there when inputs are only replayed. */
extern size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t size_max) __attribute__((weak));

static size_t pick(uint64_t *state, size_t count) { return (size_t)(random_next(state) % count); }

/* A copy with room for one more vertex and two more triangles. */
static tulle_mesh copy_mesh(const tulle_mesh *mesh) {
    tulle_mesh copy = {0};
    FUZZ_CHECK(tulle_mesh_create(mesh->vertex_count + 1, mesh->triangle_count + 2, &copy, NULL) ==
               TULLE_OK);
    memcpy(copy.positions, mesh->positions, 3 * mesh->vertex_count * sizeof *mesh->positions);
    memcpy(copy.triangles, mesh->triangles, 3 * mesh->triangle_count * sizeof *mesh->triangles);
    copy.vertex_count = mesh->vertex_count;
    copy.triangle_count = mesh->triangle_count;
    return copy;
}

static void add_triangle(tulle_mesh *mesh, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *const corners = mesh->triangles + 3 * mesh->triangle_count++;
    corners[0] = a, corners[1] = b, corners[2] = c;
}

static void move_vertex(tulle_mesh *mesh, uint64_t *state) {
    static const double amounts[] = {1e-9, 1e-3, 0.1, 1.0, 1e6};
    double *const x = mesh->positions + 3 * pick(state, mesh->vertex_count);
    double const amount = amounts[pick(state, sizeof amounts / sizeof amounts[0])];
    for (int k = 0; k < 3; k++) x[k] += amount * (random_uniform(state) - 0.5);
}

static void weld_vertex(tulle_mesh *mesh, uint64_t *state) {
    size_t const to = pick(state, mesh->vertex_count), from = pick(state, mesh->vertex_count);
    memmove(mesh->positions + 3 * to, mesh->positions + 3 * from, 3 * sizeof(double));
}

/* A vertex in the middle of the triangle, and three triangles in its place. */
static void split_triangle(tulle_mesh *mesh, uint64_t *state) {
    uint32_t *const corners = mesh->triangles + 3 * pick(state, mesh->triangle_count);
    uint32_t const middle = (uint32_t)mesh->vertex_count++, last = corners[2];
    for (size_t k = 0; k < 3; k++)
        mesh->positions[3 * (size_t)middle + k] = (mesh->positions[3 * (size_t)corners[0] + k] +
                                                   mesh->positions[3 * (size_t)corners[1] + k] +
                                                   mesh->positions[3 * (size_t)corners[2] + k]) /
                                                  3.0;
    add_triangle(mesh, corners[1], last, middle);
    add_triangle(mesh, last, corners[0], middle);
    corners[2] = middle;
}

/* Two triangles (a, b, c) and (b, a, d) become (a, d, c) and (d, b, c). */
static void flip_edge(tulle_mesh *mesh, uint64_t *state) {
    uint32_t *const first = mesh->triangles + 3 * pick(state, mesh->triangle_count);
    size_t const side = pick(state, 3);
    uint32_t const a = first[side], b = first[(side + 1) % 3], c = first[(side + 2) % 3];
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (size_t k = 0; k < 3; k++) {
            uint32_t *const second = mesh->triangles + 3 * t;
            if (second[k] != b || second[(k + 1) % 3] != a) continue;
            uint32_t const d = second[(k + 2) % 3];
            first[0] = a, first[1] = d, first[2] = c;
            second[0] = d, second[1] = b, second[2] = c;
            return;
        }
}

static void drop_triangle(tulle_mesh *mesh, uint64_t *state) {
    uint32_t *const corners = mesh->triangles + 3 * pick(state, mesh->triangle_count);
    mesh->triangle_count--;
    memmove(corners, mesh->triangles + 3 * mesh->triangle_count, 3 * sizeof *corners);
}

static void double_triangle(tulle_mesh *mesh, uint64_t *state) {
    const uint32_t *const corners = mesh->triangles + 3 * pick(state, mesh->triangle_count);
    add_triangle(mesh, corners[0], corners[1], corners[2]);
}

static void turn_triangle(tulle_mesh *mesh, uint64_t *state) {
    uint32_t *const corners = mesh->triangles + 3 * pick(state, mesh->triangle_count);
    uint32_t const second = corners[1];
    corners[1] = corners[2];
    corners[2] = second;
}

static void change_corner(tulle_mesh *mesh, uint64_t *state) {
    mesh->triangles[pick(state, 3 * mesh->triangle_count)] =
        (uint32_t)pick(state, mesh->vertex_count);
}

static void scale(tulle_mesh *mesh, uint64_t *state) {
    static const double factors[] = {1e-12, 1e-3, -1.0, 0.0, 1e3, 1e150};
    double const factor = factors[pick(state, sizeof factors / sizeof factors[0])];
    size_t const axis = pick(state, 4); /* 3: all */
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++)
        if (axis == 3 || i % 3 == axis) mesh->positions[i] *= factor;
}

/* Changes the mesh, or leaves it where that would make valid cloth invalid. */
static void change(tulle_mesh *mesh, uint64_t *state) {
    static void (*const changes[])(tulle_mesh *, uint64_t *) = {
        move_vertex,     weld_vertex,   split_triangle, flip_edge, drop_triangle,
        double_triangle, turn_triangle, change_corner,  scale};
    if (mesh->triangle_count == 0 || mesh->vertex_count > VERTEX_MAX) return;
    tulle_mesh changed = copy_mesh(mesh);
    changes[pick(state, sizeof changes / sizeof changes[0])](&changed, state);
    bool const was_cloth =
        tulle_mesh_validate(tulle_mesh_get_view(mesh), TULLE_MESH_ROLE_CLOTH, NULL) == TULLE_OK;
    bool const is_cloth =
        tulle_mesh_validate(tulle_mesh_get_view(&changed), TULLE_MESH_ROLE_CLOTH, NULL) == TULLE_OK;
    tulle_mesh *const left = was_cloth && !is_cloth ? &changed : mesh;
    tulle_mesh const kept = was_cloth && !is_cloth ? *mesh : changed;
    tulle_mesh_destroy(left);
    *mesh = kept;
}

size_t fuzz_mutate_mesh(const fuzz_mesh_format *format, uint8_t *data, size_t size, size_t size_max,
                        unsigned seed) {
    uint64_t state = seed;
    tulle_mesh mesh = {0};
    const char *const path = fuzz_put_file(format->name, data, size);
    if (pick(&state, BYTES_ONE_IN) == 0 || format->read(path, &mesh) != TULLE_OK)
        return LLVMFuzzerMutate ? LLVMFuzzerMutate(data, size, size_max) : size;
    for (size_t left = 1 + pick(&state, CHANGES_MAX); left > 0; left--) change(&mesh, &state);
    tulle_status const status = format->write(path, tulle_mesh_get_view(&mesh));
    tulle_mesh_destroy(&mesh);
    if (status != TULLE_OK) return size;
    size_t written;
    char *const bytes = get_file(path, &written);
    if (written <= size_max) memcpy(data, bytes, written);
    free(bytes);
    return written <= size_max ? written : size;
}
