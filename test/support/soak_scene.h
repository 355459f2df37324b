/* support/soak_scene.h - a live scene that may run for days: all that moves on a script goes round
 * and round, and the host pushes the bodies back.
 *
 * A hammock is held at its corners, and carries two loose boxes. A ball pokes it from below, as a
 * mesh sequence without end. A curtain beside it is drawn together until it touches itself, and
 * opened again; a paddle sways into it. Both follow keyframes, which must be there beforehand.
 * Gusts blow over all. */
#ifndef TULLE_TEST_SOAK_SCENE_H
#define TULLE_TEST_SOAK_SCENE_H

#include "tulle/tulle.h"

enum {
    SOAK_STEPS_PER_CYCLE = 128,
    SOAK_CLOTHS = 2,
    SOAK_BODIES = 2, /* obstacles 0 and 1 */
    SOAK_OBSTACLES = SOAK_BODIES + 2
};
static const double SOAK_STEP = 1.0 / 64.0; /* [s] */

typedef struct soak_scene {
    tulle_mesh cloths[SOAK_CLOTHS], obstacles[SOAK_OBSTACLES];
    tulle_keyframe *keys[3]; /* of both curtain rods and the paddle */
    size_t key_count;        /* of each */
} soak_scene;

/* A scene whose keyframes last for `cycles`. */
soak_scene soak_scene_make(size_t cycles);
void soak_scene_destroy(soak_scene *scene);

/* A world on one thread; the scene must outlive it. Fails the cmocka test on an error. */
tulle_world *soak_scene_build(const soak_scene *scene, const tulle_allocator *heap);
/* What the host does before a step: it pushes bodies back over the hammock, and tosses each up once
 * a cycle. */
void soak_scene_push(tulle_world *world);
/* Pairs of triangles that intersect, of everything with everything, by the exact judge. */
size_t soak_scene_judge(const soak_scene *scene, const tulle_world *world);

#endif
