/* io/animation/alembic_none.c - in the place of alembic.cpp, without TULLE_ALEMBIC: says what is
 * missing. */
#include "base/error.h"
#include "io/animation/animation.h"
#include "io/animation/animation_read.h"

static tulle_status refuse(const char *path, tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                        "this build of Tulle has no Alembic; configure it with "
                        "-DTULLE_ALEMBIC=ON, where libalembic-dev is installed");
}

tulle_status alembic_write(animation_job *job, tulle_error *error) {
    return refuse(job->path, error);
}

static tulle_status open_file(memory *heap, const char *path, void *state,
                              animation_content *content, tulle_error *error) {
    (void)heap, (void)state, (void)content;
    return refuse(path, error);
}

static void close_file(void *state) { (void)state; }

const animation_reader alembic_reader = {
    .extensions = {".abc"}, .state_size = 1, .open = open_file, .close = close_file};
