/* test/support/mini_world.c - see mini_world.h. */
#include "support/mini_world.h"

#include "base/hash.h"
#include "base/timer.h"
#include "support/test_support.h"
#include "tulle/check.h"

#include <stdlib.h>
#include <string.h>

mini_world mini_world_make(void) {
    return (mini_world){.heap = memory_default(),
                        .settings = contact_settings_default(),
                        .contact_distance = 3e-3,
                        .friction = 0.5,
                        .dynamic_friction = -1.0,
                        .gravity = {0.0, 0.0, -9.81},
                        .material = {.area_density = 0.25,
                                     .stretch_stiffness = 1500.0,
                                     .bend_stiffness = 1e-5,
                                     .stretch_damping = 5e-4,
                                     .bend_damping = 2e-3},
                        .threads = 1};
}

static void *grow(void *data, size_t count, size_t size) {
    void *const grown = realloc(data, (count ? count : 1) * size);
    assert_non_null(grown);
    return grown;
}

size_t add_mini_surface(mini_world *world, mini_mesh mesh, bool is_obstacle) {
    size_t const first = world->vertex_count, first_triangle = world->triangle_count;
    assert_true(world->surface_count < MINI_MAX_SURFACES);
    world->x0 = grow(world->x0, 3 * (first + mesh.vertex_count), sizeof(double));
    world->triangles =
        grow(world->triangles, 3 * (first_triangle + mesh.triangle_count), sizeof(uint32_t));
    memcpy(world->x0 + 3 * first, mesh.positions, 3 * mesh.vertex_count * sizeof(double));
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        world->triangles[3 * first_triangle + i] = mesh.triangles[i] + (uint32_t)first;
    world->vertex_count += mesh.vertex_count;
    world->triangle_count += mesh.triangle_count;
    if (!is_obstacle) world->cloth_vertex_count = world->vertex_count;
    world->surfaces[world->surface_count] =
        (surface_range){.vertex_begin = (uint32_t)first,
                        .vertex_end = (uint32_t)world->vertex_count,
                        .triangle_begin = (uint32_t)first_triangle,
                        .triangle_end = (uint32_t)world->triangle_count,
                        .is_obstacle = is_obstacle,
                        .is_present = true};
    return world->surface_count++;
}

static void fill_surfaces(mini_world *world) {
    uint32_t edge = 0;
    for (size_t s = 0; s < world->surface_count; s++) {
        surface_range *const range = &world->surfaces[s];
        range->edge_begin = edge;
        while (edge < world->topo.edge_count && world->topo.edges[2 * edge] < range->vertex_end)
            edge++;
        range->edge_end = edge;
        for (uint32_t i = range->vertex_begin; i < range->vertex_end; i++)
            world->vertex_surface[i] = (uint32_t)s;
        for (size_t other = 0; other < world->surface_count; other++)
            world->laws[s * world->surface_count + other] = (contact_law){
                .contact_distance = world->contact_distance,
                .separation_distance = 1.5 * world->contact_distance,
                .static_friction = world->friction,
                .dynamic_friction =
                    world->dynamic_friction < 0.0 ? world->friction : world->dynamic_friction,
                .restitution = world->restitution};
    }
}

static void build_dynamics(mini_world *world) {
    cloth_model_def const def = {.vertex_count = world->cloth_vertex_count,
                                 .surface = &world->topo,
                                 .rest_positions = world->rest,
                                 .materials = &world->material,
                                 .material_count = 1};
    assert_int_equal(cloth_model_build(&world->heap, &def, &world->model, NULL), TULLE_OK);
    assert_int_equal(linear_system_build(&world->heap, &world->model, &world->system), TULLE_OK);
    for (size_t i = 0; i < world->cloth_vertex_count; i++)
        world->inverse_mass[i] = 1.0 / world->model.masses[i];
}

void start_mini_world(mini_world *world) {
    size_t const size = 3 * world->vertex_count * sizeof(double);
    world->scratch = arena_make(&world->heap);
    double **const arrays[] = {&world->rest, &world->velocities, &world->targets,
                               &world->x1,   &world->u,          &world->bounds};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        *arrays[i] = grow(NULL, 1, size);
        memset(*arrays[i], 0, size);
    }
    memcpy(world->rest, world->x0, size);
    for (int i = 0; i < 2; i++) {
        world->particles[i] = grow(NULL, world->vertex_count, 1);
        memset(world->particles[i], 0, world->vertex_count);
    }
    world->inverse_mass = grow(NULL, world->vertex_count, sizeof(double));
    memset(world->inverse_mass, 0, world->vertex_count * sizeof(double));
    world->vertex_surface = grow(NULL, world->vertex_count, sizeof(uint32_t));
    assert_int_equal(topology_build(&world->heap, world->triangles, world->triangle_count,
                                    world->vertex_count, &world->topo),
                     TULLE_OK);
    world->set = (surface_set){
        .topo = &world->topo, .surfaces = world->surfaces, .surface_count = world->surface_count};
    fill_surfaces(world);
    build_dynamics(world);
    if (!world->use_brute_force)
        assert_int_equal(broad_phase_create(&world->heap, &world->set, world->rest,
                                            BROAD_PHASE_REFIT, &world->broad),
                         TULLE_OK);
}

void pin_mini_vertex(mini_world *world, size_t vertex) { world->inverse_mass[vertex] = 0.0; }

void mini_world_destroy(mini_world *world) {
    void *const arrays[] = {world->x0,      world->rest,         world->velocities,
                            world->u,       world->x1,           world->inverse_mass,
                            world->bounds,  world->triangles,    world->vertex_surface,
                            world->targets, world->particles[0], world->particles[1]};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) free(arrays[i]);
    if (world->broad) broad_phase_destroy(world->broad);
    linear_system_destroy(&world->heap, &world->system);
    cloth_model_destroy(&world->heap, &world->model);
    topology_destroy(&world->heap, &world->topo);
    ARRAY_FREE(&world->heap, &world->pairs.vertex_triangle);
    ARRAY_FREE(&world->heap, &world->pairs.edge_edge);
    contact_store_destroy(&world->store, &world->heap);
    row_list_destroy(&world->rows, &world->heap);
    arena_destroy(&world->scratch);
    assert_int_equal(world->heap.bytes_held, 0);
}

contact_scene get_mini_scene(mini_world *world, double h) {
    world->paper = (paper_rules){world->motion_space, world->particles[0], world->particles[1]};
    contact_law largest = {0};
    for (size_t i = 0; i < world->set.surface_count * world->set.surface_count; i++) {
        contact_law const *const law = &world->laws[i];
        largest.contact_distance = fmax(largest.contact_distance, law->contact_distance);
        largest.separation_distance = fmax(largest.separation_distance, law->separation_distance);
    }
    return (contact_scene){.set = &world->set,
                           .vertex_count = world->vertex_count,
                           .cloth_vertex_count = world->cloth_vertex_count,
                           .vertex_surface = world->vertex_surface,
                           .x0 = world->x0,
                           .v0 = world->velocities,
                           .rest = world->rest,
                           .targets = world->targets,
                           .inverse_mass = world->inverse_mass,
                           .laws = world->laws,
                           .largest_contact = largest.contact_distance,
                           .largest_separation = largest.separation_distance,
                           .grains = world->grains,
                           .gravity = vec3_load(world->gravity, 0),
                           .carriers = world->carriers,
                           .ignored = world->ignored,
                           .ignored_count = world->ignored_count,
                           .time_step = h,
                           .settings = world->settings,
                           .response = world->uses_paper ? &paper_response : &coupled_response,
                           .paper = world->uses_paper ? &world->paper : NULL,
                           .heap = &world->heap,
                           .scratch = &world->scratch,
                           .threads = world->threads};
}

/* Brute force: boxes of all features against one another. */
static void get_path_box(const mini_world *world, const double *x1, const uint32_t *vertices,
                         int count, double half, double box[6]) {
    for (int axis = 0; axis < 3; axis++) {
        box[axis] = INFINITY;
        box[3 + axis] = -INFINITY;
        for (int k = 0; k < count; k++) {
            double const a = world->x0[3 * vertices[k] + (uint32_t)axis];
            double const b = x1[3 * vertices[k] + (uint32_t)axis];
            box[axis] = fmin(box[axis], fmin(a, b) - half);
            box[3 + axis] = fmax(box[3 + axis], fmax(a, b) + half);
        }
    }
}

static bool boxes_meet(const double a[6], const double b[6]) {
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] > b[3 + axis] || b[axis] > a[3 + axis]) return false;
    return true;
}

static bool may_meet(const mini_world *world, uint32_t vertex, uint32_t other) {
    return !(world->surfaces[world->vertex_surface[vertex]].is_obstacle &&
             world->surfaces[world->vertex_surface[other]].is_obstacle);
}

static bool shares_vertex(const uint32_t *a, int a_count, const uint32_t *b, int b_count) {
    for (int i = 0; i < a_count; i++)
        for (int j = 0; j < b_count; j++)
            if (a[i] == b[j]) return true;
    return false;
}

static double *make_boxes(const mini_world *world, const double *x1, const uint32_t *features,
                          size_t count, int corners, double half) {
    double *const boxes = grow(NULL, 6 * count, sizeof(double));
    for (size_t i = 0; i < count; i++)
        get_path_box(world, x1, features + (size_t)corners * i, corners, half, boxes + 6 * i);
    return boxes;
}

static tulle_status find_brute_pairs(mini_world *world, const double *x1, double margin) {
    double *const triangles =
        make_boxes(world, x1, world->triangles, world->triangle_count, 3, 0.5 * margin);
    double *const edges =
        make_boxes(world, x1, world->topo.edges, world->topo.edge_count, 2, 0.5 * margin);
    world->pairs.vertex_triangle.count = world->pairs.edge_edge.count = 0;
    bool has_memory = true;
    for (uint32_t v = 0; v < world->vertex_count; v++) {
        double box[6];
        get_path_box(world, x1, &v, 1, 0.5 * margin, box);
        for (uint32_t t = 0; has_memory && t < world->triangle_count; t++) {
            const uint32_t *const corner = world->triangles + 3 * (size_t)t;
            if (!may_meet(world, v, corner[0]) || !boxes_meet(box, triangles + 6 * (size_t)t) ||
                shares_vertex(&v, 1, corner, 3))
                continue;
            has_memory = ARRAY_RESERVE(&world->heap, &world->pairs.vertex_triangle, 1);
            if (has_memory)
                world->pairs.vertex_triangle.data[world->pairs.vertex_triangle.count++] =
                    (feature_pair){v, t};
        }
    }
    for (uint32_t a = 0; a < world->topo.edge_count; a++) {
        const uint32_t *const first = world->topo.edges + 2 * (size_t)a;
        for (uint32_t b = a + 1; has_memory && b < world->topo.edge_count; b++) {
            const uint32_t *const second = world->topo.edges + 2 * (size_t)b;
            if (!may_meet(world, first[0], second[0]) ||
                !boxes_meet(edges + 6 * (size_t)a, edges + 6 * (size_t)b) ||
                shares_vertex(first, 2, second, 2))
                continue;
            has_memory = ARRAY_RESERVE(&world->heap, &world->pairs.edge_edge, 1);
            if (has_memory)
                world->pairs.edge_edge.data[world->pairs.edge_edge.count++] = (feature_pair){a, b};
        }
    }
    free(triangles);
    free(edges);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

static tulle_status renew_pairs(pair_source *source, const double *x1) {
    mini_world *const world = source->context;
    memmove(world->bounds, x1, 3 * world->vertex_count * sizeof(double));
    source->near_pairs = NULL;
    if (world->use_brute_force) return find_brute_pairs(world, x1, source->margin);
    tulle_status status =
        build_trees(world->broad, &world->set, world->x0, x1, source->margin, world->threads);
    if (status == TULLE_OK)
        status =
            find_unsorted_pairs(world->broad, &world->set, world->threads, &world->pairs, NULL);
    return status;
}

static pair_source make_source(mini_world *world) {
    return (pair_source){.pairs = &world->pairs,
                         .bounds = world->bounds,
                         .margin = 1.5 * world->contact_distance,
                         .renew = renew_pairs,
                         .context = world};
}

pair_source find_mini_pairs(mini_world *world, const double *x1) {
    pair_source source = make_source(world);
    assert_int_equal(source.renew(&source, x1), TULLE_OK);
    return source;
}

static void move_obstacles(mini_world *world, double h) {
    memcpy(world->targets, world->x0, 3 * world->vertex_count * sizeof(double));
    for (size_t s = 0; s < world->surface_count; s++) {
        world->carriers[s] = NULL;
        if (!world->surfaces[s].is_obstacle || !world->move) continue;
        world->maps[s] = world->move(world, s, world->time, h);
        world->carriers[s] = &world->maps[s];
        for (uint32_t i = world->surfaces[s].vertex_begin; i < world->surfaces[s].vertex_end; i++)
            vec3_store(world->targets, i,
                       vec3_add(mat3_multiply_vec3(&world->maps[s].matrix, vec3_load(world->x0, i)),
                                world->maps[s].offset));
    }
}

static void predict_paths(mini_world *world, double h) {
    for (size_t i = 0; i < world->vertex_count; i++)
        for (size_t k = 0; k < 3; k++) {
            double const v = world->velocities[3 * i + k] + h * world->gravity[k];
            world->x1[3 * i + k] = world->inverse_mass[i] > 0.0 ? world->x0[3 * i + k] + h * v
                                                                : world->targets[3 * i + k];
        }
}

/* Adds the time since *start to a stage and restarts the clock. */
static void count_time(mini_world *world, int stage, double *start) {
    double const now = timer_now();
    world->stage_seconds[stage] += now - *start;
    *start = now;
}

static tulle_status run_stages(mini_world *world, double h, const motion_system *system) {
    contact_scene const scene = get_mini_scene(world, h);
    pair_source source = make_source(world);
    double start = timer_now();
    predict_paths(world, h);
    tulle_status status = source.renew(&source, world->x1);
    count_time(world, 0, &start);
    if (status == TULLE_OK)
        status = gather_rows(&scene, &world->store, world->x1, &source, &world->rows);
    count_time(world, 1, &start);
    memcpy(world->u, world->velocities, 3 * world->vertex_count * sizeof(double));
    prescribe_motion(&scene, world->u);
    if (status == TULLE_OK)
        status =
            scene.response->solve_motion(&scene, system, &world->rows, world->u, &world->solve);
    count_time(world, 2, &start);
    propose_paths(&scene, world->u, world->x1);
    if (status == TULLE_OK)
        status =
            resolve_impacts(&scene, &source, &world->rows, world->u, world->x1, &world->impacts);
    count_time(world, 3, &start);
    if (status == TULLE_OK)
        status = commit_safely(&scene, &source, world->impacts.is_clean, world->u, world->x1,
                               &world->commit);
    if (status == TULLE_OK) scene.response->keep_contacts(&scene, world->x1, &world->rows);
    count_time(world, 4, &start);
    return status;
}

static tulle_status run_substep(mini_world *world, double h) {
    motion_state const state = {.positions = world->x0,
                                .velocities = world->velocities,
                                .time_step = h,
                                .time = world->time};
    environment const surroundings = {.gravity = vec3_load(world->gravity, 0),
                                      .wind = {.gust_length = 1.0, .gust_time = 1.0}};
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, world->threads, 0.0};
    tulle_status const status = compute_forces(&world->model, &state, &surroundings, options,
                                               &world->scratch, &world->system);
    if (status != TULLE_OK) return status;
    linear_system_operator matrix = {&world->system, world->threads};
    motion_system const motion = {.right_hand_side = world->system.right_hand_side,
                                  .matrix = &world->system.matrix,
                                  .apply = linear_system_apply,
                                  .apply_context = &matrix,
                                  .forces = world->system.forces,
                                  .force_time = world->system.force_time};
    move_obstacles(world, h);
    return run_stages(world, h, &motion);
}

tulle_status step_mini_world(mini_world *world, double h) {
    double remaining = h;
    world->substep_count = 0;
    while (remaining > 1e-9 * h) {
        double const start = timer_now();
        tulle_status status = run_substep(world, remaining);
        if (status == TULLE_OK)
            status = update_contacts(&world->store, &world->heap, &world->rows, remaining);
        world->stage_seconds[5] += timer_now() - start;
        if (status != TULLE_OK) return status;
        if (world->commit.outcome == COMMIT_BLOCKED || ++world->substep_count > 50)
            return TULLE_ERROR_PINCHED;
        double *const swapped = world->x0;
        world->x0 = world->x1;
        world->x1 = swapped;
        memcpy(world->velocities, world->u, 3 * world->vertex_count * sizeof(double));
        world->time += remaining * world->commit.fraction;
        remaining -= remaining * world->commit.fraction;
        world->rescue_count += world->commit.impact_zones + world->commit.component_scalings +
                               world->commit.global_scalings;
    }
    return TULLE_OK;
}

size_t judge_mini_world(const mini_world *world) {
    tulle_check_body bodies[MINI_MAX_SURFACES];
    uint32_t *const local = grow(NULL, 3 * world->triangle_count, sizeof(uint32_t));
    for (size_t s = 0; s < world->surface_count; s++) {
        const surface_range *const range = &world->surfaces[s];
        for (size_t i = 3 * (size_t)range->triangle_begin; i < 3 * (size_t)range->triangle_end; i++)
            local[i] = world->triangles[i] - range->vertex_begin;
        bodies[s] = (tulle_check_body){.mesh = {world->x0 + 3 * (size_t)range->vertex_begin,
                                                range->vertex_end - range->vertex_begin,
                                                local + 3 * (size_t)range->triangle_begin,
                                                range->triangle_end - range->triangle_begin},
                                       .is_obstacle = range->is_obstacle};
    }
    tulle_check_result result;
    assert_int_equal(tulle_check_intersections(bodies, world->surface_count, 1, &result, NULL),
                     TULLE_OK);
    size_t const count = result.pair_count;
    tulle_check_result_destroy(&result);
    free(local);
    return count;
}

uint64_t hash_mini_world(const mini_world *world) {
    size_t const size = 3 * world->vertex_count * sizeof(double);
    uint64_t const hash =
        hash_bytes(hash_bytes(HASH_SEED, world->x0, size), world->velocities, size);
    return contact_store_hash(&world->store, hash);
}

mini_grid make_mini_grid(uint32_t columns, uint32_t rows, vec3 origin, vec3 across, vec3 along) {
    mini_grid grid = {.positions = grow(NULL, 3 * (size_t)columns * rows, sizeof(double)),
                      .triangles = grow(NULL, 6 * (size_t)columns * rows, sizeof(uint32_t))};
    size_t triangle_count = 0;
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t const a = j * columns + i, b = a + 1, c = a + columns, d = c + 1;
            vec3 const p = vec3_add_scaled(origin, across, (double)i / (columns - 1));
            vec3_store(grid.positions, a, vec3_add_scaled(p, along, (double)j / (rows - 1)));
            if (i + 1 == columns || j + 1 == rows) continue;
            uint32_t const even[6] = {a, b, d, a, d, c}, odd[6] = {a, b, c, b, d, c};
            memcpy(grid.triangles + 3 * triangle_count, (i + j) % 2 ? odd : even, sizeof even);
            triangle_count += 2;
        }
    grid.mesh = (mini_mesh){grid.positions, (size_t)columns * rows, grid.triangles, triangle_count};
    return grid;
}

void free_mini_grid(mini_grid *grid) {
    free(grid->positions);
    free(grid->triangles);
}

void add_mini_spike(mini_world *world, vec3 foot, double height) {
    double positions[12];
    for (size_t k = 0; k < 3; k++) {
        double const angle = 2.0943951 * (double)k + 0.1;
        vec3_store(positions, k,
                   vec3_add(foot, vec3_make(0.04 * cos(angle), 0.04 * sin(angle), 0.0)));
    }
    vec3_store(positions, 3, vec3_add(foot, vec3_make(0.0, 0.0, height)));
    uint32_t const triangles[12] = {0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 2, 1};
    add_mini_surface(world, (mini_mesh){positions, 4, triangles, 4}, true);
}

double find_mini_stretch(const mini_world *world) {
    double largest = 0.0;
    for (size_t i = 0; i < world->model.spring_count; i++) {
        const cloth_spring *const spring = &world->model.springs[i];
        vec3 const d = vec3_sub(vec3_load(world->x0, spring->vertices[0]),
                                vec3_load(world->x0, spring->vertices[1]));
        largest = fmax(largest, vec3_norm(d) / spring->rest_length);
    }
    return largest;
}

void make_coarse_sheet_over_cloth(mini_world *world, uint64_t *random) {
    *world = mini_world_make();
    double const angle = 6.28 * random_uniform(random);
    vec3 const across = {0.15 * cos(angle), 0.15 * sin(angle), 0.0};
    vec3 const along = {-0.15 * sin(angle), 0.15 * cos(angle), 0.0};
    mini_grid sheet = make_mini_grid(8, 9, vec3_make(0.0, 0.0, HEIGHT_OVER_PLANE), across, along);
    mini_grid plane = make_mini_grid(21, 21, vec3_make(-0.3, -0.31, 0.0), vec3_make(0.6, 0.01, 0.0),
                                     vec3_make(0.013, 0.6, 0.0));
    add_mini_surface(world, sheet.mesh, false);
    add_mini_surface(world, plane.mesh, false);
    start_mini_world(world);
    free_mini_grid(&sheet);
    free_mini_grid(&plane);
}

size_t count_sheet_vertices(const mini_world *world) { return world->set.surfaces[0].vertex_end; }

void gather_at_rest(mini_world *world, double h) {
    contact_scene const scene = get_mini_scene(world, h);
    memcpy(world->x1, world->x0, 3 * world->vertex_count * sizeof(double));
    pair_source source = find_mini_pairs(world, world->x1);
    assert_int_equal(gather_rows(&scene, &world->store, world->x1, &source, &world->rows),
                     TULLE_OK);
}
