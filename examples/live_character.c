/* live_character - a cape on a character whose pose is known only just before each step. A host
 * that guesses the player's input wrongly for a while goes back and ends in the same state as one
 * that knew it. */
#include <tulle/tulle.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEPS = 90, SAVED_AT = 40, LEARNT_AT = 52 };
enum { ACROSS = 17, DOWN = 25, BODY_MAX = 4096 }; /* vertices of the cape, and of a body */

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* What a game has of a character: it runs along x and leans into it. */
typedef struct character {
    double way, speed; /* [m], [m/s] */
} character;

typedef struct game {
    character hero;
    tulle_mesh body, cape;      /* as modelled */
    uint32_t shoulders[ACROSS]; /* the uppermost row of the cape */
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id obstacle;
} game;

/* What skinning does in a real game: a point as modelled to where the pose has it. */
static void pose_point(const character *hero, const double model[3], double posed[3]) {
    for (int c = 0; c < 3; c++) posed[c] = model[c];
    posed[0] += hero->way + 0.15 * hero->speed * model[2];
}

/* [m/s] What the player wants. */
static double get_input(int step) { return step < SAVED_AT ? 1.0 : -1.0; }

static void make_game(game *made) {
    *made = (game){0};
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    def.radius = 0.15;
    def.height = 0.7;
    require(tulle_shape_generate(&def, &made->body, &error));
    def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = 0.4, def.size[1] = 0.6;
    def.resolution[0] = ACROSS, def.resolution[1] = DOWN;
    require(tulle_shape_generate(&def, &made->cape, &error));
    /* upright behind the body: x to y, y to z */
    tulle_mesh_transform(&made->cape, (double[]){1, 1, 1}, (double[]){0.5, 0.5, 0.5, 0.5},
                         (double[]){-0.17, 0, 0.35});
    for (uint32_t k = 0; k < ACROSS; k++) made->shoulders[k] = (DOWN - 1) * ACROSS + k;

    tulle_world_def world_def = tulle_world_def_default();
    require(tulle_world_create(&world_def, &made->world, &error));
    tulle_pin pin = tulle_pin_default();
    pin.vertices = made->shoulders;
    pin.vertex_count = ACROSS;
    tulle_cloth_def cloth_def = tulle_cloth_def_default();
    cloth_def.mesh = tulle_mesh_get_view(&made->cape);
    cloth_def.pins = &pin;
    cloth_def.pin_count = 1;
    require(tulle_world_add_cloth(made->world, &cloth_def, &made->cloth, &error));
    tulle_obstacle_def body_def = tulle_obstacle_def_default();
    body_def.mesh = tulle_mesh_get_view(&made->body);
    body_def.drive = TULLE_DRIVE_DEFORMING;
    require(tulle_world_add_obstacle(made->world, &body_def, &made->obstacle, &error));
    require(tulle_world_start(made->world, &error));
}

/* One step of the game: the pose at its end is given, then the world steps. */
static void go_on(game *self, double input) {
    static double posed[3 * BODY_MAX], pinned[3 * ACROSS];
    self->hero.speed += 0.1 * (input - self->hero.speed);
    self->hero.way += self->hero.speed / 60.0;
    size_t const count = self->body.vertex_count;
    for (size_t v = 0; v < count && v < BODY_MAX; v++)
        pose_point(&self->hero, self->body.positions + 3 * v, posed + 3 * v);
    for (size_t k = 0; k < ACROSS; k++)
        pose_point(&self->hero, self->cape.positions + 3 * self->shoulders[k], pinned + 3 * k);
    require(tulle_obstacle_set_next_positions(self->world, self->obstacle, posed, count,
                                              TULLE_TRAVEL_MOVE, &error));
    require(tulle_cloth_set_pin_targets(self->world, self->cloth, 0, pinned, ACROSS, &error));
    require(tulle_world_step(self->world, 1.0 / 60.0, NULL, &error));
}

int main(void) {
    game games[2], *const knows = &games[0], *const guesses = &games[1];
    for (int k = 0; k < 2; k++) make_game(&games[k]);
    for (int step = 0; step < STEPS; step++) go_on(knows, get_input(step));

    /* at SAVED_AT the player turns round, and the host does not know it yet */
    for (int step = 0; step < SAVED_AT; step++) go_on(guesses, get_input(step));
    void *bytes = NULL;
    size_t byte_count = 0;
    character const hero = guesses->hero;
    require(tulle_world_save_state(guesses->world, &bytes, &byte_count, &error));
    for (int step = SAVED_AT; step < LEARNT_AT; step++) go_on(guesses, get_input(SAVED_AT - 1));
    printf("guessed for %d steps: at %.3f m\n", LEARNT_AT - SAVED_AT, guesses->hero.way);

    guesses->hero = hero;
    require(tulle_world_load_state(guesses->world, bytes, byte_count, &error));
    for (int step = SAVED_AT; step < STEPS; step++) go_on(guesses, get_input(step));
    uint64_t const known = tulle_world_get_state_hash(knows->world);
    uint64_t const guessed = tulle_world_get_state_hash(guesses->world);
    printf("known: at %.3f m, hash %016" PRIx64 "\n", knows->hero.way, known);
    printf("rolled back: at %.3f m, hash %016" PRIx64 "\n", guesses->hero.way, guessed);
    tulle_world_free_state(guesses->world, bytes, byte_count);
    for (int k = 0; k < 2; k++) {
        tulle_world_destroy(games[k].world);
        tulle_mesh_destroy(&games[k].body);
        tulle_mesh_destroy(&games[k].cape);
    }
    return known != guessed;
}
