/* The model: masses, several cloths beside obstacles, refusals, memory; and that a step's bits do
 * not depend on threads and it calls no heap. */
#include "dynamics/fixture.h"

static void masses_add_up(void **state) {
    (void)state;
    for (int pattern = 0; pattern < 3; pattern++) {
        fixture *const f = fixture_make_grid(7, 5, 0.7, 0.5, pattern, plain_material());
        double mass = 0.0;
        for (size_t v = 0; v < f->vertex_count; v++) mass += f->model.masses[v];
        assert_true(fabs(mass - 0.2 * 0.35) < 1e-15);
        assert_int_equal(f->model.edge_count, 7 * 6 + 8 * 5 + 35);
        assert_int_equal(f->model.hinge_count, 7 * 4 + 6 * 5 + 35);
        fixture_free(f);
    }
}

/* A long strip pulled along: stretch stiffness times width times strain. */
static void stretch_is_in_force_per_width(void **state) {
    (void)state;
    for (size_t cells = 4; cells <= 16; cells *= 2) {
        /* Equilateral triangles: rows shifted by half a cell, here as a torn parallelogram. */
        grid g = grid_make(6 * cells, cells, 6.0, sqrt(0.75), 0);
        double const cell = 1.0 / (double)cells;
        for (size_t j = 0; j <= cells; j++)
            for (size_t i = 0; i <= 6 * cells; i++)
                g.positions[3 * (j * (6 * cells + 1) + i)] -= 0.5 * cell * (double)j;
        fixture *const f = fixture_make(g.positions, g.vertex_count, g.triangles, g.triangle_count,
                                        plain_material());
        grid_free(&g);
        double const strain = 0.02;
        /* Uniform strain of an isotropic sheet of Poisson ratio 1/3. */
        for (size_t v = 0; v < f->vertex_count; v++) {
            f->x[3 * v] *= 1.0 + strain;
            f->x[3 * v + 2] *= 1.0 - strain / 3.0;
        }
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
        double pull = 0.0;
        for (size_t j = 0; j <= cells; j++)
            for (size_t i = 3 * cells + j / 2; i <= 6 * cells; i++)
                pull -= f->system.forces[3 * (j * (6 * cells + 1) + i)];
        /* Border springs have one triangle: the sum is off by about one cell in the width. */
        assert_true(fabs(pull / (500.0 * strain * sqrt(0.75)) - 1.0) < 0.03);
        fixture_free(f);
    }
}

/* Two triangles on an edge of 1 m, of one height: the moment of their hinge is that of the bending
 * stiffness, and below a tenth of the edge it falls with the square of the height more. */
static void slivers_are_soft(void **state) {
    (void)state;
    static const double heights[] = {0.5, 0.1, 0.05, 0.02, 1e-3};
    static const uint32_t triangles[6] = {0, 1, 2, 1, 0, 3};
    for (size_t i = 0; i < sizeof heights / sizeof *heights; i++) {
        double const height = heights[i], softening = fmin(1.0, height / 0.1);
        double const rest[12] = {0.0, 0.0, 0.0,    1.0, 0.0, 0.0, /* the edge */
                                 0.5, 0.0, height, 0.5, 0.0, -height};
        fixture *const f = fixture_make(rest, 4, triangles, 2, plain_material());
        assert_int_equal(f->model.hinge_count, 1);
        double const stiffness = 2.0 * 1e-4 / (4.0 * 0.5 * height); /* of both triangles */
        assert_int_equal(f->model.scalar_begin[3] - f->model.scalar_begin[2], 1);
        /* of corners 2 and 3, which share no edge: their weights are minus one over the height */
        double const coupling = f->model.bend_scalars[f->model.scalar_begin[2]] * height * height;
        assert_true(fabs(coupling / (stiffness * softening * softening) - 1.0) < 1e-12);
        fixture_free(f);
    }
}

enum { FIRST = 20, SECOND = 30, OBSTACLE = 9, CLOTH = FIRST + SECOND, ALL = CLOTH + OBSTACLE };

/* Joins three grids into one numbering; returns the number of triangles. */
static size_t join_parts(const grid parts[3], double *positions, uint32_t *triangles,
                         uint32_t *vertex_materials) {
    size_t vertex = 0, triangle = 0;
    for (int p = 0; p < 3; p++) {
        memcpy(positions + 3 * vertex, parts[p].positions,
               3 * parts[p].vertex_count * sizeof(double));
        for (size_t i = 0; i < 3 * parts[p].triangle_count; i++)
            triangles[3 * triangle + i] = parts[p].triangles[i] + (uint32_t)vertex;
        for (size_t v = 0; p < 2 && v < parts[p].vertex_count; v++)
            vertex_materials[vertex + v] = (uint32_t)p;
        vertex += parts[p].vertex_count;
        triangle += parts[p].triangle_count;
    }
    assert_int_equal(vertex, ALL);
    return triangle;
}

static const environment WINDY = {.gravity = {0.0, -9.81, 0.0},
                                  .wind = {{1.0, 2.0, 3.0}, 1.0, 0.5, 0.5, 3, 0.4}};

/* The part alone, in the same state, has the same system. */
static void check_part(const grid *part, tulle_material material, const double *x, const double *v,
                       size_t first, const linear_system *together) {
    fixture *const f = fixture_make(part->positions, part->vertex_count, part->triangles,
                                    part->triangle_count, material);
    size_t const bytes = 3 * f->vertex_count * sizeof(double);
    memcpy(f->x, x + 3 * first, bytes);
    memcpy(f->v, v + 3 * first, bytes);
    f->surroundings = WINDY;
    f->time = 0.3;
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    assert_memory_equal(f->system.forces, together->forces + 3 * first, bytes);
    assert_memory_equal(f->system.right_hand_side, together->right_hand_side + 3 * first, bytes);
    double *const diagonals = malloc(9 * together->vertex_count * sizeof(double));
    block_matrix_get_diagonal(&together->matrix, diagonals, 2);
    fixture_find_diagonal(f);
    assert_memory_equal(f->diagonal, diagonals + 9 * first, 3 * bytes);
    free(diagonals);
    fixture_free(f);
}

/* Two cloths of different materials and an obstacle in one numbering, against each cloth alone. */
static void cloths_beside_obstacles_are_independent(void **state) {
    (void)state;
    tulle_material materials[2] = {plain_material(), plain_material()};
    materials[1].area_density = 0.5;
    materials[1].springs.bend_stiffness = 3e-3;
    materials[1].bend_damping = 0.01;
    materials[1].air_damping = 2.0;
    grid parts[3] = {grid_make(4, 3, 0.4, 0.3, 0), grid_make(5, 4, 0.5, 0.4, 2),
                     grid_make(2, 2, 1.0, 1.0, 0)};
    double positions[3 * ALL], x[3 * CLOTH], v[3 * CLOTH];
    uint32_t triangles[3 * 80], vertex_materials[CLOTH];
    size_t const triangle_count = join_parts(parts, positions, triangles, vertex_materials);
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    topology surface;
    assert_int_equal(topology_build(&heap, triangles, triangle_count, ALL, &surface), TULLE_OK);
    cloth_model_def const def = {.vertex_count = CLOTH,
                                 .surface = &surface,
                                 .rest_positions = positions,
                                 .materials = materials,
                                 .material_count = 2,
                                 .vertex_materials = vertex_materials,
                                 .membrane = TULLE_MEMBRANE_SPRINGS};
    cloth_model model;
    linear_system system;
    assert_int_equal(cloth_model_build(&heap, &def, &model, NULL), TULLE_OK);
    assert_int_equal(linear_system_build(&heap, &model, true, &system), TULLE_OK);
    uint64_t random = 4;
    for (size_t i = 0; i < 3 * CLOTH; i++) {
        x[i] = positions[i] + 0.02 * random_signed(&random);
        v[i] = random_signed(&random);
    }
    cloth_start const now = {.positions = x, .velocities = v, .time_step = 0.01, .time = 0.3};
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, 1, 0.0, true};
    assert_int_equal(compute_forces(&model, &now, &WINDY, options, &scratch, &system), TULLE_OK);
    check_part(&parts[0], materials[0], x, v, 0, &system);
    check_part(&parts[1], materials[1], x, v, FIRST, &system);
    for (int p = 0; p < 3; p++) grid_free(&parts[p]);
    linear_system_destroy(&heap, &system);
    cloth_model_destroy(&heap, &model);
    topology_destroy(&heap, &surface);
    arena_destroy(&scratch);
    assert_int_equal(heap.bytes_held, 0);
}

/* A sheet that waves, in wind: what the system holds from kernels of one vector width. */
static void fill_width(fixture *f, tulle_integrator integrator, kernel_target target) {
    kernel_target const widest = kernel_target_get();
    if (!kernel_target_force(target)) return;
    fixture_assemble(f, integrator, 0.01);
    kernel_target_force(widest);
}

/* Whole systems: both membranes, flat and curved at rest, all integrators, and counts that no width
 * divides. */
static void all_widths_give_the_same_bits(void **state) {
    (void)state;
    for (int round = 0; round < 12; round++) {
        bool const is_woven = round % 2, is_curved = round / 2 % 2;
        tulle_integrator const integrator = (tulle_integrator)(round / 4);
        grid g = grid_make(7, 5, 0.35, 0.25, round % 3);
        double warps[3 * 70];
        for (size_t i = 0; i < 70; i++) memcpy(warps + 3 * i, (double[]){1.0, 0.2, 0.0}, 24);
        if (is_curved)
            for (size_t v = 0; v < g.vertex_count; v++)
                g.positions[3 * v + 1] = 0.02 * sin(20.0 * g.positions[3 * v]);
        tulle_material material;
        assert_int_equal(tulle_material_preset("cotton", &material), TULLE_OK);
        fixture *const f = fixture_make_woven(g.positions, g.vertex_count, g.triangles,
                                              g.triangle_count, material, is_woven ? warps : NULL);
        assert_int_equal(f->model.has_curved_rest, is_curved);
        assert_true(f->model.has_bend_damping);
        uint64_t random = (uint64_t)round + 1;
        for (size_t i = 0; i < 3 * f->vertex_count; i++) {
            f->x[i] += 0.005 * random_signed(&random);
            f->v[i] = random_signed(&random);
            f->previous_mean[i] = random_signed(&random);
            f->previous_v[i] = random_signed(&random);
        }
        f->previous_step = 0.01;
        f->surroundings = WINDY;
        size_t const bytes = 3 * f->vertex_count * sizeof(double);
        size_t const matrix_bytes = BLOCK_NUMBERS * f->system.matrix.block_count * sizeof(double);
        fill_width(f, integrator, KERNEL_BASE);
        double *const forces = copy_doubles(f->system.forces, 3 * f->vertex_count);
        double *const sums = copy_doubles(f->system.right_hand_side, 3 * f->vertex_count);
        double *const blocks = copy_doubles(f->system.matrix.values, matrix_bytes / sizeof(double));
        for (int target = 1; target < KERNEL_TARGET_COUNT; target++) {
            fill_width(f, integrator, (kernel_target)target);
            assert_memory_equal(f->system.forces, forces, bytes);
            assert_memory_equal(f->system.right_hand_side, sums, bytes);
            assert_memory_equal(f->system.matrix.values, blocks, matrix_bytes);
        }
        free(forces), free(sums), free(blocks);
        grid_free(&g);
        fixture_free(f);
    }
}

/* Builds a model of a triangle with these positions and an extra vertex; returns the status. */
static tulle_status try_build(const double *positions, size_t vertex_count, tulle_membrane membrane,
                              size_t byte_limit, tulle_error *error) {
    uint32_t const triangles[] = {0, 1, 2, 2, 1, 3};
    memory heap = memory_default(), limited = {.allocator = {.byte_limit = byte_limit}};
    topology surface;
    assert_int_equal(topology_build(&heap, triangles, 2, vertex_count, &surface), TULLE_OK);
    tulle_material cotton;
    assert_int_equal(tulle_material_preset("cotton", &cotton), TULLE_OK);
    cloth_model_def const def = {.vertex_count = vertex_count,
                                 .surface = &surface,
                                 .rest_positions = positions,
                                 .materials = &cotton,
                                 .material_count = 1,
                                 .membrane = membrane};
    cloth_model model;
    linear_system system;
    tulle_status status = cloth_model_build(&limited, &def, &model, error);
    if (status == TULLE_OK) {
        status = linear_system_build(&limited, &model, true, &system);
        if (status == TULLE_OK) linear_system_destroy(&limited, &system);
        cloth_model_destroy(&limited, &model);
    }
    assert_int_equal(limited.bytes_held, 0);
    topology_destroy(&heap, &surface);
    return status;
}

static void check_refusals(tulle_membrane membrane) {
    tulle_error error;
    double good[] = {0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 1, 5, 5, 5};
    assert_int_equal(try_build(good, 4, membrane, 0, &error), TULLE_OK);
    assert_int_equal(try_build(good, 5, membrane, 0, &error), TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "vertex 4"));
    double flat[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 1, 0, 1};
    assert_int_equal(try_build(flat, 4, membrane, 0, &error), TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "triangle 0"));
    double infinite[] = {0, 0, 0, 1e200, 0, 0, 0, 0, 1e200, 1, 0, 1};
    assert_int_equal(try_build(infinite, 4, membrane, 0, NULL), TULLE_ERROR_INVALID_MESH);
    double needle[] = {0, 0, 0, 1e10, 0, 0, 0, 1e-170, 0, 1e10, 1, 0}; /* it has an area */
    assert_int_equal(try_build(needle, 4, membrane, 0, &error), TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "vertices 0 and 2 are at the same place"));
}

static void bad_cloth_is_refused_by_name(void **state) {
    (void)state;
    check_refusals(TULLE_MEMBRANE_WOVEN);
    check_refusals(TULLE_MEMBRANE_SPRINGS);
}

static void fail_each_allocation(tulle_membrane membrane) {
    double const good[] = {0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 1};
    int failures = 0;
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t limit = 1; status != TULLE_OK; limit += 20, failures++) {
        status = try_build(good, 4, membrane, limit, NULL);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY);
    }
    assert_true(failures > 100);
}

static void failing_memory_is_reported(void **state) {
    (void)state;
    fail_each_allocation(TULLE_MEMBRANE_WOVEN);
    fail_each_allocation(TULLE_MEMBRANE_SPRINGS);
    /* A step without scratch memory fails and says so. */
    fixture *const f = fixture_make_grid(30, 30, 1.0, 1.0, 0, plain_material());
    memory limited = {.allocator = {.byte_limit = 100000}};
    arena scratch = arena_make(&limited);
    cloth_start const now = fixture_state(f, 0.01);
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, 1, 0.0, true};
    assert_int_equal(
        compute_forces(&f->model, &now, &f->surroundings, options, &scratch, &f->system),
        TULLE_ERROR_OUT_OF_MEMORY);
    cloth_energies energies;
    assert_int_equal(compute_energies(&f->model, f->x, f->v, (energy_options){.threads = 1},
                                      &scratch, &energies),
                     TULLE_OK);
    arena_destroy(&scratch);
    fixture_free(f);
}

/* Fifteen steps in wind; returns positions and velocities. */
static double *run_threads(int threads) {
    tulle_material material;
    assert_int_equal(tulle_material_preset("silk", &material), TULLE_OK);
    fixture *const f = fixture_make_grid(40, 40, 1.0, 1.0, 2, material);
    f->threads = threads;
    f->tolerance = 1e-4;
    f->surroundings = (environment){.gravity = {0.0, -9.81, 0.0},
                                    .wind = {{3.0, 0.0, 1.0}, 2.0, 0.3, 0.3, 9, 1.2}};
    f->is_fixed[0] = f->is_fixed[40] = 1;
    uint64_t heap_calls = 0;
    for (int i = 0; i < 15; i++) {
        fixture_step(f, TULLE_INTEGRATOR_BDF2, 0.01);
        cloth_energies energies;
        compute_energies(&f->model, f->x, f->v,
                         (energy_options){.gravity = f->surroundings.gravity, .threads = threads},
                         &f->scratch, &energies);
        if (i == 1) heap_calls = f->heap.allocate_count;
    }
    assert_int_equal(f->heap.allocate_count, heap_calls);
    size_t const n = 3 * f->vertex_count;
    double *const end = malloc(2 * n * sizeof(double));
    memcpy(end, f->x, n * sizeof(double));
    memcpy(end + n, f->v, n * sizeof(double));
    fixture_free(f);
    return end;
}

static void bits_do_not_depend_on_threads(void **state) {
    (void)state;
    double *const one = run_threads(1);
    for (int threads = 2; threads <= 5; threads += 3) {
        double *const many = run_threads(threads);
        assert_memory_equal(one, many, 2 * 3 * 41 * 41 * sizeof(double));
        free(many);
    }
    free(one);
}

/* BDF2 needs history of the same step, and pinned vertices end with their mean velocity. */
static void history_decides_the_integrator(void **state) {
    (void)state;
    fixture *const f = fixture_make_grid(2, 2, 1.0, 1.0, 0, plain_material());
    fixture_step(f, TULLE_INTEGRATOR_BDF2, 0.01);
    assert_int_equal(f->system.integrator, TULLE_INTEGRATOR_IMPLICIT_EULER);
    fixture_step(f, TULLE_INTEGRATOR_BDF2, 0.01);
    assert_int_equal(f->system.integrator, TULLE_INTEGRATOR_BDF2);
    fixture_step(f, TULLE_INTEGRATOR_BDF2, 0.005);
    assert_int_equal(f->system.integrator, TULLE_INTEGRATOR_IMPLICIT_EULER);
    f->system.integrator = TULLE_INTEGRATOR_CRANK_NICOLSON;
    f->system.share = 0.5;
    double mean[27], end[27];
    for (int i = 0; i < 27; i++) mean[i] = i, f->v[i] = 1.0;
    for (int i = 0; i < 27; i++) end[i] = -1.0;
    cloth_start const now = fixture_state(f, 0.01);
    finish_velocities(&f->system, &now, 8, mean, end);
    assert_true(end[1] == 1.0 && end[3] == 5.0 && end[24] == -1.0);
    fixture_free(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masses_add_up),
        cmocka_unit_test(stretch_is_in_force_per_width),
        cmocka_unit_test(slivers_are_soft),
        cmocka_unit_test(cloths_beside_obstacles_are_independent),
        cmocka_unit_test(all_widths_give_the_same_bits),
        cmocka_unit_test(bad_cloth_is_refused_by_name),
        cmocka_unit_test(failing_memory_is_reported),
        cmocka_unit_test(bits_do_not_depend_on_threads),
        cmocka_unit_test(history_decides_the_integrator),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
