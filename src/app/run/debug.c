/* app/run/debug.c - what `tulle run --record debug` and `--record velocities` keep of a frame:
 * velocities of all that moves, contacts of the last step, patches of each cloth. Patches are those
 * that the last step used. For a method without patches they are grown for the cloth's way over the
 * next step. */
#include "app/run/session.h"

#include <stdlib.h>

bool debug_record_prepare(debug_record *record, const run_session *session) {
    size_t const body_count = session->body_count;
    *record = (debug_record){.cloth_count = session->built.cloth_count,
                             .velocities = calloc(body_count, sizeof *record->velocities),
                             .labels = calloc(body_count, sizeof *record->labels),
                             .patch_counts = calloc(body_count, sizeof *record->patch_counts)};
    if (!record->velocities || !record->labels || !record->patch_counts) return false;
    for (size_t i = 0; i < record->cloth_count; i++) {
        record->labels[i] =
            malloc(session->bodies[i].mesh.triangle_count * sizeof *record->labels[i]);
        if (!record->labels[i]) return false;
    }
    record->debug = (tulle_run_debug){.velocities = record->velocities,
                                      .patch_labels = (const uint32_t *const *)record->labels,
                                      .patch_counts = record->patch_counts};
    return true;
}

tulle_status debug_record_fill(debug_record *record, const run_session *session,
                               tulle_error *error) {
    const tulle_scene_world *const built = &session->built;
    tulle_detect_method const method = tulle_world_get_paper_options(built->world).detection.method;
    tulle_patch_options const options = {.time_step = tulle_scene_get_time_step(session->scene),
                                         .is_in_use = method == TULLE_DETECT_PATCHES ||
                                                      method == TULLE_DETECT_PAPER};
    bool const is_all = session->options.records_debug;
    for (size_t i = 0; i < built->cloth_count; i++) {
        size_t patch_count = 0;
        record->velocities[i] = tulle_cloth_get_velocities(built->world, built->cloths[i], NULL);
        if (!is_all) continue;
        tulle_status const status = tulle_cloth_get_patches(
            built->world, built->cloths[i], &options, record->labels[i], &patch_count, error);
        if (status != TULLE_OK) return status;
        record->patch_counts[i] = (uint32_t)patch_count;
    }
    for (size_t i = 0; i < built->obstacle_count; i++)
        record->velocities[built->cloth_count + i] =
            tulle_obstacle_get_velocities(built->world, built->obstacles[i], NULL);
    if (!is_all) return TULLE_OK;
    return tulle_world_get_contacts(built->world, &record->debug.contacts,
                                    &record->debug.contact_count, error);
}

void debug_record_release(debug_record *record) {
    for (size_t i = 0; record->labels && i < record->cloth_count; i++) free(record->labels[i]);
    free(record->labels);
    free(record->velocities);
    free(record->patch_counts);
}
