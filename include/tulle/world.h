/* tulle/world.h - the simulated world: cloth, obstacles, rigid bodies and time.
 *
 * A host makes a world, adds cloths and obstacles, and calls tulle_world_step again and again.
 * examples/hello_cloth.c is a whole program; docs/method/index.md explains a step.
 *
 * The promise: no accepted state holds an intersection of cloth with itself, with other cloth or
 * with an obstacle, and nothing passes through a surface on the way there. Pairs that the caller
 * chose to ignore are excluded. A step that cannot keep the promise returns an error and leaves the
 * world as it was.
 *
 * A world may be used by one thread at a time, different worlds by different threads at once
 * (tulle/threads.h). Results do not depend on threads.   */
#ifndef TULLE_WORLD_H
#define TULLE_WORLD_H

#include "tulle/base.h"
#include "tulle/detect.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- settings of a world ---- */

/* A world. Made by tulle_world_create, released by tulle_world_destroy. */
typedef struct tulle_world tulle_world;
struct tulle_paper_options;

/* Names a cloth of a world. {0, 0} names none. */
typedef struct tulle_cloth_id {
    uint32_t index;      /* in the order of adding, from 0; indices of removed cloths are reused */
    uint32_t generation; /* from 1; grows with each reuse of the index (tulle/objects.h) */
} tulle_cloth_id;
/* Names an obstacle or a rigid body of a world. {0, 0} names none. */
typedef struct tulle_obstacle_id {
    uint32_t index;      /* as of a cloth */
    uint32_t generation; /* as of a cloth */
} tulle_obstacle_id;

/* How a step integrates motion over time. */
typedef enum tulle_integrator {
    TULLE_INTEGRATOR_IMPLICIT_EULER, /* backward Euler, first order: robust, damps most */
    TULLE_INTEGRATOR_CRANK_NICOLSON, /* trapezoidal, second order; Wong & Baciu 2005, 5.1 */
    TULLE_INTEGRATOR_BDF2            /* two-step backward differences, second order */
} tulle_integrator;

/* How exactly costly solves of a step are solved. The promise does not depend on it. Cheap solves,
 * such as small cloth at rest, are always exact; so are all solves of TULLE_RESPONSE_PAPER.
 * docs/method/linear_solve.md has the bounds; tulle/paper.h has cg_tolerance. */
typedef enum tulle_quality {
    /* a long solve may end at 100 times cg_tolerance; friction and impacts are rough */
    TULLE_QUALITY_DRAFT,
    /* a long solve may end at 30 times cg_tolerance; very stiff cloth is solved nearly exactly */
    TULLE_QUALITY_NORMAL,
    /* a solve ends at cg_tolerance, and impulses are found until they settle */
    TULLE_QUALITY_EXACT
} tulle_quality;

/* How cloth resists stretch and shear. */
typedef enum tulle_membrane {
    /* warp, weft and shear, each with a law of its own, and bending by direction; the same on every
     * mesh */
    TULLE_MEMBRANE_WOVEN,
    TULLE_MEMBRANE_SPRINGS /* springs along edges, as the paper has it; depends on the mesh */
} tulle_membrane;

/* What happens when a yarn of woven cloth is stretched beyond the limit of its material. */
typedef enum tulle_on_overstretch {
    TULLE_ON_OVERSTRETCH_WARN, /* the report of the step counts it */
    TULLE_ON_OVERSTRETCH_STOP  /* the step fails; the state stays */
} tulle_on_overstretch;

/* What happens when the start intersects. */
typedef enum tulle_start_intersections {
    /* the start fails. It also fails if cloth lies wholly inside a closed obstacle that faces
       outwards, or if an obstacle lies inside another and one of them is a rigid body */
    TULLE_START_REFUSE,
    TULLE_START_IGNORE, /* a pair is ignored until it comes apart: an exception to the promise */
    /* cloth is moved before the first step until nothing intersects; an obstacle that appears in
     * cloth later is refused */
    TULLE_START_UNTANGLE
} tulle_start_intersections;
/* What happens when obstacles close on cloth and leave it no room. */
typedef enum tulle_on_pinch {
    TULLE_ON_PINCH_STOP, /* the step fails, before the cloth tears; the state stays */
    TULLE_ON_PINCH_SLOW, /* as LAG; after a pinch rigid obstacles and pins lag, too */
    TULLE_ON_PINCH_LAG   /* obstacles that deform lag behind their frames; a rigid obstacle: STOP */
} tulle_on_pinch;

/* Wind: a mean velocity plus gusts. The same seed, time and place give the same gust on every
 * machine. The force per area is -drag_coefficient |v_rel| (n . v_rel) n, where v_rel is the
 * velocity of the cloth relative to the air and n its normal. */
typedef struct tulle_wind {
    double velocity[3];      /* [m/s] -1e6 .. 1e6: mean */
    double gust_strength;    /* [m/s] 0 .. 1e6: standard deviation of each component of the gusts */
    double gust_length;      /* [m] 1e-6 .. 1e6, default 0.5: correlation length */
    double gust_time;        /* [s] 1e-6 .. 1e6, default 0.5: correlation time */
    uint64_t seed;           /* default 1: of the gusts */
    double drag_coefficient; /* [kg/m^3] 0 .. 1e6, default 0.7: as of air; 0: a vacuum */
} tulle_wind;

/* Settings of a world. Made by tulle_world_def_default. */
typedef struct tulle_world_def {
    uint32_t cookie;   /* set by tulle_world_def_default, checked on use */
    double gravity[3]; /* [m/s^2] -1e6 .. 1e6, default (0, 0, -9.81) */
    tulle_wind wind;   /* default: air at rest */
    /* [m] 0 .. 1: distance within which contact acts (delta_c); 0: derived from the meshes, or from
     * the thickness of cloth that has one. Without intersections at the start, the derived one
     * leaves surfaces that begin close together their room, down to four minimum gaps. */
    double contact_distance;
    /* [m] 0 .. 2: distance within which pairs are looked for (delta_s). At least the contact
     * distance of every pair of objects, else the start fails; 0: 1.5 times the contact distance.
     * */
    double separation_distance;
    /* [m] 0 .. 0.5: smallest gap in any accepted state (xi); at most half of every contact
     * distance; 0: derived. Two exceptions: vertices and edges of one cloth whose rest distance is
     * smaller keep a quarter of it; pairs that start nearer do not come nearer. */
    double minimum_gap;
    tulle_integrator integrator;         /* default TULLE_INTEGRATOR_IMPLICIT_EULER */
    tulle_membrane membrane;             /* default TULLE_MEMBRANE_WOVEN */
    tulle_on_overstretch on_overstretch; /* default TULLE_ON_OVERSTRETCH_WARN */
    tulle_quality quality;               /* default TULLE_QUALITY_NORMAL */
    double friction_cloth_cloth;         /* 0 .. 10, default 0.3: static Coulomb coefficient */
    /* up to 10, default -1: the coefficient of cloths that slide on one another, at most
     * friction_cloth_cloth; negative: the static one */
    double dynamic_friction_cloth_cloth;
    double sleep_speed; /* [m/s] 0 .. 1000: slower cloth sleeps (tulle/live.h); 0: never */
    double sleep_time;  /* [s] 1e-12 .. 1e6, default 0.5: time for which it must be slow */
    tulle_start_intersections start_intersections; /* default TULLE_START_REFUSE */
    int untangle_limit;      /* 1 .. 1e6, default 2000: rounds; then the start is refused */
    tulle_on_pinch on_pinch; /* default TULLE_ON_PINCH_LAG */
    /* how it detects, answers contact and solves, for studies (tulle/paper.h), copied; null: as
     * suits simulations */
    const struct tulle_paper_options *paper;
    /* the host's: */
    int threads;               /* 0 .. 256; 0: one per processor. Results do not depend on it */
    tulle_allocator allocator; /* zeroed: malloc without a limit */
} tulle_world_def;
/* Settings that suit most scenes: earth's gravity, air at rest, derived distances. */
TULLE_API tulle_world_def tulle_world_def_default(void);

/* ---- materials, motions, cloth and obstacles ---- */

/* How cloth pulls at a strain e: k e while slack; taut, k e (1 + (e / knee)^2) up to the limit, and
 * from there on straight, with the slope at the limit. */
typedef struct tulle_curve {
    double stiffness; /* [N/m] 1e-12 .. 1e12: k, force per width and strain */
    double knee;  /* 0 or 1e-3 .. 1e6: strain at which cloth pulls twice as hard as k e; 0: never */
    double limit; /* 1e-3 .. 1e6: strain up to which the fabric holds */
} tulle_curve;
/* The values of cloth that is made of springs, the same in every direction. */
typedef struct tulle_springs {
    double stretch_stiffness; /* [N/m] 1e-12 .. 1e12: force per width and strain */
    double bend_stiffness;    /* [N m] 0 .. 1e9: bending rigidity of a plate */
    /* 0 or 1e-3 .. 1e6: strain s at which cloth pulls twice as hard as stretch_stiffness says. The
     * factor is 1 + (strain / s)^2 up to a strain of 3 s; beyond it the force grows with the slope
     * at 3 s. 0: the factor is always 1, as with TULLE_RESPONSE_PAPER. */
    double stiffening_strain;
} tulle_springs;
/* A fabric in SI values, which do not depend on the mesh. The warp lies along the cloth's grain,
 * the weft across it. Begin with a preset: a value left at 0 is 0. docs/guide/materials.md. */
typedef struct tulle_material {
    double area_density; /* [kg/m^2] 1e-12 .. 1e6 */
    /* woven cloth: */
    tulle_curve warp; /* along the yarns of the warp */
    tulle_curve weft; /* along the yarns of the weft */
    /* shear strain: the scalar product of both yarns' stretched unit lengths, for small angles the
     * angle [rad] of shear. The square of its stiffness is at most the product of the yarns'. */
    tulle_curve shear;
    double poisson;    /* -0.9 .. 0.9: Poisson's ratio, the geometric mean of both directions' */
    double bend_warp;  /* [N m] 0 .. 1e9: bending rigidity of the yarns of the warp */
    double bend_weft;  /* [N m] 0 .. 1e9: bending rigidity of the yarns of the weft */
    double bend_twist; /* [N m] 0 .. 1e9: twisting rigidity; half of the others: isotropic */
    /* [N] 0 .. 1e15: width of the loop of moment per width over curvature along the warp, 2HB of
     * KES; 0: none. At most 1e6 1/m times bend_warp. */
    double bend_hysteresis_warp;
    double bend_hysteresis_weft; /* [N] 0 .. 1e15: the same along the weft, by bend_weft */
    /* [N/m] 0 .. 2e12: width of the loop of force per length over the angle of shear, 2HG of KES;
     * 0: none. At most twice the stiffness of shear. */
    double shear_hysteresis;
    /* cloth of springs: */
    tulle_springs springs; /* with TULLE_MEMBRANE_SPRINGS, in place of what woven cloth has */
    /* damping: */
    double stretch_damping; /* [s] 0 .. 1e6: damping coefficient per stiffness */
    double bend_damping;    /* [s] 0 .. 1e6: damping coefficient per stiffness */
    double air_damping;     /* [1/s] 0 .. 1e6: viscous damping per mass */
    /* 0 .. 10: static Coulomb coefficient against obstacles, of contacts that do not slide. The
     * geometric mean of both sides counts. */
    double friction;
    double dynamic_friction; /* up to 10: while sliding, at most friction; negative: as friction */
    /* 0 .. 1: part of an impact's speed with which the cloth rebounds. The geometric mean of both
     * sides counts, between cloths too. */
    double restitution;
    /* 0 .. 10: factor on both coefficients at right angles to the cloth's grain (see
     * tulle_cloth_def), whatever law they come from; 1: the same all around, as always with
     * TULLE_RESPONSE_PAPER */
    double friction_across;
} tulle_material;
/* Fills `material` with the preset `name`. tulle_material_preset_name lists the names. Error:
 * TULLE_ERROR_INVALID_ARGUMENT for another name and for null. */
TULLE_API tulle_status tulle_material_preset(const char *name, tulle_material *material);
/* Name of the preset number `index`, from 0; static. Null past the last one. */
TULLE_API const char *tulle_material_preset_name(size_t index);
/* Where the values of the preset number `index` come from; static. Null past the last one. */
TULLE_API const char *tulle_material_preset_source(size_t index);
/* [m] Thickness of the fabric of preset number `index`; worlds do not use it. 0 past the last. */
TULLE_API double tulle_material_preset_thickness(size_t index);
/* Values of a preset that were measured, not estimated; the source says in which work. */
typedef enum tulle_measured {
    TULLE_MEASURED_AREA_DENSITY = 1, /* mass per area */
    TULLE_MEASURED_THICKNESS = 2,    /* as tulle_material_preset_thickness has it */
    TULLE_MEASURED_TENSION = 4,      /* stiffness and knee of warp and weft */
    TULLE_MEASURED_LIMIT = 8,        /* of warp and weft */
    TULLE_MEASURED_SHEAR = 16,       /* its stiffness */
    TULLE_MEASURED_BENDING = 32,     /* along warp and weft */
    TULLE_MEASURED_HYSTERESIS = 64,  /* of bending and shear */
    TULLE_MEASURED_FRICTION = 128    /* against a smooth hard surface */
} tulle_measured;
/* Set of tulle_measured of the preset number `index`. 0 (none measured) past the last preset. */
TULLE_API unsigned tulle_material_preset_measured(size_t index);

/* A keyframe of a rigid motion: x -> translation + R (x - pivot) + pivot. */
typedef struct tulle_keyframe {
    double time;           /* [s] finite: later than the keyframe before */
    double translation[3]; /* [m] finite */
    /* [rad] finite: axis times angle, of any length up to 1e6: 2 pi is a whole turn. Of a unit
     * quaternion w, r it is 2 atan2(|r|, w) r / |r| */
    double rotation_vector[3];
} tulle_keyframe;
/* A rigid motion by keyframes. Between two keyframes translation is linear. Rotation turns by the
 * difference of the angles where both axes are the same or one angle is 0, else the shorter way
 * about a third axis. All holds still before the first and after the last keyframe. */
typedef struct tulle_motion {
    const tulle_keyframe *keys; /* key_count: keyframes, copied; null without any */
    size_t key_count;           /* 0: no motion */
    double pivot[3];            /* [m] finite: point that rotations turn about */
    int is_eased;               /* 1: starts and stops gently at each keyframe (3 s^2 - 2 s^3) */
} tulle_motion;

/* A group of pinned vertices of a cloth: they are held, or follow a motion. A pin that never lets
 * go clamps the vertices that no other pin holds: woven cloth does not bend there, and bends from
 * the pin's edge on. A single row of vertices is a hinge. Made by tulle_pin_default. */
typedef struct tulle_pin {
    uint32_t cookie;          /* set by tulle_pin_default, checked on use */
    const uint32_t *vertices; /* vertex_count: numbers of vertices of the cloth, copied */
    size_t vertex_count;      /* length of `vertices` */
    tulle_motion motion;      /* key_count 0: held, or where tulle_cloth_set_pin_targets says */
    double release_time;      /* [s] any, default INFINITY: when the pin lets go; INFINITY: never */
} tulle_pin;
/* A pin that is never released; the caller fills in the vertices. */
TULLE_API tulle_pin tulle_pin_default(void);

/* A fold that cloth has at rest, along an edge of its mesh. */
typedef struct tulle_crease {
    uint32_t vertices[2]; /* ends of the edge, vertices of the cloth */
    double angle; /* [rad] -3 .. 3: of the fold from flat; positive: a ridge seen from the front */
} tulle_crease;

/* A cloth to add. Made by tulle_cloth_def_default; its arrays and strings are copied. */
typedef struct tulle_cloth_def {
    uint32_t cookie;              /* set by tulle_cloth_def_default, checked on use */
    const char *name;             /* for messages; may be null */
    tulle_mesh_view mesh;         /* start positions; an oriented manifold */
    const double *rest_positions; /* [m] 3 * vertex_count, each -1e6 .. 1e6; null: the start */
    /* [m] 9 * triangle_count, each -1e6 .. 1e6: the corners of each triangle at rest, wherever it
     * lies, for rest shapes whose triangles do not fit together, as in sewn garments. They give
     * lengths; rest_positions still give folds. Null: triangles of rest_positions */
    const double *rest_corners;
    int has_flat_rest; /* 1: at rest nothing is folded, whatever rest_positions say */
    /* crease_count: folds, in place of those at rest. Of two for one edge the last counts; folds
     * along the border are ignored. A fold off the edges makes the start fail. */
    const tulle_crease *creases;
    size_t crease_count;     /* length of `creases` */
    tulle_material material; /* the preset cotton, where nothing is said */
    /* -1e6 .. 1e6, default (1, 0, 0): direction of the warp in the rest shape, rest_corners where
     * given; friction_across acts at right angles to it. Any length from 1e-100 on where
     * friction_across is not 1. At right angles to it the warp of a triangle lies along x, else y.
     */
    double grain[3];
    /* 3 * triangle_count, each -1e6 .. 1e6: directions of the warp in the rest shape, of any length
     * from 1e-100 on; null: all along the grain */
    const double *warps;
    /* triangle_count, each 0.01 .. 100: factors on all stiffness and hysteresis of the material: a
     * stiff collar, a soft hem. Null: 1 everywhere */
    const double *stiffness_factors;
    /* name of the surface for tulle_world_set_material_law, at most 79 bytes; null: none */
    const char *contact_material;
    double thickness;         /* [m] 0 .. 1; 0: the world's contact distance decides */
    const tulle_pin *pins;    /* pin_count: groups; null without any */
    size_t pin_count;         /* length of `pins` */
    double velocity[3];       /* [m/s] -1e6 .. 1e6: of all vertices at the start */
    const double *velocities; /* [m/s] 3 * vertex_count, each finite; null: `velocity` */
} tulle_cloth_def;
/* A cloth of cotton without pins; the caller fills in the mesh. */
TULLE_API tulle_cloth_def tulle_cloth_def_default(void);

/* Gives a frame of a mesh sequence: fills `positions` (3 * vertex_count, [m]) of frame `frame`,
 * 0 .. frame_count - 1. `context` is frame_context of the obstacle. A status other than TULLE_OK
 * ends the step with that status. */
typedef tulle_status (*tulle_frame_reader)(void *context, uint32_t frame, double *positions,
                                           tulle_error *error);

/* The values of an obstacle that is a rigid body, which answers contact. Its mesh must face
 * outwards, and be closed unless area_density is given. It collides with cloth, with all obstacles
 * and with other bodies. It needs TULLE_RESPONSE_COUPLED. Exactly one of mass, density and
 * area_density is > 0.
 *
 * A body falls asleep when no point of it, nor of any body that touches it directly or over others,
 * was faster than sleep_speed for sleep_time. A sleeping body stands still and costs little. It
 * wakes, with all that fell asleep with it, when one of these happens:
 *   - a body that is awake presses on it;
 *   - cloth presses on it so differently that it would gain sleep_speed within a step;
 *   - something on a script moves near it;
 *   - an obstacle appears or leaves;
 *   - tulle_obstacle_add_impulse or tulle_obstacle_wake is called.   */
typedef struct tulle_body {
    int is_dynamic;      /* 0: the obstacle is not a body; all other members are ignored */
    double mass;         /* [kg] 0 or 1e-12 .. 1e12: spread evenly over the volume */
    double density;      /* [kg/m^3] 0 or 1e-12 .. 1e12: of the volume */
    double area_density; /* [kg/m^2] 0 or 1e-12 .. 1e12: of the surface: a shell */
    double velocity[3]; /* [m/s] -1e6 .. 1e6: of the centre of mass, when it comes into the world */
    double angular_velocity[3]; /* [rad/s] -1e6 .. 1e6: when it comes into the world */
    double linear_damping;      /* [1/s] 0 .. 1e6 */
    double angular_damping;     /* [1/s] 0 .. 1e6 */
    double start_time;  /* [s] any: until then it follows `motion`; after that it moves freely, with
                           the velocity that it has */
    double sleep_speed; /* [m/s] 0 .. 1e6; 0: never sleeps */
    double sleep_time;  /* [s] 0 .. 1e6: > 0 where sleep_speed is */
} tulle_body;

/* How a host moves an obstacle step by step, by the calls of tulle/live.h. */
typedef enum tulle_drive {
    TULLE_DRIVE_NONE,     /* not at all: it stands, follows its script or is a body */
    TULLE_DRIVE_RIGID,    /* as a whole: tulle_obstacle_set_next_transform */
    TULLE_DRIVE_DEFORMING /* each vertex by itself: tulle_obstacle_set_next_positions */
} tulle_drive;

/* An obstacle to add: static, on keyframes, deforming by a mesh sequence, driven by the host, or a
 * rigid body. Made by tulle_obstacle_def_default; its arrays and strings are copied. */
typedef struct tulle_obstacle_def {
    uint32_t cookie;      /* set by tulle_obstacle_def_default, checked on use */
    const char *name;     /* for messages; may be null */
    tulle_mesh_view mesh; /* where the motion has it at zero, or frame 0 of the sequence */
    double friction; /* 0 .. 10, default 0.3: static Coulomb coefficient, as of tulle_material */
    double dynamic_friction; /* up to 10, default -1: while sliding; negative: as friction */
    double restitution;      /* 0 .. 1: as of tulle_material */
    double friction_across;  /* 0 .. 10, default 1: as of tulle_material */
    /* -1e6 .. 1e6, default (1, 0, 0): direction in `mesh`, as of tulle_cloth_def. It follows the
     * motion and the deformation of the mesh. Where the surface is at right angles to it, friction
     * has no direction. */
    double grain[3];
    const char *contact_material; /* as of tulle_cloth_def */
    tulle_motion motion;          /* rigid keyframes; key_count 0: static */
    tulle_drive drive;            /* not together with keyframes, a sequence or a body */
    /* null: no sequence. Else vertices follow the frames, linearly in between. */
    tulle_frame_reader read_frame;
    void *frame_context;     /* handed to read_frame; lives as long as the obstacle */
    uint32_t frame_count;    /* 0 .. 1e9: frames that read_frame has; a motion may repeat them */
    double frame_start_time; /* [s] -1e6 .. 1e6: time of frame 0 */
    double frame_interval;   /* [s] 1e-9 .. 1e6, default 1 / 24: between frames */
    double appear_time;      /* [s] any, default -INFINITY: when it comes into the scene */
    double disappear_time;   /* [s] any, default INFINITY: when it leaves the scene */
    tulle_body body;         /* is_dynamic 0: no rigid body */
} tulle_obstacle_def;
/* A static obstacle with friction 0.3; the caller fills in the mesh. */
TULLE_API tulle_obstacle_def tulle_obstacle_def_default(void);

/* ---- making a world ---- */

/* Makes an empty world. `*world` is null after an error. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null, or a value of the def, which `error` names), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_create(const tulle_world_def *def, tulle_world **world,
                                          tulle_error *error);
/* Releases a world and everything that it handed out. Null is fine. */
TULLE_API void tulle_world_destroy(tulle_world *world);

/* Adds a cloth and gives its id; null `id` is fine. After the start: tulle/objects.h. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, also an array whose count is above 0; a value of the def),
 * TULLE_ERROR_INVALID_MESH (tulle_mesh_validate), TULLE_ERROR_OUT_OF_MEMORY, and after the start
 * the errors of a start. */
TULLE_API tulle_status tulle_world_add_cloth(tulle_world *world, const tulle_cloth_def *def,
                                             tulle_cloth_id *id, tulle_error *error);
/* Adds an obstacle or a rigid body and gives its id; null `id` is fine. After the start and errors:
 * as tulle_world_add_cloth. */
TULLE_API tulle_status tulle_world_add_obstacle(tulle_world *world, const tulle_obstacle_def *def,
                                                tulle_obstacle_id *id, tulle_error *error);

/* Friction and restitution of a pair, in place of the values of the materials; friction_across of a
 * grain still counts. Beware: a dynamic_friction of 0 means no friction while sliding; -1 means the
 * static value. */
typedef struct tulle_contact_law {
    double static_friction;  /* 0 .. 10: Coulomb coefficient of contacts that do not slide */
    double dynamic_friction; /* up to 10: while sliding; negative: as static_friction */
    double restitution;      /* 0 .. 1: part of an impact's speed that comes back */
} tulle_contact_law;
/* Sets the law of two cloths; a later call for the same pair replaces it. After the start it holds
 * from the next step on, is part of the state, and wakes bodies if it changes. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, the same cloth twice, a value),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_set_cloth_cloth_law(tulle_world *world, tulle_cloth_id a,
                                                       tulle_cloth_id b,
                                                       const tulle_contact_law *law,
                                                       tulle_error *error);
/* Sets the law of a cloth and an obstacle, as tulle_world_set_cloth_cloth_law does. */
TULLE_API tulle_status tulle_world_set_cloth_obstacle_law(tulle_world *world, tulle_cloth_id cloth,
                                                          tulle_obstacle_id obstacle,
                                                          const tulle_contact_law *law,
                                                          tulle_error *error);
/* Sets the law of two obstacles of which one at least is a rigid body, as
 * tulle_world_set_cloth_cloth_law does. */
TULLE_API tulle_status tulle_world_set_obstacle_obstacle_law(tulle_world *world,
                                                             tulle_obstacle_id a,
                                                             tulle_obstacle_id b,
                                                             const tulle_contact_law *law,
                                                             tulle_error *error);
/* Sets the law of all pairs of surfaces of which one has the contact material `a` and the other
 * `b`. If `a` equals `b`, it holds for a cloth on itself, too. A law of two objects takes
 * precedence. Each name must be the contact material of an added object, or a preset (see
 * tulle_material_preset_name). Only before the start; errors as of tulle_world_set_cloth_cloth_law.
 */
TULLE_API tulle_status tulle_world_set_material_law(tulle_world *world, const char *a,
                                                    const char *b, const tulle_contact_law *law,
                                                    tulle_error *error);

/* ---- the start ---- */

/* A pair of triangles that intersects. An object is the place of a cloth in the order of adding, or
 * the number of cloths plus the place of an obstacle. */
typedef struct tulle_intersection {
    uint32_t object_a;   /* first object */
    uint32_t triangle_a; /* triangle of the first object */
    uint32_t object_b;   /* second object; may be the first one again */
    uint32_t triangle_b; /* triangle of the second object */
} tulle_intersection;

/* Prepares the first step: derives distances, builds trees, judges the start. The first step calls
 * it if the caller did not. Errors: TULLE_ERROR_INTERSECTING_START (the message gives depth and
 * place of the deepest pairs, tulle_world_get_intersections gives all),
 * TULLE_ERROR_INVALID_ARGUMENT (null, distances that do not fit), TULLE_ERROR_OUT_OF_MEMORY,
 * TULLE_ERROR_INTERRUPTED, what a frame reader returns. */
TULLE_API tulle_status tulle_world_start(tulle_world *world, tulle_error *error);
/* Asks the host whether to stop; `context` comes from tulle_world_set_stop_request. Any value but 0
 * ends tulle_world_start or tulle_world_step with TULLE_ERROR_INTERRUPTED. The world is then as it
 * was before the call, which may be repeated. The thread that called the world asks before each
 * round of untangling, and some thousand times a second within a step. It may call only
 * tulle_world_get_untangle_report and tulle_world_get_step_progress. */
typedef int (*tulle_stop_request)(void *context);
/* Sets the function that is asked, and the `context` that it gets. With a null `is_stopped` nothing
 * is asked any more. A null world is fine. */
TULLE_API void tulle_world_set_stop_request(tulle_world *world, tulle_stop_request is_stopped,
                                            void *context);
/* The `*count` intersecting pairs of the last start, or step with a new obstacle, that failed. Null
 * `count` is fine. A null world gives null and 0. Owned by the world, until its next start or step.
 */
TULLE_API const tulle_intersection *tulle_world_get_intersections(const tulle_world *world,
                                                                  size_t *count);
/* How deep the triangles of a pair lie in each other, and where. */
typedef struct tulle_overlap {
    double depth;       /* [m] length of the shortest move of one triangle that parts the two */
    double position[3]; /* [m] the middle of their intersection */
} tulle_overlap;
/* The overlaps of the pairs of tulle_world_get_intersections, in the same order, the deepest pair
 * first. Null and `*count` 0 if no start or step failed because of them, and for a null world. Null
 * `count` is fine. Owned by the world, until its next start or step. */
TULLE_API const tulle_overlap *tulle_world_get_overlaps(const tulle_world *world, size_t *count);

/* What untangling did at the start. All zero when it had nothing to do. */
typedef struct tulle_untangle_report {
    uint64_t intersections;      /* pairs of triangles that intersected */
    uint32_t rounds;             /* rounds of untangling made */
    uint64_t moved_vertices;     /* vertices that untangling moved */
    double largest_displacement; /* [m] of a vertex */
    int keeps_minimum_gap; /* 0: some pair that does not intersect is nearer than the minimum gap */
    double seconds;        /* [s] wall clock */
    uint64_t left;         /* pairs left in the best state so far; 0: clean */
} tulle_untangle_report;
/* What untangling did, or how far it has come while it is under way. All zero for null. */
TULLE_API tulle_untangle_report tulle_world_get_untangle_report(const tulle_world *world);

/* ---- the step ---- */

/* Number of the stages of a step. */
#define TULLE_STAGE_COUNT 10
/* Name of the stage number `stage`, 0 .. TULLE_STAGE_COUNT - 1, in the order in which a step runs
 * them; static. Null out of range. */
TULLE_API const char *tulle_stage_name(int stage);

/* What one step did. Counts are sums over the substeps of the step and their rounds. */
typedef struct tulle_step_report {
    uint64_t step;                           /* index of the step, from 0 */
    double time;                             /* [s] of the world after the step */
    double stage_seconds[TULLE_STAGE_COUNT]; /* [s] wall clock, without stages inside the stage */
    double total_seconds;                    /* [s] wall clock; at least the sum of the stages */
    uint32_t solve_count;                    /* solves of the linear system */
    uint32_t cg_iterations;  /* iterations of conjugate gradients, over all solves */
    double cg_residual;      /* largest relative preconditioned residual of the last solves */
    int cg_converged;        /* 0: a solve stopped at its limit of iterations */
    uint64_t box_pairs;      /* pairs of features whose swept boxes met, over all searches */
    uint64_t tested_pairs;   /* pairs that the cheapest tests of a path did not prove apart */
    uint64_t turning_pairs;  /* of the tested pairs: proven apart by a plane that turns with them */
    uint64_t contacts;       /* contacts of the last substep, impacts included */
    uint64_t new_contacts;   /* of the contacts: not in the step before */
    uint64_t stick_contacts; /* of the contacts: held by friction */
    uint64_t slip_contacts;  /* of the contacts: sliding */
    uint64_t hard_contacts;  /* of the contacts: in the matrix of the solve */
    uint32_t impact_rounds;  /* rounds in which impacts were resolved */
    uint64_t rescue_impact_zones;       /* rescue 3: impact zones projected */
    uint64_t rescue_component_scalings; /* rescue 4: groups whose displacement was shortened */
    uint64_t rescue_global_scalings;    /* rescues 4 and 5: times the whole scene was shortened */
    uint32_t substeps;                  /* 1 in a healthy step */
    uint64_t ignored_pairs; /* triangle pairs that intersected at the start and still do */
    /* [m] over the candidate pairs of the last test, at the end of the step; INFINITY if none is
     * within the separation distance */
    double smallest_gap;
    double kinetic_energy; /* [J] */
    double gravity_energy; /* [J] 0 at the height of the origin */
    double elastic_energy; /* [J] of stretching and bending */
    double max_stretch;    /* largest length over rest length: of a yarn, of an edge with springs */
    uint64_t overstretched; /* triangles of woven cloth with a yarn beyond its limit */
    /* 1: a pinch between obstacles was found (see tulle_world_last_message), or obstacles still
     * wait because of one */
    int pinched;
    uint32_t pair_searches;     /* searches for pairs; 1 in a quiet step */
    uint64_t patches;           /* patches in use at the end of the step; 0 for methods without */
    uint64_t patch_triangles;   /* triangles in patches in use */
    uint64_t patches_certified; /* patches in use that are proven not to touch themselves */
    uint64_t patches_dissolved; /* kept patches dissolved whole; not those cut or grown again */
    double largest_lag;         /* [m] of a vertex behind its path (TULLE_ON_PINCH_LAG) */
} tulle_step_report;

/* Moves the world on by `time_step` [s], 0 < time_step <= 1. `report` and `error` may be null.
 * After an error the world is as it was; only tulle_world_last_message and
 * tulle_world_get_intersections may differ, and poses and targets given for the step (tulle/live.h)
 * are discarded. Errors:
 *
 * - the errors of tulle_world_start, if the caller has not called it;
 * - TULLE_ERROR_INVALID_ARGUMENT (null, a time step out of range), TULLE_ERROR_OUT_OF_MEMORY;
 * - TULLE_ERROR_INTERSECTING_START, when an obstacle appears in or around cloth;
 * - TULLE_ERROR_PINCHED, when obstacles leave cloth no room;
 * - TULLE_ERROR_STEP_FAILED: forces lead to numbers that are not finite, TULLE_RESPONSE_PAPER tears
 *   cloth, or a body turns too far for 4096 substeps;
 * - TULLE_ERROR_LIMIT, too many candidate pairs even in 4,096 substeps;
 * - TULLE_ERROR_INTERRUPTED, by a stop request; and what a frame reader returns.      */
TULLE_API tulle_status tulle_world_step(tulle_world *world, double time_step,
                                        tulle_step_report *report, tulle_error *error);

/* How far the step that is under way has come. For a tulle_stop_request. */
typedef struct tulle_step_progress {
    int is_under_way; /* 0: no step is being made, and all else is 0 */
    uint64_t step;    /* index of the step, from 0 */
    uint32_t substep; /* number of the substep, from 1 */
    double share;     /* of the step's time that has passed, 0 .. 1; falls when a pinch restarts the
                         step */
    uint32_t solve_count; /* solves so far; they grow also while `share` stands still */
} tulle_step_progress;
/* How far the step that is under way has come. All zero for null. */
TULLE_API tulle_step_progress tulle_world_get_step_progress(const tulle_world *world);

/* ---- reading a world ---- */

/* Time of the world [s], 0 at the start and for null. */
TULLE_API double tulle_world_get_time(const tulle_world *world);
/* Number of steps made; 0 for null. */
TULLE_API uint64_t tulle_world_get_step_count(const tulle_world *world);
/* The distances in force [m], after derivation: `contact`, `separation` and `minimum_gap` as in
 * tulle_world_def. Each of the three may be null; for a null world they get 0. */
TULLE_API void tulle_world_get_distances(const tulle_world *world, double *contact,
                                         double *separation, double *minimum_gap);
/* The message of the last step: for example that a pinch begins or ends, or that an obstacle
 * appears in cloth and is ignored. Before the first step: the message of the start. Empty if there
 * is none, and for null. Owned by the world, until its next step. */
TULLE_API const char *tulle_world_last_message(const tulle_world *world);

/* Positions of a cloth: 3 * `*vertex_count` doubles [m]. Borrowed until the next step. A stale id
 * and a null world give null and 0; `vertex_count` may be null. */
TULLE_API const double *tulle_cloth_get_positions(const tulle_world *world, tulle_cloth_id id,
                                                  size_t *vertex_count);
/* Velocities of a cloth: 3 * `*vertex_count` doubles [m/s]. Borrowed until the next step. A stale
 * id and a null world give null and 0; `vertex_count` may be null. */
TULLE_API const double *tulle_cloth_get_velocities(const tulle_world *world, tulle_cloth_id id,
                                                   size_t *vertex_count);
/* Positions of an obstacle: 3 * `*vertex_count` doubles [m]. Borrowed until the next step. A stale
 * id and a null world give null and 0; `vertex_count` may be null. */
TULLE_API const double *tulle_obstacle_get_positions(const tulle_world *world, tulle_obstacle_id id,
                                                     size_t *vertex_count);
/* Velocities of an obstacle: 3 * `*vertex_count` doubles [m/s]. An obstacle on a script has the
 * mean over the last step. Borrowed until the next step. Null before the start. A stale id and a
 * null world give null and 0; `vertex_count` may be null. */
TULLE_API const double *tulle_obstacle_get_velocities(const tulle_world *world,
                                                      tulle_obstacle_id id, size_t *vertex_count);
/* 1 while the obstacle is in the scene; 0 for a stale id and a null world. */
TULLE_API int tulle_obstacle_is_present(const tulle_world *world, tulle_obstacle_id id);

/* ---- rigid bodies ---- */

/* Where a body is: vertex p of the given mesh is at position + R (p - centre). */
typedef struct tulle_transform {
    double position[3];         /* [m] of the centre of mass */
    double rotation[4];         /* R as a unit quaternion w, x, y, z */
    double velocity[3];         /* [m/s] of the centre of mass */
    double angular_velocity[3]; /* [rad/s] */
    double centre[3];           /* [m] the centre of mass in the mesh as given */
    double mass;                /* [kg] */
    double inertia[9];          /* [kg m^2] about the centre of mass, in the world's axes */
} tulle_transform;
/* Fills `transform` of a body. Error: TULLE_ERROR_INVALID_ARGUMENT for null, for a stale id, for an
 * obstacle that is not a rigid body, and before the start. */
TULLE_API tulle_status tulle_obstacle_get_transform(const tulle_world *world, tulle_obstacle_id id,
                                                    tulle_transform *transform, tulle_error *error);
/* Changes the velocities of a body at once by `impulse` [N s] at `point` [m] of the world. The body
 * must be present and free. Errors as of tulle_obstacle_get_transform, and for numbers that are not
 * finite. */
TULLE_API tulle_status tulle_obstacle_add_impulse(tulle_world *world, tulle_obstacle_id id,
                                                  const double point[3], const double impulse[3],
                                                  tulle_error *error);
/* Gives the impulse of contact on an obstacle in the last substep of the last accepted step.
 * `impulse` [N s] is the sum over its contacts. `angular_impulse` [N m s] is the sum of their
 * moments, about a body's centre of mass or else about the origin. Divided by the substep they are
 * the mean force and torque. Restitution adds nothing to it. Contacts between two obstacles that
 * are not bodies are left out. Contacts of sleeping objects keep their last values. Between a load
 * and the next step only these are counted. Error: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id,
 * not started). */
TULLE_API tulle_status tulle_obstacle_get_contact_impulse(const tulle_world *world,
                                                          tulle_obstacle_id id, double impulse[3],
                                                          double angular_impulse[3],
                                                          tulle_error *error);
/* 1 while a body sleeps; 0 for a stale id, for an obstacle that is not a body, and for a null
 * world. */
TULLE_API int tulle_obstacle_is_asleep(const tulle_world *world, tulle_obstacle_id id);
/* Wakes a body and those that fell asleep with it. The time for which the body must be slow starts
 * again from 0. Errors as of tulle_obstacle_get_transform. */
TULLE_API tulle_status tulle_obstacle_wake(tulle_world *world, tulle_obstacle_id id,
                                           tulle_error *error);

/* ---- contacts and patches ---- */

/* Which features a contact holds apart. */
typedef enum tulle_contact_kind {
    TULLE_CONTACT_VERTEX_FACE, /* vertices: the vertex, then the corners of the face */
    TULLE_CONTACT_EDGE_EDGE    /* vertices: ends of the first edge, then of the second */
} tulle_contact_kind;
/* What friction does at a contact. */
typedef enum tulle_contact_state {
    TULLE_CONTACT_OPEN,  /* the contact carries no load */
    TULLE_CONTACT_STICK, /* friction holds it */
    TULLE_CONTACT_SLIP   /* it is loaded and slides */
} tulle_contact_state;

/* A contact of the last accepted step: a pair of features that the solve of the step held apart.
 * Place, normal, weights and gap belong to the closest points at the end of the step. An object is
 * numbered as in tulle_intersection. */
typedef struct tulle_contact {
    uint32_t object_a;         /* object of the first feature */
    uint32_t object_b;         /* object of the second feature; may be the first one again */
    uint32_t vertices[4];      /* each within its own object */
    tulle_contact_kind kind;   /* vertex and face, or edge and edge */
    tulle_contact_state state; /* open, stick or slip */
    int is_new;  /* 1: not a contact in the step before; `state` is valid in any case */
    int is_hard; /* 1: part of the matrix of the solve, as nearly all contacts with a load are */
    /* position on a minus position on b = sum of weights[i] * vertex i; weights on a add up to 1,
     * weights on b to -1 */
    double weights[4];
    double position[3]; /* [m] middle between the two closest points */
    double normal[3];   /* unit, from b to a */
    double gap;         /* [m] distance of the closest points */
    double impulse[3];  /* [N s] on a, over the last substep; the opposite acts on b */
} tulle_contact;

/* Gives the contacts of the last accepted step, impacts included: `*count` of them, as
 * tulle_step_report counts them. A pair may appear twice, from the solve and from an impact. The
 * world owns them, until its next step or load, even if that fails. There are none before the first
 * step, nor between a load and the next step. The first call after a step makes the array. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_get_contacts(tulle_world *world, const tulle_contact **contacts,
                                                size_t *count, tulle_error *error);

/* The place where cloth is stretched most: an edge of springs, or the edge of a woven triangle that
 * lies most along the yarn. */
typedef struct tulle_stretch {
    double stretch;       /* length over rest length; 0: there is no cloth */
    uint32_t cloth;       /* place of the cloth in the order of adding */
    uint32_t vertices[2]; /* ends of the edge, vertices of the cloth */
    double position[3];   /* [m] middle of the edge */
} tulle_stretch;
/* Finds the largest stretch of the world as it is. All zero before the start and for null. */
TULLE_API tulle_stretch tulle_world_find_largest_stretch(const tulle_world *world);

/* ---- saving and loading ---- */

/* Hash of everything that decides the next steps: positions, velocities, contacts with their
 * impulses, time, state of motions. Equal states have equal hashes on every machine. All worlds
 * that have not started have the same hash, which is also the hash for null. */
TULLE_API uint64_t tulle_world_get_state_hash(const tulle_world *world);

/* Gives the state as one block: `*bytes`, of `*byte_count` bytes, made by the world's allocator.
 * Free it with tulle_world_free_state. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, not started),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_save_state(const tulle_world *world, void **bytes,
                                              size_t *byte_count, tulle_error *error);
/* Frees `bytes`, a block of `byte_count` bytes from tulle_world_save_state of the same world. Null
 * `bytes` are fine; for a null world nothing happens. */
TULLE_API void tulle_world_free_state(const tulle_world *world, void *bytes, size_t byte_count);
/* Loads a saved state: `bytes`, `byte_count` of them. The world must have been made from the same
 * defs (this is checked). In a world that has not started, the load replaces the start, and
 * intersections at the start are not judged. A call that fails leaves the world as it was, but
 * tulle_world_get_intersections may give no pairs any more. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null, another world), TULLE_ERROR_PARSE (bytes cut short or changed, another version of the
 * format, values that no world has), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_load_state(tulle_world *world, const void *bytes,
                                              size_t byte_count, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
