/* tulle/base.h - status codes, errors, allocators and mesh views, which every public header uses.
 *
 * All quantities of the library are in SI units: metres, kilograms, seconds, radians. All are
 * doubles.
 *
 * A def is a struct of settings. Its `..._def_default` function makes it; the caller then changes
 * the fields that matter. A def whose cookie is not set is refused.
 *
 * A call that can fail returns a tulle_status. Its last parameter `error` may be null; otherwise
 * the call writes there what is wrong and what to do about it.
 *
 * A call that returns a tulle_status refuses a null pointer with TULLE_ERROR_INVALID_ARGUMENT,
 * unless its comment allows null. It also refuses a null array whose count is above 0. A call that
 * returns something else says what it gives for null. A call never crashes on a null pointer, an
 * index, an enum value or a number. It may crash on a pointer that is neither null nor valid. */
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

/* Version of the library: MAJOR.MINOR.PATCH. The first number changes when the interface breaks. */
#define TULLE_VERSION_MAJOR 0
/* The second number of the version changes when the interface grows. */
#define TULLE_VERSION_MINOR 1
/* The third number of the version changes with corrections. */
#define TULLE_VERSION_PATCH 0

/* Stands for "no index" wherever the library gives a uint32_t index. */
#define TULLE_NONE UINT32_MAX

/* What a call that can fail returns. Zero is success. */
typedef enum tulle_status {
    TULLE_OK = 0, /* success */
    /* a value is out of its range, an id is stale, or a def has no cookie */
    TULLE_ERROR_INVALID_ARGUMENT,
    TULLE_ERROR_OUT_OF_MEMORY, /* the allocator returned null, or its byte limit was met */
    TULLE_ERROR_IO,            /* a file could not be opened, read, written or renamed */
    TULLE_ERROR_DISK_FULL,     /* the disk filled up while a file was being written */
    TULLE_ERROR_PARSE,         /* the text or the bytes of a file do not follow its format */
    TULLE_ERROR_INVALID_MESH,  /* indices, topology or coordinates of a mesh cannot be used */
    /* before the first step, cloth intersects itself, another cloth or an obstacle */
    TULLE_ERROR_INTERSECTING_START,
    /* obstacles or pins leave cloth no room, and what `on_pinch` says did not help */
    TULLE_ERROR_PINCHED,
    /* the step found no state without an intersection; the world is as it was before the step */
    TULLE_ERROR_STEP_FAILED,
    TULLE_ERROR_LIMIT,       /* a documented size limit would be exceeded */
    TULLE_ERROR_INTERRUPTED, /* the caller asked to stop */
    TULLE_ERROR_UNSUPPORTED, /* the file or the option is valid, but this build cannot handle it */
    TULLE_STATUS_COUNT       /* number of the values above; never returned */
} tulle_status;

/* A short English phrase for a status, also for a number that is not a status. Never null; the
 * string is static. */
TULLE_API const char *tulle_status_text(tulle_status status);

/* What went wrong. Every call that takes a `tulle_error *` accepts null. A call that succeeds
 * leaves the struct as it was. */
typedef struct tulle_error {
    tulle_status status; /* the value that the call returned */
    char file[512];      /* path of the file that caused the error; empty if none did */
    int line;            /* line in that file, from 1; 0 if there is none */
    int column;          /* column in that line, from 1; 0 if there is none */
    /* what is wrong and what to do about it; without file and line, without a newline at the end */
    char message[2048];
} tulle_error;

/* Version of the library that runs: "MAJOR.MINOR.PATCH"; static. TULLE_VERSION_MAJOR and so on are
 * the version of the headers that the program was built with. */
TULLE_API const char *tulle_version(void);
/* Checks that the library's struct `name`, such as "tulle_world_def", has `size` bytes. Another
 * size means that the library was built with other headers, or that a binding declares the struct
 * wrongly. Call it before the first use of the struct if the loaded library may be another version.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, no struct of libtulle's headers, another size). */
TULLE_API tulle_status tulle_check_struct(const char *name, size_t size, tulle_error *error);
/* The same for a struct as this program has it: TULLE_CHECK_STRUCT(tulle_world_def, &error). */
#define TULLE_CHECK_STRUCT(type, error) tulle_check_struct(#type, sizeof(type), (error))

/* Where a world or a detector takes its memory. If both functions are null, it uses malloc and
 * free, and asks Linux for large pages for blocks of 2 MiB and more. If only one is null, the
 * allocator is refused with TULLE_ERROR_INVALID_ARGUMENT. The functions may be called from the
 * thread that called the library and from its workers, but never at the same time for one world.
 * The judge always uses malloc, also when a world calls it. */
typedef struct tulle_allocator {
    /* returns `byte_count` bytes, or null when there are none; any alignment will do */
    void *(*allocate)(void *context, size_t byte_count);
    /* takes back what `allocate` returned; `byte_count` is the size that was asked for */
    void (*release)(void *context, void *pointer, size_t byte_count);
    void *context;     /* handed to both functions; the library never looks at it */
    size_t byte_limit; /* [bytes] most that may be held at once; 0: no limit */
} tulle_allocator;

/* A task that the library gives a host to run: call it with `work` and the index of the task. */
typedef void (*tulle_task)(void *work, size_t index);
/* Runs tasks on threads of the host, such as the job system of an engine. */
typedef struct tulle_tasks {
    /* Calls task(work, index) once for each index 0 .. count - 1, on any threads, at the same time
     * or one after the other, and returns when all calls have. Tasks do not wait for one another.
     * What a task writes must be seen by the thread that called `run`. */
    void (*run)(void *context, tulle_task task, void *work, size_t count);
    void *context; /* handed to `run`; the library never looks at it */
} tulle_tasks;

/* Triangles over points, borrowed: the caller owns the arrays, the library copies what it keeps. */
typedef struct tulle_mesh_view {
    const double
        *positions;      /* [m] 3 * vertex_count, each -1e100 .. 1e100: x, y, z of each vertex */
    size_t vertex_count; /* 1 .. 2147483647 */
    /* 3 * triangle_count: vertex indices, counterclockwise seen from outside */
    const uint32_t *triangles;
    size_t triangle_count; /* 0 .. 2147483647 */
} tulle_mesh_view;

#ifdef __cplusplus
}
#endif
#endif
