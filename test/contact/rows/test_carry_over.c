/* Contacts that change their features: impulses go on with the vertex or edge that slides, each at
 * most once, and never to the other side. */
#include "base/hash.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* Rows with impulses that tell them apart, stored. */
static void store_marked_rows(contact_world *world) {
    for (size_t r = 0; r < world->rows->rows.count; r++)
        world->rows->rows.data[r].solve.impulse = vec3_make(0.0, (double)(r + 1), 0.0);
    assert_int_equal(store_contacts(world->store, world->heap, world->rows, NULL, 0, TIME_STEP),
                     TULLE_OK);
}

static void shift_sheet(contact_world *world, double dx, double dy, double dz) {
    for (size_t i = 0; i < count_sheet_vertices(world); i++) {
        world->x0[3 * i] += dx;
        world->x0[3 * i + 1] += dy;
        world->x0[3 * i + 2] += dz;
    }
}

/* Index of the stored row whose mark the row bears, or SIZE_MAX; every mark only once. */
static size_t read_mark(const contact_row *row, bool *is_taken, size_t count) {
    double const mark = fabs(row->solve.impulse.y);
    assert_true(row->solve.impulse.x == 0.0 && row->solve.impulse.z == 0.0);
    assert_int_equal(mark > 0.0, row->law.is_old);
    if (!row->law.is_old) return SIZE_MAX;
    size_t const index = (size_t)(mark + 0.5) - 1;
    assert_true(index < count && mark == (double)(index + 1));
    assert_false(is_taken[index]);
    is_taken[index] = true;
    return index;
}

enum { MAX_ROWS = 4096 };

/* The sheet slides by up to a third of a cell: every row of a vertex of the sheet goes on with
 * that vertex's contact, other rows with one that has a vertex in common, and nothing is doubled.
 */
static void impulses_slide_with_the_sheet(void **state) {
    (void)state;
    static bool is_taken[MAX_ROWS];
    static contact_row before[MAX_ROWS];
    uint64_t random = 11;
    size_t changed = 0, edge_rows = 0, carried_edge_rows = 0;
    for (int i = 0; i < 40; i++) {
        contact_world world;
        make_coarse_sheet_over_cloth(&world, &random);
        gather_at_rest(&world, TIME_STEP);
        size_t const count = world.rows->rows.count;
        assert_true(count < MAX_ROWS);
        store_marked_rows(&world);
        memcpy(before, world.rows->rows.data, count * sizeof *before);
        memset(is_taken, 0, sizeof is_taken);
        shift_sheet(&world, 0.01 * random_uniform(&random), 0.01 * random_uniform(&random), 0.0);
        gather_at_rest(&world, TIME_STEP);
        for (size_t r = 0; r < world.rows->rows.count; r++) {
            const contact_row *const row = &world.rows->rows.data[r];
            size_t const index = read_mark(row, is_taken, count);
            bool const is_sheet_vertex = row->frame.kind == FEATURE_VERTEX_TRIANGLE &&
                                         row->frame.vertices[0] < count_sheet_vertices(&world);
            if (is_sheet_vertex) {
                assert_true(index < count && before[index].frame.kind == row->frame.kind);
                assert_int_equal(before[index].frame.pair.first, row->frame.pair.first);
                changed += before[index].frame.pair.second != row->frame.pair.second;
            }
            edge_rows += row->frame.kind == FEATURE_EDGE_EDGE;
            carried_edge_rows += row->frame.kind == FEATURE_EDGE_EDGE && index < count;
        }
        contact_world_destroy(&world);
    }
    print_message("%zu vertex rows changed their triangle; %zu of %zu edge rows carried over\n",
                  changed, carried_edge_rows, edge_rows);
    assert_true(changed > 1000 && 2 * carried_edge_rows > edge_rows);
}

/* Sheets on the other side of the plane have rows of the other direction: nothing is carried. */
static void impulses_do_not_change_sides(void **state) {
    (void)state;
    uint64_t random = 17;
    contact_world world;
    make_coarse_sheet_over_cloth(&world, &random);
    gather_at_rest(&world, TIME_STEP);
    store_marked_rows(&world);
    shift_sheet(&world, 0.015, 0.01, -2.0 * HEIGHT_OVER_PLANE);
    gather_at_rest(&world, TIME_STEP);
    assert_true(world.rows->rows.count > count_sheet_vertices(&world));
    size_t old_count = 0;
    for (size_t r = 0; r < world.rows->rows.count; r++) {
        const contact_row *const row = &world.rows->rows.data[r];
        contact_reader reader = {.store = world.store};
        const stored_contact *const own = read_contact(&reader, row->frame.kind, row->frame.pair);
        assert_int_equal(row->law.is_old, own != NULL);
        old_count += row->law.is_old;
    }
    assert_true(old_count < world.rows->rows.count);
    contact_world_destroy(&world);
}

/* A store of another scene, whose features do not exist here, is read without harm. */
static void unknown_contacts_are_left_alone(void **state) {
    (void)state;
    uint64_t random = 19;
    contact_world world;
    make_coarse_sheet_over_cloth(&world, &random);
    gather_at_rest(&world, TIME_STEP);
    for (size_t r = 0; r < world.rows->rows.count; r++) {
        contact_row *const row = &world.rows->rows.data[r];
        row->solve.impulse = vec3_make(1.0, 0.0, 0.0);
        row->frame.pair = (feature_pair){1000000 + (uint32_t)r, 2000000};
    }
    assert_int_equal(store_contacts(world.store, world.heap, world.rows, NULL, 0, TIME_STEP),
                     TULLE_OK);
    gather_at_rest(&world, TIME_STEP);
    for (size_t r = 0; r < world.rows->rows.count; r++)
        assert_false(world.rows->rows.data[r].law.is_old);
    contact_world_destroy(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impulses_slide_with_the_sheet),
        cmocka_unit_test(impulses_do_not_change_sides),
        cmocka_unit_test(unknown_contacts_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
