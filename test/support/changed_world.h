/* support/changed_world.h - the same small scene told in other words: turned, mirrored, moved,
 * renumbered, in other units, in another order, at another time. */
#ifndef TULLE_TEST_CHANGED_WORLD_H
#define TULLE_TEST_CHANGED_WORLD_H

#include "tulle/tulle.h"

#include <stdbool.h>

enum { CHANGED_OBJECTS_MAX = 6, CHANGED_PINS_MAX = 8, CHANGED_KEYS_MAX = 3 };

/* A cloth, an obstacle, or a rigid body where `density` is not 0. */
typedef struct plain_object {
    tulle_mesh mesh;
    bool is_obstacle;
    double density;                  /* [kg/m^3] */
    double velocity[3];              /* [m/s] of a cloth or a body at the start */
    uint32_t pins[CHANGED_PINS_MAX]; /* of a cloth */
    size_t pin_count, key_count;
    tulle_keyframe keys[CHANGED_KEYS_MAX]; /* of an obstacle, or of the pins; about the origin */
} plain_object;

/* Objects in the order of adding, cloths first. */
typedef struct plain_scene {
    plain_object objects[CHANGED_OBJECTS_MAX];
    size_t object_count;
    double friction;     /* of all pairs */
    double air_speed;    /* [m/s] along each axis, of a steady wind along (3, 2, 1) */
    double cg_tolerance; /* 0: the default */
    tulle_integrator integrator;
    tulle_membrane membrane;
} plain_scene;

/* How a scene is told. A place x becomes length (matrix x + shift). */
typedef struct change {
    const char *name;
    double matrix[9];       /* orthonormal */
    double shift[3];        /* [m] in the scene's own unit */
    int length, time, mass; /* exponents: the unit is 2^-exponent of the old one */
    double start_time;      /* [s] in the old unit */
    uint64_t seed;          /* of the new order of vertices, triangles and corners; 0: none */
    bool is_reversed;       /* objects are added in the opposite order */
    bool turns_over;        /* triangles face the other side, as a mirror asks of solids */
    double jitter;          /* [m] in the old unit: vertices of cloth start up to so far away */
    uint64_t jitter_seed;
} change;

typedef struct changed_world {
    const plain_scene *scene;
    change how;
    tulle_world *world;
    uint32_t ids[CHANGED_OBJECTS_MAX];     /* index of each object among cloths, or obstacles */
    uint32_t *places[CHANGED_OBJECTS_MAX]; /* new number of each vertex */
    tulle_step_report report;              /* of the last step */
} changed_world;

void plain_scene_destroy(plain_scene *scene);

/* Makes the world and starts it. The scene must outlive it. Fails the cmocka test on an error. */
changed_world changed_world_make(const plain_scene *scene, const change *how);
void changed_world_destroy(changed_world *own);
/* A step of `time_step` [s] in the scene's own unit. */
void changed_world_step(changed_world *own, double time_step);

/* How far two worlds of one scene differ, in the scene's own units; both are 0 where all numbers
 * are the same but for the sign of a zero. */
typedef struct difference {
    double position; /* [m] largest of a coordinate */
    double velocity; /* [m/s] */
} difference;
difference changed_world_compare(const changed_world *a, const changed_world *b);
/* Pairs of triangles that intersect, by the judge. */
size_t changed_world_judge(const changed_world *own);
/* [J] in the scene's own unit. */
double changed_world_get_energy(const changed_world *own);

#endif
