/* What a step costs where cloth is at rest: cloths of 100 x 100 particles on a table and hanging
 * from two corners, awake and asleep; and a small one that swings, alone and beside a large one at
 * rest, which is awake or sleeps. One thread. Prints Markdown. Usage: bench_sleep [side] [steps] */
#include "tulle/tulle.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static const double STEP = 1.0 / 60.0; /* [s] */
static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "bench_sleep: %s\n", error.message);
    exit(1);
}

typedef struct bench_case {
    const char *name;
    bool has_table, hangs, has_swing; /* a large cloth on a table, or one that hangs; a small one */
    double sleep_speed;               /* [m/s] */
} bench_case;
static const bench_case CASES[] = {
    {"on a table, awake", true, false, false, 0.0},
    {"on a table, asleep", true, false, false, 1e-3},
    {"hangs, awake", false, true, false, 0.0},
    {"hangs, asleep", false, true, false, 1e-3},
    {"625 particles that swing", false, false, true, 1e-3},
    {"the same beside one on a table, awake", true, false, true, 0.0},
    {"the same beside one on a table, asleep", true, false, true, 1e-3},
};

/* [s] of all threads of the process. */
static double processor_time(void) { return (double)clock() / CLOCKS_PER_SEC; }

static tulle_mesh make_sheet(double size, unsigned side, double x, double z) {
    tulle_mesh sheet;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = shape.size[1] = size;
    shape.resolution[0] = shape.resolution[1] = side;
    require(tulle_shape_generate(&shape, &sheet, &error));
    for (size_t v = 0; v < sheet.vertex_count; v++) {
        sheet.positions[3 * v] += x;
        sheet.positions[3 * v + 2] = z;
    }
    return sheet;
}

static void add_sheet(tulle_world *world, tulle_mesh sheet, unsigned pinned_side, double damping) {
    uint32_t const corners[2] = {0, pinned_side - 1};
    tulle_pin pin = tulle_pin_default();
    pin.vertices = corners;
    pin.vertex_count = 2;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    def.pins = &pin;
    def.pin_count = pinned_side > 0;
    def.material.air_damping = damping;
    require(tulle_world_add_cloth(world, &def, NULL, &error));
    tulle_mesh_destroy(&sheet);
}

static tulle_world *make_world(const bench_case *kind, unsigned side) {
    tulle_world *world;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.contact_distance = 3e-3;
    def.sleep_speed = kind->sleep_speed;
    require(tulle_world_create(&def, &world, &error));
    if (kind->has_table) add_sheet(world, make_sheet(1.0, side, 0.0, 4e-3), 0, 0.0);
    /* damped, so that it comes to rest within seconds */
    if (kind->hangs) add_sheet(world, make_sheet(1.0, side, 0.0, 2.0), side, 5.0);
    if (kind->has_swing) add_sheet(world, make_sheet(0.5, 25, 2.0, 2.0), 25, 0.0);
    tulle_mesh table;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    shape.size[0] = shape.size[1] = 3.0;
    require(tulle_shape_generate(&shape, &table, &error));
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&table);
    require(tulle_world_add_obstacle(world, &obstacle, NULL, &error));
    tulle_mesh_destroy(&table);
    return world;
}

int main(int argc, char **argv) {
    unsigned const side = argc > 1 ? (unsigned)atoi(argv[1]) : 100;
    int const steps = argc > 2 ? atoi(argv[2]) : 60;
    if (side < 2 || steps < 1) {
        fprintf(stderr, "usage: bench_sleep [side] [steps]\n");
        return 1;
    }
    printf("| a step of %u x %u particles | ms | solves | asleep |\n|---|---|---|---|\n", side,
           side);
    for (size_t c = 0; c < sizeof CASES / sizeof CASES[0]; c++) {
        const bench_case *const kind = &CASES[c];
        tulle_world *const world = make_world(kind, side);
        tulle_cloth_id const first = {0, 1};
        bool const waits = kind->sleep_speed > 0.0 && (kind->has_table || kind->hangs);
        /* what hangs has 8 s to come to rest; what sleeps until then sleeps */
        int const settling = kind->hangs ? 480 : 45;
        for (int i = 0; i < settling || (waits && !tulle_cloth_is_asleep(world, first)); i++) {
            if (i > 6000) return 1;
            require(tulle_world_step(world, STEP, NULL, &error));
        }
        double solves = 0.0;
        double const start = processor_time();
        for (int i = 0; i < steps; i++) {
            tulle_step_report report;
            require(tulle_world_step(world, STEP, &report, &error));
            solves += report.solve_count;
        }
        printf("| %s | %.3f | %.1f | %s |\n", kind->name, 1e3 * (processor_time() - start) / steps,
               solves / steps, tulle_cloth_is_asleep(world, first) ? "yes" : "no");
        fflush(stdout);
        tulle_world_destroy(world);
    }
    return 0;
}
