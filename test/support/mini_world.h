/* test/support/mini_world.h - a small world for tests of the contact stages: cloths of one
 * material and moving obstacles in the arrays that contact reads, and a step that chains the
 * stages. Everything fails the running cmocka test on an error of the library, but step_mini_world.
 */
#ifndef TULLE_TEST_SUPPORT_MINI_WORLD_H
#define TULLE_TEST_SUPPORT_MINI_WORLD_H

#include "contact/commit/commit_safely.h"
#include "contact/commit/resolve_impacts.h"
#include "contact/response.h"
#include "contact/rows/gather_rows.h"
#include "contact/rows/stick_anchors.h"
#include "contact/solve/solve_motion.h"
#include "detect/trees/broad_phase.h"
#include "dynamics/compute_forces.h"

enum { MINI_MAX_SURFACES = 16 };

/* A mesh to add; arrays are copied. */
typedef struct mini_mesh {
    const double *positions;
    size_t vertex_count;
    const uint32_t *triangles;
    size_t triangle_count;
} mini_mesh;

typedef struct mini_world {
    memory heap;
    arena scratch;
    /* Settings, before the first step. */
    contact_settings settings;
    double contact_distance, friction, dynamic_friction, restitution; /* of all pairs; negative
                                                                         dynamic: as friction */
    double gravity[3];
    const surface_grain *grains; /* one a surface, borrowed; null: none */
    tulle_material material;     /* of all cloths */
    int threads;
    bool uses_paper; /* response of the paper, with this motion space */
    tulle_motion_space motion_space;
    bool use_brute_force; /* all pairs with meeting boxes instead of the broad phase */
    /* Affine motion of an obstacle: fills its targets from its x0 for a step h at time t. */
    affine_map (*move)(const struct mini_world *world, size_t surface, double time, double h);
    /* State. */
    size_t surface_count, vertex_count, cloth_vertex_count, triangle_count;
    surface_range surfaces[MINI_MAX_SURFACES];
    double *x0, *rest, *velocities, *inverse_mass, *targets, *x1, *u, *bounds;
    uint32_t *triangles, *vertex_surface;
    topology topo;
    contact_law laws[MINI_MAX_SURFACES * MINI_MAX_SURFACES];
    affine_map maps[MINI_MAX_SURFACES];
    const affine_map *carriers[MINI_MAX_SURFACES];
    uint64_t *ignored;
    size_t ignored_count;
    surface_set set;
    broad_phase *broad;
    pair_list pairs;
    contact_store store;
    row_list rows;
    uint8_t *particles[2]; /* particle_state of each cloth vertex: before and after a step */
    paper_rules paper;
    double time;
    cloth_model model;
    linear_system system;
    /* Reports of the last (sub)step. */
    solve_report solve;
    impact_report impacts;
    commit_report commit;
    int substep_count;
    uint64_t rescue_count;   /* over the whole run */
    double stage_seconds[6]; /* over the run: pairs, gather, solve, impacts, commit, all */
} mini_world;

/* Defaults; fill the settings, add surfaces, then start. The struct must not move after that. */
mini_world mini_world_make(void);
void mini_world_destroy(mini_world *world);
/* Cloths first, then obstacles; returns the surface index. */
size_t add_mini_surface(mini_world *world, mini_mesh mesh, bool is_obstacle);
/* Masses, springs, laws, trees. After this no surface may be added. */
void start_mini_world(mini_world *world);
/* Gives vertex infinite mass. */
void pin_mini_vertex(mini_world *world, size_t vertex);
/* What contact sees for a (sub)step of h. */
contact_scene get_mini_scene(mini_world *world, double h);
/* Finds pairs of x0 -> x1 and returns a source that renews them. */
pair_source find_mini_pairs(mini_world *world, const double *x1);
/* Moves the world by h; substeps where time was shortened, at most 50 times. */
tulle_status step_mini_world(mini_world *world, double h);
/* Number of intersecting triangle pairs by the judge. */
size_t judge_mini_world(const mini_world *world);
uint64_t hash_mini_world(const mini_world *world);

/* A grid of columns x rows vertices with origin and two spanning vectors; release with free. */
typedef struct mini_grid {
    double *positions;
    uint32_t *triangles;
    mini_mesh mesh;
} mini_grid;
mini_grid make_mini_grid(uint32_t columns, uint32_t rows, vec3 origin, vec3 across, vec3 along);
void free_mini_grid(mini_grid *grid);

/* A spike of three sides on a triangle of 4 cm around `foot`, tip upwards. [m] */
void add_mini_spike(mini_world *world, vec3 foot, double height);
/* A whole world: a sheet of 8 x 9 vertices, turned by chance, HEIGHT_OVER_PLANE over another
 * cloth of cells of 3 cm. */
#define HEIGHT_OVER_PLANE 3e-3 /* [m] the contact distance */
void make_coarse_sheet_over_cloth(mini_world *world, uint64_t *random);
size_t count_sheet_vertices(const mini_world *world);
/* Rows of the state as it is, as if nothing moved in a step of h. */
void gather_at_rest(mini_world *world, double h);

/* Largest length of an edge over its rest length. */
double find_mini_stretch(const mini_world *world);

#endif
