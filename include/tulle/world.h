/* tulle/world.h - the simulated world: cloth, obstacles, time. See docs/method/index.md for what a
 * step does.
 *
 * The promise: no accepted state holds an intersection of cloth with itself, other cloth or an
 * obstacle (beyond those that the caller told the world to ignore), and none is passed through on
 * the way. A step that cannot keep it returns an error and leaves the world as it was. */
#ifndef TULLE_WORLD_H
#define TULLE_WORLD_H

#include "tulle/base.h"
#include "tulle/detect.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tulle_world tulle_world;

/* Ids by value; {0, 0} is no object. */
typedef struct tulle_cloth_id {
    uint32_t index, generation;
} tulle_cloth_id;
typedef struct tulle_obstacle_id {
    uint32_t index, generation;
} tulle_obstacle_id;

typedef enum tulle_integrator {
    TULLE_INTEGRATOR_IMPLICIT_EULER,
    TULLE_INTEGRATOR_CRANK_NICOLSON, /* Wong & Baciu 2005, 5.1 */
    TULLE_INTEGRATOR_BDF2
} tulle_integrator;

/* How a world finds the pairs of features that come near each other. With a certificate every
 * choice keeps the promise of the step and leads to the same states, bit for bit, unless two
 * features of one patch come together by over 14 contact distances within a step (350 with the
 * distances derived by default; docs/method/update_patches.md); they differ in time. */
typedef struct tulle_world_detection {
    tulle_detect_method method;
    tulle_detect_cone cone; /* of methods with patches */
    double max_angle;       /* [rad] alpha_max, > 0 and < pi/2: widest cone in which a patch grows;
                               certified ones may be       wider once they are merged or kept */
    int has_certificate;    /* 1: only patches that are proven not to touch themselves are skipped.
                               0: every patch is, the paper's own rule: the promise then holds only
                               for pairs that do not lie within one patch */
    int grows_patches_anew; /* 1: patches are grown for every search; 0: kept from step to step and
                               checked again. TULLE_DETECT_PAPER always grows */
} tulle_world_detection;

/* How a world answers contact (stages 3 and 10). The safe commit guards both alike. */
typedef enum tulle_response {
    TULLE_RESPONSE_COUPLED, /* impulses with friction act inside the implicit solve */
    TULLE_RESPONSE_PAPER    /* Wong & Baciu 2005, 4 and 5.2: forces projected before the solve,
                               velocities after it, vertex by vertex */
} tulle_response;
/* What a vertex in contact may do, for TULLE_RESPONSE_PAPER. */
typedef enum tulle_motion_space {
    TULLE_MOTION_SPACE_CONE,      /* the paper's: the widest circular cone inside the half-spaces of
                                     its contacts, which are fixed in space */
    TULLE_MOTION_SPACE_POLYHEDRAL /* their whole intersection, which moves with the other side */
} tulle_motion_space;

typedef enum tulle_start_intersections {
    TULLE_START_REFUSE,  /* also cloth wholly inside a closed obstacle that faces outward, and an
                            obstacle inside another of which one is a body */
    TULLE_START_IGNORE,  /* such pairs count once they came apart */
    TULLE_START_UNTANGLE /* cloth is moved before the first step until nothing intersects. Obstacles
                            that appear into cloth later are refused */
} tulle_start_intersections;
typedef enum tulle_on_pinch {
    TULLE_ON_PINCH_STOP,   /* the step fails; the state stays, from before the cloth is torn */
    TULLE_ON_PINCH_SLOW,   /* obstacles that bring one another too near are held apart until their
                              script asks for more room; all else goes on */
    TULLE_ON_PINCH_RELEASE /* the moving ones let the cloth through until they are free of it */
} tulle_on_pinch;

/* Wind: mean velocity plus seeded gusts, the same for the same seed, time and place on every
 * machine. */
typedef struct tulle_wind {
    double velocity[3];   /* [m/s] mean */
    double gust_strength; /* [m/s] standard deviation of each component, >= 0 */
    double gust_length;   /* [m] correlation length, > 0 */
    double gust_time;     /* [s] correlation time, > 0 */
    uint64_t seed;
    double drag_coefficient; /* [kg/m^3] k_f of  -k_f A |v_rel| (n . v_rel) n  per area, >= 0; 0
                                turns wind off */
} tulle_wind;

typedef struct tulle_world_def {
    uint32_t cookie;   /* set by tulle_world_def_default, checked on use */
    double gravity[3]; /* [m/s^2] */
    tulle_wind wind;
    double contact_distance; /* [m] delta_c; 0: derived from the meshes (thickness where given) */
    double separation_distance; /* [m] delta_s, at least the contact distance of every pair of
                                   objects, else the start fails; 0: 1.5 of it */
    double minimum_gap;         /* [m] xi, at most half of every contact distance; no accepted state
                                   undercuts it, but that vertices and edges of one cloth that
                                   rest nearer keep a quarter of their rest distance, and pairs
                                   that start nearer come no nearer; 0: derived */
    tulle_integrator integrator;
    tulle_world_detection detection;
    tulle_response response;
    tulle_motion_space motion_space; /* of TULLE_RESPONSE_PAPER */
    double cg_tolerance;             /* 1e-12 .. 1e-1, relative preconditioned residual */
    int cg_max_iterations;           /* 1 .. 1e6 */
    int solve_rounds;                /* fewest solves of motion and impulses a step, 1 .. 20 */
    int impulse_sweeps;              /* projected Gauss-Seidel sweeps a round, 1 .. 1000 */
    int impact_rounds;               /* rounds of stage 10 before the rescue, 0 .. 100 */
    double friction_cloth_cloth; /* Coulomb coefficient between cloths, 0 .. 10: what holds them */
    double dynamic_friction_cloth_cloth; /* what slows cloths that slide on one another, 0 ..
                                            friction_cloth_cloth; negative: the same */
    tulle_start_intersections start_intersections;
    int untangle_limit; /* rounds of untangling, 1 .. 1e6; a start that is not clean by then is
                           refused */
    tulle_on_pinch on_pinch;
    int threads; /* 1 .. 256; 0: one per processor. Results do not depend on it */
    tulle_allocator allocator;
} tulle_world_def;
TULLE_API tulle_world_def tulle_world_def_default(void);

/* Material in SI values that do not depend on the mesh. */
typedef struct tulle_material {
    double area_density;      /* [kg/m^2] > 0 */
    double stretch_stiffness; /* [N/m] force per width and strain, > 0 */
    double bend_stiffness;    /* [N m] plate bending rigidity, >= 0 */
    double stretch_damping;   /* [s] damping coefficient per stiffness, >= 0 */
    double bend_damping;      /* [s] >= 0 */
    double air_damping;       /* [1/s] viscous damping per mass, >= 0 */
    double friction;         /* Coulomb coefficient of this cloth against obstacles, combined as the
                                geometric mean, 0 .. 10: what holds a contact that does not slide */
    double dynamic_friction; /* of contacts that slide, 0 .. friction; negative: the same */
    double restitution;      /* part of the speed of an impact with which it rebounds, 0 .. 1; the
                                geometric mean of both sides' counts, between cloths too */
    double friction_across;  /* factor on both coefficients across the cloth's grain (see
                                tulle_cloth_def), whatever law they come from, 0 .. 10; 1:
                                isotropic, as always with TULLE_RESPONSE_PAPER */
    double stiffening_strain; /* strain s at which cloth pulls twice as hard as stretch_stiffness
                                 says: by 1 + (strain / s)^2 up to 3 s, then
                                 with the slope there; 1e-3 .. 1e6; 0: never, as with
                                 TULLE_RESPONSE_PAPER */
} tulle_material;
/* Presets cotton, silk, wool, denim, net, rubber-sheet; TULLE_ERROR_INVALID_ARGUMENT for other
 * names. */
TULLE_API tulle_status tulle_material_preset(const char *name, tulle_material *material);
/* Name of preset `index` and where its values come from; null when index is past the last. */
TULLE_API const char *tulle_material_preset_name(size_t index);
TULLE_API const char *tulle_material_preset_source(size_t index);

/* A keyframe of a rigid motion: x -> translation + R (x - pivot) + pivot. Between keys: linear or
 * eased (3s^2 - 2s^3), rotation by spherical interpolation. Before the first and after the last key
 * the motion holds still. */
typedef struct tulle_keyframe {
    double time;           /* [s] strictly increasing */
    double translation[3]; /* [m] */
    double rotation[4];    /* unit quaternion w, x, y, z */
} tulle_keyframe;
typedef struct tulle_motion {
    const tulle_keyframe *keys;
    size_t key_count; /* 0: no motion */
    double pivot[3];  /* [m] */
    int is_eased;
} tulle_motion;

/* A group of pinned vertices. */
typedef struct tulle_pin {
    const uint32_t *vertices;
    size_t vertex_count;
    tulle_motion motion; /* key_count 0: held where they start */
    double release_time; /* [s] the pin lets go at this time; INFINITY: never */
} tulle_pin;

typedef struct tulle_cloth_def {
    uint32_t cookie;
    const char *name;             /* for messages; may be null */
    tulle_mesh_view mesh;         /* start positions */
    const double *rest_positions; /* [m] 3 * vertex_count, null: the start is the rest shape */
    tulle_material material;
    double grain[3]; /* direction in the rest shape, of any length >= 1e-100 where friction_across
                        is  not 1: that is at right angles to it */
    const char *contact_material; /* what its surface is in tulle_world_set_material_law, at most 63
                                     bytes; null: none */
    double thickness;             /* [m] 0: the world's contact distance decides */
    const tulle_pin *pins;
    size_t pin_count;
    double velocity[3];       /* [m/s] at the start, of all vertices */
    const double *velocities; /* [m/s] 3 * vertex_count, null: `velocity` */
} tulle_cloth_def;
TULLE_API tulle_cloth_def tulle_cloth_def_default(void);

/* Frames of a mesh sequence: the caller fills positions (3 * vertex_count, [m]) of frame 0 ..
 * frame_count - 1. */
typedef tulle_status (*tulle_frame_reader)(void *context, uint32_t frame, double *positions,
                                           tulle_error *error);

/* A rigid body: an obstacle that answers contact. Its mesh must be closed and face outwards, but
 * for area_density. It collides with cloth, with all obstacles and with other bodies. Only with
 * TULLE_RESPONSE_COUPLED. */
typedef struct tulle_body {
    int is_dynamic;             /* 0: the obstacle is no body, and nothing else here counts */
    double mass;                /* [kg] evenly in the volume; exactly one of the three is > 0 */
    double density;             /* [kg/m^3] of the volume */
    double area_density;        /* [kg/m^2] of the surface: a shell */
    double velocity[3];         /* [m/s] of the centre of mass, at time 0 */
    double angular_velocity[3]; /* [rad/s] at time 0 */
    double linear_damping, angular_damping; /* [1/s] >= 0 */
    double start_time; /* [s] the body follows `motion` until then, and goes on as that moved */
    /* It falls asleep when no point of it, nor of any body that touches it directly or over others,
       was faster than sleep_speed for sleep_time: then it stands still and costs little until it
       wakes. It wakes with all that fell asleep with it: when a body that is awake presses on it,
       when cloth presses on it more or less than when it fell asleep, by what would give it
       sleep_speed within a step, when something on a script moves near it, when an obstacle
       appears or leaves, by tulle_obstacle_add_impulse and by tulle_obstacle_wake. */
    double sleep_speed; /* [m/s] 0: never */
    double sleep_time;  /* [s] > 0 where sleep_speed is */
} tulle_body;

typedef struct tulle_obstacle_def {
    uint32_t cookie;
    const char *name;
    tulle_mesh_view mesh; /* at motion zero, or frame 0 of the sequence */
    double friction;      /* 0 .. 10, see tulle_material for these three */
    double dynamic_friction, restitution;
    double friction_across; /* factor on friction across the grain, as of tulle_material */
    double grain[3]; /* direction in `mesh`, as of tulle_cloth_def; goes with what moves and deforms
                        the mesh. Where the surface is at right angles to it, friction has no
                        direction */
    const char *contact_material; /* as of tulle_cloth_def */
    tulle_motion motion;          /* rigid keyframes; key_count 0: static */
    tulle_frame_reader
        read_frame; /* null: no sequence; else vertices follow the frames, linearly in between */
    void *frame_context;
    uint32_t frame_count;
    double frame_start_time; /* [s] time of frame 0 */
    double frame_interval;   /* [s] between frames, > 0 */
    double appear_time;      /* [s] -INFINITY: there from the start */
    double disappear_time;   /* [s] INFINITY: stays */
    tulle_body body;
} tulle_obstacle_def;
TULLE_API tulle_obstacle_def tulle_obstacle_def_default(void);

/* A pair of triangles that intersects. Objects are named as in their defs. */
typedef struct tulle_intersection {
    uint32_t object_a, triangle_a, object_b,
        triangle_b; /* object: cloth index, or cloth count + obstacle index */
} tulle_intersection;

/* Names of the twelve stages, in order. */
#define TULLE_STAGE_COUNT 12
TULLE_API const char *tulle_stage_name(int stage);

/* What one step did. Counts are sums over the step's substeps and rounds. */
typedef struct tulle_step_report {
    uint64_t step;                           /* index of the step, from 0 */
    double time;                             /* [s] of the world after the step */
    double stage_seconds[TULLE_STAGE_COUNT]; /* [s] wall clock, each without what stages inside it
                                                took */
    double total_seconds;                    /* [s] wall clock; at least the sum of the stages */
    uint32_t solve_count, cg_iterations;
    double cg_residual;     /* largest relative preconditioned residual of the solves, but for
                               those that end early because others follow */
    int cg_converged;       /* 0: a solve stopped at its limit */
    uint64_t box_pairs;     /* feature pairs whose swept boxes met, over all searches of stage 7 */
    uint64_t tested_pairs;  /* that the cheapest tests of stages 10 and 11 did not prove apart, over
                               all their tests */
    uint64_t turning_pairs; /* of these proven apart by a plane that turns with the pair */
    uint64_t contacts;      /* contact rows of the last substep, impacts included */
    uint64_t new_contacts, stick_contacts, slip_contacts, hard_contacts;
    uint32_t impact_rounds;
    uint64_t rescue_impact_zones;       /* rescue 3: zones projected */
    uint64_t rescue_component_scalings; /* rescue 4: components whose displacement was scaled */
    uint64_t rescue_global_scalings;    /* rescue 4, 5: the whole scene's time was shortened */
    uint32_t substeps;                  /* 1 in a healthy step */
    uint64_t
        ignored_pairs;   /* triangle pairs that intersected at the start and have not come apart */
    double smallest_gap; /* [m] over the candidate pairs of the last test, at the end of the step;
                            INFINITY if none is within the separation distance */
    double kinetic_energy, gravity_energy, elastic_energy; /* [J] */
    double max_stretch; /* largest edge length over rest length */
    int pinched;        /* 1: a pinch between obstacles was found, see tulle_world_last_message, or
                           one found earlier still holds them back or lets cloth through */
    uint32_t pair_searches;     /* runs of stages 6 and 7: 1 in a quiet step */
    uint64_t patches;           /* in use at the end of the step; 0 for methods without */
    uint64_t patch_triangles;   /* triangles in them */
    uint64_t patches_certified; /* of them proven not to touch themselves: all, or none without the
                                   certificate */
    uint64_t patches_dissolved; /* kept ones that held no more and were dissolved whole in this
                                   step; not those that were cut or grown again */
} tulle_step_report;

/* Makes an empty world. Errors: INVALID_ARGUMENT (with a message for `error`), OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_create(const tulle_world_def *def, tulle_world **world,
                                          tulle_error *error);
TULLE_API void tulle_world_destroy(tulle_world *world);

/* Copies the def's arrays. Only before the first step. Validates the mesh (see tulle_mesh_validate)
 * and all values. */
TULLE_API tulle_status tulle_world_add_cloth(tulle_world *world, const tulle_cloth_def *def,
                                             tulle_cloth_id *id, tulle_error *error);
TULLE_API tulle_status tulle_world_add_obstacle(tulle_world *world, const tulle_obstacle_def *def,
                                                tulle_obstacle_id *id, tulle_error *error);

/* What friction and impact of two objects are, instead of what their materials say. Friction along
 * the grains, where the objects have some: the factors across them count as ever. */
typedef struct tulle_contact_law {
    double static_friction;  /* 0 .. 10 */
    double dynamic_friction; /* 0 .. static_friction; negative: the same */
    double restitution;      /* 0 .. 1 */
} tulle_contact_law;
/* Only before the start; a later call for the same pair replaces an earlier one. Errors:
 * INVALID_ARGUMENT (stale ids, the same cloth twice, values, started), OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_set_cloth_cloth_law(tulle_world *world, tulle_cloth_id a,
                                                       tulle_cloth_id b,
                                                       const tulle_contact_law *law,
                                                       tulle_error *error);
TULLE_API tulle_status tulle_world_set_cloth_obstacle_law(tulle_world *world, tulle_cloth_id cloth,
                                                          tulle_obstacle_id obstacle,
                                                          const tulle_contact_law *law,
                                                          tulle_error *error);
/* The same of two obstacles of which one at least is a rigid body. */
TULLE_API tulle_status tulle_world_set_obstacle_obstacle_law(tulle_world *world,
                                                             tulle_obstacle_id a,
                                                             tulle_obstacle_id b,
                                                             const tulle_contact_law *law,
                                                             tulle_error *error);
/* The law of all pairs of surfaces of which one is of contact material `a` and the other of `b`, in
 * either order; where both are the same name, also of a cloth on itself. Laws set for two objects
 * go before it. The names must be of objects that were added or of presets (see
 * tulle_material_preset_name). Else as above. */
TULLE_API tulle_status tulle_world_set_material_law(tulle_world *world, const char *a,
                                                    const char *b, const tulle_contact_law *law,
                                                    tulle_error *error);

/* Prepares the first step: derives distances, builds trees, judges the start. Called by the first
 * step if the caller did not. TULLE_ERROR_INTERSECTING_START names the first pairs in the message;
 * tulle_world_get_intersections gives all of them. */
TULLE_API tulle_status tulle_world_start(tulle_world *world, tulle_error *error);
/* Nonzero ends tulle_world_start or tulle_world_step with TULLE_ERROR_INTERRUPTED: the world is as
 * it was before and can be started or stepped again, to the same bits as if never asked. Asked by
 * the thread that called, before each round of untangling, when tulle_world_get_untangle_report
 * says how far that is, and within a step some thousand times a second, when
 * tulle_world_get_step_progress says how far that is: it should be quick, and may call no other
 * function of the world. Null asks no more. */
typedef int (*tulle_stop_request)(void *context);
TULLE_API void tulle_world_set_stop_request(tulle_world *world, tulle_stop_request is_stopped,
                                            void *context);
TULLE_API const tulle_intersection *tulle_world_get_intersections(const tulle_world *world,
                                                                  size_t *count);

/* What untangling did at the start; zeros when it had nothing to do. */
typedef struct tulle_untangle_report {
    uint64_t intersections; /* pairs of triangles that intersected */
    uint32_t rounds;
    uint64_t moved_vertices;
    double largest_displacement; /* [m] of a vertex */
    int keeps_minimum_gap; /* 0: some pair that does not intersect is nearer, as in a start that
                              touches */
    double seconds;        /* [s] wall clock */
    uint64_t left;         /* pairs in the state with the fewest so far; 0: clean */
} tulle_untangle_report;
TULLE_API tulle_untangle_report tulle_world_get_untangle_report(const tulle_world *world);

/* Moves the world by time_step [s], 0 < time_step <= 1. report and error may be null. After an
 * error the world is as it was, but for tulle_world_last_message and tulle_world_get_intersections.
 * Errors: those of tulle_world_start when it was not called; INVALID_ARGUMENT, OUT_OF_MEMORY;
 * INTERSECTING_START when an obstacle appears into or around cloth; PINCHED; STEP_FAILED when the
 * forces lead to numbers that are not finite, TULLE_RESPONSE_PAPER tears cloth, or a body would
 * turn further than 4096 substeps follow; LIMIT beyond 2^32 candidate pairs; INTERRUPTED by a stop
 * request; what a frame reader returns. */
TULLE_API tulle_status tulle_world_step(tulle_world *world, double time_step,
                                        tulle_step_report *report, tulle_error *error);

/* How far the step that is under way has come, for a tulle_stop_request. */
typedef struct tulle_step_progress {
    int is_under_way;     /* 0: no step is being made, and all else is 0 */
    uint64_t step;        /* index of the step, from 0 */
    uint32_t substep;     /* from 1 */
    double share;         /* of the step's time that has passed, 0 .. 1; less again when the step is
                             made anew after a pinch */
    uint32_t solve_count; /* before this substep */
} tulle_step_progress;
TULLE_API tulle_step_progress tulle_world_get_step_progress(const tulle_world *world);

TULLE_API double tulle_world_get_time(const tulle_world *world);
TULLE_API uint64_t tulle_world_get_step_count(const tulle_world *world);
/* Distances in force (after derivation) [m]. */
TULLE_API void tulle_world_get_distances(const tulle_world *world, double *contact,
                                         double *separation, double *minimum_gap);
/* As the def said. */
TULLE_API tulle_world_detection tulle_world_get_detection(const tulle_world *world);
/* The same of the response; motion_space may be null. */
TULLE_API tulle_response tulle_world_get_response(const tulle_world *world,
                                                  tulle_motion_space *motion_space);
/* What the last step has to say, as that a pinch begins or ends, or that an obstacle appears in
 * cloth and is ignored; static until the next step, empty string if nothing. */
TULLE_API const char *tulle_world_last_message(const tulle_world *world);

/* Borrowed arrays, valid until the next step: 3 * vertex_count doubles [m] or [m/s]; null for a
 * stale id. */
TULLE_API const double *tulle_cloth_get_positions(const tulle_world *world, tulle_cloth_id id,
                                                  size_t *vertex_count);
TULLE_API const double *tulle_cloth_get_velocities(const tulle_world *world, tulle_cloth_id id,
                                                   size_t *vertex_count);
TULLE_API const double *tulle_obstacle_get_positions(const tulle_world *world, tulle_obstacle_id id,
                                                     size_t *vertex_count);
/* Null before the start too. Scripted obstacles bear the mean velocity of the last step. */
TULLE_API const double *tulle_obstacle_get_velocities(const tulle_world *world,
                                                      tulle_obstacle_id id, size_t *vertex_count);
/* Where a body is: vertex p of the mesh as given is now at position + R (p - centre). */
typedef struct tulle_transform {
    double position[3];         /* [m] of the centre of mass */
    double rotation[4];         /* R, unit quaternion w, x, y, z */
    double velocity[3];         /* [m/s] of the centre */
    double angular_velocity[3]; /* [rad/s] */
    double centre[3];           /* [m] the centre of mass in the mesh as given */
    double mass;                /* [kg] */
    double inertia[9];          /* [kg m^2] now, about the centre, in the world's axes */
} tulle_transform;
/* INVALID_ARGUMENT for a stale id, an obstacle that is no body, and before the start. */
TULLE_API tulle_status tulle_obstacle_get_transform(const tulle_world *world, tulle_obstacle_id id,
                                                    tulle_transform *transform, tulle_error *error);
/* Changes the body's velocities at once by an impulse [N s] at `point` [m] of the world. Only while
 * it is present and free; errors as above, and for numbers that are not finite. */
TULLE_API tulle_status tulle_obstacle_add_impulse(tulle_world *world, tulle_obstacle_id id,
                                                  const double point[3], const double impulse[3],
                                                  tulle_error *error);
/* What contact gave a body in the last substep of the last accepted step: the sum of the impulses
 * [N s] of its contacts, as tulle_world_get_contacts has them, and of their moments [N m s] about
 * its centre of mass. Divided by the step they are the mean force and torque. Without what rebounds
 * (restitution) add. Zero while nothing touches it or it follows its script; while it sleeps those
 * of the step in which it fell asleep. Errors as above. */
TULLE_API tulle_status tulle_obstacle_get_contact_impulse(const tulle_world *world,
                                                          tulle_obstacle_id id, double impulse[3],
                                                          double angular_impulse[3],
                                                          tulle_error *error);
/* 1 while a body sleeps. */
TULLE_API int tulle_obstacle_is_asleep(const tulle_world *world, tulle_obstacle_id id);
/* Wakes a body and those that fell asleep with it; one that is awake is slow from now on. Errors as
 * above. */
TULLE_API tulle_status tulle_obstacle_wake(tulle_world *world, tulle_obstacle_id id,
                                           tulle_error *error);
/* 1 while the obstacle is in the scene. */
TULLE_API int tulle_obstacle_is_present(const tulle_world *world, tulle_obstacle_id id);

typedef enum tulle_contact_kind {
    TULLE_CONTACT_VERTEX_FACE, /* vertices: the vertex, then the corners of the face */
    TULLE_CONTACT_EDGE_EDGE    /* vertices: ends of the first edge, then of the second */
} tulle_contact_kind;
typedef enum tulle_contact_state {
    TULLE_CONTACT_OPEN,  /* carries no load */
    TULLE_CONTACT_STICK, /* held by friction */
    TULLE_CONTACT_SLIP   /* loaded, at the limit of friction */
} tulle_contact_state;

/* A contact of the last accepted step: a pair of features that the step's solve held apart. Place,
 * normal, weights and gap are those of the closest points at the end of the step. */
typedef struct tulle_contact {
    uint32_t object_a, object_b; /* cloth index, or cloth count + obstacle index; of the first and
                                    of the second feature; the same in contacts with oneself */
    uint32_t vertices[4];        /* each within its own object */
    tulle_contact_kind kind;
    tulle_contact_state state;
    int is_new;         /* 1: was no contact in the step before; `state` holds all the same */
    int is_hard;        /* 1: part of the matrix of the solve, as nearly all that carry load */
    double weights[4];  /* position on a minus position on b = sum of weights[i] * vertex i: those
                           of a add up to 1, those of b to -1 */
    double position[3]; /* [m] middle between the two closest points */
    double normal[3];   /* unit, from b to a */
    double gap;         /* [m] distance of the closest points */
    double impulse[3];  /* [N s] on a, over the last substep; the opposite acts on b */
} tulle_contact;

/* Contacts of the last accepted step, those of impacts included: the rows of its last substep, as
 * counted by tulle_step_report.contacts. A pair may be there twice, from the solve and from an
 * impact. Valid until the next step or load, even one that fails. None before the first step and
 * after tulle_world_load_state, until a step is made. The array is made on the first call after a
 * step; the state hash does not depend on it. Errors: INVALID_ARGUMENT (null), OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_get_contacts(tulle_world *world, const tulle_contact **contacts,
                                                size_t *count, tulle_error *error);

typedef struct tulle_patch_options {
    double time_step; /* [s] length of the coming step, 0 .. 1; 0: patches of the shape as it is */
    double max_angle; /* [rad] alpha_max, > 0 and < pi/2; 0: pi/3 */
    int is_in_use;    /* 1: the patches that the last step used, whatever the other options: none
                         before the first step and for methods without patches */
} tulle_patch_options;
/* Patches of a cloth: edge-connected triangles whose normals all stay within max_angle of one axis
 * while every vertex moves on by time_step with its velocity of now: the (zeta, alpha, I)-surfaces
 * of Wong & Baciu 2005, 3.1 to 3.3. They explain what a detection by patches skips, that is pairs
 * within one patch. They are found by their cones alone; a step uses those of them for which it
 * finds a certificate (is_in_use).
 * labels: one for each triangle, 1 .. *patch_count, or 0 for an isolated triangle, whose own normal
 * turns too far. The world must have started; it does not change. Errors: INVALID_ARGUMENT (stale
 * id, not started, options), OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_cloth_get_patches(tulle_world *world, tulle_cloth_id id,
                                               const tulle_patch_options *options, uint32_t *labels,
                                               size_t *patch_count, tulle_error *error);

/* Hash of everything that decides the future: positions, velocities, contacts with impulses, time,
 * motion state. */
TULLE_API uint64_t tulle_world_get_state_hash(const tulle_world *world);

/* The state as one block of bytes, to be loaded into a world built from the same defs (checked).
 * Free with the release function or tulle_world_free_state. */
TULLE_API tulle_status tulle_world_save_state(const tulle_world *world, void **bytes,
                                              size_t *byte_count, tulle_error *error);
TULLE_API void tulle_world_free_state(const tulle_world *world, void *bytes, size_t byte_count);
/* Takes the place of the first state of a world that has not started, which then is not judged. */
TULLE_API tulle_status tulle_world_load_state(tulle_world *world, const void *bytes,
                                              size_t byte_count, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
