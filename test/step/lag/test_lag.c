/* Bodies that pass through themselves with cloth between: the lagging surface keeps the cloth's
 * room, the drawn one goes its way, and both are the same again as soon as there is room. */
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0;
static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double SIDE = 0.06;             /* [m] of each block */
static const double GAP = 0.03;              /* [m] between the blocks at first */
static const double DEPTH = 0.04; /* [m] by which one block is in the other at last, as drawn */
static const double CLOSED = 0.4, HELD = 0.7, OPEN = 1.1, END = 1.4; /* [s] */
enum { FRAMES = 127 };                                               /* of 1/90 s */

/* ---- two blocks in one mesh ---- */

/* [m] by how much each block is nearer to the middle than at first */
static double get_way(double time) {
    double const way = 0.5 * (GAP + DEPTH);
    if (time < 0.1 || time > OPEN) return 0.0;
    double const share = time < CLOSED ? (time - 0.1) / (CLOSED - 0.1)
                         : time < HELD ? 1.0
                                       : (OPEN - time) / (OPEN - HELD);
    return way * share * share * (3.0 - 2.0 * share);
}

typedef struct blocks {
    tulle_mesh mesh; /* as they are at first; the left block's vertices first */
    size_t left_count;
} blocks;

static void place_blocks(const blocks *made, double time, double *positions) {
    for (size_t v = 0; v < made->mesh.vertex_count; v++) {
        memcpy(positions + 3 * v, made->mesh.positions + 3 * v, 3 * sizeof(double));
        positions[3 * v + 1] += (v < made->left_count ? 1.0 : -1.0) * get_way(time);
    }
}

static tulle_status read_blocks(void *context, uint32_t frame, double *positions,
                                tulle_error *error) {
    (void)error;
    place_blocks(context, (double)frame * STEP, positions);
    return TULLE_OK;
}

/* A block left and one right of the plane y = 0, of squares of a centimetre. */
static blocks make_blocks(void) {
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    for (int k = 0; k < 3; k++) box.size[k] = SIDE;
    box.resolution[0] = box.resolution[1] = 7;
    tulle_mesh parts[2];
    blocks made = {0};
    for (int k = 0; k < 2; k++)
        parts[k] = small_shape(box, 0.0, (k == 0 ? -0.5 : 0.5) * (SIDE + GAP), 0.0);
    size_t const vertices = parts[0].vertex_count, triangles = parts[0].triangle_count;
    made.left_count = vertices;
    made.mesh.vertex_count = 2 * vertices;
    made.mesh.triangle_count = 2 * triangles;
    made.mesh.positions = malloc(6 * vertices * sizeof(double));
    made.mesh.triangles = malloc(6 * triangles * sizeof(uint32_t));
    for (size_t k = 0; k < 2; k++) {
        memcpy(made.mesh.positions + 3 * k * vertices, parts[k].positions,
               3 * vertices * sizeof(double));
        for (size_t i = 0; i < 3 * triangles; i++)
            made.mesh.triangles[3 * k * triangles + i] =
                parts[k].triangles[i] + (uint32_t)(k * vertices);
        tulle_mesh_destroy(&parts[k]);
    }
    return made;
}

static void free_blocks(blocks *made) {
    free(made->mesh.positions);
    free(made->mesh.triangles);
}

/* ---- the world ---- */

typedef enum where { BETWEEN, ASIDE } where;

typedef struct room_world {
    tulle_world *world;
    blocks blocks;
    tulle_mesh sheet;
    tulle_cloth_id cloth;
    tulle_obstacle_id body;
} room_world;

static tulle_world_def make_def(tulle_on_pinch choice, int threads) {
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = CONTACT_DISTANCE;
    def.threads = threads;
    if (choice != TULLE_ON_PINCH_LAG) def.on_pinch = choice; /* it is the default */
    return def;
}

/* A sheet that hangs in a plane of y, pinned along its upper edge. */
static void add_sheet_at(room_world *made, double y) {
    tulle_mesh_destroy(&made->sheet);
    made->sheet = small_sheet(0.2, 17, 0.0);
    uint32_t upper[32];
    size_t count = 0;
    for (uint32_t v = 0; v < made->sheet.vertex_count; v++) {
        double *const x = made->sheet.positions + 3 * v;
        x[2] = x[1];
        x[1] = y;
        if (x[2] > 0.0999) upper[count++] = v;
    }
    assert_int_equal(count, 17);
    tulle_pin const pin = make_pin(upper, count, (double)INFINITY);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&made->sheet);
    def.pins = &pin;
    def.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(made->world, &def, &made->cloth, NULL), TULLE_OK);
}

static void add_hanging_sheet(room_world *made, where place) {
    add_sheet_at(made, place == BETWEEN ? 0.0 : 0.5);
}

static void add_body(room_world *made, bool is_given) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&made->blocks.mesh);
    def.name = "body";
    if (is_given) {
        def.drive = TULLE_DRIVE_DEFORMING;
    } else {
        def.read_frame = read_blocks;
        def.frame_context = &made->blocks;
        def.frame_count = FRAMES;
        def.frame_interval = STEP;
    }
    assert_int_equal(tulle_world_add_obstacle(made->world, &def, &made->body, NULL), TULLE_OK);
}

static void make_world(room_world *made, tulle_world_def def, where place, bool is_given) {
    *made = (room_world){.blocks = make_blocks()};
    assert_int_equal(tulle_world_create(&def, &made->world, NULL), TULLE_OK);
    add_hanging_sheet(made, place);
    add_body(made, is_given);
}

static void free_world(room_world *made) {
    tulle_world_destroy(made->world);
    tulle_mesh_destroy(&made->sheet);
    free_blocks(&made->blocks);
}

static void copy_values(const room_world *made, tulle_values values, double *numbers) {
    size_t const count = made->blocks.mesh.vertex_count;
    tulle_target const target = {numbers, 3 * count * sizeof(double), 0, TULLE_NUMBER_DOUBLE};
    assert_int_equal(tulle_object_copy_values(made->world, tulle_object_from_obstacle(made->body),
                                              values, &target, NULL),
                     TULLE_OK);
}

static double *allocate_positions(const room_world *made) {
    return calloc(3 * made->blocks.mesh.vertex_count, sizeof(double));
}

/* Pairs of the sheet with the surface of the blocks at `positions`. */
static size_t count_crossings(const room_world *made, const double *positions) {
    tulle_mesh_view sheet = tulle_mesh_get_view(&made->sheet);
    tulle_mesh_view body = tulle_mesh_get_view(&made->blocks.mesh);
    sheet.positions = tulle_cloth_get_positions(made->world, made->cloth, NULL);
    body.positions = positions;
    tulle_check_body const bodies[2] = {{sheet, 0}, {body, 1}};
    tulle_check_result result = {0};
    assert_int_equal(tulle_check_intersections(bodies, 2, 1, &result, NULL), TULLE_OK);
    size_t const count = result.pair_count;
    tulle_check_result_destroy(&result);
    return count;
}

/* [m] between the inner faces of the blocks: the least over their vertices. */
static double measure_gap(const room_world *made, const double *positions) {
    double left = -1.0, right = 1.0;
    for (size_t v = 0; v < made->blocks.mesh.vertex_count; v++) {
        const double *const start = made->blocks.mesh.positions + 3 * v;
        if (v < made->blocks.left_count && start[1] > -0.51 * GAP)
            left = fmax(left, positions[3 * v + 1]);
        if (v >= made->blocks.left_count && start[1] < 0.51 * GAP)
            right = fmin(right, positions[3 * v + 1]);
    }
    return right - left;
}

/* [m] the farthest way of a vertex between two moments */
static double measure_fastest(const double *before, const double *after, size_t vertex_count) {
    double farthest = 0.0;
    for (size_t v = 0; v < vertex_count; v++) {
        double square = 0.0;
        for (size_t k = 3 * v; k < 3 * v + 3; k++)
            square += (after[k] - before[k]) * (after[k] - before[k]);
        farthest = fmax(farthest, sqrt(square));
    }
    return farthest;
}

static void step_world(const room_world *made, tulle_step_report *report) {
    tulle_error error = {0};
    if (tulle_world_step(made->world, STEP, report, &error) != TULLE_OK)
        fail_msg("step %llu: %s", (unsigned long long)tulle_world_get_step_count(made->world),
                 error.message);
}

/* ---- tests ---- */

/* What a run of the closing blocks saw. */
typedef struct seen {
    size_t begins, ends; /* messages */
    size_t drawn_crossings;
    double narrowest;                      /* [m] gap of the lagging blocks */
    double last_lag, largest_lag, fastest; /* [m], [m] of a lagging vertex in a step */
} seen;

/* Steps with all that must hold in each; `drawn` and `lagging` take the blocks. */
static void watch_step(const room_world *made, double *drawn, double *lagging, double *sheet,
                       seen *saw) {
    tulle_step_report report = {0};
    size_t const count = made->blocks.mesh.vertex_count, cloth_count = made->sheet.vertex_count;
    double *const place_before = allocate_positions(made);
    double *const sheet_before = calloc(3 * cloth_count, sizeof(double));
    memcpy(place_before, lagging, 3 * count * sizeof(double));
    memcpy(sheet_before, sheet, 3 * cloth_count * sizeof(double));
    step_world(made, &report);
    copy_values(made, TULLE_VALUES_POSITIONS, lagging);
    copy_values(made, TULLE_VALUES_DRAWN_POSITIONS, drawn);
    memcpy(sheet, tulle_cloth_get_positions(made->world, made->cloth, NULL),
           3 * cloth_count * sizeof(double));
    assert_int_equal(count_crossings(made, lagging), 0);
    saw->drawn_crossings += count_crossings(made, drawn) > 0;
    saw->narrowest = fmin(saw->narrowest, measure_gap(made, lagging));
    saw->largest_lag = fmax(saw->largest_lag, report.largest_lag);
    assert_int_equal(report.pinched, report.largest_lag > 0.0 || saw->last_lag > 0.0);
    saw->last_lag = report.largest_lag;
    assert_true(fabs(measure_fastest(drawn, lagging, count) - report.largest_lag) < 1e-15);
    assert_int_equal(report.rescue_impact_zones + report.rescue_component_scalings +
                         report.rescue_global_scalings,
                     0);
    const char *const message = tulle_world_last_message(made->world);
    saw->begins += strstr(message, "'body' leaves cloth no room near (") != NULL;
    saw->ends += strstr(message, "'body' follows its script again at") != NULL;
    /* neither closing nor coming back throws anything */
    saw->fastest = fmax(saw->fastest, measure_fastest(place_before, lagging, count));
    double const thrown = measure_fastest(sheet_before, sheet, cloth_count);
    if (report.largest_lag > 0.0 && thrown > 3.0 * saw->fastest)
        fail_msg("%g s: cloth goes %g m, the lagging surface %g m", report.time, thrown,
                 saw->fastest);
    free(place_before);
    free(sheet_before);
}

static void cloth_between_parts_keeps_its_room(void **state) {
    (void)state;
    room_world made;
    make_world(&made, make_def(TULLE_ON_PINCH_LAG, 1), BETWEEN, false);
    double *const drawn = allocate_positions(&made), *const lagging = allocate_positions(&made);
    double *const frame = allocate_positions(&made);
    double *const sheet = calloc(3 * made.sheet.vertex_count, sizeof(double));
    seen saw = {.narrowest = 1.0};
    place_blocks(&made.blocks, 0.0, lagging);
    for (int i = 1; i < FRAMES; i++) {
        watch_step(&made, drawn, lagging, sheet, &saw);
        place_blocks(&made.blocks, (double)i * STEP, frame);
        assert_true(measure_fastest(drawn, frame, made.blocks.mesh.vertex_count) < 1e-15);
    }
    /* a layer has nine tenths of the contact distance on both sides */
    double const room = 1.8 * CONTACT_DISTANCE;
    if (!(saw.narrowest > 0.8 * room && saw.narrowest < 1.1 * room))
        fail_msg("the blocks come as near as %g m, not %g m", saw.narrowest, room);
    assert_true(saw.largest_lag > 0.45 * (DEPTH + room) && saw.largest_lag < DEPTH + 2.0 * room);
    assert_true(saw.drawn_crossings > 20);
    assert_int_equal(saw.begins, 1);
    assert_int_equal(saw.ends, 1);
    assert_memory_equal(lagging, frame, 3 * made.blocks.mesh.vertex_count * sizeof(double));
    free(drawn);
    free(lagging);
    free(frame);
    free(sheet);
    free_world(&made);
}

/* Each layer on the way across has its room: three thicknesses for two layers, where one has two.
 */
static void two_layers_have_more_room(void **state) {
    (void)state;
    room_world made = {.blocks = make_blocks()};
    tulle_world_def const def = make_def(TULLE_ON_PINCH_LAG, 1);
    assert_int_equal(tulle_world_create(&def, &made.world, NULL), TULLE_OK);
    add_sheet_at(&made, -0.6 * CONTACT_DISTANCE);
    add_sheet_at(&made, 0.6 * CONTACT_DISTANCE);
    add_body(&made, false);
    double *const lagging = allocate_positions(&made);
    double narrowest = 1.0;
    for (int i = 1; i < (int)(HELD / STEP); i++) {
        step_world(&made, NULL);
        copy_values(&made, TULLE_VALUES_POSITIONS, lagging);
        narrowest = fmin(narrowest, measure_gap(&made, lagging));
    }
    double const room = 2.7 * CONTACT_DISTANCE;
    if (!(narrowest > 0.8 * room && narrowest < 1.2 * room))
        fail_msg("the blocks come as near as %g m, not %g m", narrowest, room);
    free(lagging);
    free_world(&made);
}

/* Where no cloth is between, a world that may lag has the bits of one that stops. */
static void without_cloth_between_nothing_lags(void **state) {
    (void)state;
    room_world made[2];
    make_world(&made[0], make_def(TULLE_ON_PINCH_LAG, 1), ASIDE, false);
    make_world(&made[1], make_def(TULLE_ON_PINCH_STOP, 1), ASIDE, false);
    for (int i = 1; i < FRAMES; i++) {
        tulle_step_report report = {0};
        for (int k = 0; k < 2; k++) step_world(&made[k], &report);
        assert_true(report.largest_lag == 0.0);
        assert_true(tulle_world_get_state_hash(made[0].world) ==
                    tulle_world_get_state_hash(made[1].world));
    }
    for (int k = 0; k < 2; k++) free_world(&made[k]);
}

/* Two threads give the bits of one; so does a world that takes over from a saved state while its
 * body lags. */
static void threads_and_saved_states_have_the_same_bits(void **state) {
    (void)state;
    room_world made[3];
    for (int k = 0; k < 3; k++)
        make_world(&made[k], make_def(TULLE_ON_PINCH_LAG, k == 1 ? 2 : 1), BETWEEN, false);
    bool was_loaded = false;
    for (int i = 1; i < FRAMES; i++) {
        tulle_step_report report = {0};
        for (int k = 0; k < 3; k++)
            if (k < 2 || was_loaded) step_world(&made[k], &report);
        uint64_t const hash = tulle_world_get_state_hash(made[0].world);
        assert_true(tulle_world_get_state_hash(made[1].world) == hash);
        if (was_loaded) assert_true(tulle_world_get_state_hash(made[2].world) == hash);
        if (was_loaded || !((double)i * STEP > CLOSED)) continue;
        assert_true(report.largest_lag > 0.0);
        void *bytes = NULL;
        size_t size = 0;
        assert_int_equal(tulle_world_save_state(made[0].world, &bytes, &size, NULL), TULLE_OK);
        assert_int_equal(tulle_world_load_state(made[2].world, bytes, size, NULL), TULLE_OK);
        assert_true(tulle_world_get_state_hash(made[2].world) == hash);
        double *const drawn[2] = {allocate_positions(&made[0]), allocate_positions(&made[2])};
        for (int k = 0; k < 2; k++)
            copy_values(&made[2 * k], TULLE_VALUES_DRAWN_POSITIONS, drawn[k]);
        assert_memory_equal(drawn[0], drawn[1],
                            3 * made[0].blocks.mesh.vertex_count * sizeof(double));
        for (int k = 0; k < 2; k++) free(drawn[k]);
        tulle_world_free_state(made[0].world, bytes, size);
        was_loaded = true;
    }
    assert_true(was_loaded);
    for (int k = 0; k < 3; k++) free_world(&made[k]);
}

/* A host gives the frames, and nothing for some steps in the middle: the drawn blocks stand still
 * then, and so do the lagging ones. A jump out of the cloth leaves no lag. */
static void given_positions_lag_alike(void **state) {
    (void)state;
    room_world made;
    make_world(&made, make_def(TULLE_ON_PINCH_LAG, 1), BETWEEN, true);
    assert_int_equal(tulle_world_start(made.world, NULL), TULLE_OK);
    double *const drawn = allocate_positions(&made), *const lagging = allocate_positions(&made);
    double *const frame = allocate_positions(&made);
    double *const sheet = calloc(3 * made.sheet.vertex_count, sizeof(double));
    seen saw = {.narrowest = 1.0};
    place_blocks(&made.blocks, 0.0, lagging);
    place_blocks(&made.blocks, 0.0, frame);
    int const closed = (int)(CLOSED / STEP) + 1;
    for (int i = 1; i < closed + 10; i++) {
        if (i <= closed) {
            place_blocks(&made.blocks, (double)i * STEP, frame);
            assert_int_equal(tulle_obstacle_set_next_positions(made.world, made.body, frame,
                                                               made.blocks.mesh.vertex_count,
                                                               TULLE_TRAVEL_MOVE, NULL),
                             TULLE_OK);
        }
        watch_step(&made, drawn, lagging, sheet, &saw);
        assert_true(measure_fastest(drawn, frame, made.blocks.mesh.vertex_count) < 1e-14);
    }
    assert_true(saw.largest_lag > 0.01 && saw.narrowest > CONTACT_DISTANCE);
    place_blocks(&made.blocks, 0.0, frame);
    assert_int_equal(tulle_obstacle_set_next_positions(made.world, made.body, frame,
                                                       made.blocks.mesh.vertex_count,
                                                       TULLE_TRAVEL_JUMP, NULL),
                     TULLE_OK);
    tulle_step_report report = {0};
    step_world(&made, &report);
    copy_values(&made, TULLE_VALUES_POSITIONS, lagging);
    assert_true(report.largest_lag == 0.0);
    assert_memory_equal(lagging, frame, 3 * made.blocks.mesh.vertex_count * sizeof(double));
    free(drawn);
    free(lagging);
    free(frame);
    free(sheet);
    free_world(&made);
}

/* What still lags when it is given nothing more comes to where it was told, to the end. */
static void what_is_given_nothing_more_comes_back(void **state) {
    (void)state;
    room_world made;
    make_world(&made, make_def(TULLE_ON_PINCH_LAG, 1), BETWEEN, true);
    assert_int_equal(tulle_world_start(made.world, NULL), TULLE_OK);
    size_t const count = made.blocks.mesh.vertex_count;
    double *const frame = allocate_positions(&made), *const lagging = allocate_positions(&made);
    tulle_step_report report = {0};
    int const closed = (int)(CLOSED / STEP) + 1;
    for (int i = 1; i <= closed + 8; i++) { /* then wide open within eight steps */
        place_blocks(&made.blocks, i <= closed ? (double)i * STEP : 0.0, frame);
        if (i > closed) {
            double const share = (double)(closed + 8 - i) / 8.0;
            for (size_t v = 0; v < count; v++)
                frame[3 * v + 1] += (v < made.blocks.left_count ? 1.0 : -1.0) * share *
                                    get_way((double)closed * STEP);
        }
        assert_int_equal(tulle_obstacle_set_next_positions(made.world, made.body, frame, count,
                                                           TULLE_TRAVEL_MOVE, NULL),
                         TULLE_OK);
        step_world(&made, &report);
    }
    assert_true(report.largest_lag > 1e-3);
    for (int i = 0; i < 90 && report.largest_lag > 0.0; i++) step_world(&made, &report);
    assert_true(report.largest_lag == 0.0);
    for (int i = 0; i < 3; i++) {
        copy_values(&made, TULLE_VALUES_POSITIONS, lagging);
        assert_true(measure_fastest(lagging, frame, count) < 1e-14);
        step_world(&made, &report);
    }
    free(frame);
    free(lagging);
    free_world(&made);
}

/* Frames of one block that goes down by `context` [m] until HELD, and up again. */
typedef struct press {
    tulle_mesh block;
    double way;
} press;

static tulle_status read_press(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    (void)error;
    const press *const made = context;
    double const time = (double)frame * STEP;
    double const share = fmin(1.0, fmax(0.0, time < HELD ? time / 0.5 : (END - time) / 0.5));
    for (size_t k = 0; k < 3 * made->block.vertex_count; k++)
        positions[k] = made->block.positions[k] - (k % 3 == 2 ? share * made->way : 0.0);
    return TULLE_OK;
}

static void add_pressed(tulle_world *world, press *made) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&made->block);
    def.name = "press";
    def.read_frame = read_press;
    def.frame_context = made;
    def.frame_count = FRAMES;
    def.frame_interval = STEP;
    assert_int_equal(tulle_world_add_obstacle(world, &def, NULL, NULL), TULLE_OK);
}

static void add_press(tulle_world *world, press *made, double height) {
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    for (int k = 0; k < 3; k++) box.size[k] = SIDE;
    box.resolution[0] = box.resolution[1] = 7;
    made->block = small_shape(box, 0.0, 0.0, height + 0.5 * SIDE);
    add_pressed(world, made);
}

static double find_lowest(const tulle_world *world, tulle_obstacle_id id) {
    size_t count = 0;
    const double *const x = tulle_obstacle_get_positions(world, id, &count);
    double lowest = 1.0;
    for (size_t v = 0; v < count; v++) lowest = fmin(lowest, x[3 * v + 2]);
    return lowest;
}

/* What does not deform keeps its place; what deforms lags by all that is missing. */
static void press_on_table(tulle_on_pinch choice) {
    tulle_world_def const def = make_def(choice, 1);
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.2, 17, 1.5e-3);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.3;
    box.size[2] = 0.05;
    tulle_mesh table = small_shape(box, 0.0, 0.0, -0.025);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &table);
    press made = {.way = 0.05}; /* 2 cm into the table */
    add_press(world, &made, 0.03);
    tulle_obstacle_id const id = {1, 1};
    double lowest = 1.0, largest = 0.0;
    for (int i = 1; i < FRAMES; i++) {
        tulle_step_report report = {0};
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        lowest = fmin(lowest, find_lowest(world, id));
        largest = fmax(largest, report.largest_lag);
    }
    double const room = 1.8 * CONTACT_DISTANCE;
    if (!(lowest > 0.85 * room && lowest < 1.2 * room)) fail_msg("down to %g m", lowest);
    if (!(largest > 0.02 && largest < 0.02 + 1.5 * room)) fail_msg("lags by up to %g m", largest);
    assert_true(find_lowest(world, id) == 0.03);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&table);
    tulle_mesh_destroy(&made.block);
}

static void a_table_does_not_lag(void **state) {
    (void)state;
    press_on_table(TULLE_ON_PINCH_LAG);
    press_on_table(TULLE_ON_PINCH_SLOW);
}

/* Cloth that is pinned all over cannot give way at all. */
static void pins_are_kept_clear(void **state) {
    (void)state;
    tulle_world_def const def = make_def(TULLE_ON_PINCH_LAG, 1);
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.2, 21, 0.0);
    uint32_t all[21 * 21];
    for (uint32_t v = 0; v < 21 * 21; v++) all[v] = v;
    tulle_pin const pin = make_pin(all, 21 * 21, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    press made = {.way = 0.05};
    add_press(world, &made, 0.03);
    tulle_obstacle_id const id = {0, 1};
    double lowest = 1.0;
    for (int i = 1; i < FRAMES; i++) {
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, NULL, &error) != TULLE_OK) fail_msg("%s", error.message);
        lowest = fmin(lowest, find_lowest(world, id));
    }
    if (!(lowest > 0.5 * CONTACT_DISTANCE && lowest < 1.1 * CONTACT_DISTANCE))
        fail_msg("down to %g m", lowest);
    assert_true(find_lowest(world, id) == 0.03);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&made.block);
}

/* A plate that rises past a pin, 6 mm beside its edge: the pin is not on its way, so nothing lags
 * although the plate comes level with it. */
static void what_passes_beside_a_pin_goes_on(void **state) {
    (void)state;
    tulle_world_def const def = make_def(TULLE_ON_PINCH_LAG, 1);
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    static const double corners[9] = {0.036, 0.0, 0.0, 0.05, -0.01, 0.0, 0.05, 0.01, 0.0};
    static const uint32_t all[3] = {0, 1, 2};
    tulle_pin const pin = make_pin(all, 3, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = (tulle_mesh_view){corners, 3, all, 1};
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    plane.size[0] = plane.size[1] = SIDE;
    plane.resolution[0] = plane.resolution[1] = 7;
    press made = {.block = small_shape(plane, 0.0, 0.0, -0.006), .way = -0.012};
    add_pressed(world, &made);
    double highest = -1.0;
    for (int i = 1; i < FRAMES; i++) {
        tulle_step_report report = {0};
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        if (report.largest_lag != 0.0) fail_msg("step %d: lags by %g m", i, report.largest_lag);
        highest = fmax(highest, find_lowest(world, (tulle_obstacle_id){0, 1}));
    }
    assert_true(fabs(highest - 0.006) < 1e-12);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&made.block);
}

/* Blocks on keyframes that close as those of the mesh sequence do. */
static void add_fingers(tulle_world *world, tulle_mesh fingers[2]) {
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    for (int k = 0; k < 3; k++) box.size[k] = SIDE;
    for (int k = 0; k < 2; k++) {
        double const side = k == 0 ? -1.0 : 1.0;
        fingers[k] = small_shape(box, 0.0, side * 0.5 * (SIDE + GAP), 0.0);
        tulle_keyframe const keys[2] = {{0.1, {0, 0, 0}, {0, 0, 0}},
                                        {CLOSED, {0, -side * 0.5 * (GAP + DEPTH), 0}, {0, 0, 0}}};
        tulle_obstacle_def finger = tulle_obstacle_def_default();
        finger.mesh = tulle_mesh_get_view(&fingers[k]);
        finger.motion = (tulle_motion){keys, 2, {0, 0, 0}, 0};
        assert_int_equal(tulle_world_add_obstacle(world, &finger, NULL, NULL), TULLE_OK);
    }
}

/* The default lets nothing rigid lag: blocks on keyframes stop the step. */
static void what_is_rigid_stops(void **state) {
    (void)state;
    room_world made = {.blocks = make_blocks()};
    tulle_world_def const def = make_def(TULLE_ON_PINCH_LAG, 1);
    assert_int_equal(tulle_world_create(&def, &made.world, NULL), TULLE_OK);
    add_hanging_sheet(&made, BETWEEN);
    tulle_mesh fingers[2];
    add_fingers(made.world, fingers);
    tulle_status status = TULLE_OK;
    tulle_error error = {0};
    for (int i = 1; i < FRAMES && status == TULLE_OK; i++)
        status = tulle_world_step(made.world, STEP, NULL, &error);
    assert_int_equal(status, TULLE_ERROR_PINCHED);
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&fingers[k]);
    free_world(&made);
}

/* What may lag far off takes nothing from the tries at a pinch between rigid things. */
static void what_is_far_changes_no_try(void **state) {
    (void)state;
    room_world made[2];
    tulle_mesh fingers[2][2];
    uint32_t most = 0;
    for (int k = 0; k < 2; k++) {
        made[k] = (room_world){.blocks = make_blocks()};
        tulle_world_def const def = make_def(TULLE_ON_PINCH_SLOW, 1);
        assert_int_equal(tulle_world_create(&def, &made[k].world, NULL), TULLE_OK);
        add_hanging_sheet(&made[k], BETWEEN);
        add_fingers(made[k].world, fingers[k]);
        for (size_t v = 0; v < made[k].blocks.mesh.vertex_count; v++)
            made[k].blocks.mesh.positions[3 * v] += 5.0;
        if (k == 1) add_body(&made[k], true);
    }
    for (int i = 1; i < FRAMES; i++) {
        tulle_step_report reports[2] = {{0}};
        for (int k = 0; k < 2; k++) step_world(&made[k], &reports[k]);
        assert_int_equal(reports[0].substeps, reports[1].substeps);
        most = reports[0].substeps > most ? reports[0].substeps : most;
        assert_memory_equal(tulle_cloth_get_positions(made[0].world, made[0].cloth, NULL),
                            tulle_cloth_get_positions(made[1].world, made[1].cloth, NULL),
                            3 * made[0].sheet.vertex_count * sizeof(double));
    }
    assert_true(most > 20); /* shorter ones were tried */
    for (int k = 0; k < 2; k++) {
        for (int f = 0; f < 2; f++) tulle_mesh_destroy(&fingers[k][f]);
        free_world(&made[k]);
    }
}

/* A host that polls hears of it once when it begins and once when it ends. */
static void events_tell_of_a_lag(void **state) {
    (void)state;
    room_world made;
    make_world(&made, make_def(TULLE_ON_PINCH_LAG, 1), BETWEEN, false);
    assert_int_equal(tulle_world_start(made.world, NULL), TULLE_OK);
    tulle_event_watch const watch = tulle_event_watch_default();
    assert_int_equal(tulle_world_watch_events(made.world, &watch, NULL), TULLE_OK);
    size_t counts[2] = {0};
    for (int i = 1; i < FRAMES; i++) {
        step_world(&made, NULL);
        tulle_event events[64];
        size_t count = 0;
        assert_int_equal(tulle_world_poll_events(made.world, events, 64, &count, NULL, NULL),
                         TULLE_OK);
        for (size_t k = 0; k < count; k++) {
            counts[0] += events[k].kind == TULLE_EVENT_PINCH_BEGIN;
            counts[1] += events[k].kind == TULLE_EVENT_PINCH_END;
        }
    }
    assert_int_equal(counts[0], 1);
    assert_int_equal(counts[1], 1);
    free_world(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_between_parts_keeps_its_room),
        cmocka_unit_test(two_layers_have_more_room),
        cmocka_unit_test(without_cloth_between_nothing_lags),
        cmocka_unit_test(threads_and_saved_states_have_the_same_bits),
        cmocka_unit_test(given_positions_lag_alike),
        cmocka_unit_test(what_is_given_nothing_more_comes_back),
        cmocka_unit_test(a_table_does_not_lag),
        cmocka_unit_test(pins_are_kept_clear),
        cmocka_unit_test(what_passes_beside_a_pin_goes_on),
        cmocka_unit_test(what_is_rigid_stops),
        cmocka_unit_test(what_is_far_changes_no_try),
        cmocka_unit_test(events_tell_of_a_lag),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
