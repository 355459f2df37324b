/* io/animation/animation_read.c - tulle_animation_open and what follows: a file of an animation as
 * one mesh that moves. */
#include "io/animation/animation_read.h"

#include "base/error.h"
#include "io/file_data.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

struct tulle_animation {
    memory heap;
    char *path;
    size_t path_size;
    const animation_reader *reader;
    void *state;
    animation_content content;
};

void animation_add_note(tulle_animation_info *info, const char *format, ...) {
    size_t const length = strlen(info->note), room = sizeof info->note - length;
    va_list arguments;
    va_start(arguments, format);
    int const added =
        snprintf(info->note + length, room, "%s", length > 0 ? ", " : "passed over: ");
    if (added > 0 && (size_t)added < room)
        (void)vsnprintf(info->note + length + added, room - (size_t)added, format, arguments);
    va_end(arguments);
}

static const animation_reader *const readers[] = {&gltf_reader, &usd_reader, &npz_reader,
                                                  &alembic_reader};

static bool has_extension(const char *path, const char *extension) {
    size_t const length = strlen(path), tail = strlen(extension);
    return length >= tail && strcasecmp(path + length - tail, extension) == 0;
}

static const animation_reader *find_reader(const char *path) {
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; i++)
        for (int k = 0; k < 3; k++)
            if (readers[i]->extensions[k] && has_extension(path, readers[i]->extensions[k]))
                return readers[i];
    return NULL;
}

static tulle_status open_file(tulle_animation *animation, const char *path, tulle_error *error) {
    animation->path_size = strlen(path) + 1;
    animation->path = memory_allocate(&animation->heap, animation->path_size);
    animation->state = memory_allocate_zeroed(&animation->heap, 1, animation->reader->state_size);
    if (!animation->path || !animation->state) return file_fail_memory(error, path);
    memcpy(animation->path, path, animation->path_size);
    return animation->reader->open(&animation->heap, animation->path, animation->state,
                                   &animation->content, error);
}

tulle_status tulle_animation_open(const char *path, tulle_animation **animation,
                                  tulle_animation_info *info, tulle_error *error) {
    if (!path || !animation)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "path and animation may not be null");
    *animation = NULL;
    const animation_reader *const reader = find_reader(path);
    if (!reader)
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "animations that can be read end in .glb, .gltf, .usda, .npz or .abc");
    memory heap = memory_default();
    tulle_animation *const made = memory_allocate_zeroed(&heap, 1, sizeof *made);
    if (!made) return file_fail_memory(error, path);
    made->heap = heap;
    made->reader = reader;
    tulle_status const status = open_file(made, path, error);
    if (status) {
        tulle_animation_close(made);
        return status;
    }
    if (info) *info = made->content.info;
    *animation = made;
    return TULLE_OK;
}

size_t animation_get_file_count(const tulle_animation *animation) {
    return animation->content.file_count;
}

int animation_get_file(const tulle_animation *animation, size_t number) {
    return animation->reader->get_file(animation->state, number);
}

const uint32_t *tulle_animation_get_triangles(const tulle_animation *animation) {
    return animation && animation->content.info.triangle_count > 0 ? animation->content.triangles
                                                                   : NULL;
}

double tulle_animation_get_time(const tulle_animation *animation, uint32_t frame) {
    if (!animation || frame >= animation->content.info.frame_count) return (double)NAN;
    return animation->content.times[frame];
}

tulle_status tulle_animation_read_frame(tulle_animation *animation, uint32_t frame,
                                        double *positions, tulle_error *error) {
    if (!animation || !positions || frame >= animation->content.info.frame_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no frame %u", frame);
    return animation->reader->read(animation->state, frame, positions, error);
}

void tulle_animation_close(tulle_animation *animation) {
    if (!animation) return;
    if (animation->path && animation->state) animation->reader->close(animation->state);
    memory_release(&animation->heap, animation->state, animation->reader->state_size);
    memory_release(&animation->heap, animation->path, animation->path_size);
    memory heap = animation->heap;
    memory_release(&heap, animation, sizeof *animation);
}
