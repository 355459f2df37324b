/* app/bench/bench.h - what the parts of `tulle bench` share: scenes in several sizes, rows of
 * measures, and the steps from a captured input to a comparison. docs/experiments/benchmarks.md
 * tells what is measured.
 */
#ifndef TULLE_APP_BENCH_BENCH_H
#define TULLE_APP_BENCH_BENCH_H

#include "app/bench/rows.h"
#include "app/cli/progress_bar.h"
#include "scene/scene.h"

#include <stdbool.h>
#include <stdio.h>

enum {
    BENCH_SIZE_COUNT = 6,
    BENCH_OVERRIDE_MAX = 3, /* of one scene in one size */
    BENCH_THREADS_MAX = 8,  /* numbers of threads in one call */
    BENCH_PATH_SIZE = 1024  /* [bytes] */
};

/* ---- bench_scenes.c: what is measured ---- */

/* A size of cloth. */
typedef struct bench_size {
    const char *name;    /* "9.8k" */
    uint32_t step_count; /* that are timed; fewer where they take long */
    bool is_quick;       /* of --quick alone */
    bool is_apart;       /* not among "all" */
    bool is_small;       /* small enough to count its instructions */
} bench_size;
extern const bench_size bench_sizes[BENCH_SIZE_COUNT];

/* A scene and how it comes to each size. */
typedef struct bench_scene {
    const char *name;
    const char *file;      /* below the directory of scenes, without .yaml */
    uint32_t capture_step; /* steps from the start to the captured input */
    bool is_apart;         /* not among "all" */
    const char *overrides[BENCH_SIZE_COUNT][BENCH_OVERRIDE_MAX]; /* all null: not in this size */
} bench_scene;
extern const bench_scene bench_scenes[];
extern const size_t bench_scene_count;

/* Index of a name, or the count where there is none. */
size_t bench_find_scene(const char *name);
size_t bench_find_size(const char *name);

static inline bool bench_has_size(const bench_scene *of, size_t size) {
    return of->overrides[size][0] != NULL;
}

/* ---- the session ---- */

typedef struct bench_case {
    const bench_scene *scene;
    size_t size; /* index in bench_sizes */
} bench_case;

typedef struct bench_session {
    char scenes[BENCH_PATH_SIZE]; /* directory */
    const char *inputs;           /* directory of captured inputs */
    bool is_scene_wanted[16], is_size_wanted[BENCH_SIZE_COUNT];
    int threads[BENCH_THREADS_MAX];
    size_t threads_count;
    uint32_t repeat_count;
    double most_seconds; /* [s] no further repeat of a case after that */
    bool renews_inputs, counts_instructions;
    uint64_t fingerprint; /* of the physics, see bench_find_fingerprint */
    progress_bar bar;
    size_t whole_cases; /* that are measured */
    bench_rows rows;
} bench_session;

/* ---- bench_input.c: a state of the scene in the middle of contact ---- */

/* Where a saved state is. It is read for each repeat: large ones would count in what is held. */
typedef struct bench_input {
    char path[2 * BENCH_PATH_SIZE];
} bench_input;

/* The scene in a size; prints what is wrong with it. Gives an exit code. */
int bench_load_scene(const bench_session *self, const bench_case *which, tulle_scene **loaded);
/* The input of a case in the directory, made and put there if it is not. */
int bench_get_input(bench_session *self, const bench_case *which, tulle_scene *loaded,
                    bench_input *input);
/* The hash of a short simulation: two builds of one fingerprint nearly always make the same inputs,
 * bit for bit. */
tulle_status bench_find_fingerprint(uint64_t *fingerprint, tulle_error *error);

/* ---- measuring; each appends rows and gives an exit code ---- */

/* bench_about.c: the program, its compiler, the machine. */
int bench_describe_machine(bench_session *self);
/* bench_measure.c: times, counts and memory of a case with every number of threads. */
int bench_measure_case(bench_session *self, const bench_case *which);
/* bench_instructions.c: instructions of the timed steps on one thread, by callgrind. Where valgrind
 * is missing it says so and adds no row. */
int bench_count_instructions(bench_session *self, const bench_case *which);
/* bench_steps.c: makes the timed steps. */
tulle_status bench_make_steps(tulle_world *world, double time_step, uint32_t count,
                              tulle_step_report *reports, tulle_error *error);

/* ---- bench_table.c, bench_compare.c: what the rows say ---- */

/* Markdown tables: times, counts, and of scenes in several sizes what a particle takes. */
void bench_print_tables(const bench_rows *rows, FILE *stream);
/* Numbers of measures: of all that both have, and of those that got worse: slower times, more
 * memory or instructions, other counts or results. */
typedef struct bench_verdict {
    size_t compared, worse;
} bench_verdict;
/* What differs from the baseline, a line each, and a summary. */
bench_verdict bench_compare(const bench_rows *baseline, const bench_rows *rows, FILE *stream);

#endif
