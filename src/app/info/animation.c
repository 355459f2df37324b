/* app/info/animation.c - what `tulle info` prints of an animation with its triangles: a scene of
 * glTF, USD, NPZ or Alembic, or numbered mesh files. */
#include "app/commands.h"
#include "app/info/info.h"

#include "app/cli/axes.h"
#include "app/convert/names.h"
#include "app/convert/source.h"
#include "base/error.h"

#include "tulle/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *get_kind(const convert_source *source) {
    if (source->kind == SOURCE_FILES) return "numbered meshes";
    switch (convert_get_format(source->path)) {
    case CONVERT_GLB:
    case CONVERT_GLTF: return "animation (glTF)";
    case CONVERT_USDA: return "animation (USD)";
    case CONVERT_NPZ: return "animation (NPZ)";
    default: return "animation (Alembic)";
    }
}

static void print_frames(const convert_source *source, double first, double last) {
    frame_range const frames = source->frames;
    uint32_t const count = frame_range_get_count(frames);
    printf("  %-16s %u", "frames", count);
    if (source->kind == SOURCE_FILES)
        printf(", numbers %u to %u in steps of %u", frames.first, frames.last, frames.step);
    else if (isfinite(first) && isfinite(last))
        printf(", from %.6g s to %.6g s", first, last);
    putchar('\n');
    if (source->kind == SOURCE_ANIMATION && source->animation_info.added_frame_count > 0)
        printf("  %-16s %u of them between keys, along the arcs of turns and curves, and before "
               "jumps\n",
               "", source->animation_info.added_frame_count);
    if (source->needs_frames_named) printf("  %-16s no file of number %u\n", "", source->gap);
}

static tulle_status print_frame(convert_source *source, uint32_t frame, const axes_change *change,
                                tulle_error *error) {
    double *const positions = calloc(source->mesh.vertex_count + 1, 3 * sizeof *positions);
    if (!positions) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a frame");
    tulle_status const status = convert_source_read(source, frame, positions, error);
    if (status == TULLE_OK) {
        printf("  frame %u\n", frame);
        axes_apply(change, positions, source->mesh.vertex_count);
        info_print_bounds(positions, source->mesh.vertex_count);
    }
    free(positions);
    return status;
}

static tulle_status print_all(convert_source *source, tulle_error *error) {
    frame_range const frames = source->frames;
    double ends[2];
    tulle_status status = convert_source_find_time(source, frames.first, &ends[0], error);
    if (status == TULLE_OK) status = convert_source_find_time(source, frames.last, &ends[1], error);
    if (status != TULLE_OK) return status;
    app_print_names(stdout, "%s: %s\n", source->path, get_kind(source));
    printf("  %-16s %zu\n", "vertices", source->mesh.vertex_count);
    printf("  %-16s %zu\n", "triangles", source->mesh.triangle_count);
    print_frames(source, ends[0], ends[1]);
    axes_change const change = convert_source_find_scene_change(source);
    if (source->kind == SOURCE_ANIMATION) {
        double const meters = source->animation_info.meters_per_unit;
        bool const is_changed = meters != 1.0 || source->animation_info.is_y_up;
        printf("  %-16s %s points up; a unit is %.7g m%s\n", "axes", change.from.up, meters,
               is_changed ? "; below z points up, in metres" : "");
    }
    if (source->described.note[0])
        app_print_names(stdout, "  %-16s %s\n", "file", source->described.note);
    status = print_frame(source, frames.first, &change, error);
    if (status == TULLE_OK && frames.last != frames.first)
        status = print_frame(source, frames.last, &change, error);
    if (status != TULLE_OK || source->mesh.triangle_count == 0) return status;
    axes_apply(&change, source->mesh.positions, source->mesh.vertex_count);
    info_print_use(tulle_mesh_get_view(&source->mesh), TULLE_MESH_ROLE_CLOTH, &source->described,
                   "as cloth");
    return info_print_use_as_obstacle(&source->mesh, &source->described, true, error);
}

tulle_status info_print_animation(const char *path, tulle_error *error) {
    convert_source source;
    tulle_status status = convert_source_open(&(source_options){.path = path}, &source, error);
    if (status == TULLE_OK) status = print_all(&source, error);
    convert_source_close(&source);
    return status;
}
