/* fuzz/support/fuzz.h - what the fuzz targets share: a check that ends the process, numbers taken
 * from an input's bytes, files in a folder of the process, seeds.
 *
 * A target is one file of fuzz/targets. It defines the two functions below. libFuzzer calls the
 * first one; so does fuzz/support/replay_main.c, for AFL++ and for the kept corpus. */
#ifndef TULLE_FUZZ_FUZZ_H
#define TULLE_FUZZ_FUZZ_H

#include "tulle/mesh.h"

#include <stdbool.h>

/* Gives one input to what is tested. Any input is fine; returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
/* Writes inputs to begin with, by fuzz_put_seed. */
void fuzz_make_seeds(void);

/* Ends the process by abort, with a message, where `condition` does not hold. */
#define FUZZ_CHECK(condition)                                                                      \
    ((condition) ? (void)0 : fuzz_fail(__FILE__, __LINE__, #condition, NULL))
/* The same where a call failed that must not fail; the message has the error's text. */
#define FUZZ_CHECK_OK(status, error)                                                               \
    ((status) == TULLE_OK ? (void)0 : fuzz_fail(__FILE__, __LINE__, #status, error))
_Noreturn void fuzz_fail(const char *file, int line, const char *what, const tulle_error *error);

/* A call that failed said what is wrong: the error has its status and a message that ends. */
void fuzz_check_error(tulle_status status, const tulle_error *error);
/* All indices are in range and all coordinates are finite. */
void fuzz_check_mesh(tulle_mesh_view mesh);

/* The bytes of an input, taken from the front; zeros follow its end. */
typedef struct fuzz_bytes {
    const uint8_t *data;
    size_t size, used;
} fuzz_bytes;
uint8_t fuzz_take(fuzz_bytes *bytes);
/* 0 .. count - 1, 1 <= count <= 256. */
uint32_t fuzz_take_below(fuzz_bytes *bytes, uint32_t count);
/* One of 65536 numbers from `low` to `high`, both included. */
double fuzz_take_between(fuzz_bytes *bytes, double low, double high);
/* The next `size` bytes, or as many as are left; at most all of them. */
fuzz_bytes fuzz_take_part(fuzz_bytes *bytes, size_t size);

/* The path of a file in the folder of this process, which is removed at the end; the text stays. */
const char *fuzz_path(const char *name);
/* Writes a file there and returns its path. */
const char *fuzz_put_file(const char *name, const void *bytes, size_t byte_count);

/* Writes one seed. Only within fuzz_make_seeds. */
void fuzz_put_seed(const char *name, const void *bytes, size_t byte_count);
void fuzz_put_text_seed(const char *name, const char *text);
/* The contents of a file as a seed. */
void fuzz_put_file_seed(const char *name, const char *path);
/* Seeds of random bytes, for targets that make something of any bytes. */
void fuzz_put_random_seeds(size_t count, size_t byte_count);
/* The folder that fuzz_put_seed writes to. */
void fuzz_set_seed_folder(const char *folder);

#endif
