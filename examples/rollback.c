/* rollback - two players of a game over a network, each with a host of its own. A host knows its
 * player's input at once and the other's DELAY frames late; until then it guesses that he goes on
 * as before. Where that was wrong it goes back and makes the frames since then again. Both end
 * alike. */
#include <tulle/tulle.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { PLAYERS = 2, FRAMES = 120, DELAY = 5, RING = DELAY + 1, SIDE = 12, BYTES_MAX = 1 << 20 };
static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* The state at the start of a frame: the game's own part, and that of the world. */
typedef struct frame_state {
    double ways[PLAYERS]; /* [m] of the balls, along y */
    unsigned char bytes[BYTES_MAX];
    size_t byte_count;
} frame_state;

typedef struct host {
    int other, rollbacks; /* the player whose input comes late; how often it went back */
    tulle_world *world;
    tulle_obstacle_id balls[PLAYERS];
    double ways[PLAYERS], inputs[FRAMES][PLAYERS]; /* [m], [m/s], known or guessed */
    frame_state states[RING];
} host;

/* [m/s] What a player does: something else every ten frames. */
static double play(int player, int frame) { return 0.5 * sin(0.7 * (frame / 10) + 2.0 * player); }

/* A flag between two balls that the players move to and fro. */
static void make_host(host *made, int other) {
    made->other = other;
    tulle_mesh flag, ball;
    tulle_shape_def flag_def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    flag_def.size[0] = flag_def.size[1] = 0.4; /* [m], turned upright below */
    flag_def.resolution[0] = flag_def.resolution[1] = SIDE;
    tulle_shape_def ball_def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    ball_def.radius = 0.06, ball_def.resolution[0] = 5;
    tulle_world_def world_def = tulle_world_def_default();
    world_def.on_pinch = TULLE_ON_PINCH_SLOW;
    require(tulle_world_create(&world_def, &made->world, &error));
    require(tulle_shape_generate(&flag_def, &flag, &error));
    tulle_mesh_transform(&flag, (double[]){1, 1, 1}, (double[]){sqrt(0.5), sqrt(0.5), 0, 0},
                         (double[]){0, 0, 0});
    uint32_t row[SIDE];
    for (uint32_t k = 0; k < SIDE; k++) row[k] = (SIDE - 1) * SIDE + k;
    tulle_pin pin = tulle_pin_default();
    pin.vertices = row;
    pin.vertex_count = SIDE;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&flag);
    cloth.pins = &pin, cloth.pin_count = 1;
    require(tulle_world_add_cloth(made->world, &cloth, NULL, &error));
    for (int p = 0; p < PLAYERS; p++) {
        require(tulle_shape_generate(&ball_def, &ball, &error));
        tulle_mesh_transform(&ball, (double[]){1, 1, 1}, (double[]){1, 0, 0, 0},
                             (double[]){0.2 * p - 0.1, 0.3 * p - 0.15, -0.1});
        tulle_obstacle_def obstacle = tulle_obstacle_def_default();
        obstacle.mesh = tulle_mesh_get_view(&ball), obstacle.drive = TULLE_DRIVE_RIGID;
        require(tulle_world_add_obstacle(made->world, &obstacle, &made->balls[p], &error));
        tulle_mesh_destroy(&ball);
    }
    require(tulle_world_start(made->world, &error));
    tulle_mesh_destroy(&flag);
}

/* Saves the state, then makes the frame of it. */
static void make_frame(host *self, int frame) {
    frame_state *const kept = &self->states[frame % RING];
    for (int p = 0; p < PLAYERS; p++) kept->ways[p] = self->ways[p];
    require(tulle_world_save_state_into(self->world, kept->bytes, BYTES_MAX, &kept->byte_count,
                                        &error));
    for (int p = 0; p < PLAYERS; p++) {
        self->ways[p] += self->inputs[frame][p] / 60.0;
        require(tulle_obstacle_set_next_transform(
            self->world, self->balls[p], (double[]){0, self->ways[p], 0}, (double[]){1, 0, 0, 0},
            TULLE_TRAVEL_MOVE, &error));
    }
    require(tulle_world_step(self->world, 1.0 / 60.0, NULL, &error));
}

/* Learns what the other player did in a frame; `next` is the frame that comes next. */
static void learn(host *self, int frame, double input, int next) {
    if (self->inputs[frame][self->other] == input) return; /* as guessed */
    for (int i = frame; i < FRAMES; i++) self->inputs[i][self->other] = input;
    const frame_state *const kept = &self->states[frame % RING];
    for (int p = 0; p < PLAYERS; p++) self->ways[p] = kept->ways[p];
    require(tulle_world_load_state(self->world, kept->bytes, kept->byte_count, &error));
    for (int i = frame; i < next; i++) make_frame(self, i);
    self->rollbacks++;
}

int main(void) {
    static host hosts[PLAYERS];
    for (int k = 0; k < PLAYERS; k++) make_host(&hosts[k], 1 - k);
    for (int frame = 0; frame < FRAMES + DELAY; frame++)
        for (int k = 0; k < PLAYERS; k++) {
            int const late = frame - DELAY, next = frame < FRAMES ? frame : FRAMES;
            if (late >= 0) learn(&hosts[k], late, play(1 - k, late), next);
            if (frame >= FRAMES) continue;
            hosts[k].inputs[frame][k] = play(k, frame);
            make_frame(&hosts[k], frame);
        }
    uint64_t hashes[PLAYERS];
    for (int k = 0; k < PLAYERS; k++) {
        hashes[k] = tulle_world_get_state_hash(hosts[k].world);
        printf("host %d: %d rollbacks, %zu bytes a state, hash %016" PRIx64 "\n", k,
               hosts[k].rollbacks, hosts[k].states[0].byte_count, hashes[k]);
        tulle_world_destroy(hosts[k].world);
    }
    return hashes[0] != hashes[1];
}
