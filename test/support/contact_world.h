/* test/support/contact_world.h - a small world for tests of contact: cloths of one material and
 * obstacles in a tulle_world made by the public interface, and views of what lies inside it.
 *
 * A test either steps the world, and then looks at its state, rows and report; or it sets the state
 * and the paths itself and runs single stages on contact_scene and pair_source as the world makes
 * them. Everything fails the running cmocka test on an error of the library, but
 * step_contact_world. */
#ifndef TULLE_TEST_SUPPORT_CONTACT_WORLD_H
#define TULLE_TEST_SUPPORT_CONTACT_WORLD_H

#include "step/step_context.h"
#include "world/world_state.h"

enum { CONTACT_MAX_SURFACES = 16, CONTACT_MAX_PINS = 16 };

/* A mesh to add; arrays are copied. */
typedef struct contact_mesh {
    const double *positions;
    size_t vertex_count;
    const uint32_t *triangles;
    size_t triangle_count;
} contact_mesh;

typedef struct contact_world {
    /* Settings, before the start. */
    tulle_world_def def;
    tulle_material material; /* of all cloths */
    vec3 grain;              /* of all cloths; counts where material.friction_across is not 1 */
    double friction, dynamic_friction,
        restitution;                            /* of all pairs; negative dynamic: as friction */
    tulle_motion motions[CONTACT_MAX_SURFACES]; /* of obstacles, borrowed until the start */
    const double *rest_positions;               /* of the first cloth; null: as it starts */
    uint32_t pinned[CONTACT_MAX_PINS];          /* vertices of the first cloth */
    size_t pin_count;
    /* The world, once it has started. */
    tulle_world *world;
    tulle_step_report report; /* of the last step */
    tulle_error error;        /* of the last step, where it failed */
    uint64_t rescue_count;    /* over the whole run */
    /* Views of it; a step makes them anew. */
    size_t surface_count, vertex_count, cloth_vertex_count, triangle_count;
    const surface_range *surfaces;
    const topology *topo;
    const surface_set *set;
    const uint32_t *triangles, *vertex_surface;
    double *x0, *velocities, *targets, *inverse_mass;
    row_list *rows; /* of the last step; before it, those that stages make */
    contact_store *store;
    const pair_list *pairs;
    memory *heap;
    arena *scratch;
    /* What single stages are given and give: the test's own. */
    contact_settings settings; /* at first those of the world */
    double *u, *x1;            /* all vertices */
    double *bounds, *certified_end;
    affine_map maps[CONTACT_MAX_SURFACES];
    const affine_map *carriers[CONTACT_MAX_SURFACES];
    uint8_t *particles; /* by the paper's response, after a step */
    step_context context;
    impact_report impacts;
    commit_report commit;
    /* Meshes that were added, until the start. */
    contact_mesh meshes[CONTACT_MAX_SURFACES];
    bool is_obstacle[CONTACT_MAX_SURFACES];
} contact_world;

/* Defaults; fill the settings, add surfaces, then start. After the start the struct must not move.
 */
contact_world contact_world_make(void);
void contact_world_destroy(contact_world *world);
/* Cloths first, then obstacles; returns the surface index. */
size_t add_contact_surface(contact_world *world, contact_mesh mesh, bool is_obstacle);
void start_contact_world(contact_world *world);

/* What contact sees in a step of h, with the world's targets, the test's settings and carriers. */
contact_scene get_contact_scene(contact_world *world, double h);
/* Finds pairs of x0 -> x1 and returns a source that renews them. */
pair_source *find_contact_pairs(contact_world *world, const double *x1);
/* A step of h by the world. */
tulle_status step_contact_world(contact_world *world, double h);
/* Number of intersecting triangle pairs by the judge. */
size_t judge_contact_world(const contact_world *world);

/* A grid of columns x rows vertices with origin and two spanning vectors; release with free. */
typedef struct contact_grid {
    double *positions;
    uint32_t *triangles;
    contact_mesh mesh;
} contact_grid;
contact_grid make_contact_grid(uint32_t columns, uint32_t rows, vec3 origin, vec3 across,
                               vec3 along);
void free_contact_grid(contact_grid *grid);

/* A spike of three sides on a triangle of 4 cm around `foot`, tip upwards. [m] */
void add_contact_spike(contact_world *world, vec3 foot, double height);
/* A whole world: a sheet of 8 x 9 vertices, turned by chance, HEIGHT_OVER_PLANE over another
 * cloth of cells of 3 cm. */
#define HEIGHT_OVER_PLANE 3e-3 /* [m] the contact distance */
void make_coarse_sheet_over_cloth(contact_world *world, uint64_t *random);
size_t count_sheet_vertices(const contact_world *world);
/* Rows of the state as it is, as if nothing moved in a step of h. */
void gather_at_rest(contact_world *world, double h);

/* Largest length of an edge over its rest length. */
double measure_contact_stretch(const contact_world *world);

#endif
