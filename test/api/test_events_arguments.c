/* Arguments of the public functions of tulle/events.h, against a world that has started and
 * watches, one that watches nothing, and one that has not started. */
#include "api/arguments.h"
#include "support/small_world.h"

static tulle_world *watching, *blind, *fresh;

static tulle_world *make_world(void) {
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_mesh sheet = small_sheet(0.3, 4, 0.1);
    small_add_cloth(world, &sheet);
    tulle_mesh_destroy(&sheet);
    return world;
}

static int set_up(void **unused) {
    (void)unused;
    watching = make_world();
    blind = make_world();
    fresh = make_world();
    FINE(tulle_world_start(watching, &error));
    FINE(tulle_world_start(blind, &error));
    tulle_event_watch const watch = tulle_event_watch_default();
    FINE(tulle_world_watch_events(watching, &watch, &error));
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    FINE(tulle_world_step(watching, 0.01, NULL, &error));
    FINE(tulle_world_step(blind, 0.01, NULL, &error));
    assert_true(tulle_world_get_state_hash(watching) == tulle_world_get_state_hash(blind));
    tulle_world_destroy(watching);
    tulle_world_destroy(blind);
    tulle_world_destroy(fresh);
    return 0;
}

ARGUMENTS_OF(tulle_event_watch_default) {
    tulle_event_watch const watch = tulle_event_watch_default();
    assert_int_equal(watch.kinds, (1u << TULLE_EVENT_KIND_COUNT) - 1u);
    assert_true(watch.contact_force == 0.0 && watch.capacity == 1024);
}

ARGUMENTS_OF(tulle_world_watch_events) {
    tulle_event_watch const right = tulle_event_watch_default();
    REFUSED(tulle_world_watch_events(NULL, &right, &error));
    REFUSED(tulle_world_watch_events(fresh, &right, &error));
    REFUSED(tulle_world_watch_events(fresh, NULL, &error));
    tulle_event_watch wrong = right;
    unsigned const kinds[] = {1u << TULLE_EVENT_KIND_COUNT, UINT_MAX, 0};
    for (int i = 0; i < 3; i++) {
        wrong.kinds = kinds[i];
        REFUSED(tulle_world_watch_events(watching, &wrong, &error));
    }
    wrong = right;
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        wrong.contact_force = no_numbers[i];
        REFUSED(tulle_world_watch_events(watching, &wrong, &error));
    }
    wrong = right;
    size_t const capacities[] = {0, ((size_t)1 << 24) + 1, SIZE_MAX};
    for (int i = 0; i < 3; i++) {
        wrong.capacity = capacities[i];
        REFUSED(tulle_world_watch_events(watching, &wrong, &error));
    }
    wrong = right;
    wrong.kinds = 1; /* fine, and so is a change */
    wrong.capacity = 1;
    FINE(tulle_world_watch_events(watching, &wrong, &error));
    FINE(tulle_world_watch_events(watching, &right, &error));
    FINE(tulle_world_watch_events(blind, NULL, &error));
}

ARGUMENTS_OF(tulle_world_poll_events) {
    tulle_event events[2];
    size_t count = 7;
    uint64_t lost;
    REFUSED(tulle_world_poll_events(NULL, events, 2, &count, &lost, &error));
    assert_int_equal(count, 0);
    REFUSED(tulle_world_poll_events(fresh, events, 2, &count, &lost, &error));
    REFUSED(tulle_world_poll_events(blind, events, 2, &count, &lost, &error));
    REFUSED(tulle_world_poll_events(watching, NULL, 2, &count, &lost, &error));
    REFUSED(tulle_world_poll_events(watching, events, 2, NULL, &lost, &error));
    FINE(tulle_world_poll_events(watching, NULL, 0, &count, NULL, &error));
    FINE(tulle_world_poll_events(watching, events, 2, &count, &lost, &error));
    assert_true(count == 0 && lost == 0);
}

int main(void) { return run_arguments(HEADERS("tulle/events.h"), set_up, tear_down); }
