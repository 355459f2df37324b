/* Arguments of the public functions of tulle/attach.h, against a world that has started, with a
 * pinned cloth, another one and obstacles, and against one that has not. */
#include "api/arguments.h"
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"

#include "tulle/attach.h"

static const double STEP = 1.0 / 64.0;

static tulle_mesh sheet, plate;
static tulle_world *started, *fresh, *of_paper;
static tulle_cloth_id cloth, other;
static tulle_obstacle_id fixed, late;

static tulle_world *make_world(tulle_response response) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    change_paper(&world_def)->response = response;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&world_def, &world, &error));
    static const uint32_t vertices[2] = {0, 1};
    tulle_pin pin = make_pin(vertices, 2, (double)INFINITY);
    pin.motion = (tulle_motion){NULL, 0, {0.0, 0.0, 0.0}, 0};
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    def.pins = &pin;
    def.pin_count = 1;
    if (response == TULLE_RESPONSE_PAPER) def.material.springs.stiffening_strain = 0.0;
    FINE(tulle_world_add_cloth(world, &def, &cloth, &error));
    tulle_mesh aside = small_sheet(0.3, 4, 2.0);
    def.mesh = tulle_mesh_get_view(&aside);
    def.pin_count = 0;
    FINE(tulle_world_add_cloth(world, &def, &other, &error));
    tulle_mesh_destroy(&aside);
    fixed = small_add_obstacle(world, &plate);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&plate);
    obstacle.appear_time = 10.0;
    FINE(tulle_world_add_obstacle(world, &obstacle, &late, &error));
    return world;
}

static int make_worlds(void **state) {
    (void)state;
    sheet = small_sheet(0.3, 4, 0.5);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 1.0;
    shape.size[2] = 0.1;
    plate = small_shape(shape, 0.0, 0.0, 0.0);
    started = make_world(TULLE_RESPONSE_COUPLED);
    fresh = make_world(TULLE_RESPONSE_COUPLED);
    of_paper = make_world(TULLE_RESPONSE_PAPER);
    FINE(tulle_world_start(started, &error));
    FINE(tulle_world_start(of_paper, &error));
    return 0;
}

static int free_worlds(void **state) {
    (void)state;
    tulle_world_destroy(started);
    tulle_world_destroy(fresh);
    tulle_world_destroy(of_paper);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&plate);
    return 0;
}

static const uint32_t some[3] = {13, 14, 15};
static const double somewhere[9] = {0.0, 0.0, 0.6, 0.1, 0.0, 0.6, 0.2, 0.0, 0.6};

static tulle_attachment_def make_def(void) {
    tulle_attachment_def def = tulle_attachment_def_default();
    def.cloth = cloth;
    def.vertices = some;
    def.vertex_count = 3;
    def.points = somewhere;
    return def;
}

/* Refused with a word of the message, and nothing is attached. */
static void refuse(tulle_world *world, const tulle_attachment_def *def, const char *word) {
    uint64_t const before = tulle_world_get_state_hash(world);
    tulle_attachment_id id = 77;
    tulle_status const status = tulle_world_attach(world, def, &id, &error);
    if (status != TULLE_ERROR_INVALID_ARGUMENT) fail_msg("%s: status %d", word, (int)status);
    if (!strstr(error.message, word)) fail_msg("no '%s' in '%s'", word, error.message);
    assert_int_equal(id, 77);
    assert_true(tulle_world_get_state_hash(world) == before);
}

ARGUMENTS_OF(tulle_attachment_def_default) {
    tulle_attachment_def const def = tulle_attachment_def_default();
    assert_true(def.cookie != 0 && def.max_distance == (double)INFINITY &&
                def.stiffness == (double)INFINITY && def.break_force == (double)INFINITY);
}

static void refuse_holders(void);

ARGUMENTS_OF(tulle_world_attach) {
    tulle_attachment_def def = make_def();
    tulle_attachment_id id;
    REFUSED(tulle_world_attach(NULL, &def, &id, &error));
    REFUSED(tulle_world_attach(started, NULL, &id, &error));
    REFUSED(tulle_world_attach(started, &def, NULL, &error));
    refuse(of_paper, &def, "TULLE_RESPONSE_COUPLED");
#define WITH(member, value, word)                                                                  \
    do {                                                                                           \
        def = make_def();                                                                          \
        def.member = value;                                                                        \
        refuse(started, &def, word);                                                               \
    } while (0)
    WITH(cookie, 0, "tulle_attachment_def_default");
    WITH(cloth.generation, 0, "cloth");
    WITH(cloth.index, 2, "cloth");
    WITH(vertices, NULL, "vertices");
    WITH(vertex_count, 0, "vertices");
    WITH(vertex_count, 17, "more vertices");
    WITH(points, NULL, "exactly one holder");
    WITH(obstacle, fixed, "exactly one holder");
    WITH(other_cloth, other, "exactly one holder");
    WITH(stiffness, 1e13, "stiffness");
    WITH(release_time, (double)NAN, "release_time");
    static const uint32_t beyond[3] = {13, 14, 16}, twice[3] = {13, 14, 13}, pinned[3] = {1, 2, 3};
    WITH(vertices, beyond, "not there");
    WITH(vertices, twice, "twice");
    WITH(vertices, pinned, "pin");
    static const double nowhere[9] = {0.0, 0.0, 0.0, 0.0, 1e101, 0.0, 0.0, 0.0, 0.0};
    static const double no_place[9] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (double)NAN, 0.0};
    WITH(points, nowhere, "points of vertex 1");
    WITH(points, no_place, "points of vertex 2");
#undef WITH
    refuse_holders();
}

static void refuse_holders(void) {
    tulle_attachment_def def = make_def();
    def.points = NULL;
    def.obstacle = (tulle_obstacle_id){2, 1};
    refuse(started, &def, "obstacle");
    def.obstacle = (tulle_obstacle_id){0, 2};
    refuse(started, &def, "obstacle");
    def.obstacle = late;
    refuse(started, &def, "not in the scene");
    def.obstacle = (tulle_obstacle_id){0, 0};
    def.other_cloth = (tulle_cloth_id){2, 1};
    refuse(started, &def, "another cloth");
    def.other_cloth = other;
    uint32_t triangles[3] = {0, 1, 17};
    static double weights[9] = {1.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.2, 0.2, 0.6};
    def.triangles = triangles;
    refuse(started, &def, "together");
    def.weights = weights;
    def.triangles = NULL;
    refuse(started, &def, "together");
    def.triangles = triangles;
    triangles[2] = 18;
    refuse(started, &def, "triangle 18");
    triangles[2] = 17;
    weights[4] = 0.6;
    refuse(started, &def, "sum");
    weights[4] = (double)NAN;
    refuse(started, &def, "weights of vertex 1");
    weights[4] = 0.5;
    def.other_cloth = cloth;
    for (uint32_t t = 0; t < sheet.triangle_count; t++)
        for (size_t k = 0; k < 3; k++)
            if (sheet.triangles[3 * t + k] == some[2]) triangles[2] = t;
    refuse(started, &def, "triangle of its own");
    def.other_cloth = (tulle_cloth_id){0, 0};
    def.points = somewhere;
    refuse(started, &def, "triangles");
}

/* Two attachments to points and one to an obstacle, and a place that is none. */
static tulle_attachment_id points_id, soft_id, over_id;
static const double no_place[9] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (double)INFINITY};

static int make_attachments(void **unused) {
    (void)unused;
    tulle_attachment_def def = make_def();
    FINE(tulle_world_attach(started, &def, &points_id, &error));
    refuse(started, &def, "rigidly");
    def.stiffness = 100.0; /* a spring may pull at what is held */
    FINE(tulle_world_attach(started, &def, &soft_id, &error));
    static const uint32_t first[1] = {4};
    def.vertices = first;
    def.vertex_count = 1;
    def.points = NULL;
    def.obstacle = fixed;
    FINE(tulle_world_attach(started, &def, &over_id, &error));
    assert_true(points_id == 1 && soft_id == 2 && over_id == 3);
    return 0;
}

ARGUMENTS_OF(tulle_attachment_set_points) {
    uint64_t const before = tulle_world_get_state_hash(started);
    REFUSED(tulle_attachment_set_points(NULL, points_id, somewhere, 3, &error));
    REFUSED(tulle_attachment_set_points(fresh, points_id, somewhere, 3, &error));
    REFUSED(tulle_attachment_set_points(started, 0, somewhere, 3, &error));
    REFUSED(tulle_attachment_set_points(started, 4, somewhere, 3, &error));
    REFUSED(tulle_attachment_set_points(started, points_id, NULL, 3, &error));
    REFUSED(tulle_attachment_set_points(started, points_id, somewhere, 2, &error));
    REFUSED(tulle_attachment_set_points(started, points_id, somewhere, SIZE_MAX / 2, &error));
    REFUSED(tulle_attachment_set_points(started, over_id, somewhere, 1, &error));
    REFUSED(tulle_attachment_set_points(started, points_id, no_place, 3, &error));
    assert_true(tulle_world_get_state_hash(started) == before);
    FINE(tulle_attachment_set_points(started, points_id, somewhere, 3, NULL));
}

ARGUMENTS_OF(tulle_attachment_get_report) {
    assert_int_equal(tulle_attachment_get_report(NULL, 1).held_count, 0);
    assert_int_equal(tulle_attachment_get_report(fresh, 1).held_count, 0);
    assert_int_equal(tulle_attachment_get_report(started, 0).held_count, 0);
    assert_int_equal(tulle_attachment_get_report(started, 4).held_count, 0);
    assert_int_equal(tulle_attachment_get_report(started, soft_id).held_count, 3);
}

ARGUMENTS_OF(tulle_attachment_holds) {
    assert_int_equal(tulle_attachment_holds(NULL, 1, 13), 0);
    assert_int_equal(tulle_attachment_holds(fresh, 1, 13), 0);
    assert_int_equal(tulle_attachment_holds(started, 0, 13), 0);
    assert_int_equal(tulle_attachment_holds(started, points_id, 12), 0);
    assert_int_equal(tulle_attachment_holds(started, points_id, UINT32_MAX), 0);
    assert_int_equal(tulle_attachment_holds(started, points_id, 13), 1);
}

ARGUMENTS_OF(tulle_attachment_release) {
    uint64_t const before = tulle_world_get_state_hash(started);
    REFUSED(tulle_attachment_release(NULL, points_id, &error));
    REFUSED(tulle_attachment_release(started, 0, &error));
    REFUSED(tulle_attachment_release(started, 4, &error));
    REFUSED(tulle_attachment_release(fresh, 1, &error));
    assert_true(tulle_world_get_state_hash(started) == before);
    FINE(tulle_attachment_release(started, over_id, &error));
    FINE(tulle_attachment_release(started, points_id, &error));
    FINE(tulle_attachment_release(started, soft_id, &error));
    FINE(tulle_world_step(started, STEP, NULL, &error));
}

int main(void) {
    for (size_t i = 0; i < argument_test_count; i++)
        if (strcmp(argument_tests[i].name, "tulle_attachment_set_points") == 0)
            argument_tests[i].setup_func = make_attachments;
    return run_arguments(HEADERS("tulle/attach.h"), make_worlds, free_worlds);
}
