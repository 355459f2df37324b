/* Rows behind the plane of a nearer one: where an obstacle is flat, a sheet has one row a vertex,
 * pushed straight up, whether triangles share vertices or not and over the seam of two obstacles;
 * over a ridge, a step or a gap nothing that matters is left out. */
#include "base/hash.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <stdlib.h>
#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* Each triangle with vertices of its own. */
static contact_grid split_triangles(const contact_grid *grid) {
    size_t const count = 3 * grid->mesh.triangle_count;
    contact_grid soup = {
        malloc(3 * count * sizeof *soup.positions), malloc(count * sizeof *soup.triangles), {0}};
    for (size_t i = 0; i < count; i++) {
        memcpy(soup.positions + 3 * i, grid->positions + 3 * (size_t)grid->triangles[i],
               3 * sizeof *soup.positions);
        soup.triangles[i] = (uint32_t)i;
    }
    soup.mesh = (contact_mesh){soup.positions, count, soup.triangles, grid->mesh.triangle_count};
    return soup;
}

static contact_grid make_plane(double from, double to, uint32_t columns) {
    return make_contact_grid(columns, 9, vec3_make(from, -0.31, 0.0),
                             vec3_make(to - from, 0.0, 0.0), vec3_make(0.0, 0.6, 0.0));
}

static void add_sheet(contact_world *world, uint64_t *random) {
    double const angle = 6.28 * random_uniform(random);
    vec3 const across = {0.1 * cos(angle), 0.1 * sin(angle), 0.0};
    vec3 const along = {-0.12 * sin(angle), 0.12 * cos(angle), 0.0};
    contact_grid sheet =
        make_contact_grid(6, 7, vec3_make(0.0, 0.0, HEIGHT_OVER_PLANE), across, along);
    add_contact_surface(world, sheet.mesh, false);
    free_contact_grid(&sheet);
}

/* Rows for a sheet that slides at 1 m/s and falls below the contact distance as predicted. */
static void gather_sliding(contact_world *world) {
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    memcpy(world->x1, world->x0, 3 * world->vertex_count * sizeof(double));
    for (size_t v = 0; v < world->cloth_vertex_count; v++) {
        world->x1[3 * v] += 1.0 * TIME_STEP;
        world->x1[3 * v + 2] -= 9.81 * TIME_STEP * TIME_STEP;
    }
    pair_source *const source = find_contact_pairs(world, world->x1);
    assert_int_equal(gather_rows(&scene, world->store, world->x1, source, world->rows), TULLE_OK);
}

static void check_flat_rows(contact_world *world) {
    size_t of_vertex[64] = {0};
    for (size_t r = 0; r < world->rows->rows.count; r++) {
        const contact_row *const row = &world->rows->rows.data[r];
        assert_int_equal(row->frame.kind, FEATURE_VERTEX_TRIANGLE);
        assert_true(row->frame.vertices[0] < world->cloth_vertex_count);
        assert_true(fabs(row->frame.normal.z - 1.0) < 1e-12);
        of_vertex[row->frame.vertices[0]]++;
    }
    for (size_t v = 0; v < world->cloth_vertex_count; v++) assert_int_equal(of_vertex[v], 1);
}

static void flats_have_a_row_a_vertex(void **state) {
    (void)state;
    uint64_t random = 5;
    for (int i = 0; i < 30; i++) {
        contact_world world = contact_world_make();
        add_sheet(&world, &random);
        contact_grid plane = make_plane(-0.3, 0.31, 5 + (uint32_t)i);
        contact_grid soup = split_triangles(&plane);
        add_contact_surface(&world, i % 2 == 0 ? plane.mesh : soup.mesh, true);
        start_contact_world(&world);
        gather_sliding(&world);
        check_flat_rows(&world);
        contact_world_destroy(&world);
        free_contact_grid(&plane);
        free_contact_grid(&soup);
    }
}

static void seams_are_no_edges(void **state) {
    (void)state;
    uint64_t random = 9;
    for (int i = 0; i < 30; i++) {
        contact_world world = contact_world_make();
        add_sheet(&world, &random);
        double const seam = 0.02 * random_uniform(&random);
        contact_grid left = make_plane(-0.3, seam, 7), right = make_plane(seam, 0.31, 4);
        add_contact_surface(&world, left.mesh, true);
        add_contact_surface(&world, right.mesh, true);
        start_contact_world(&world);
        gather_sliding(&world);
        check_flat_rows(&world);
        contact_world_destroy(&world);
        free_contact_grid(&left);
        free_contact_grid(&right);
    }
}

/* The second plane lies `rise` above the first, or falls away by a slope: its edge keeps rows. */
static size_t count_edge_rows(double rise, double slope) {
    uint64_t random = 3;
    contact_world world = contact_world_make();
    add_sheet(&world, &random);
    contact_grid left = make_plane(-0.3, 0.013, 7), right = make_plane(0.013, 0.31, 4);
    for (size_t v = 0; v < right.mesh.vertex_count; v++)
        right.positions[3 * v + 2] += rise - slope * (right.positions[3 * v] - 0.013);
    add_contact_surface(&world, left.mesh, true);
    add_contact_surface(&world, right.mesh, true);
    start_contact_world(&world);
    gather_sliding(&world);
    size_t count = 0;
    for (size_t r = 0; r < world.rows->rows.count; r++)
        count += world.rows->rows.data[r].frame.kind == FEATURE_EDGE_EDGE;
    contact_world_destroy(&world);
    free_contact_grid(&left);
    free_contact_grid(&right);
    return count;
}

static void true_edges_stay(void **state) {
    (void)state;
    assert_int_equal(count_edge_rows(0.0, 0.0), 0);
    assert_true(count_edge_rows(1e-3, 0.0) > 3);
    assert_true(count_edge_rows(0.0, 0.1) > 3);
}

/* Largest change of a vertex' rise from step to step, long after the start [m]: a sheet that drifts
 * over a low step, which is just hidden or just not. */
static double measure_tremble(double drop) {
    contact_world world = contact_world_make();
    world.def.contact_distance = 5e-3;
    world.friction = 0.0;
    contact_grid sheet = make_contact_grid(12, 12, vec3_make(-0.287, -0.3, 5.5e-3),
                                           vec3_make(0.6, 0.0, 0.0), vec3_make(0.0, 0.6, 0.0));
    contact_grid left = make_contact_grid(2, 2, vec3_make(-1.0, -0.5, 0.0),
                                          vec3_make(1.0, 0.0, 0.0), vec3_make(0.0, 1.0, 0.0));
    contact_grid right = make_contact_grid(2, 2, vec3_make(0.0, -0.5, -drop),
                                           vec3_make(1.0, 0.0, 0.0), vec3_make(0.0, 1.0, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    add_contact_surface(&world, left.mesh, true);
    add_contact_surface(&world, right.mesh, true);
    start_contact_world(&world);
    double last[144] = {0.0}, before[144] = {0.0}, largest = 0.0;
    for (int step = 0; step < 270; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        for (size_t v = 0; v < world.cloth_vertex_count; v++) {
            double const z = world.x0[3 * v + 2];
            if (step > 210) largest = fmax(largest, fabs(z - 2.0 * last[v] + before[v]));
            before[v] = last[v];
            last[v] = z;
        }
    }
    contact_world_destroy(&world);
    free_contact_grid(&sheet);
    free_contact_grid(&left);
    free_contact_grid(&right);
    return largest;
}

static void low_steps_do_not_come_and_go(void **state) {
    (void)state;
    double largest = 0.0;
    for (int i = 0; i < 4; i++) largest = fmax(largest, measure_tremble(4.8e-4 + 2e-5 * i));
    print_message("over a low step cloth trembles by %.2g m\n", largest);
    assert_true(largest < 1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flats_have_a_row_a_vertex),
        cmocka_unit_test(seams_are_no_edges),
        cmocka_unit_test(true_edges_stay),
        cmocka_unit_test(low_steps_do_not_come_and_go),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
