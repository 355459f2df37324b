/* Arguments of the public functions of tulle/query.h, against a world that has started, with a
 * cloth and an obstacle, and against one that has not. */
#include "api/arguments.h"
#include "support/small_world.h"

static const double STEP = 1.0 / 64.0;

static tulle_mesh sheet, plate;
static tulle_world *started, *fresh, *springs;
static tulle_object_id cloth, obstacle;

static tulle_world *make_world(tulle_membrane membrane) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.membrane = membrane;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    cloth = tulle_object_from_cloth(small_add_cloth(world, &sheet));
    obstacle = tulle_object_from_obstacle(small_add_obstacle(world, &plate));
    return world;
}

static int set_up(void **unused) {
    (void)unused;
    sheet = small_sheet(0.3, 4, 0.1);
    plate = small_shape(tulle_shape_def_default(TULLE_SHAPE_BOX), 0.0, 0.0, -1.0);
    started = make_world(TULLE_MEMBRANE_WOVEN);
    fresh = make_world(TULLE_MEMBRANE_WOVEN);
    springs = make_world(TULLE_MEMBRANE_SPRINGS);
    FINE(tulle_world_step(started, STEP, NULL, &error));
    FINE(tulle_world_start(springs, &error));
    return 0;
}

/* Nothing that was refused has changed the worlds. */
static int tear_down(void **unused) {
    (void)unused;
    tulle_world *const other = make_world(TULLE_MEMBRANE_WOVEN);
    FINE(tulle_world_step(fresh, STEP, NULL, &error));
    FINE(tulle_world_step(other, STEP, NULL, &error));
    uint64_t const hash = tulle_world_get_state_hash(other);
    assert_true(tulle_world_get_state_hash(fresh) == hash);
    assert_true(tulle_world_get_state_hash(started) == hash);
    tulle_world *const worlds[] = {started, fresh, springs, other};
    for (int k = 0; k < 4; k++) tulle_world_destroy(worlds[k]);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&plate);
    return 0;
}

static const tulle_object_id bad_objects[] = {
    {TULLE_OBJECT_NONE, 0, 0},     {TULLE_OBJECT_NONE, 0, 1},
    {TULLE_OBJECT_CLOTH, 0, 0},    {TULLE_OBJECT_CLOTH, 0, 2},
    {TULLE_OBJECT_CLOTH, 1, 1},    {TULLE_OBJECT_CLOTH, UINT32_MAX, 1},
    {TULLE_OBJECT_OBSTACLE, 0, 0}, {TULLE_OBJECT_OBSTACLE, 1, 1},
    {(tulle_object_kind)99, 0, 1},
};
enum { BAD_OBJECT_COUNT = sizeof bad_objects / sizeof bad_objects[0] };

static void expect_zero(const void *bytes, size_t byte_count) {
    for (size_t i = 0; i < byte_count; i++) assert_int_equal(((const char *)bytes)[i], 0);
}

/* ---- objects ---- */

ARGUMENTS_OF(tulle_object_from_cloth) {
    tulle_object_id const none = tulle_object_from_cloth((tulle_cloth_id){0, 0});
    expect_zero(&none, sizeof none);
    tulle_object_id const some = tulle_object_from_cloth((tulle_cloth_id){7, 1});
    assert_true(some.kind == TULLE_OBJECT_CLOTH && some.index == 7 && some.generation == 1);
}

ARGUMENTS_OF(tulle_object_from_obstacle) {
    tulle_object_id const none = tulle_object_from_obstacle((tulle_obstacle_id){3, 0});
    expect_zero(&none, sizeof none);
    tulle_object_id const some = tulle_object_from_obstacle((tulle_obstacle_id){7, 1});
    assert_true(some.kind == TULLE_OBJECT_OBSTACLE && some.index == 7 && some.generation == 1);
}

ARGUMENTS_OF(tulle_world_get_object) {
    assert_int_equal(tulle_world_get_object(NULL, 0).kind, TULLE_OBJECT_NONE);
    assert_int_equal(tulle_world_get_object(started, 2).kind, TULLE_OBJECT_NONE);
    assert_int_equal(tulle_world_get_object(started, UINT32_MAX).kind, TULLE_OBJECT_NONE);
    assert_int_equal(tulle_world_get_object(fresh, 1).kind, TULLE_OBJECT_OBSTACLE);
}

ARGUMENTS_OF(tulle_world_get_counts) {
    tulle_counts const none = tulle_world_get_counts(NULL);
    expect_zero(&none, sizeof none);
    assert_int_equal(tulle_world_get_counts(fresh).cloth_vertices, 16);
}

ARGUMENTS_OF(tulle_object_get_info) {
    tulle_object_info info = tulle_object_get_info(NULL, cloth);
    expect_zero(&info, sizeof info);
    for (int i = 0; i < BAD_OBJECT_COUNT; i++) {
        info = tulle_object_get_info(started, bad_objects[i]);
        expect_zero(&info, sizeof info);
    }
    assert_int_equal(tulle_object_get_info(fresh, cloth).vertex_count, 16);
}

ARGUMENTS_OF(tulle_object_set_user_data) {
    REFUSED(tulle_object_set_user_data(NULL, cloth, &error, &error));
    for (int i = 0; i < BAD_OBJECT_COUNT; i++)
        REFUSED(tulle_object_set_user_data(started, bad_objects[i], &error, &error));
    assert_null(tulle_object_get_user_data(started, cloth));
    FINE(tulle_object_set_user_data(started, cloth, &cloth, NULL));
    assert_ptr_equal(tulle_object_get_user_data(started, cloth), &cloth);
    assert_null(tulle_object_get_user_data(started, obstacle));
    FINE(tulle_object_set_user_data(started, cloth, NULL, &error));
    assert_null(tulle_object_get_user_data(started, cloth));
}

ARGUMENTS_OF(tulle_object_get_user_data) {
    assert_null(tulle_object_get_user_data(NULL, cloth));
    for (int i = 0; i < BAD_OBJECT_COUNT; i++)
        assert_null(tulle_object_get_user_data(started, bad_objects[i]));
}

/* ---- queries ---- */

static tulle_hit hit;
static double const low[3] = {-1.0, -1.0, -1.0}, high[3] = {1.0, 1.0, 1.0};

/* A hit that was refused is all zero. */
#define REFUSED_HIT(call)                                                                          \
    do {                                                                                           \
        memset(&hit, 0x5a, sizeof hit);                                                            \
        REFUSED(call);                                                                             \
        expect_zero(&hit, sizeof hit);                                                             \
    } while (0)

ARGUMENTS_OF(tulle_world_cast_ray) {
    tulle_ray const ray = {.from = {0.0, 0.0, 1.0}, .to = {0.0, 0.0, -1.0}};
    REFUSED_HIT(tulle_world_cast_ray(NULL, &ray, &hit, &error));
    REFUSED_HIT(tulle_world_cast_ray(fresh, &ray, &hit, &error));
    REFUSED_HIT(tulle_world_cast_ray(started, NULL, &hit, &error));
    REFUSED(tulle_world_cast_ray(started, &ray, NULL, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 6; k++) {
            tulle_ray bad = ray;
            *(k < 3 ? &bad.from[k] : &bad.to[k - 3]) = no_numbers[i];
            REFUSED_HIT(tulle_world_cast_ray(started, &bad, &hit, &error));
        }
    tulle_ray still = ray;
    memcpy(still.to, still.from, sizeof still.to);
    REFUSED_HIT(tulle_world_cast_ray(started, &still, &hit, &error));
    FINE(tulle_world_cast_ray(started, &ray, &hit, NULL));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_CLOTH);
    tulle_ray const longest = {.from = {0.01, 0.02, 1e100}, .to = {0.01, 0.02, -1e100}};
    FINE(tulle_world_cast_ray(started, &longest, &hit, &error));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_CLOTH);
    assert_true(fabs(hit.position[0] - 0.01) < 1e-12 && fabs(hit.position[2]) < 0.11);
    tulle_ray const shortest = {.from = {5.0, 0.0, 0.0}, .to = {5.0, 0.0, DBL_TRUE_MIN}};
    FINE(tulle_world_cast_ray(started, &shortest, &hit, &error));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_NONE);
}

ARGUMENTS_OF(tulle_world_find_closest_point) {
    double const point[3] = {0.0, 0.0, 1.0};
    REFUSED_HIT(tulle_world_find_closest_point(NULL, point, 1.0, 0, &hit, &error));
    REFUSED_HIT(tulle_world_find_closest_point(fresh, point, 1.0, 0, &hit, &error));
    REFUSED_HIT(tulle_world_find_closest_point(started, NULL, 1.0, 0, &hit, &error));
    REFUSED(tulle_world_find_closest_point(started, point, 1.0, 0, NULL, &error));
    REFUSED_HIT(tulle_world_find_closest_point(started, point, -1.0, 0, &hit, &error));
    REFUSED_HIT(tulle_world_find_closest_point(started, point, (double)NAN, 0, &hit, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 3; k++) {
            double bad[3] = {0.0, 0.0, 1.0};
            bad[k] = no_numbers[i];
            REFUSED_HIT(tulle_world_find_closest_point(started, bad, 1.0, 0, &hit, &error));
        }
    FINE(tulle_world_find_closest_point(started, point, 0.5, 0, &hit, &error));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_NONE);
    double const far_away[3] = {1e100, 0.0, 0.0};
    FINE(tulle_world_find_closest_point(started, far_away, (double)INFINITY, 0, &hit, NULL));
    assert_int_not_equal(hit.object.kind, TULLE_OBJECT_NONE);
}

static tulle_found_triangle triangles[64];
static tulle_found found;

/* Nothing is found by what is refused. */
#define REFUSED_FIND(status, call)                                                                 \
    do {                                                                                           \
        found = (tulle_found){triangles, 64, 7};                                                   \
        REFUSED_WITH(status, call);                                                                \
        assert_int_equal(found.count, 0);                                                          \
    } while (0)

static tulle_status in_box(tulle_world *world, const double *from, const double *to) {
    return tulle_world_find_box_overlaps(world, from, to, 0, &found, &error);
}

ARGUMENTS_OF(tulle_world_find_box_overlaps) {
    tulle_status const bad = TULLE_ERROR_INVALID_ARGUMENT;
    REFUSED_FIND(bad, in_box(NULL, low, high));
    REFUSED_FIND(bad, in_box(fresh, low, high));
    REFUSED_FIND(bad, in_box(started, NULL, high));
    REFUSED_FIND(bad, in_box(started, low, NULL));
    for (int k = 0; k < 3; k++) {
        double sides[2][3] = {{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
        sides[0][k] = 1.001;
        REFUSED_FIND(bad, in_box(started, sides[0], sides[1]));
        for (int i = 0; i < NO_NUMBER_COUNT; i++) {
            double numbers[2][3] = {{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
            numbers[0][k] = no_numbers[i];
            REFUSED_FIND(bad, in_box(started, numbers[0], numbers[1]));
            numbers[0][k] = -1.0;
            numbers[1][k] = no_numbers[i];
            REFUSED_FIND(bad, in_box(started, numbers[0], numbers[1]));
        }
    }
    REFUSED(tulle_world_find_box_overlaps(started, low, high, 0, NULL, &error));
    tulle_found none = {NULL, 1, 7};
    REFUSED(tulle_world_find_box_overlaps(started, low, high, 0, &none, &error));
    assert_int_equal(none.count, 0);
    none.capacity = 0;
    FINE(tulle_world_find_box_overlaps(started, low, high, 0, &none, NULL));
    assert_true(none.count >= 18);
    FINE(in_box(started, high, high));
    assert_int_equal(found.count, 0);
}

static tulle_status in_mesh(tulle_world *world, tulle_mesh_view mesh) {
    return tulle_world_find_mesh_overlaps(world, mesh, 0, &found, &error);
}

ARGUMENTS_OF(tulle_world_find_mesh_overlaps) {
    tulle_status const bad = TULLE_ERROR_INVALID_ARGUMENT, bad_mesh = TULLE_ERROR_INVALID_MESH;
    static const double x[9] = {-1.0, 0.05, -1.0, 1.0, 0.05, -1.0, 0.0, 0.05, 1.0};
    static const uint32_t corners[3] = {0, 1, 2}, outside[3] = {0, 1, 3};
    tulle_mesh_view const mesh = {x, 3, corners, 1};
    REFUSED_FIND(bad, in_mesh(NULL, mesh));
    REFUSED_FIND(bad, in_mesh(fresh, mesh));
    REFUSED_FIND(bad, in_mesh(started, (tulle_mesh_view){NULL, 3, corners, 1}));
    REFUSED_FIND(bad, in_mesh(started, (tulle_mesh_view){x, 3, NULL, 1}));
    REFUSED_FIND(bad_mesh, in_mesh(started, (tulle_mesh_view){x, 3, outside, 1}));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 9; k++) {
            double numbers[9];
            memcpy(numbers, x, sizeof numbers);
            numbers[k] = no_numbers[i];
            REFUSED_FIND(bad_mesh, in_mesh(started, (tulle_mesh_view){numbers, 3, corners, 1}));
        }
    if (SIZE_MAX > UINT32_MAX)
        REFUSED_FIND(bad_mesh, in_mesh(started, (tulle_mesh_view){x, 3, corners, SIZE_MAX / 16}));
    REFUSED(tulle_world_find_mesh_overlaps(started, mesh, 0, NULL, &error));
    tulle_found none = {NULL, 1, 7};
    REFUSED(tulle_world_find_mesh_overlaps(started, mesh, 0, &none, &error));
    assert_int_equal(none.count, 0);
    found = (tulle_found){triangles, 64, 7};
    FINE(in_mesh(started, (tulle_mesh_view){NULL, 0, NULL, 0}));
    assert_int_equal(found.count, 0);
    none.capacity = 0;
    FINE(tulle_world_find_mesh_overlaps(started, mesh, 0, &none, NULL));
    assert_true(none.count > 0);
}

ARGUMENTS_OF(tulle_world_update_queries) {
    REFUSED(tulle_world_update_queries(NULL, &error));
    REFUSED(tulle_world_update_queries(fresh, &error));
    FINE(tulle_world_update_queries(started, NULL));
    FINE(tulle_world_update_queries(started, &error));
}

#define REFUSED_COUNT(status, call)                                                                \
    do {                                                                                           \
        count = 7;                                                                                 \
        REFUSED_WITH(status, call);                                                                \
        assert_int_equal(count, 0);                                                                \
    } while (0)

ARGUMENTS_OF(tulle_object_copy_contacts) {
    tulle_status const bad = TULLE_ERROR_INVALID_ARGUMENT;
    static tulle_contact contacts[4];
    size_t count = 0;
    REFUSED_COUNT(bad, tulle_object_copy_contacts(NULL, cloth, contacts, 4, &count, &error));
    for (int i = 0; i < BAD_OBJECT_COUNT; i++)
        REFUSED_COUNT(
            bad, tulle_object_copy_contacts(started, bad_objects[i], contacts, 4, &count, &error));
    REFUSED_COUNT(bad, tulle_object_copy_contacts(started, cloth, NULL, 4, &count, &error));
    REFUSED(tulle_object_copy_contacts(started, cloth, contacts, 4, NULL, &error));
    FINE(tulle_object_copy_contacts(fresh, cloth, contacts, 4, &count, &error));
    assert_int_equal(count, 0);
}

/* ---- values ---- */

ARGUMENTS_OF(tulle_object_copy_values) {
    static double numbers[3 * 18];
    tulle_target const target = {numbers, sizeof numbers, 0, TULLE_NUMBER_DOUBLE};
    tulle_values const x = TULLE_VALUES_POSITIONS, strains = TULLE_VALUES_STRAINS;
    REFUSED(tulle_object_copy_values(NULL, cloth, x, &target, &error));
    REFUSED(tulle_object_copy_values(fresh, cloth, x, &target, &error));
    REFUSED(tulle_object_copy_values(started, cloth, x, NULL, &error));
    for (int i = 0; i < BAD_OBJECT_COUNT; i++)
        REFUSED(tulle_object_copy_values(started, bad_objects[i], x, &target, &error));
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_values values = x;
        tulle_target bad = target;
        SET_CHOICE(values, no_choices[i]);
        SET_CHOICE(bad.type, no_choices[i]);
        REFUSED(tulle_object_copy_values(started, cloth, values, &target, &error));
        REFUSED(tulle_object_copy_values(started, cloth, x, &bad, &error));
    }
    const tulle_target bad_targets[] = {
        {NULL, sizeof numbers, 0, TULLE_NUMBER_DOUBLE},
        {numbers, 0, 0, TULLE_NUMBER_DOUBLE},
        {numbers, 16 * 24 - 1, 0, TULLE_NUMBER_DOUBLE},
        {numbers, 16 * 12 - 1, 0, TULLE_NUMBER_FLOAT},
        {numbers, sizeof numbers, 23, TULLE_NUMBER_DOUBLE},
        {numbers, sizeof numbers, 11, TULLE_NUMBER_FLOAT},
        {numbers, sizeof numbers, 29, TULLE_NUMBER_DOUBLE},
        {numbers, sizeof numbers, SIZE_MAX, TULLE_NUMBER_DOUBLE},
        {numbers, sizeof numbers, SIZE_MAX / 8, TULLE_NUMBER_FLOAT},
    };
    for (size_t i = 0; i < sizeof bad_targets / sizeof bad_targets[0]; i++)
        REFUSED(tulle_object_copy_values(started, cloth, x, &bad_targets[i], &error));
    REFUSED(tulle_object_copy_values(started, obstacle, strains, &target, &error));
    REFUSED(tulle_object_copy_values(springs, cloth, strains, &target, &error));
    expect_zero(numbers, sizeof numbers);
    FINE(tulle_object_copy_values(springs, cloth, x, &target, NULL));
    FINE(tulle_object_copy_values(started, cloth, strains, &target, &error)); /* of 18 triangles */
    tulle_target const exact = {numbers, 16 * 24, 0, TULLE_NUMBER_DOUBLE};
    REFUSED(tulle_object_copy_values(started, cloth, strains, &exact, &error));
    FINE(tulle_object_copy_values(started, cloth, x, &exact, &error));
}

/* ---- which objects collide ---- */

ARGUMENTS_OF(tulle_object_set_filter) {
    REFUSED(tulle_object_set_filter(NULL, cloth, 1, 1, &error));
    REFUSED(tulle_object_set_filter(started, cloth, 0, 0, &error));
    for (int i = 0; i < BAD_OBJECT_COUNT; i++)
        REFUSED(tulle_object_set_filter(fresh, bad_objects[i], 0, 0, &error));
    FINE(tulle_object_set_filter(fresh, cloth, 0, 0, NULL));
    FINE(tulle_object_set_filter(fresh, cloth, 1, UINT32_MAX, &error));
}

static int refuse_all(void *context, const tulle_world *world, tulle_object_id a,
                      tulle_object_id b) {
    (void)context, (void)world, (void)a, (void)b;
    return 0;
}

ARGUMENTS_OF(tulle_world_set_pair_filter) {
    REFUSED(tulle_world_set_pair_filter(NULL, refuse_all, NULL, &error));
    REFUSED(tulle_world_set_pair_filter(started, refuse_all, NULL, &error));
    REFUSED(tulle_world_set_pair_filter(started, NULL, NULL, &error));
    FINE(tulle_world_set_pair_filter(fresh, refuse_all, NULL, NULL));
    FINE(tulle_world_set_pair_filter(fresh, NULL, NULL, &error));
}

int main(void) { return run_arguments(HEADERS("tulle/query.h"), set_up, tear_down); }
