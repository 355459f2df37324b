/* many_worlds - eight worlds in eight threads, each a towel that falls over a ball of its own size;
 * then the same worlds as one batch on two threads. Every world comes to the same bits both times.
 */
#include <tulle/tulle.h>

#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { WORLDS = 8, STEPS = 60 };
static const double TIME_STEP = 1.0 / 60.0; /* [s] */

static void require(tulle_status status, const tulle_error *error) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error->message);
    exit(2);
}

static tulle_world *make_world(int number) {
    tulle_error error;
    tulle_mesh towel, ball;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 0.3;
    def.resolution[0] = def.resolution[1] = 10;
    require(tulle_shape_generate(&def, &towel, &error), &error);
    double const radius = 0.06 + 0.005 * number;
    def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = 6;
    require(tulle_shape_generate(&def, &ball, &error), &error);
    tulle_mesh_transform(&towel, (double[]){1, 1, 1}, (double[]){1, 0, 0, 0},
                         (double[]){0.02, 0.01, radius + 0.01});

    tulle_world *world;
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1; /* there are as many worlds as threads */
    require(tulle_world_create(&world_def, &world, &error), &error);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&towel);
    require(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&ball);
    require(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    tulle_mesh_destroy(&towel);
    tulle_mesh_destroy(&ball);
    return world;
}

/* What a thread does with its world. Worlds share nothing: no lock is needed. */
static void *run_world(void *argument) {
    tulle_world *const world = argument;
    tulle_error error;
    for (int step = 0; step < STEPS; step++)
        require(tulle_world_step(world, TIME_STEP, NULL, &error), &error);
    return NULL;
}

int main(void) {
    tulle_world *alone[WORLDS], *batch[WORLDS];
    pthread_t threads[WORLDS];
    for (int i = 0; i < WORLDS; i++) {
        alone[i] = make_world(i);
        batch[i] = make_world(i);
    }
    for (int i = 0; i < WORLDS; i++)
        if (pthread_create(&threads[i], NULL, run_world, alone[i]) != 0) return 2;
    for (int i = 0; i < WORLDS; i++) pthread_join(threads[i], NULL);

    tulle_error error;
    tulle_world_batch const together = {.worlds = batch, .count = WORLDS, .threads = 2};
    for (int step = 0; step < STEPS; step++)
        require(tulle_worlds_step(&together, TIME_STEP, &error), &error);

    int differ = 0;
    for (int i = 0; i < WORLDS; i++) {
        uint64_t const first = tulle_world_get_state_hash(alone[i]);
        uint64_t const second = tulle_world_get_state_hash(batch[i]);
        printf("world %d: %016" PRIx64 " in a thread, %016" PRIx64 " in a batch\n", i, first,
               second);
        differ += first != second;
        tulle_world_destroy(alone[i]);
        tulle_world_destroy(batch[i]);
    }
    printf("%d worlds, %d differ\n", WORLDS, differ);
    return differ > 0;
}
