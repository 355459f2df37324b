/* tulle/base.h - status codes, errors, allocators and views shared by every public header.
 *
 * All quantities in this library are in SI units (metres, kilograms, seconds, radians) and in
 * double precision.
 */
#ifndef TULLE_BASE_H
#define TULLE_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(TULLE_BUILD_SHARED) && defined(__GNUC__)
#define TULLE_API __attribute__((visibility("default")))
#else
#define TULLE_API
#endif

#define TULLE_VERSION_MAJOR 0
#define TULLE_VERSION_MINOR 1
#define TULLE_VERSION_PATCH 0

/* Marks "no index" in any uint32_t index of the library. */
#define TULLE_NONE UINT32_MAX

/* What every call that can fail returns. Zero is success. */
typedef enum tulle_status {
    TULLE_OK = 0,
    TULLE_ERROR_INVALID_ARGUMENT, /* a value given to the call is out of its range, or a def has no
                                     cookie */
    TULLE_ERROR_OUT_OF_MEMORY,    /* the allocator returned null, or its byte limit was met */
    TULLE_ERROR_IO,               /* a file could not be opened, read, written or renamed */
    TULLE_ERROR_DISK_FULL,        /* no space left where a file was being written */
    TULLE_ERROR_PARSE,            /* a file's text or bytes do not follow its format */
    TULLE_ERROR_INVALID_MESH,     /* indices, topology or coordinates of a mesh cannot be used */
    TULLE_ERROR_INTERSECTING_START, /* cloth intersects itself, other cloth or an obstacle before
                                       the first step */
    TULLE_ERROR_PINCHED, /* cloth is held between obstacles that close on it and on_pinch says stop
                          */
    TULLE_ERROR_STEP_FAILED, /* no admissible state was found; the world is as it was before the
                                step */
    TULLE_ERROR_LIMIT,       /* a documented size limit would be exceeded */
    TULLE_ERROR_INTERRUPTED, /* the caller asked to stop */
    TULLE_ERROR_UNSUPPORTED, /* the file or option is valid but this build cannot handle it */
    TULLE_STATUS_COUNT       /* sentinel, never returned */
} tulle_status;

/* A short English phrase for a status; never null, static storage. */
TULLE_API const char *tulle_status_text(tulle_status status);

/* Details of a failure. Calls that take a `tulle_error *` accept null. On success the struct is
 * untouched. */
typedef struct tulle_error {
    tulle_status status; /* the same value that the call returned */
    char file[512];      /* path of the offending file; empty if none */
    int line;            /* 1-based line; 0 if it does not apply */
    int column;          /* 1-based column; 0 if it does not apply */
    char message[2048];  /* what is wrong and what to do about it, without file or line, no trailing
                            newline */
} tulle_error;

/* Memory of a world comes through these. `allocate` returns null on failure; memory needs alignment
 * of 64 bytes at most, which the library arranges itself. `release` receives the size that was
 * asked for. Both may be called from the thread that called the library, and from its workers, but
 * never concurrently for one world. Both null: malloc and free; one of them alone is refused with
 * INVALID_ARGUMENT. The judge takes memory of its own by malloc, also when a world asks it. */
typedef struct tulle_allocator {
    void *(*allocate)(void *context, size_t byte_count);
    void (*release)(void *context, void *pointer, size_t byte_count);
    void *context;
    size_t byte_limit; /* [bytes] most that may be held at once; 0: no limit */
} tulle_allocator;

/* Triangles over points, borrowed: the library copies what it keeps. */
typedef struct tulle_mesh_view {
    const double *positions; /* [m], 3 * vertex_count */
    size_t vertex_count;     /* 1 .. 2^31 - 1 */
    const uint32_t
        *triangles; /* 3 * triangle_count vertex indices, counterclockwise seen from outside */
    size_t triangle_count; /* 0 .. 2^31 - 1 */
} tulle_mesh_view;

#ifdef __cplusplus
}
#endif
#endif
