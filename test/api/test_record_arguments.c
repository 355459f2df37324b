/* Arguments of the public functions of tulle/record.h, and when a world can be recorded. */
#include "api/arguments.h"
#include "support/recording.h"
#include "support/small_world.h"

static tulle_world *make_world(void) {
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    return world;
}

static int keep_all(void *context, const tulle_world *world, tulle_object_id a, tulle_object_id b) {
    (void)context, (void)world, (void)a, (void)b;
    return 1;
}

ARGUMENTS_OF(tulle_world_record) {
    recording bytes;
    tulle_record_writer const right = recording_begin(&bytes), none = {NULL, &bytes};
    tulle_mesh sheet = small_sheet(0.1, 2, 0.0);
    REFUSED(tulle_world_record(NULL, &right, &error));
    REFUSED(tulle_world_record(NULL, NULL, &error));
    tulle_world *world = make_world();
    FINE(tulle_world_record(world, NULL, &error)); /* there is nothing to end */
    REFUSED(tulle_world_record(world, &none, &error));
    assert_int_equal(bytes.byte_count, 0);
    bytes.blocks_left = 0;
    REFUSED_WITH(TULLE_ERROR_IO, tulle_world_record(world, &right, &error));
    bytes.blocks_left = -1;
    FINE(tulle_world_record(world, &right, &error));
    REFUSED(tulle_world_record(world, &right, &error)); /* it is recorded already */
    FINE(tulle_world_record(world, NULL, &error));
    tulle_world_destroy(world);
    assert_true(bytes.byte_count > 0);
    for (int kind = 0; kind < 5; kind++) { /* too late */
        world = make_world();
        tulle_contact_law const law = {0.3, 0.2, 0.0};
        if (kind == 0) small_add_obstacle(world, &sheet);
        if (kind == 1) FINE(tulle_world_set_material_law(world, "silk", "wool", &law, &error));
        if (kind == 2) FINE(tulle_world_set_pair_filter(world, keep_all, NULL, &error));
        if (kind == 3) small_add_cloth(world, &sheet);
        if (kind == 3) FINE(tulle_world_start(world, &error));
        if (kind == 4) /* ids would be others */
            FINE(tulle_world_remove_obstacle(world, small_add_obstacle(world, &sheet), &error));
        REFUSED(tulle_world_record(world, &right, &error));
        tulle_world_destroy(world);
    }
    tulle_mesh_destroy(&sheet);
    free(bytes.bytes);
}

ARGUMENTS_OF(tulle_replay) {
    recording bytes;
    tulle_record_writer const writer = recording_begin(&bytes);
    tulle_world *const world = make_world();
    FINE(tulle_world_record(world, &writer, &error));
    tulle_world_destroy(world);
    tulle_replay_options options = {0};
    tulle_replay_report report;
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, &options, &report, &error));
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, NULL));
    assert_true(report.is_whole && report.calls == 1);
    REFUSED(tulle_replay(NULL, bytes.byte_count, &options, &report, &error));
    REFUSED(tulle_replay(NULL, 0, &options, &report, &error));
    REFUSED(tulle_replay(bytes.bytes, bytes.byte_count, &options, NULL, &error));
    int const wrong[] = {-1, 257, INT_MIN, INT_MAX};
    for (int i = 0; i < 4; i++) {
        options.threads = wrong[i];
        REFUSED(tulle_replay(bytes.bytes, bytes.byte_count, &options, &report, &error));
    }
    options.threads = 256;
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, &options, &report, &error));
    REFUSED_WITH(TULLE_ERROR_PARSE, tulle_replay("", 0, NULL, &report, &error));
    REFUSED_WITH(TULLE_ERROR_PARSE, tulle_replay("TULLREC4", 7, NULL, &report, &error));
    REFUSED_WITH(TULLE_ERROR_PARSE, tulle_replay("TULLREC9", 8, NULL, &report, &error));
    REFUSED_WITH(TULLE_ERROR_PARSE, tulle_replay("TULLREC3", 8, NULL, &report, &error));
    FINE(tulle_replay("TULLREC4", 8, NULL, &report, &error)); /* cut off before the first call */
    assert_true(!report.is_whole && report.calls == 0 && !report.call);
    free(bytes.bytes);
}

int main(void) { return run_arguments(HEADERS("tulle/record.h"), NULL, NULL); }
