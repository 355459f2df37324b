/* test/support/contact_world.c - see contact_world.h. */
#include "support/contact_world.h"
#include "support/paper_options.h"
#include "support/pins.h"

#include "base/hash.h"
#include "step/script.h"
#include "support/test_support.h"
#include "tulle/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

contact_world contact_world_make(void) {
    contact_world world = {.def = tulle_world_def_default(),
                           .friction = 0.5,
                           .dynamic_friction = -1.0,
                           .material = {.area_density = 0.25,
                                        .springs.stretch_stiffness = 1500.0,
                                        .springs.bend_stiffness = 1e-5,
                                        .stretch_damping = 5e-4,
                                        .bend_damping = 2e-3,
                                        .friction_across = 1.0}};
    world.def.membrane = TULLE_MEMBRANE_SPRINGS;
    world.def.contact_distance = 3e-3;
    world.def.minimum_gap = default_contact_settings.minimum_gap;
    change_paper(&world.def)->detection.method = TULLE_DETECT_REFIT; /* no pair is left out */
    world.def.threads = 1;
    world.def.wind.drag_coefficient = 0.0;
    return world;
}

static void *copy_bytes(const void *data, size_t size) {
    void *const copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, data, size);
    return copy;
}

static void *make_zeroed(size_t count, size_t size) {
    void *const zeroed = calloc(count ? count : 1, size);
    assert_non_null(zeroed);
    return zeroed;
}

size_t add_contact_surface(contact_world *world, contact_mesh mesh, bool is_obstacle) {
    size_t const surface = world->surface_count++;
    assert_true(surface < CONTACT_MAX_SURFACES);
    world->meshes[surface] = (contact_mesh){
        copy_bytes(mesh.positions, 3 * mesh.vertex_count * sizeof(double)), mesh.vertex_count,
        copy_bytes(mesh.triangles, 3 * mesh.triangle_count * sizeof(uint32_t)),
        mesh.triangle_count};
    world->is_obstacle[surface] = is_obstacle;
    return surface;
}

/* The views, after the start and after a step, which swaps what they show. */
static void look_inside(contact_world *world) {
    tulle_world *const inside = world->world;
    world->vertex_count = inside->model.vertex_count;
    world->cloth_vertex_count = inside->model.cloth_vertex_count;
    world->triangle_count = inside->model.topo.triangle_count;
    world->surfaces = inside->work.surfaces;
    world->topo = &inside->model.topo;
    world->set = &inside->work.set;
    world->triangles = inside->model.topo.triangles;
    world->vertex_surface = inside->model.vertex_surface;
    world->x0 = inside->now.positions;
    world->velocities = inside->now.velocities;
    world->targets = inside->work.targets;
    world->inverse_mass = inside->work.active_inverse_masses;
    world->store = &inside->now.contacts;
    world->pairs = &inside->work.pairs;
    world->heap = &inside->heap;
    world->scratch = &inside->work.scratch;
}

void start_contact_world(contact_world *world) {
    double const friction = world->friction, dynamic = world->dynamic_friction;
    world->def.friction_cloth_cloth = friction;
    world->def.dynamic_friction_cloth_cloth = dynamic;
    world->material.friction = friction;
    world->material.dynamic_friction = dynamic;
    world->material.restitution = world->restitution;
    assert_int_equal(tulle_world_create(&world->def, &world->world, NULL), TULLE_OK);
    for (size_t s = 0; s < world->surface_count; s++) {
        const contact_mesh *const mesh = &world->meshes[s];
        tulle_mesh_view const view = {mesh->positions, mesh->vertex_count, mesh->triangles,
                                      mesh->triangle_count};
        char name[32];
        snprintf(name, sizeof name, "surface %zu", s);
        tulle_error error = {0};
        tulle_cloth_def cloth = tulle_cloth_def_default();
        tulle_obstacle_def obstacle = tulle_obstacle_def_default();
        tulle_pin const pins = make_pin(world->pinned, world->pin_count, (double)INFINITY);
        cloth.mesh = obstacle.mesh = view;
        cloth.name = obstacle.name = name;
        cloth.material = world->material;
        vec3_store(cloth.grain, 0, world->grain);
        if (s == 0) cloth.rest_positions = world->rest_positions;
        if (s == 0 && world->pin_count > 0) {
            cloth.pins = &pins;
            cloth.pin_count = 1;
        }
        obstacle.friction = friction;
        obstacle.dynamic_friction = dynamic;
        obstacle.restitution = world->restitution;
        obstacle.motion = world->motions[s];
        tulle_status const status =
            world->is_obstacle[s] ? tulle_world_add_obstacle(world->world, &obstacle, NULL, &error)
                                  : tulle_world_add_cloth(world->world, &cloth, NULL, &error);
        if (status != TULLE_OK) fail_msg("surface %zu: %s", s, error.message);
    }
    tulle_error error = {0};
    if (tulle_world_start(world->world, &error) != TULLE_OK) fail_msg("%s", error.message);
    look_inside(world);
    world->rows = &world->world->work.rows;
    world->u = make_zeroed(3 * world->vertex_count, sizeof(double));
    world->x1 = make_zeroed(3 * world->vertex_count, sizeof(double));
    world->bounds = make_zeroed(3 * world->vertex_count, sizeof(double));
    world->certified_end = make_zeroed(3 * world->vertex_count, sizeof(double));
    world->particles = make_zeroed(world->vertex_count, 1);
    step_work *const work = &world->world->work;
    world->context = (step_context){.model = &world->world->model, .work = work, .sub = &work->sub};
    world->settings = get_contact_scene(world, 1.0).settings;
    assert_int_equal(step_script_targets(&world->world->model, work, 0.0, 0.0, NULL),
                     TULLE_OK); /* pins have no mass */
}

void contact_world_destroy(contact_world *world) {
    tulle_world_destroy(world->world);
    for (size_t s = 0; s < world->surface_count; s++) {
        free((void *)(uintptr_t)world->meshes[s].positions);
        free((void *)(uintptr_t)world->meshes[s].triangles);
    }
    free(world->u);
    free(world->x1);
    free(world->bounds);
    free(world->certified_end);
    free(world->particles);
}

contact_scene get_contact_scene(contact_world *world, double h) {
    step_context *const context = &world->context;
    context->state = &world->world->now;
    context->work->whole_step = context->sub->time_step = h;
    context->work->carriers.used = world->carriers;
    context->sub->paper = (paper_rules){get_paper(&world->def).motion_space,
                                        context->state->particles, world->particles};
    contact_scene scene = step_make_scene(context);
    if (world->settings.minimum_gap > 0.0) scene.settings = world->settings;
    return scene;
}

pair_source *find_contact_pairs(contact_world *world, const double *x1) {
    step_context *const context = &world->context;
    context->state = &world->world->now;
    context->work->report = &world->report; /* a step lets go of it */
    context->sub->bounds = world->bounds;
    context->sub->certified_end = world->certified_end;
    context->source = step_make_pair_source(context);
    assert_int_equal(context->source.renew(&context->source, x1), TULLE_OK);
    return &context->source;
}

tulle_status step_contact_world(contact_world *world, double h) {
    tulle_status const status = tulle_world_step(world->world, h, &world->report, &world->error);
    if (status != TULLE_OK) print_message("%s\n", world->error.message);
    look_inside(world);
    world->rows = status == TULLE_OK ? &world->world->accepted_rows : &world->world->work.rows;
    world->rescue_count += world->report.rescue_impact_zones +
                           world->report.rescue_component_scalings +
                           world->report.rescue_global_scalings;
    return status;
}

size_t judge_contact_world(const contact_world *world) {
    tulle_check_body bodies[CONTACT_MAX_SURFACES];
    for (size_t s = 0; s < world->surface_count; s++) {
        const contact_mesh *const mesh = &world->meshes[s];
        bodies[s] =
            (tulle_check_body){.mesh = {world->x0 + 3 * (size_t)world->surfaces[s].vertex_begin,
                                        mesh->vertex_count, mesh->triangles, mesh->triangle_count},
                               .is_obstacle = world->is_obstacle[s]};
    }
    tulle_check_result result;
    assert_int_equal(tulle_check_intersections(bodies, world->surface_count, 1, &result, NULL),
                     TULLE_OK);
    size_t const count = result.pair_count;
    tulle_check_result_destroy(&result);
    return count;
}

contact_grid make_contact_grid(uint32_t columns, uint32_t rows, vec3 origin, vec3 across,
                               vec3 along) {
    contact_grid grid = {.positions = make_zeroed(3 * (size_t)columns * rows, sizeof(double)),
                         .triangles = make_zeroed(6 * (size_t)columns * rows, sizeof(uint32_t))};
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
    grid.mesh =
        (contact_mesh){grid.positions, (size_t)columns * rows, grid.triangles, triangle_count};
    return grid;
}

void free_contact_grid(contact_grid *grid) {
    free(grid->positions);
    free(grid->triangles);
}

void add_contact_spike(contact_world *world, vec3 foot, double height) {
    double positions[12];
    for (size_t k = 0; k < 3; k++) {
        double const angle = 2.0943951 * (double)k + 0.1;
        vec3_store(positions, k,
                   vec3_add(foot, vec3_make(0.04 * cos(angle), 0.04 * sin(angle), 0.0)));
    }
    vec3_store(positions, 3, vec3_add(foot, vec3_make(0.0, 0.0, height)));
    uint32_t const triangles[12] = {0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 2, 1};
    add_contact_surface(world, (contact_mesh){positions, 4, triangles, 4}, true);
}

double measure_contact_stretch(const contact_world *world) {
    const cloth_model *const model = world->world->model.cloth_model;
    double largest = 0.0;
    for (size_t i = 0; i < model->edge_count; i++) {
        const cloth_spring *const spring = &model->springs[i];
        vec3 const d = vec3_sub(vec3_load(world->x0, spring->vertices[0]),
                                vec3_load(world->x0, spring->vertices[1]));
        largest = fmax(largest, vec3_norm(d) / spring->rest_length);
    }
    return largest;
}

void make_coarse_sheet_over_cloth(contact_world *world, uint64_t *random) {
    *world = contact_world_make();
    double const angle = 6.28 * random_uniform(random);
    vec3 const across = {0.15 * cos(angle), 0.15 * sin(angle), 0.0};
    vec3 const along = {-0.15 * sin(angle), 0.15 * cos(angle), 0.0};
    contact_grid sheet =
        make_contact_grid(8, 9, vec3_make(0.0, 0.0, HEIGHT_OVER_PLANE), across, along);
    contact_grid plane = make_contact_grid(21, 21, vec3_make(-0.3, -0.31, 0.0),
                                           vec3_make(0.6, 0.01, 0.0), vec3_make(0.013, 0.6, 0.0));
    add_contact_surface(world, sheet.mesh, false);
    add_contact_surface(world, plane.mesh, false);
    start_contact_world(world);
    free_contact_grid(&sheet);
    free_contact_grid(&plane);
}

size_t count_sheet_vertices(const contact_world *world) { return world->surfaces[0].vertex_end; }

void gather_at_rest(contact_world *world, double h) {
    contact_scene const scene = get_contact_scene(world, h);
    memcpy(world->x1, world->x0, 3 * world->vertex_count * sizeof(double));
    pair_source *const source = find_contact_pairs(world, world->x1);
    assert_int_equal(gather_rows(&scene, world->store, world->x1, source, world->rows), TULLE_OK);
}
