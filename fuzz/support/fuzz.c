/* fuzz/support/fuzz.c - see fuzz.h. */
#define _XOPEN_SOURCE 700
#include "support/fuzz.h"

#include "base/hash.h"
#include "io/io_support.h"

#include <math.h>

static char seed_folder[512];

_Noreturn void fuzz_fail(const char *file, int line, const char *what, const tulle_error *error) {
    fprintf(stderr, "%s:%d: does not hold: %s%s%s\n", file, line, what, error ? ": " : "",
            error ? error->message : "");
    abort();
}

void fuzz_check_error(tulle_status status, const tulle_error *error) {
    FUZZ_CHECK(status != TULLE_OK && status < TULLE_STATUS_COUNT);
    FUZZ_CHECK(error->status == status);
    FUZZ_CHECK(memchr(error->message, '\0', sizeof error->message));
    FUZZ_CHECK(memchr(error->file, '\0', sizeof error->file));
    FUZZ_CHECK(error->message[0] != '\0');
    FUZZ_CHECK(error->line >= 0 && error->column >= 0);
}

void fuzz_check_mesh(tulle_mesh_view mesh) {
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) FUZZ_CHECK(isfinite(mesh.positions[i]));
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        FUZZ_CHECK(mesh.triangles[i] < mesh.vertex_count);
}

/* ---- numbers from bytes ---- */

uint8_t fuzz_take(fuzz_bytes *bytes) {
    return bytes->used < bytes->size ? bytes->data[bytes->used++] : 0;
}

uint32_t fuzz_take_below(fuzz_bytes *bytes, uint32_t count) { return fuzz_take(bytes) % count; }

double fuzz_take_between(fuzz_bytes *bytes, double low, double high) {
    int const first = fuzz_take(bytes), second = fuzz_take(bytes);
    return low + (high - low) * (256 * first + second) / 65535.0;
}

fuzz_bytes fuzz_take_part(fuzz_bytes *bytes, size_t size) {
    size_t const left = bytes->size - bytes->used;
    fuzz_bytes const part = {.data = bytes->data + bytes->used, .size = size < left ? size : left};
    bytes->used += part.size;
    return part;
}

/* ---- files ---- */

static void remove_folder(void) { remove_test_folder(NULL); }

const char *fuzz_path(const char *name) {
    if (!test_folder[0]) {
        /* run.sh names a folder that it removes itself, since a crash leaves what is in it. */
        const char *const base = getenv("TULLE_FUZZ_FOLDER");
        snprintf(test_folder, sizeof test_folder, "%s/tulle-fuzz-XXXXXX",
                 base                            ? base
                 : access("/dev/shm", W_OK) == 0 ? "/dev/shm"
                                                 : "/tmp");
        FUZZ_CHECK(mkdtemp(test_folder));
        atexit(remove_folder);
    }
    return test_path(name);
}

const char *fuzz_put_file(const char *name, const void *bytes, size_t byte_count) {
    const char *const path = fuzz_path(name);
    put_file(path, bytes, byte_count);
    return path;
}

/* ---- seeds ---- */

void fuzz_set_seed_folder(const char *folder) {
    snprintf(seed_folder, sizeof seed_folder, "%s", folder);
}

void fuzz_put_seed(const char *name, const void *bytes, size_t byte_count) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", seed_folder, name);
    put_file(path, bytes, byte_count);
}

void fuzz_put_text_seed(const char *name, const char *text) {
    fuzz_put_seed(name, text, strlen(text));
}

void fuzz_put_file_seed(const char *name, const char *path) {
    size_t byte_count;
    char *const bytes = get_file(path, &byte_count);
    fuzz_put_seed(name, bytes, byte_count);
    free(bytes);
}

void fuzz_put_random_seeds(size_t count, size_t byte_count) {
    uint64_t seed = 1;
    uint8_t *const bytes = malloc(byte_count);
    FUZZ_CHECK(bytes);
    for (size_t i = 0; i < count; i++) {
        char name[32];
        for (size_t k = 0; k < byte_count; k++) bytes[k] = (uint8_t)random_next(&seed);
        snprintf(name, sizeof name, "random_%02zu", i);
        fuzz_put_seed(name, bytes, byte_count);
    }
    free(bytes);
}
