/* fuzz/support/shapes.c - see shapes.h. */
#include "support/shapes.h"

#include "tulle/shapes.h"

#include <math.h>

static void place(fuzz_bytes *bytes, tulle_mesh *mesh, double spread) {
    double const angle = fuzz_take_below(bytes, 8) * 0.7853981633974483;
    double const tilt = fuzz_take_below(bytes, 4) == 3 ? 0.5 : 0.0;
    double const rotation[4] = {cos(0.5 * angle) * cos(tilt), sin(tilt) * cos(0.5 * angle),
                                sin(tilt) * sin(0.5 * angle), sin(0.5 * angle) * cos(tilt)};
    double const one[3] = {1.0, 1.0, 1.0};
    double const at[3] = {fuzz_take_between(bytes, -spread, spread),
                          fuzz_take_between(bytes, -spread, spread),
                          fuzz_take_between(bytes, -0.2, 0.4)};
    tulle_mesh_transform(mesh, one, rotation, at);
}

tulle_mesh shapes_take_cloth(fuzz_bytes *bytes) {
    static const tulle_shape shapes[] = {TULLE_SHAPE_RECTANGLE, TULLE_SHAPE_RECTANGLE,
                                         TULLE_SHAPE_RIBBON, TULLE_SHAPE_DISC, TULLE_SHAPE_TUBE};
    tulle_shape const shape = shapes[fuzz_take_below(bytes, 5)];
    tulle_shape_def def = tulle_shape_def_default(shape);
    bool const is_round = shape == TULLE_SHAPE_TUBE || shape == TULLE_SHAPE_DISC;
    double const first = fuzz_take_between(bytes, 0.1, 0.5);
    double const second = fuzz_take_between(bytes, 0.05, 0.5);
    if (def.size[0] != 0.0) def.size[0] = first, def.size[1] = second; /* 0: it has none */
    if (def.radius != 0.0) def.radius = first;
    if (def.height != 0.0) def.height = second;
    def.resolution[0] = 2 + fuzz_take_below(bytes, 3) + (shape == TULLE_SHAPE_TUBE ? 2 : 0);
    def.resolution[1] = is_round ? 4 + fuzz_take_below(bytes, 3) : 2 + fuzz_take_below(bytes, 3);
    def.is_irregular = (int)fuzz_take_below(bytes, 2);
    tulle_mesh mesh = {0};
    if (tulle_shape_generate(&def, &mesh, NULL) != TULLE_OK) {
        def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE); /* needles: of no area */
        def.resolution[0] = def.resolution[1] = 3;
        FUZZ_CHECK(tulle_shape_generate(&def, &mesh, NULL) == TULLE_OK);
    }
    place(bytes, &mesh, 0.2);
    return mesh;
}

tulle_mesh shapes_take_obstacle(fuzz_bytes *bytes, int *is_closed) {
    static const tulle_shape shapes[] = {TULLE_SHAPE_BOX, TULLE_SHAPE_TETRAHEDRON,
                                         TULLE_SHAPE_SPHERE, TULLE_SHAPE_CONE, TULLE_SHAPE_PLANE};
    tulle_shape const shape = shapes[fuzz_take_below(bytes, 5)];
    tulle_shape_def def = tulle_shape_def_default(shape);
    double size[3];
    for (int k = 0; k < 3; k++) {
        size[k] = fuzz_take_between(bytes, 0.03, 0.4);
        if (def.size[k] != 0.0) def.size[k] = size[k]; /* 0: it has none */
    }
    if (def.radius != 0.0) def.radius = 0.5 * size[0];
    if (def.height != 0.0) def.height = size[1];
    if (shape != TULLE_SHAPE_TETRAHEDRON) def.resolution[0] = shape == TULLE_SHAPE_CONE ? 5 : 2;
    if (shape == TULLE_SHAPE_CONE || shape == TULLE_SHAPE_PLANE) def.resolution[1] = 2;
    *is_closed = shape != TULLE_SHAPE_PLANE;
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_shape_generate(&def, &mesh, &error), &error);
    place(bytes, &mesh, 0.3);
    return mesh;
}

bool shapes_contain(const tulle_mesh *mesh, const double *positions, const double *point) {
    static const double rounding = 1e-9; /* [m] */
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double *const a = positions + 3 * (size_t)mesh->triangles[3 * t];
        const double *const b = positions + 3 * (size_t)mesh->triangles[3 * t + 1];
        const double *const c = positions + 3 * (size_t)mesh->triangles[3 * t + 2];
        double const u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        double const v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        double const n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                             u[0] * v[1] - u[1] * v[0]};
        double height = 0.0;
        for (int k = 0; k < 3; k++) height += n[k] * (point[k] - a[k]);
        double const length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (!(height < -rounding * length)) return false;
    }
    return true;
}
