/* contact/contact_types.h - the data of the contact stages 5 and 7 to 10: settings, one step as
 * contact sees it, rows, and the store that lives from step to step.
 *
 * All vertices share one numbering, cloths first (0 .. cloth_vertex_count - 1), then obstacles. The
 * unknown of a step is u, the mean displacement velocity of every vertex: x1 = x0 + h u. Vertices
 * of inverse mass 0 (obstacles, pins) end the step where `targets` says.
 *
 * Based on: Moreau 1988 and Jean 1999 (contact dynamics, projected Gauss-Seidel on total impulses);
 * Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects, 2005. */
#ifndef TULLE_CONTACT_CONTACT_TYPES_H
#define TULLE_CONTACT_CONTACT_TYPES_H

#include "base/arena.h"
#include "base/stop.h"
#include "detect/surface_set.h"
#include "dynamics/rigid_body.h"
#include "tulle/paper.h"

/* Numbers that shape the response. default_contact_settings gives each a value and a reason. */
typedef struct contact_settings {
    double minimum_gap;     /* [m] xi: no accepted state undercuts it */
    int impulse_sweeps;     /* projected Gauss-Seidel sweeps a round, each forward and backward */
    int impact_rounds;      /* rounds of stage 8 */
    int zone_rounds;        /* rescue: rounds of impact zones */
    int component_rounds;   /* rescue: rounds of component scaling */
    double slip_speed;      /* [m/s] a contact that starts slower is at rest: static friction */
    double push_out_speed;  /* [m/s] a row inside the contact distance asks for this at most */
    double slope_tolerance; /* sine of the angle by which a new row's normal may lie outside of a
                               normal cone */
    double old_slope_tolerance; /* as above, for a row that continues a contact */
    /* Rounds end when all of these hold: */
    double settled_speed;  /* [m/s] violations, and misfits of friction, have at most this root mean
                              square */
    double settled_drift;  /* [m/s] errors of friction give each cloth at most this speed */
    double settled_slip;   /* [m/s] a cloth that rows hold slips as a whole at most this fast */
    double settled_misfit; /* [m/s] the error of friction of each row is at most this */
    double settled_most;   /* [m/s] each row is violated by at most this speed */
    double hard_stiffness; /* penalty of a hard row over its share of diag(A) */
    double anchor_share;   /* a step undoes this part of the offset of a contact that sticks */
    double hard_friction;  /* penalty of slip over that of the normal part */
    double push_out_softness; /* compliance of a row times its share of diag(A) */
} contact_settings;

extern const contact_settings default_contact_settings;

/* How two surfaces touch. */
typedef struct contact_law {
    double contact_distance;    /* [m] delta_c: where a contact carries load */
    double separation_distance; /* [m] delta_s >= delta_c: where it ends */
    double static_friction;     /* Coulomb coefficient of a contact that does not slide */
    double dynamic_friction;    /* <= static_friction, of one that slides */
    double restitution;         /* 0 .. 1, rebound speed over impact speed */
} contact_law;

/* How friction of a surface depends on the direction. */
typedef struct surface_grain {
    vec3 direction; /* of the grain in the rest shape, of any length */
    double across;  /* factor on friction at right angles to it; 1: no grain */
} surface_grain;

/* x -> matrix x + offset takes every vertex of a surface from its x0 to its target. */
typedef struct affine_map {
    mat3 matrix;
    vec3 offset; /* [m] */
} affine_map;

/* How a vertex took part in contact by the paper's response, kept from step to step. */
typedef enum particle_state { PARTICLE_FREE, PARTICLE_SLIDES, PARTICLE_STICKS } particle_state;

/* What the paper's response reads and writes (paper/paper_response.c). */
typedef struct paper_rules {
    tulle_motion_space motion_space;
    uint8_t *before; /* particle_state of each cloth vertex at the start of the step */
    uint8_t *after;  /* as above, at its end; filled by the response */
} paper_rules;

/* The impulse on an axis of a driven body. */
typedef enum drive_state {
    DRIVE_FOLLOWS,  /* push - gain u */
    DRIVE_AT_MOST,  /* the limit, forwards */
    DRIVE_AT_LEAST, /* the limit, backwards */
    DRIVE_IS_OFF    /* nothing */
} drive_state;

/* What drives and locks a body in one (sub)step, for each axis of the world: three of its centre,
 * then three of its turn. The solve finds states and impulses (solve/body_drives.h). */
enum { BODY_AXES = 6 };
typedef struct body_drive {
    bool is_locked[BODY_AXES];
    double gains[BODY_AXES];  /* [kg], [kg m^2] >= 0 */
    double pushes[BODY_AXES]; /* [N s], [N m s] */
    double limits[BODY_AXES]; /* [N s], [N m s] >= 0 */
    drive_state states[BODY_AXES];
    double impulses[BODY_AXES]; /* [N s], [N m s] of the drive */
} body_drive;

/* A vector without its parts along the locked axes of the centre. */
static inline vec3 mask_locked(const body_drive *drive, vec3 a) {
    return vec3_make(drive->is_locked[0] ? 0.0 : a.x, drive->is_locked[1] ? 0.0 : a.y,
                     drive->is_locked[2] ? 0.0 : a.z);
}

/* A rigid body in one (sub)step. It has two slots among the vertices, after those of cloths. The
 * slot of body b is cloth_vertex_count + 2 b, where u is the velocity V of its centre. In the next
 * slot u is its angular velocity w, for the inertia at x0. The positions of the two slots are the
 * centre, and the orientation as modified Rodrigues parameters. The body's own vertices go where
 * its motion places them; nothing reads their u. */
typedef struct contact_body {
    const rigid_body *body;
    const double *points;              /* [m] of its vertices, in the body's coordinates */
    uint32_t vertex_begin, vertex_end; /* its surface's vertices */
    bool is_free;      /* else scripted or absent: the solve has no unknowns for it */
    rigid_state start; /* at x0 */
    mat3 inertia;      /* about the centre, in the world's axes at x0 */
    /* The implicit solve multiplies mass and inertia by these: 1 + alpha damping. */
    double mass_factor, inertia_factor;
    bool has_own_answers; /* in the solve it answers otherwise than by its mass and inertia alone */
    body_drive *drive;    /* null: nothing drives or locks it */
    vec3 inverse_mass; /* [1/kg] of each axis. These two answer an impulse. They include damping and
                          gains of the drive, and are zero along locks */
    mat3 inverse_inertia;
    vec3 momentum, spin; /* [N s], [N m s] right-hand sides: of the start, or by BDF2 with its
                            history; with gravity and forces of the host */
    mat3 turn;           /* predicted for the step */
    vec3 turn_vector;    /* [rad] h w of the prediction */
} contact_body;

typedef struct contact_response contact_response;

/* All that contact reads of one (sub)step. Borrowed. It is constant while the stages run; only
 * `scratch` and `heap` are used up. */
typedef struct contact_scene {
    const surface_set *set;
    size_t vertex_count, cloth_vertex_count;
    const uint32_t *vertex_surface; /* vertex_count: index into set->surfaces */
    const double *x0;               /* [m] 3 * vertex_count, start of the step */
    const double *v0;      /* [m/s] 3 * vertex_count, velocities at the start; null: at rest */
    const double *rest;    /* [m] 3 * vertex_count; read of cloths, and of surfaces with a grain */
    const double *targets; /* [m] 3 * vertex_count; only read where inverse_mass is 0 */
    const double *inverse_mass; /* [1/kg] vertex_count; 0: obstacles and pinned vertices */
    const contact_law *laws;    /* surface_count^2, row-major, symmetric */
    double largest_contact, largest_separation; /* [m] distances of all laws */
    const surface_grain *grains;                /* surface_count; null: none has one */
    /* [m] vertex_count: how much room there was at the start, INFINITY: enough. Contact of cloth
     * keeps no more distance, where its distance is the automatic one of the cloth. Null: there is
     * room everywhere */
    const double *rooms;
    const double *automatic; /* [m] surface_count, read with rooms; 0: its thickness is given */
    contact_body *bodies;    /* body_count */
    size_t body_count;
    const uint32_t *surface_bodies;    /* surface_count: body of each surface, or TULLE_NONE; may be
                                          null where body_count is 0 */
    vec3 gravity;                      /* [m/s^2] */
    const affine_map *const *carriers; /* surface_count entries, each may be null; null: none. How
                                          cloth on a scripted obstacle moves with it */
    const uint64_t *ignored;           /* triangle pairs that may intersect, ascending, see
                                          ignored_pair_key; null: none */
    size_t ignored_count;
    const uint32_t *tied_surfaces; /* cloth_vertex_count: surface at which each vertex is held
                                      rigidly, or TULLE_NONE; null: none is */
    const double *tied_places; /* [m] 3 * cloth_vertex_count: where each of these vertices is held,
                                  in the rest shape of its holder */
    double time_step;          /* [s] h > 0 */
    const contact_response *response; /* how contact answers, see response.h */
    const paper_rules *paper;         /* read by the paper's response alone; else null */
    contact_settings settings;
    memory *heap;
    arena *scratch;  /* each stage releases its memory */
    stop_poll *stop; /* asked often. When it says stop, stages end with TULLE_ERROR_INTERRUPTED, or
                        with any result where they have no status. May be null */
    int threads;
} contact_scene;

/* Key of the triangle pair {a, b} in contact_scene.ignored. A feature pair is ignored if every
 * triangle that owns the first feature forms an ignored pair with every triangle that owns the
 * second. So no pair of triangles outside the list can begin to intersect. */
static inline uint64_t ignored_pair_key(uint32_t a, uint32_t b) {
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

/* Unknowns of the solve come first in u: cloth vertices and the slots of bodies. */
static inline size_t get_solved_count(const contact_scene *scene) {
    return scene->cloth_vertex_count + 2 * scene->body_count;
}

static inline uint32_t get_body_slot(const contact_scene *scene, size_t body) {
    return (uint32_t)(scene->cloth_vertex_count + 2 * body);
}

static inline bool is_slot(const contact_scene *scene, size_t vertex) {
    return vertex >= scene->cloth_vertex_count && vertex < get_solved_count(scene);
}

/* The free body that a vertex belongs to, or TULLE_NONE. */
static inline uint32_t find_body(const contact_scene *scene, uint32_t vertex) {
    if (scene->body_count == 0 || vertex < get_solved_count(scene)) return TULLE_NONE;
    uint32_t const body = scene->surface_bodies[scene->vertex_surface[vertex]];
    return body != TULLE_NONE && scene->bodies[body].is_free ? body : TULLE_NONE;
}

typedef enum row_state { ROW_OPEN, ROW_STICKS, ROW_SLIDES } row_state;

/* A triangle of cloth that turns carries along a vertex that is tied at a height over it: its
 * corner k adds arms[k] (normal . u)  to the row's velocity, and an impulse p on the row gives it
 * as much as normal (arms[k] . p)  more. Without that a tie would turn cloth for ever. */
typedef struct row_tilt {
    vec3 normal;  /* unit normal of the triangle */
    vec3 arms[3]; /* height times the gradients of the barycentric coordinates */
} row_tilt;

/* Where a row is and how it moves. Written when rows are made: in stage 5, or in stage 8 for an
 * impact. All later stages read it. Sweeps read only `weights` and what follows. */
typedef struct row_frame {
    feature_kind kind;
    feature_pair pair;
    uint32_t slots[2];     /* of each side's body, or TULLE_NONE; not set without a body */
    bool is_without_cloth; /* no vertex of it is of cloth; not set without a body */
    bool has_end_arms;     /* arms as of the predicted end of the step, else as of x0 */
    vec3 arms[2];          /* [m] sum w_i r_i of each side's body; not set without one */
    double gap;            /* [m] n . sum w x0 in the frame the row was made with */
    double weights[4];     /* signed, see closest_points */
    vec3 normal;           /* unit, from the second feature to the first */
    vec3 turning; /* [m/s] relative velocity at which the contact keeps its place. Tangentially:
                     cloth a gap away from a scripted obstacle that turns seems to slip. Along the
                     normal: the gap seems to shrink while the frame turns to the end of the step */
    uint32_t vertices[4];
    bool has_body;        /* a side lies on a free body */
    const row_tilt *tilt; /* of a tie at a height over cloth; null for contacts */
} row_frame;

/* What contact and friction ask of a row. Written when rows are made, from the laws of the surfaces
 * and the contact of the step before. Between solves the bias is lowered where pushing bodies apart
 * would cost too much energy. Stage 10 sets the rebound and moves the anchor. Sweeps read the
 * members up to `return_velocity`. */
typedef struct row_law {
    double bias;     /* [m/s] normal speed that the row asks for */
    double friction; /* coefficient in this step: the static or the dynamic one */
    double friction_along, friction_across; /* factors on it along the grain and across; 1: none */
    vec3 return_velocity; /* [m/s] tangential; friction aims at it, and it undoes the anchor */
    vec3 grain;           /* unit tangent; read where the two factors differ */
    vec3 anchor;          /* [m] tangential offset since the contact began to stick */
    double restitution;   /* as in contact_law */
    double approach;     /* [m/s] n . sum w v0: negative where the sides come nearer at the start */
    double fall;         /* [m/s] that gravity adds to it in this step */
    double rebound;      /* [m/s] speed at which an impact parts at the end of the step; 0: none */
    row_state old_state; /* of the contact of the step before; ROW_OPEN for a new row */
    uint32_t age;        /* steps before this one in which that contact was there */
    bool is_old;         /* continues a contact of the step before */
    bool is_sliding;     /* slips at the start of the step */
} row_law;

/* What the solve keeps of a row. Stage 5 sets the masses, and takes impulse and state over from the
 * contact of the step before. Stages 7 and 8 write it; sweeps read and write the members up to
 * `slip_answer`. Stage 10 stores impulse and state. */
typedef struct row_solve {
    vec3 impulse;        /* [N s] total over the step, acts w_i impulse on vertex i */
    double inverse_mass; /* [1/kg] sum w_i^2 / m_i, with bodies along the normal, > 0 */
    double compliance;   /* [1/kg] times the normal impulse: is taken off a push-out's speed */
    double friction_cap; /* [N s] normal impulse that bounds friction of a hard row; < 0: its own */
    row_state state;     /* after the last sweep */
    bool is_hard;        /* joins the matrix of the solve while it carries load */
    bool is_in_matrix;   /* is in the matrix in this round */
    double slip_inverse_mass; /* [1/kg] with a body: largest answer to a tangential impulse */
    vec3 slip_answer;    /* [1/kg] with a body: tangential velocity for a unit of normal impulse */
    double stiffness;    /* [kg] penalty of a hard row in the solve */
    double slip_penalty; /* [kg] penalty of its slip */
    mat3 pull;           /* [kg] of a row in the matrix: impulse against a velocity */
    double slip_pull;    /* [kg] the part of `pull` that acts against slip */
    vec3 slip_free;      /* unit: slip_pull does not act along this; zero: it acts on all slip */
    vec3 slip_target;    /* [m/s] slip_pull pulls towards this slip */
} row_solve;

/* One contact: the half-space  n . sum_i w_i u_i >= bias  with friction and its total impulse.
 * Sweeps touch the end of `frame` and the beginnings of `solve` and `law`, which lie together in
 * memory. */
typedef struct contact_row {
    row_frame frame;
    row_solve solve;
    row_law law;
} contact_row;

/* A spring that pulls a vertex of cloth to its place over a triangle or to a point. */
typedef struct tie_spring {
    contact_row row; /* its frame: vertex and triangle, and their bodies */
    row_tilt tilt;   /* the frame's, where it has one */
    vec3 away; /* [m] from the place to the vertex at x0, with the second-order turn of bodies */
    double stiffness; /* [N/m] INFINITY: stiffer than the cloth around it */
    double pull;      /* [kg] impulse against a velocity, set by the solve */
} tie_spring;

/* A pair that starts nearer than the scene's largest separation distance, or that stage 5 found to
 * come within its contact distance. */
typedef struct near_pair {
    feature_kind kind;
    feature_pair pair;
    double distance; /* [m] at x0 */
} near_pair;

typedef struct near_pair_list {
    ARRAY(near_pair) pairs;
    size_t nearest; /* index of the smallest distance */
} near_pair_list;

/* Rows in a fixed order: gathered ones by (kind, pair), then those of impacts as they were found.
 */
typedef struct row_list {
    ARRAY(contact_row) rows;
    size_t gathered_count; /* rows before those of stage 8 */
    double push_out_cut; /* [m/s] rows of stage 8 ask for so much less push-out than the settings */
    near_pair_list near_pairs;
} row_list;

/* The part of a contact that is kept from step to step. Plain data without padding: may be saved,
 * loaded and hashed as bytes. */
typedef struct stored_contact {
    uint32_t kind, first, second; /* key; sorted by it */
    uint32_t is_hard;             /* 0 or 1 */
    uint32_t state;               /* row_state */
    uint32_t age;                 /* steps since the contact began, on whatever features */
    double impulse[3];            /* [N s] of a step of length contact_store.time_step */
    double normal[3];             /* unit, from the second feature to the first: the side */
    double anchor[3];             /* [m] tangential offset of the sides, while the contact sticks */
} stored_contact;

/* Contacts at the end of the last step. Zeroed is empty. */
typedef struct contact_store {
    ARRAY(stored_contact) contacts;
    double time_step; /* [s] of the step that made the impulses; 0 when empty */
} contact_store;

#endif
