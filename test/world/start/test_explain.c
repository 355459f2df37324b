/* What a world tells of its contacts and patches: they agree with the report, with the laws of
 * motion and with each other, and asking changes nothing. */
#include "support/paper_options.h"
#include "support/small_world.h"
#include "tulle/paper.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0; /* [s] */
static const double DEGREE = 0.017453292519943295;

/* A sheet on a table, both meshes kept. */
typedef struct table_world {
    tulle_mesh sheet, table;
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id obstacle;
} table_world;

static table_world make_world(void) {
    table_world made = {.sheet = small_sheet(0.3, 9, 0.01)};
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.5;
    box.size[2] = 0.1;
    made.table = small_shape(box, 0.0, 0.0, -0.055);
    tulle_world_def def = tulle_world_def_default();
    def.threads = 2;
    assert_int_equal(tulle_world_create(&def, &made.world, NULL), TULLE_OK);
    made.cloth = small_add_cloth(made.world, &made.sheet);
    made.obstacle = small_add_obstacle(made.world, &made.table);
    return made;
}

static void destroy_world(table_world *made) {
    tulle_world_destroy(made->world);
    tulle_mesh_destroy(&made->sheet);
    tulle_mesh_destroy(&made->table);
}

static const tulle_contact *get_contacts(tulle_world *world, size_t *count) {
    const tulle_contact *contacts = NULL;
    assert_int_equal(tulle_world_get_contacts(world, &contacts, count, NULL), TULLE_OK);
    return contacts;
}

static tulle_step_report make_steps(tulle_world *world, int count) {
    tulle_step_report report = {0};
    for (int i = 0; i < count; i++)
        assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
    return report;
}

/* Position of a contact's feature: the weighted vertices of one sign. */
static void find_side(const table_world *made, const tulle_contact *contact, double sign,
                      double side[3]) {
    side[0] = side[1] = side[2] = 0.0;
    double total = 0.0;
    for (int k = 0; k < 4; k++) {
        bool const is_first = k < (contact->kind == TULLE_CONTACT_VERTEX_FACE ? 1 : 2);
        uint32_t const object = is_first ? contact->object_a : contact->object_b;
        size_t count = 0;
        const double *const x =
            object == 0 ? tulle_cloth_get_positions(made->world, made->cloth, &count)
                        : tulle_obstacle_get_positions(made->world, made->obstacle, &count);
        assert_true(object <= 1);
        assert_true(contact->vertices[k] < count);
        if (is_first != (sign > 0.0)) continue;
        total += contact->weights[k];
        for (int c = 0; c < 3; c++)
            side[c] += sign * contact->weights[k] * x[3 * contact->vertices[k] + (size_t)c];
    }
    assert_true(fabs(total - sign) < 1e-12);
}

static void contacts_agree_with_the_report(void **state) {
    (void)state;
    table_world made = make_world();
    size_t count = 1;
    get_contacts(made.world, &count);
    assert_int_equal(count, 0);
    bool has_seen_new = false;
    for (int i = 0; i < 60; i++) {
        tulle_step_report const report = make_steps(made.world, 1);
        const tulle_contact *const contacts = get_contacts(made.world, &count);
        assert_int_equal(count, report.contacts);
        size_t new_count = 0, hard_count = 0, stick_count = 0, slip_count = 0;
        for (size_t k = 0; k < count; k++) {
            const tulle_contact *const contact = &contacts[k];
            double a[3], b[3];
            find_side(&made, contact, 1.0, a);
            find_side(&made, contact, -1.0, b);
            for (int c = 0; c < 3; c++) {
                assert_true(fabs(contact->position[c] - 0.5 * (a[c] + b[c])) < 1e-12);
                assert_true(fabs(b[c] + contact->gap * contact->normal[c] - a[c]) < 1e-12);
            }
            double least = 0.0;
            tulle_world_get_distances(made.world, NULL, NULL, &least);
            assert_true(contact->gap > least);
            new_count += contact->is_new != 0;
            hard_count += contact->is_hard != 0;
            stick_count += contact->state == TULLE_CONTACT_STICK;
            slip_count += contact->state == TULLE_CONTACT_SLIP;
        }
        assert_int_equal(new_count, report.new_contacts);
        has_seen_new = has_seen_new || new_count > 0;
        if (report.impact_rounds > 0) continue; /* those of impacts are not in the other counts */
        assert_int_equal(hard_count, report.hard_contacts);
        assert_int_equal(stick_count, report.stick_contacts);
        assert_int_equal(slip_count, report.slip_contacts);
    }
    assert_true(has_seen_new);
    destroy_world(&made);
}

/* At rest the impulses of a step carry the weight. */
static void impulses_carry_the_weight(void **state) {
    (void)state;
    table_world made = make_world();
    make_steps(made.world, 300);
    size_t count = 0;
    double impulse = 0.0;
    const tulle_contact *const contacts = get_contacts(made.world, &count);
    for (size_t k = 0; k < count; k++)
        impulse += (contacts[k].object_a == 0 ? 1.0 : -1.0) * contacts[k].impulse[2];
    double const weight = tulle_cloth_def_default().material.area_density * 0.3 * 0.3 * 9.81 * STEP;
    print_message("impulse over weight: %.6f\n", impulse / weight);
    assert_true(fabs(impulse / weight - 1.0) < 0.01);
    destroy_world(&made);
}

static void asking_changes_nothing(void **state) {
    (void)state;
    table_world asked = make_world(), quiet = make_world();
    uint32_t *const labels = malloc(asked.sheet.triangle_count * sizeof *labels);
    tulle_patch_options const options = {.time_step = STEP};
    assert_int_equal(tulle_world_start(asked.world, NULL), TULLE_OK);
    for (int i = 0; i < 30; i++) {
        size_t count = 0;
        get_contacts(asked.world, &count);
        assert_int_equal(
            tulle_cloth_get_patches(asked.world, asked.cloth, &options, labels, &count, NULL),
            TULLE_OK);
        make_steps(asked.world, 1);
        make_steps(quiet.world, 1);
        assert_true(tulle_world_get_state_hash(asked.world) ==
                    tulle_world_get_state_hash(quiet.world));
    }
    free(labels);
    destroy_world(&asked);
    destroy_world(&quiet);
}

static void a_loaded_world_has_contacts_after_its_first_step(void **state) {
    (void)state;
    table_world first = make_world(), second = make_world();
    make_steps(first.world, 30);
    make_steps(second.world, 31);
    void *bytes = NULL;
    size_t byte_count = 0, count = 0, other_count = 0;
    assert_int_equal(tulle_world_save_state(first.world, &bytes, &byte_count, NULL), TULLE_OK);
    get_contacts(second.world, &count);
    assert_true(count > 0);
    assert_int_equal(tulle_world_load_state(second.world, bytes, byte_count, NULL), TULLE_OK);
    tulle_world_free_state(first.world, bytes, byte_count);
    get_contacts(second.world, &count);
    assert_int_equal(count, 0);
    make_steps(first.world, 1);
    make_steps(second.world, 1);
    const tulle_contact *const a = get_contacts(first.world, &count);
    const tulle_contact *const b = get_contacts(second.world, &other_count);
    assert_int_equal(count, other_count);
    assert_true(count > 0);
    for (size_t i = 0; i < count; i++) {
        assert_memory_equal(a[i].vertices, b[i].vertices, sizeof a[i].vertices);
        assert_memory_equal(a[i].impulse, b[i].impulse, sizeof a[i].impulse);
        assert_memory_equal(a[i].position, b[i].position, sizeof a[i].position);
        assert_int_equal(a[i].state, b[i].state);
        assert_int_equal(a[i].is_new, b[i].is_new);
    }
    /* a refused step leaves them */
    assert_int_equal(tulle_world_step(first.world, -1.0, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    get_contacts(first.world, &other_count);
    assert_int_equal(count, other_count);
    destroy_world(&first);
    destroy_world(&second);
}

static void bad_calls_are_refused(void **state) {
    (void)state;
    table_world made = make_world();
    uint32_t *const labels = malloc(made.sheet.triangle_count * sizeof *labels);
    tulle_patch_options options = {.time_step = STEP, .max_angle = 60.0 * DEGREE};
    tulle_error error = {0};
    size_t count = 0;
    tulle_status const bad = TULLE_ERROR_INVALID_ARGUMENT;
    assert_int_equal(tulle_world_get_contacts(NULL, NULL, &count, &error), bad);
    assert_int_equal(tulle_world_get_contacts(made.world, NULL, &count, &error), bad);
    assert_int_equal(
        tulle_cloth_get_patches(made.world, made.cloth, &options, labels, &count, &error), bad);
    assert_non_null(strstr(error.message, "started"));
    assert_null(tulle_obstacle_get_velocities(made.world, made.obstacle, &count));
    assert_int_equal(count, made.table.vertex_count);
    assert_int_equal(tulle_world_start(made.world, NULL), TULLE_OK);
    assert_non_null(tulle_obstacle_get_velocities(made.world, made.obstacle, NULL));
    tulle_cloth_id const stale = {7, 1};
    assert_int_equal(tulle_cloth_get_patches(made.world, stale, &options, labels, &count, &error),
                     bad);
    static const double angles[] = {-0.1, 1.5707963267948966, 4.0, (double)NAN};
    for (int i = 0; i < 4; i++) {
        options.max_angle = angles[i];
        assert_int_equal(
            tulle_cloth_get_patches(made.world, made.cloth, &options, labels, &count, &error), bad);
    }
    options.max_angle = 0.0;
    static const double steps[] = {-0.1, 1.5, (double)NAN};
    for (int i = 0; i < 3; i++) {
        options.time_step = steps[i];
        assert_int_equal(
            tulle_cloth_get_patches(made.world, made.cloth, &options, labels, &count, &error), bad);
    }
    free(labels);
    destroy_world(&made);
}

/* A sheet that lies flat is one patch, until one corner moves so fast that its triangles turn. */
static void patches_follow_velocities(void **state) {
    (void)state;
    table_world made = {.sheet = small_sheet(0.3, 9, 0.01)};
    tulle_world_def const def = tulle_world_def_default();
    assert_int_equal(tulle_world_create(&def, &made.world, NULL), TULLE_OK);
    size_t const vertex_count = made.sheet.vertex_count;
    double *const velocities = calloc(3 * vertex_count, sizeof(double));
    uint32_t *const labels = malloc(made.sheet.triangle_count * sizeof *labels);
    velocities[2] = 20.0;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&made.sheet);
    cloth.velocities = velocities;
    assert_int_equal(tulle_world_add_cloth(made.world, &cloth, &made.cloth, NULL), TULLE_OK);
    assert_int_equal(tulle_world_start(made.world, NULL), TULLE_OK);
    tulle_patch_options options = {.max_angle = 30.0 * DEGREE};
    size_t count = 0;
    assert_int_equal(
        tulle_cloth_get_patches(made.world, made.cloth, &options, labels, &count, NULL), TULLE_OK);
    assert_int_equal(count, 1);
    options.time_step = STEP;
    assert_int_equal(
        tulle_cloth_get_patches(made.world, made.cloth, &options, labels, &count, NULL), TULLE_OK);
    size_t isolated = 0;
    for (size_t i = 0; i < made.sheet.triangle_count; i++) {
        const uint32_t *const corners = made.sheet.triangles + 3 * i;
        bool const moves = corners[0] == 0 || corners[1] == 0 || corners[2] == 0;
        assert_int_equal(labels[i] == 0, moves);
        isolated += labels[i] == 0;
    }
    assert_true(isolated > 0);
    assert_int_equal(count, 1);
    free(velocities);
    free(labels);
    tulle_world_destroy(made.world);
    tulle_mesh_destroy(&made.sheet);
}

/* A method without patches uses none, and so does any before its first step. */
static void without_patches_none_are_in_use(void **state) {
    (void)state;
    static const tulle_detect_method methods[] = {TULLE_DETECT_REFIT, TULLE_DETECT_PATCHES};
    tulle_mesh sheet = small_sheet(0.3, 9, 0.0);
    uint32_t labels[128];
    assert_true(sheet.triangle_count == sizeof labels / sizeof *labels);
    for (int i = 0; i < 2; i++) {
        tulle_world_def def = tulle_world_def_default();
        change_paper(&def)->detection.method = methods[i];
        tulle_world *world = NULL;
        assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
        tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
        assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
        if (i == 0) make_steps(world, 2);
        tulle_patch_options const options = {.is_in_use = 1};
        size_t count = 7;
        memset(labels, 1, sizeof labels);
        assert_int_equal(tulle_cloth_get_patches(world, cloth, &options, labels, &count, NULL),
                         TULLE_OK);
        assert_int_equal(count, 0);
        for (size_t t = 0; t < sheet.triangle_count; t++) assert_int_equal(labels[t], 0);
        tulle_world_destroy(world);
    }
    tulle_mesh_destroy(&sheet);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contacts_agree_with_the_report),
        cmocka_unit_test(impulses_carry_the_weight),
        cmocka_unit_test(asking_changes_nothing),
        cmocka_unit_test(a_loaded_world_has_contacts_after_its_first_step),
        cmocka_unit_test(bad_calls_are_refused),
        cmocka_unit_test(patches_follow_velocities),
        cmocka_unit_test(without_patches_none_are_in_use),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
