/* io/animation/mdd_write.c - writes a surface as a point cache in the format MDD of LightWave, all
 * big endian: int32 number of frames and of vertices, float32 time of each frame [s], then x, y, z
 * of each vertex as float32, frame after frame. */
#include "base/error.h"
#include "io/animation/animation.h"

static void put_word(output_file *output, uint32_t value) {
    unsigned char const bytes[4] = {(unsigned char)(value >> 24), (unsigned char)(value >> 16),
                                    (unsigned char)(value >> 8), (unsigned char)value};
    output_write(output, bytes, sizeof bytes);
}

static void put_float(output_file *output, float value) {
    union {
        float number;
        uint32_t word;
    } const both = {.number = value};
    put_word(output, both.word);
}

tulle_status mdd_write(animation_job *job, tulle_error *error) {
    const tulle_animation_def *const def = job->def;
    if (def->surface_count != 1 || def->surfaces[0].motion == TULLE_ANIMATION_RIGID)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, job->path, 0, 0,
                            "an MDD cache holds the vertices of one surface");
    if (def->frame_count > INT32_MAX)
        return error_set_at(error, TULLE_ERROR_LIMIT, job->path, 0, 0,
                            "an MDD cache holds at most %d frames", INT32_MAX);
    output_file *output = NULL;
    tulle_status status = output_open(job->path, &output, error);
    if (status) return status;
    size_t const vertex_count = def->surfaces[0].mesh.vertex_count;
    put_word(output, def->frame_count);
    put_word(output, (uint32_t)vertex_count);
    for (uint32_t i = 0; i < def->frame_count; i++) put_float(output, (float)def->times[i]);
    for (uint32_t frame = 0; frame < def->frame_count && status == TULLE_OK; frame++) {
        status = animation_read(job, 0, frame, error);
        for (size_t i = 0; i < 3 * vertex_count && status == TULLE_OK; i++)
            put_float(output, job->points[i]);
    }
    if (status == TULLE_OK) return output_commit(output, error);
    output_discard(output);
    return status;
}
