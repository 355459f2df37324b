/* world/version.c - which library this is: its version, the sizes of its public structs. */
#include "base/error.h"
#include "tulle/tulle.h"

#include <string.h>

#define TEXT_OF(number) #number
#define VERSION_OF(major, minor, patch) TEXT_OF(major) "." TEXT_OF(minor) "." TEXT_OF(patch)

const char *tulle_version(void) {
    return VERSION_OF(TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR, TULLE_VERSION_PATCH);
}

typedef struct struct_size {
    const char *name;
    size_t size; /* [bytes] */
} struct_size;

#define SIZE_OF(type)                                                                              \
    { #type, sizeof(type) }
static const struct_size SIZES[] = {
    SIZE_OF(tulle_allocator),
    SIZE_OF(tulle_attachment_def),
    SIZE_OF(tulle_attachment_report),
    SIZE_OF(tulle_body),
    SIZE_OF(tulle_body_drive),
    SIZE_OF(tulle_check_body),
    SIZE_OF(tulle_check_pair),
    SIZE_OF(tulle_check_result),
    SIZE_OF(tulle_cloth_def),
    SIZE_OF(tulle_cloth_id),
    SIZE_OF(tulle_cloth_targets),
    SIZE_OF(tulle_contact),
    SIZE_OF(tulle_contact_law),
    SIZE_OF(tulle_counts),
    SIZE_OF(tulle_crease),
    SIZE_OF(tulle_curve),
    SIZE_OF(tulle_detect_def),
    SIZE_OF(tulle_detect_event),
    SIZE_OF(tulle_detect_receiver),
    SIZE_OF(tulle_detect_result),
    SIZE_OF(tulle_detect_statistics),
    SIZE_OF(tulle_detect_surface),
    SIZE_OF(tulle_error),
    SIZE_OF(tulle_event),
    SIZE_OF(tulle_event_watch),
    SIZE_OF(tulle_fineness),
    SIZE_OF(tulle_found),
    SIZE_OF(tulle_found_triangle),
    SIZE_OF(tulle_hit),
    SIZE_OF(tulle_intersection),
    SIZE_OF(tulle_keyframe),
    SIZE_OF(tulle_material),
    SIZE_OF(tulle_mesh),
    SIZE_OF(tulle_mesh_duplicates),
    SIZE_OF(tulle_mesh_info),
    SIZE_OF(tulle_mesh_lines),
    SIZE_OF(tulle_mesh_repairs),
    SIZE_OF(tulle_mesh_view),
    SIZE_OF(tulle_moment),
    SIZE_OF(tulle_motion),
    SIZE_OF(tulle_object_id),
    SIZE_OF(tulle_object_info),
    SIZE_OF(tulle_obstacle_def),
    SIZE_OF(tulle_obstacle_id),
    SIZE_OF(tulle_overlap),
    SIZE_OF(tulle_patch_options),
    SIZE_OF(tulle_pin),
    SIZE_OF(tulle_ray),
    SIZE_OF(tulle_record_writer),
    SIZE_OF(tulle_replay_options),
    SIZE_OF(tulle_replay_report),
    SIZE_OF(tulle_shape_def),
    SIZE_OF(tulle_springs),
    SIZE_OF(tulle_step_progress),
    SIZE_OF(tulle_step_report),
    SIZE_OF(tulle_stretch),
    SIZE_OF(tulle_target),
    SIZE_OF(tulle_tasks),
    SIZE_OF(tulle_transform),
    SIZE_OF(tulle_untangle_report),
    SIZE_OF(tulle_wind),
    SIZE_OF(tulle_world_batch),
    SIZE_OF(tulle_world_def),
    SIZE_OF(tulle_world_detection),
};

tulle_status tulle_check_struct(const char *name, size_t size, tulle_error *error) {
    if (!name) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the struct has no name");
    for (size_t i = 0; i < sizeof SIZES / sizeof SIZES[0]; i++) {
        if (strcmp(SIZES[i].name, name) != 0) continue;
        if (SIZES[i].size == size) return TULLE_OK;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s has %zu bytes in the program and %zu in the library, Tulle %s: build "
                         "the program with the headers of this library",
                         name, size, SIZES[i].size, tulle_version());
    }
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "the library, Tulle %s, has no struct '%.64s'", tulle_version(), name);
}
