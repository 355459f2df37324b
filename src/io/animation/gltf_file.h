/* io/animation/gltf_file.h - a glTF file that is read: its JSON text in memory, its buffers where
 * they are, and numbers of its accessors. Errors name the line of the JSON text that says what
 * cannot be, or the byte of a buffer. */
#ifndef TULLE_IO_ANIMATION_GLTF_FILE_H
#define TULLE_IO_ANIMATION_GLTF_FILE_H

#include "io/text/json_read.h"

#include <sys/types.h>

#define GLTF_NONE UINT32_MAX /* no number */

/* A file that holds buffers; several may be in one. */
typedef struct gltf_source {
    dev_t device;
    ino_t node;
    int file;
    uint64_t size; /* [bytes] */
} gltf_source;

/* Bytes in a file, or, of a data URI, in memory. */
typedef struct gltf_buffer {
    int file; /* of a source; -1: in memory */
    unsigned char *bytes;
    size_t byte_count;
    uint64_t offset, size; /* [bytes] in the file */
} gltf_buffer;

typedef struct gltf_slice {
    uint32_t buffer;
    uint64_t offset, size, stride; /* [bytes]; stride 0: no gaps */
    const json_value *place;
} gltf_slice;

/* Numbers in a slice, one behind the other or with gaps. */
typedef struct gltf_numbers {
    uint32_t slice; /* GLTF_NONE: all are 0 */
    uint64_t offset;
    uint32_t type;  /* as glTF names it: 5120 int8 ... 5126 float32 */
    uint32_t width; /* numbers of an element */
    bool is_normalized;
} gltf_numbers;

typedef struct gltf_accessor {
    gltf_numbers numbers;
    uint64_t count; /* elements */
    uint64_t sparse_count;
    gltf_numbers sparse_indices, sparse_values;
    const json_value *place;
} gltf_accessor;

typedef struct gltf_file {
    memory *heap;
    const char *path; /* must live as long */
    char *text;
    size_t text_size;
    uint64_t file_size; /* [bytes] of all files together */
    json_document json;
    ARRAY(gltf_source) sources; /* the first is the file itself */
    ARRAY(gltf_buffer) buffers;
    ARRAY(gltf_slice) slices;
    ARRAY(gltf_accessor) accessors;
} gltf_file;

/* Release with gltf_file_close, also after a failure. */
tulle_status gltf_file_open(memory *heap, const char *path, gltf_file *file, tulle_error *error);
void gltf_file_close(gltf_file *file);

/* Whether an extension changes no surface: those of materials, textures and lights. Numbers of any
 * type are read, as KHR_mesh_quantization has them. */
bool gltf_leaves_surfaces(const char *extension);

/* Reads `count` elements from number `first` on, all below the accessor's count. What is no finite
 * number is an error. */
tulle_status gltf_read(gltf_file *file, uint32_t accessor, uint64_t first, uint64_t count,
                       double *values, tulle_error *error);

/* A member that is a whole number below `limit`; missing: GLTF_NONE. */
tulle_status gltf_find_number(const gltf_file *file, const json_value *object, const char *key,
                              uint64_t limit, uint32_t *number, tulle_error *error);
/* An accessor that a member names, of elements of `width` numbers; missing: GLTF_NONE. */
tulle_status gltf_find_accessor(const gltf_file *file, const json_value *object, const char *key,
                                uint32_t width, uint32_t *number, tulle_error *error);
/* A member that is an array of `count` finite numbers. `values` stays as it is where there is none.
 */
tulle_status gltf_find_values(const gltf_file *file, const json_value *object, const char *key,
                              size_t count, double *values, tulle_error *error);
/* The items of an array that a member of the whole is; null: none. */
const json_value *gltf_get_items(const gltf_file *file, const char *key, size_t *count);

#endif
