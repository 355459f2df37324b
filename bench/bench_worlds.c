/* What a step of small worlds costs, many of them at once by tulle_worlds_step: cloths of 10 x 10
 * particles that hang from two corners, or that fall over a box on a floor and come to rest on
 * them. And what saving, loading and hashing a state costs: of one of them, and of a cape on a
 * moving body, also where the world has gone on since it was saved. Prints Markdown.
 * Usage: bench_worlds [worlds] [steps] [threads] */
#include "base/timer.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SIDE = 10, ACROSS = 20, DOWN = 28 }; /* vertices of a small cloth, and of the cape */
enum { BODY_MAX = 1024, CAPE_STEPS = 60 };
enum { SAVES = 2000, ROLLBACKS = 40, LATE = 8 /* steps that are taken back */ };
static const double STEP = 1.0 / 60.0; /* [s] */

typedef struct bench_case {
    const char *name;
    bool has_contact;
    tulle_quality quality;
} bench_case;
static const bench_case CASES[] = {
    {"hangs", false, TULLE_QUALITY_NORMAL},
    {"hangs, draft", false, TULLE_QUALITY_DRAFT},
    {"on a box", true, TULLE_QUALITY_NORMAL},
    {"on a box, draft", true, TULLE_QUALITY_DRAFT},
};

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "bench_worlds: %s\n", error.message);
    exit(1);
}

static void add_box(tulle_world *world, double side, double height, double top) {
    tulle_mesh box;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = side;
    shape.size[2] = height;
    require(tulle_shape_generate(&shape, &box, &error));
    for (size_t v = 0; v < box.vertex_count; v++) box.positions[3 * v + 2] += top - 0.5 * height;
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    require(tulle_world_add_obstacle(world, &def, NULL, &error));
    tulle_mesh_destroy(&box);
}

/* Worlds of one case differ by their heights. */
static tulle_world *make_world(const bench_case *kind, int number) {
    tulle_world *world;
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    world_def.quality = kind->quality;
    require(tulle_world_create(&world_def, &world, &error));
    tulle_mesh sheet;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = shape.size[1] = 0.3;
    shape.resolution[0] = shape.resolution[1] = SIDE;
    require(tulle_shape_generate(&shape, &sheet, &error));
    for (size_t v = 0; v < sheet.vertex_count; v++)
        sheet.positions[3 * v + 2] += 0.02 + 1e-4 * number;
    uint32_t const corners[2] = {0, SIDE - 1};
    tulle_pin pin = tulle_pin_default();
    pin.vertices = corners;
    pin.vertex_count = 2;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = kind->has_contact ? 0 : 1;
    require(tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_mesh_destroy(&sheet);
    if (kind->has_contact) {
        add_box(world, 0.2, 0.2, 0.0);
        add_box(world, 1.0, 0.1, -0.1);
    }
    require(tulle_world_start(world, &error));
    return world;
}

/* [s] of all threads of the process. */
static double processor_time(void) { return (double)clock() / CLOCKS_PER_SEC; }

static void measure_steps(const bench_case *kind, size_t count, int steps, int threads) {
    tulle_world **const worlds = malloc(count * sizeof *worlds);
    tulle_step_report *const reports = malloc(count * sizeof *reports);
    if (!worlds || !reports) exit(1);
    for (size_t i = 0; i < count; i++) worlds[i] = make_world(kind, (int)i);
    tulle_world_batch const batch = {worlds, count, threads, reports, NULL};
    double iterations = 0.0, solves = 0.0, contacts = 0.0;
    double wall = 0.0, processor = 0.0, solving = 0.0;
    for (int step = 0; step < steps; step++) {
        double const start = timer_now(), start_processor = processor_time();
        require(tulle_worlds_step(&batch, STEP, &error));
        wall += timer_now() - start;
        processor += processor_time() - start_processor;
        for (size_t i = 0; i < count; i++) {
            iterations += reports[i].cg_iterations;
            solves += reports[i].solve_count;
            contacts += (double)reports[i].contacts;
            solving += reports[i].stage_seconds[6] / reports[i].total_seconds;
        }
    }
    double const all = (double)count * steps;
    printf("| %s | %.0f | %.0f | %.1f | %.1f | %.0f | %.0f %% |\n", kind->name, all / wall,
           1e6 * processor / all, solves / all, iterations / all, contacts / all,
           100.0 * solving / all);
    for (size_t i = 0; i < count; i++) tulle_world_destroy(worlds[i]);
    free(worlds);
    free(reports);
}

/* ---- states ---- */

/* A cape behind a body that walks backwards into it. */
typedef struct cape_world {
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id obstacle;
    tulle_mesh cape, body;
    uint32_t shoulders[ACROSS];
} cape_world;

static void make_cape(cape_world *made) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    require(tulle_world_create(&world_def, &made->world, &error));
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    shape.radius = 0.15;
    shape.height = 0.7;
    require(tulle_shape_generate(&shape, &made->body, &error));
    shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = 0.4, shape.size[1] = 0.6;
    shape.resolution[0] = ACROSS, shape.resolution[1] = DOWN;
    require(tulle_shape_generate(&shape, &made->cape, &error));
    /* upright behind the body: x to y, y to z */
    tulle_mesh_transform(&made->cape, (double[]){1, 1, 1}, (double[]){0.5, 0.5, 0.5, 0.5},
                         (double[]){-0.17, 0, 0.35});
    for (uint32_t k = 0; k < ACROSS; k++) made->shoulders[k] = (DOWN - 1) * ACROSS + k;
    tulle_pin pin = tulle_pin_default();
    pin.vertices = made->shoulders;
    pin.vertex_count = ACROSS;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&made->cape);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    require(tulle_world_add_cloth(made->world, &cloth, &made->cloth, &error));
    tulle_obstacle_def body = tulle_obstacle_def_default();
    body.mesh = tulle_mesh_get_view(&made->body);
    body.drive = TULLE_DRIVE_DEFORMING;
    require(tulle_world_add_obstacle(made->world, &body, &made->obstacle, &error));
    require(tulle_world_start(made->world, &error));
}
/* [m] Where the body is after some steps: it walks to and fro. */
static double get_way(uint64_t step) { return 0.1 * sin(0.06 * (double)step); }

static void walk(const cape_world *self) {
    static double body[3 * BODY_MAX], pinned[3 * ACROSS];
    double const way = get_way(tulle_world_get_step_count(self->world) + 1);
    size_t const count = self->body.vertex_count;
    if (count > BODY_MAX) exit(1);
    for (size_t v = 0; v < count; v++)
        for (size_t c = 0; c < 3; c++)
            body[3 * v + c] = self->body.positions[3 * v + c] + (c == 0 ? way : 0.0);
    for (size_t k = 0; k < ACROSS; k++)
        for (size_t c = 0; c < 3; c++)
            pinned[3 * k + c] =
                self->cape.positions[3 * self->shoulders[k] + c] + (c == 0 ? way : 0.0);
    require(tulle_obstacle_set_next_positions(self->world, self->obstacle, body, count,
                                              TULLE_TRAVEL_MOVE, &error));
    require(tulle_cloth_set_pin_targets(self->world, self->cloth, 0, pinned, ACROSS, &error));
    require(tulle_world_step(self->world, STEP, NULL, &error));
}

/* The least of many, since what else runs on the machine only adds. With `late` steps between
 * saving and loading. */
static void measure_state(const char *name, tulle_world *world, const cape_world *cape, int late) {
    size_t size = tulle_world_get_state_size(world);
    void *const bytes = malloc(size);
    if (!bytes) exit(1);
    double least[3] = {1.0, 1.0, 1.0};
    uint64_t const hash = tulle_world_get_state_hash(world);
    for (int i = 0; i < (late > 0 ? ROLLBACKS : SAVES); i++) {
        double const start = timer_now();
        require(tulle_world_save_state_into(world, bytes, size, &size, &error));
        double const saved = timer_now();
        for (int step = 0; step < late; step++) walk(cape);
        double const gone_on = timer_now();
        require(tulle_world_load_state(world, bytes, size, &error));
        double const loaded = timer_now();
        if (tulle_world_get_state_hash(world) != hash) printf("the hash changes\n");
        double const hashed = timer_now();
        least[0] = fmin(least[0], saved - start);
        least[1] = fmin(least[1], loaded - gone_on);
        least[2] = fmin(least[2], hashed - loaded);
    }
    printf("| %s | %zu | %.1f | %.1f | %.1f |\n", name, size, 1e6 * least[0], 1e6 * least[1],
           1e6 * least[2]);
    free(bytes);
}

static void measure_states(int steps) {
    size_t const case_count = sizeof CASES / sizeof CASES[0];
    for (size_t i = 0; i < case_count; i += 2) {
        tulle_world *const world = make_world(&CASES[i], 0);
        for (int step = 0; step < steps; step++)
            require(tulle_world_step(world, STEP, NULL, &error));
        measure_state(CASES[i].name, world, NULL, 0);
        tulle_world_destroy(world);
    }
    cape_world cape;
    make_cape(&cape);
    for (int step = 0; step < CAPE_STEPS; step++) walk(&cape);
    measure_state("a cape", cape.world, &cape, 0);
    measure_state("a cape, after some steps", cape.world, &cape, LATE);
    tulle_world_destroy(cape.world);
    tulle_mesh_destroy(&cape.cape);
    tulle_mesh_destroy(&cape.body);
}

int main(int argc, char **argv) {
    int const count = argc > 1 ? atoi(argv[1]) : 64, steps = argc > 2 ? atoi(argv[2]) : 240;
    int const threads = argc > 3 ? atoi(argv[3]) : 2;
    if (count < 1 || steps < 1 || threads < 0 || threads > 256) return 2;
    size_t const case_count = sizeof CASES / sizeof CASES[0];
    printf("%d worlds of %d particles, %d steps, %d threads\n\n", count, SIDE * SIDE, steps,
           threads);
    printf("| cloth | steps a second in sum | us of a processor a step | solves | iterations | "
           "contacts | of it solves |\n|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < case_count; i++) measure_steps(&CASES[i], (size_t)count, steps, threads);
    printf("\n| state | bytes | us to save | us to load | us to hash |\n|---|---|---|---|---|\n");
    measure_states(steps);
    return 0;
}
