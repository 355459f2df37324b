/* What one page may ask of the network's thread: its share of the time, and no more than it reads.
 */
#include "app/view/client.h"
#include "support/test_support.h"

enum { PAGES = 30, ROUNDS = 2000 };

/* Thirty pages ask without an end; each request takes 10 ms. Their requests get a quarter of the
 * time, and beside it what each saves up and the request that goes beyond it. */
static void all_pages_share_a_quarter(void **state) {
    (void)state;
    view_client *pages[PAGES];
    double now = 1000.0, spent = 0.0;
    int answered[PAGES] = {0};
    for (uint32_t i = 0; i < PAGES; i++) pages[i] = client_create(NULL, i);
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < PAGES; i++) {
            if (!client_may_ask(pages[i], PAGES, now)) continue;
            pages[i]->credit -= 0.01;
            spent += 0.01;
            answered[i]++;
        }
        now += 0.01;
    }
    assert_in_range((uint64_t)(1000.0 * spent), 4500, 1000 * (5.0 + PAGES * 0.02));
    for (int i = 1; i < PAGES; i++) assert_int_equal(answered[i], answered[0]);
    /* alone it is listened to soon again */
    pages[0]->credit = -0.01;
    assert_false(client_may_ask(pages[0], 1, now));
    assert_true(client_may_ask(pages[0], 1, now + 0.05));
    for (int i = 0; i < PAGES; i++) client_destroy(pages[i]);
}

static void who_does_not_read_is_not_listened_to(void **state) {
    (void)state;
    view_client *const page = client_create(NULL, 0);
    view_request const request = {0};
    int pushed = 0;
    for (; pushed < 100 && client_may_ask(page, 1, 0.0); pushed++)
        client_push_error(page, &request, "nothing");
    assert_int_equal(pushed, CLIENT_QUEUE_FULL);
    client_drop_first(page);
    assert_true(client_may_ask(page, 1, 0.0));
    client_destroy(page);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_pages_share_a_quarter),
                                       cmocka_unit_test(who_does_not_read_is_not_listened_to)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
