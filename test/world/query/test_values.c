/* What objects tell of themselves (tulle/query.h): counts, meshes, user data, and copies of
 * positions, velocities, normals, contact forces and strains, against closed forms and against what
 * the world tells otherwise. */
#include "tulle/query.h"

#include "support/small_world.h"
#include "support/test_support.h"
#include "tulle/mesh.h"
#include "tulle/shapes.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
enum { SIDE = 9, VERTICES = SIDE * SIDE, MOST = 3000 };
static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

/* A sheet just above a plate, and a ball aside. */
typedef struct scene {
    tulle_world *world;
    tulle_object_id sheet, plate, ball;
    tulle_cloth_id cloth;
    tulle_mesh meshes[3];
} scene;

static scene make_scene(void) {
    scene made;
    tulle_world_def const def = tulle_world_def_default();
    FINE(tulle_world_create(&def, &made.world, &error));
    made.meshes[0] = small_sheet(0.4, SIDE, 0.01);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 1.0;
    shape.size[2] = 0.25;
    made.meshes[1] = small_shape(shape, 0.0, 0.0, -0.125);
    shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.25;
    made.meshes[2] = small_shape(shape, 3.0, 0.0, 0.0);
    made.cloth = small_add_cloth(made.world, &made.meshes[0]);
    made.sheet = tulle_object_from_cloth(made.cloth);
    made.plate = tulle_object_from_obstacle(small_add_obstacle(made.world, &made.meshes[1]));
    made.ball = tulle_object_from_obstacle(small_add_obstacle(made.world, &made.meshes[2]));
    return made;
}

static void destroy(scene *made) {
    tulle_world_destroy(made->world);
    for (int k = 0; k < 3; k++) tulle_mesh_destroy(&made->meshes[k]);
}

static void copy(const scene *made, tulle_object_id object, tulle_values values, double *to,
                 size_t count) {
    tulle_target const target = {to, 3 * count * sizeof *to, 0, TULLE_NUMBER_DOUBLE};
    FINE(tulle_object_copy_values(made->world, object, values, &target, &error));
}

static void objects_tell_what_they_are(void **state) {
    (void)state;
    scene made = make_scene();
    tulle_object_id const objects[3] = {made.sheet, made.plate, made.ball};
    static const char *const names[3] = {"cloth 0", "obstacle 0", "obstacle 1"};
    int marks[3];
    for (int started = 0; started < 2; started++) {
        for (uint32_t k = 0; k < 3; k++) {
            tulle_object_id const id = tulle_world_get_object(made.world, k);
            assert_memory_equal(&id, &objects[k], sizeof id);
            tulle_object_info const info = tulle_object_get_info(made.world, id);
            assert_string_equal(info.name, names[k]);
            assert_int_equal(info.vertex_count, made.meshes[k].vertex_count);
            assert_int_equal(info.triangle_count, made.meshes[k].triangle_count);
            assert_memory_equal(info.triangles, made.meshes[k].triangles,
                                3 * info.triangle_count * sizeof *info.triangles);
            assert_true(info.category == 1 && info.mask == UINT32_MAX);
            void *const known = tulle_object_get_user_data(made.world, id);
            assert_ptr_equal(known, started ? &marks[k] : NULL);
            FINE(tulle_object_set_user_data(made.world, id, &marks[k], &error));
        }
        tulle_counts const counts = tulle_world_get_counts(made.world);
        assert_int_equal(counts.cloths, 1);
        assert_int_equal(counts.obstacles, 2);
        assert_int_equal(counts.cloth_vertices, VERTICES);
        assert_int_equal(counts.cloth_triangles, made.meshes[0].triangle_count);
        assert_int_equal(counts.obstacle_vertices,
                         made.meshes[1].vertex_count + made.meshes[2].vertex_count);
        assert_int_equal(counts.obstacle_triangles,
                         made.meshes[1].triangle_count + made.meshes[2].triangle_count);
        if (!started) FINE(tulle_world_start(made.world, &error));
    }
    destroy(&made);
}

/* Positions and velocities are those that the world lends; what lies between them stays. */
static void copies_keep_their_stride(void **state) {
    (void)state;
    scene made = make_scene();
    for (int i = 0; i < 4; i++) FINE(tulle_world_step(made.world, STEP, NULL, &error));
    const double *const lent[2] = {tulle_cloth_get_positions(made.world, made.cloth, NULL),
                                   tulle_cloth_get_velocities(made.world, made.cloth, NULL)};
    enum { STRIDE = 29, GAP_BEFORE = 3 }; /* no number lies where its type would want it */
    static unsigned char bytes[GAP_BEFORE + STRIDE * VERTICES];
    for (int values = 0; values < 2; values++) {
        for (int type = 0; type < 2; type++) {
            size_t const size = type == TULLE_NUMBER_FLOAT ? sizeof(float) : sizeof(double);
            size_t const item = 3 * size;
            memset(bytes, 0xa5, sizeof bytes);
            tulle_target target = {bytes + GAP_BEFORE, STRIDE * (VERTICES - 1) + item, STRIDE,
                                   (tulle_number_type)type};
            FINE(tulle_object_copy_values(made.world, made.sheet, (tulle_values)values, &target,
                                          &error));
            for (size_t i = 0; i < sizeof bytes; i++) {
                bool const is_before = i < GAP_BEFORE;
                size_t const at = is_before ? 0 : (i - GAP_BEFORE) % STRIDE;
                if (is_before || at >= item) assert_int_equal(bytes[i], 0xa5);
            }
            for (size_t v = 0; v < VERTICES; v++) {
                for (size_t k = 0; k < 3; k++) {
                    const unsigned char *const from = bytes + GAP_BEFORE + STRIDE * v + k * size;
                    double const wanted = lent[values][3 * v + k];
                    if (type == TULLE_NUMBER_FLOAT) {
                        float const rounded = (float)wanted;
                        assert_memory_equal(from, &rounded, size);
                    } else {
                        assert_memory_equal(from, &wanted, size);
                    }
                }
            }
            /* one byte less, and nothing is written */
            memset(bytes, 0xa5, sizeof bytes);
            target.size--;
            assert_int_equal(tulle_object_copy_values(made.world, made.sheet, (tulle_values)values,
                                                      &target, &error),
                             TULLE_ERROR_INVALID_ARGUMENT);
            for (size_t i = 0; i < sizeof bytes; i++) assert_int_equal(bytes[i], 0xa5);
        }
    }
    destroy(&made);
}

/* Of a flat sheet upwards, of a ball outwards, of a moved sheet what a sum over triangles says. */
static void normals_are_means_by_area(void **state) {
    (void)state;
    scene made = make_scene();
    static double normals[3 * MOST], sums[3 * MOST];
    FINE(tulle_world_start(made.world, &error));
    copy(&made, made.sheet, TULLE_VALUES_NORMALS, normals, VERTICES);
    for (size_t v = 0; v < VERTICES; v++)
        assert_true(normals[3 * v] == 0.0 && normals[3 * v + 1] == 0.0 &&
                    fabs(normals[3 * v + 2] - 1.0) < 1e-15);
    size_t const count = made.meshes[2].vertex_count;
    assert_true(count <= MOST);
    copy(&made, made.ball, TULLE_VALUES_NORMALS, normals, count);
    for (size_t v = 0; v < count; v++) {
        double along = 0.0;
        for (size_t k = 0; k < 3; k++)
            along += normals[3 * v + k] *
                     (made.meshes[2].positions[3 * v + k] - (k == 0 ? 3.0 : 0.0)) / 0.25;
        assert_true(along > 0.999);
    }
    for (int i = 0; i < 8; i++) FINE(tulle_world_step(made.world, STEP, NULL, &error));
    const double *const x = tulle_cloth_get_positions(made.world, made.cloth, NULL);
    memset(sums, 0, sizeof sums);
    for (size_t t = 0; t < made.meshes[0].triangle_count; t++) {
        const uint32_t *const corners = made.meshes[0].triangles + 3 * t;
        for (size_t k = 0; k < 3; k++) {
            size_t const i = (k + 1) % 3, j = (k + 2) % 3;
            const double *const a = x + 3 * (size_t)corners[0],
                                *const b = x + 3 * (size_t)corners[1],
                                *const c = x + 3 * (size_t)corners[2];
            double const part = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
            for (size_t corner = 0; corner < 3; corner++) sums[3 * corners[corner] + k] += part;
        }
    }
    copy(&made, made.sheet, TULLE_VALUES_NORMALS, normals, VERTICES);
    for (size_t v = 0; v < VERTICES; v++) {
        double const length = sqrt(sums[3 * v] * sums[3 * v] + sums[3 * v + 1] * sums[3 * v + 1] +
                                   sums[3 * v + 2] * sums[3 * v + 2]);
        for (size_t k = 0; k < 3; k++)
            assert_true(fabs(normals[3 * v + k] - sums[3 * v + k] / length) < 1e-12);
    }
    destroy(&made);
}

/* At rest the plate carries the weight of the sheet; forces are those of the contacts at all times,
 * and there are none before the first step, on the ball, and in a state that was loaded. */
static void forces_carry_the_weight(void **state) {
    (void)state;
    scene made = make_scene();
    static double on_sheet[3 * MOST], on_plate[3 * MOST], on_ball[3 * MOST];
    static float short_forces[3 * MOST];
    double const weight =
        0.4 * 0.4 * tulle_cloth_def_default().material.area_density * 9.81; /* [N] */
    size_t const plate_count = made.meshes[1].vertex_count,
                 ball_count = made.meshes[2].vertex_count;
    FINE(tulle_world_start(made.world, &error));
    for (int i = 0; i < 200; i++) {
        tulle_step_report report = {0};
        if (i > 0) FINE(tulle_world_step(made.world, STEP, &report, &error));
        copy(&made, made.sheet, TULLE_VALUES_CONTACT_FORCES, on_sheet, VERTICES);
        copy(&made, made.plate, TULLE_VALUES_CONTACT_FORCES, on_plate, plate_count);
        copy(&made, made.ball, TULLE_VALUES_CONTACT_FORCES, on_ball, ball_count);
        const tulle_contact *contacts;
        size_t count;
        FINE(tulle_world_get_contacts(made.world, &contacts, &count, &error));
        double sums[3] = {0.0}, told[3] = {0.0}, sizes = 0.0;
        for (size_t k = 0; k < 3; k++) {
            for (size_t v = 0; v < VERTICES; v++) {
                sums[k] += on_sheet[3 * v + k];
                sizes += fabs(on_sheet[3 * v + k]);
            }
            double back = 0.0;
            for (size_t v = 0; v < plate_count; v++) back += on_plate[3 * v + k];
            for (size_t c = 0; c < count && report.substeps == 1; c++)
                if (contacts[c].object_a != contacts[c].object_b)
                    told[k] +=
                        (contacts[c].object_a == 0 ? 1.0 : -1.0) * contacts[c].impulse[k] / STEP;
            assert_true(fabs(sums[k] + back) <= 1e-10 * (1.0 + sizes));
            if (report.substeps == 1) assert_true(fabs(sums[k] - told[k]) <= 1e-10 * (1.0 + sizes));
        }
        for (size_t k = 0; k < 3 * ball_count; k++) assert_true(on_ball[k] == 0.0);
        if (i == 0) assert_true(sizes == 0.0);
        if (i > 150) assert_true(fabs(sums[2] - weight) < 0.02 * weight);
    }
    tulle_target const target = {short_forces, sizeof short_forces, 0, TULLE_NUMBER_FLOAT};
    FINE(tulle_object_copy_values(made.world, made.sheet, TULLE_VALUES_CONTACT_FORCES, &target,
                                  &error));
    for (size_t k = 0; k < 3 * (size_t)VERTICES; k++)
        assert_true(fabs((double)short_forces[k] - on_sheet[k]) <= 1e-5 * weight);
    void *bytes;
    size_t byte_count;
    FINE(tulle_world_save_state(made.world, &bytes, &byte_count, &error));
    FINE(tulle_world_load_state(made.world, bytes, byte_count, &error));
    copy(&made, made.sheet, TULLE_VALUES_CONTACT_FORCES, on_sheet, VERTICES);
    for (size_t k = 0; k < 3 * (size_t)VERTICES; k++) assert_true(on_sheet[k] == 0.0);
    tulle_world_free_state(made.world, bytes, byte_count);
    destroy(&made);
}

/* A sheet that starts as a linear map of its rest shape: the strains are those of the map, whatever
 * way the grain runs. */
static void strains_are_those_of_the_map(void **state) {
    (void)state;
    static const double map[2][2] = {{1.06, 0.08}, {-0.02, 0.97}}; /* rows */
    for (int turned = 0; turned < 2; turned++) {
        tulle_mesh sheet = small_sheet(0.4, SIDE, 0.0);
        static double mapped[3 * VERTICES], strains[3 * MOST];
        for (size_t v = 0; v < VERTICES; v++) {
            const double *const x = sheet.positions + 3 * v;
            for (size_t k = 0; k < 3; k++)
                mapped[3 * v + k] = k == 2 ? 0.0 : map[k][0] * x[0] + map[k][1] * x[1];
        }
        tulle_world_def const world_def = tulle_world_def_default();
        tulle_cloth_def def = tulle_cloth_def_default();
        def.mesh = tulle_mesh_get_view(&sheet);
        def.mesh.positions = mapped;
        def.rest_positions = sheet.positions;
        def.grain[0] = turned ? 0.6 : 1.0;
        def.grain[1] = turned ? 0.8 : 0.0;
        def.grain[2] = 0.0;
        tulle_world *world;
        tulle_cloth_id cloth;
        FINE(tulle_world_create(&world_def, &world, &error));
        FINE(tulle_world_add_cloth(world, &def, &cloth, &error));
        FINE(tulle_world_start(world, &error));
        size_t const count = sheet.triangle_count;
        assert_true(count <= MOST);
        tulle_target const target = {strains, 3 * count * sizeof *strains, 0, TULLE_NUMBER_DOUBLE};
        FINE(tulle_object_copy_values(world, tulle_object_from_cloth(cloth), TULLE_VALUES_STRAINS,
                                      &target, &error));
        double const warp[2] = {map[0][0] * def.grain[0] + map[0][1] * def.grain[1],
                                map[1][0] * def.grain[0] + map[1][1] * def.grain[1]};
        double const weft[2] = {-map[0][0] * def.grain[1] + map[0][1] * def.grain[0],
                                -map[1][0] * def.grain[1] + map[1][1] * def.grain[0]};
        double const wanted[3] = {hypot(warp[0], warp[1]) - 1.0, hypot(weft[0], weft[1]) - 1.0,
                                  warp[0] * weft[0] + warp[1] * weft[1]};
        for (size_t i = 0; i < 3 * count; i++)
            assert_true(fabs(strains[i] - wanted[i % 3]) < 1e-12);
        tulle_world_destroy(world);
        tulle_mesh_destroy(&sheet);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(objects_tell_what_they_are),   cmocka_unit_test(copies_keep_their_stride),
        cmocka_unit_test(normals_are_means_by_area),    cmocka_unit_test(forces_carry_the_weight),
        cmocka_unit_test(strains_are_those_of_the_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
