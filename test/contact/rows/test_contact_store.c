/* The contact store: what store_contacts keeps, look-up, saving and loading, damaged blocks, lack
 * of memory. */
#include "base/hash.h"
#include "contact/rows/contact_store.h"
#include "contact/rows/gather_rows.h"
#include "support/test_support.h"

#include <stdlib.h>
#include <string.h>

static void add_row(row_list *list, memory *heap, feature_kind kind, uint32_t a, uint32_t b,
                    double push) {
    assert_true(ARRAY_RESERVE(heap, &list->rows, 1));
    list->rows.data[list->rows.count++] = (contact_row){
        .frame.kind = kind, .frame.pair = {a, b}, .solve.impulse = {push, 2.0 * push, 0.0}};
}

/* Random rows, some pairs twice; `first` and `second` are small so that keys repeat. */
static row_list make_rows(memory *heap, uint64_t seed, int count) {
    row_list list = {0};
    for (int i = 0; i < count; i++) {
        uint64_t const bits = random_next(&seed);
        add_row(&list, heap, bits & 1 ? FEATURE_EDGE_EDGE : FEATURE_VERTEX_TRIANGLE,
                (uint32_t)(bits >> 8) % 20, (uint32_t)(bits >> 32) % 20, random_uniform(&seed));
    }
    return list;
}

static void keeps_the_sum_of_each_pair(void **state) {
    (void)state;
    memory heap = memory_default();
    row_list list = make_rows(&heap, 3, 500);
    contact_store store = {0};
    assert_int_equal(store_contacts(&store, &heap, &list, NULL, 0, 0.01), TULLE_OK);
    assert_true(store.contacts.count < 500 && store.time_step == 0.01);
    contact_reader all = {.store = &store}, some = all, few = all;
    for (int kind = 0; kind < 2; kind++)
        for (uint32_t a = 0; a < 20; a++)
            for (uint32_t b = 0; b < 20; b++) {
                feature_pair const pair = {a, b};
                double sum = 0.0;
                bool is_there = false;
                for (size_t i = 0; i < list.rows.count; i++) {
                    const contact_row *const row = &list.rows.data[i];
                    if ((int)row->frame.kind != kind || row->frame.pair.first != a ||
                        row->frame.pair.second != b)
                        continue;
                    sum += row->solve.impulse.x;
                    is_there = true;
                }
                contact_reader fresh = {.store = &store};
                const stored_contact *const found = read_contact(&fresh, (feature_kind)kind, pair);
                assert_int_equal(found != NULL, is_there);
                assert_ptr_equal(read_contact(&all, (feature_kind)kind, pair), found);
                if (b % 3 == 0) /* some contacts are passed over */
                    assert_ptr_equal(read_contact(&some, (feature_kind)kind, pair), found);
                if (a % 9 == 4 && b == 17) /* and many */
                    assert_ptr_equal(read_contact(&few, (feature_kind)kind, pair), found);
                if (found) assert_true(fabs(found->impulse[0] - sum) < 1e-14);
            }
    ARRAY_FREE(&heap, &store.contacts);
    row_list_destroy(&list, &heap);
    assert_int_equal(heap.bytes_held, 0);
}

/* Contacts of pairs without a row take their places among those of the rows. */
static void takes_in_contacts_without_a_row(void **state) {
    (void)state;
    memory heap = memory_default();
    row_list list = make_rows(&heap, 4, 50);
    contact_store store = {0};
    assert_int_equal(store_contacts(&store, &heap, &list, NULL, 0, 0.01), TULLE_OK);
    size_t const row_count = store.contacts.count;
    stored_contact const others[2] = {{.kind = 0, .first = 21, .second = 1, .age = 4},
                                      {.kind = 1, .first = 7, .second = 30, .age = 3}};
    assert_int_equal(store_contacts(&store, &heap, &list, others, 2, 0.01), TULLE_OK);
    assert_int_equal(store.contacts.count, row_count + 2);
    contact_reader reader = {.store = &store};
    assert_int_equal(read_contact(&reader, FEATURE_VERTEX_TRIANGLE, (feature_pair){21, 1})->age, 4);
    assert_int_equal(read_contact(&reader, FEATURE_EDGE_EDGE, (feature_pair){7, 30})->age, 3);
    for (size_t i = 1; i < store.contacts.count; i++) {
        const stored_contact *const a = &store.contacts.data[i - 1], *const b = a + 1;
        assert_true(a->kind < b->kind ||
                    (a->kind == b->kind &&
                     (a->first < b->first || (a->first == b->first && a->second < b->second))));
    }
    list.rows.count = 0;
    assert_int_equal(store_contacts(&store, &heap, &list, others, 1, 0.03), TULLE_OK);
    assert_true(store.contacts.count == 1 && store.time_step == 0.03);
    ARRAY_FREE(&heap, &store.contacts);
    row_list_destroy(&list, &heap);
}

static void loads_what_it_saved(void **state) {
    (void)state;
    memory heap = memory_default();
    for (int count = 0; count < 300; count += 59) {
        row_list list = make_rows(&heap, 5, count);
        contact_store store = {0}, copy = {0};
        assert_int_equal(store_contacts(&store, &heap, &list, NULL, 0, 0.02), TULLE_OK);
        size_t const size = contact_store_get_size(&store);
        char *const bytes = malloc(size + 1);
        contact_store_save(&store, bytes + 1); /* unaligned on purpose */
        assert_int_equal(contact_store_load(&copy, &heap, bytes + 1, size), TULLE_OK);
        assert_true(contact_store_hash(&store, HASH_SEED) == contact_store_hash(&copy, HASH_SEED));
        for (size_t cut = 0; cut < size; cut += 7)
            assert_int_equal(contact_store_load(&copy, &heap, bytes + 1, cut),
                             TULLE_ERROR_INVALID_ARGUMENT);
        assert_true(contact_store_hash(&store, HASH_SEED) == contact_store_hash(&copy, HASH_SEED));
        free(bytes);
        ARRAY_FREE(&heap, &store.contacts);
        ARRAY_FREE(&heap, &copy.contacts);
        row_list_destroy(&list, &heap);
    }
    assert_int_equal(heap.bytes_held, 0);
}

static void refuses_damaged_blocks(void **state) {
    (void)state;
    memory heap = memory_default();
    row_list list = {0};
    add_row(&list, &heap, FEATURE_VERTEX_TRIANGLE, 1, 2, 1.0);
    add_row(&list, &heap, FEATURE_VERTEX_TRIANGLE, 1, 3, 1.0);
    contact_store store = {0};
    assert_int_equal(store_contacts(&store, &heap, &list, NULL, 0, 0.02), TULLE_OK);
    size_t const size = contact_store_get_size(&store);
    assert_int_equal(size, 16 + 2 * sizeof(stored_contact));
    stored_contact contacts[2];
    char bytes[16 + 2 * sizeof(stored_contact)];
    for (int damage = 0; damage < 5; damage++) {
        contact_store_save(&store, bytes);
        memcpy(contacts, bytes + 16, sizeof contacts);
        if (damage == 0) contacts[1].second = 2;
        if (damage == 1) contacts[0].impulse[1] = NAN;
        if (damage == 2) contacts[0].kind = 2;
        if (damage == 3) contacts[1].is_hard = 7;
        if (damage == 4) contacts[1].anchor[2] = INFINITY;
        memcpy(bytes + 16, contacts, sizeof contacts);
        assert_int_equal(contact_store_load(&store, &heap, bytes, size),
                         TULLE_ERROR_INVALID_ARGUMENT);
    }
    contact_store_save(&store, bytes);
    uint64_t const huge = UINT64_MAX / 2;
    memcpy(bytes, &huge, sizeof huge);
    assert_int_equal(contact_store_load(&store, &heap, bytes, size), TULLE_ERROR_INVALID_ARGUMENT);
    ARRAY_FREE(&heap, &store.contacts);
    row_list_destroy(&list, &heap);
}

static void lack_of_memory_changes_nothing(void **state) {
    (void)state;
    memory heap = memory_default();
    row_list few = make_rows(&heap, 8, 5), many = make_rows(&heap, 9, 5000);
    contact_store store = {0};
    assert_int_equal(store_contacts(&store, &heap, &few, NULL, 0, 0.02), TULLE_OK);
    uint64_t const before = contact_store_hash(&store, HASH_SEED);
    heap.allocator.byte_limit = heap.bytes_held + 1000;
    assert_int_equal(store_contacts(&store, &heap, &many, NULL, 0, 0.02),
                     TULLE_ERROR_OUT_OF_MEMORY);
    assert_true(contact_store_hash(&store, HASH_SEED) == before);
    heap.allocator.byte_limit = 0;
    ARRAY_FREE(&heap, &store.contacts);
    row_list_destroy(&few, &heap);
    row_list_destroy(&many, &heap);
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_the_sum_of_each_pair),
        cmocka_unit_test(takes_in_contacts_without_a_row),
        cmocka_unit_test(loads_what_it_saved),
        cmocka_unit_test(refuses_damaged_blocks),
        cmocka_unit_test(lack_of_memory_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
