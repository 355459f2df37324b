/* app/convert/repair.c - see repair.h. */
#include "app/convert/repair.h"

#include "app/commands.h"
#include "base/error.h"

#include "tulle/check.h"

#include <stdio.h>

/* Pairs of triangles that intersect; false where they cannot be counted. */
static bool count_pairs(tulle_mesh_view mesh, size_t *count) {
    tulle_check_body const body = {mesh, false};
    tulle_check_result result;
    *count = 0;
    if (mesh.triangle_count == 0) return true;
    if (tulle_check_intersections(&body, 1, 0, &result, NULL) != TULLE_OK) return false;
    *count = result.pair_count;
    tulle_check_result_destroy(&result);
    return true;
}

tulle_status convert_repair_source(convert_source *source, frame_range frames, double tolerance,
                                   convert_repair *repair, tulle_error *error) {
    *repair = (convert_repair){0};
    tulle_mesh *const mesh = &source->mesh;
    if (frame_range_get_count(frames) != 1)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "--repair changes vertices and triangles, so it takes one frame; "
                            "choose it by --frame");
    if (mesh->triangle_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "--repair needs triangles, and there are none");
    tulle_status status = convert_source_read(source, frames.first, mesh->positions, error);
    if (status != TULLE_OK) return status;
    repair->is_judged = count_pairs(tulle_mesh_get_view(mesh), &repair->pairs_before);
    status = tulle_mesh_repair(mesh, tolerance, &repair->done, error);
    if (status == TULLE_OK && mesh->triangle_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_MESH, source->path, 0, 0,
                            "no triangle has an area, so nothing is left to repair");
    if (status != TULLE_OK) return status;
    convert_source_keep_mesh(source);
    tulle_error reason = {0};
    repair->is_cloth =
        tulle_mesh_validate(tulle_mesh_get_view(mesh), TULLE_MESH_ROLE_CLOTH, &reason) == TULLE_OK;
    snprintf(repair->reason, sizeof repair->reason, "%s", reason.message);
    repair->is_judged &= count_pairs(tulle_mesh_get_view(mesh), &repair->pairs_after);
    return TULLE_OK;
}

void convert_repair_print(const convert_repair *repair) {
    static const char *const words[TULLE_REPAIR_COUNT] = {
        [TULLE_REPAIR_DEGENERATE] = "triangles without area dropped",
        [TULLE_REPAIR_DUPLICATE] = "triangles with the same corners as others dropped",
        [TULLE_REPAIR_JOINED] = "boundary vertices joined with others in the same place",
        [TULLE_REPAIR_T_JUNCTION] = "T-junctions mended: boundary edges split at vertices on them",
        [TULLE_REPAIR_EDGE] = "edges with three triangles or more cut: two stay joined there",
        [TULLE_REPAIR_CUT] = "vertices doubled where fans of triangles met, and moved inwards",
        [TULLE_REPAIR_TURNED] = "triangles turned over",
        [TULLE_REPAIR_LOOSE] = "vertices without a triangle left out"};
    int line = 0;
    for (size_t k = 0; k < TULLE_REPAIR_COUNT; k++) {
        const double *const place = repair->done.places + 3 * k;
        if (repair->done.counts[k] == 0) continue;
        printf("  %-11s %zu %s, first at (%.6g, %.6g, %.6g)\n", line++ == 0 ? "repaired" : "",
               repair->done.counts[k], words[k], place[0], place[1], place[2]);
    }
    if (line == 0) printf("  %-11s nothing: there was nothing to repair\n", "repaired");
    app_print_names(stdout, "  %-11s %s\n", "as cloth",
                    repair->is_cloth ? "can be used" : repair->reason);
    if (!repair->is_judged)
        printf("  %-11s no: there are too many pairs of triangles\n", "judged");
    else if (repair->pairs_after > repair->pairs_before)
        printf("  %-11s %zu pairs of triangles intersect, %zu before: the repair made some; "
               "`tulle check` lists them\n",
               "judged", repair->pairs_after, repair->pairs_before);
    else
        printf("  %-11s %zu pairs of triangles intersect, %zu before\n", "judged",
               repair->pairs_after, repair->pairs_before);
}
