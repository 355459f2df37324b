/* app/bench/bench.h - what the parts of `tulle bench` share: a scene, rows of measures, and the
 * steps from a state in the middle of it to a comparison. lab/benchmarks.md tells what
 * is measured. */
#ifndef TULLE_APP_BENCH_BENCH_H
#define TULLE_APP_BENCH_BENCH_H

#include "app/bench/rows.h"
#include "app/cli/options.h"
#include "app/cli/progress_bar.h"
#include "io/file_data.h"
#include "scene/scene.h"

#include <stdbool.h>
#include <stdio.h>

enum { BENCH_THREADS_MAX = 8 /* numbers of threads in one call */ };

typedef struct bench_session {
    const char *scene_path;
    option_list overrides;
    char name[BENCH_NAME_SIZE], size[BENCH_NAME_SIZE]; /* of the case in the rows */
    uint32_t skip_count;    /* steps from the start to the state that is measured from */
    uint32_t step_count;    /* that are timed */
    const char *state_path; /* where that state is kept; null: nowhere */
    int threads[BENCH_THREADS_MAX];
    size_t threads_count;
    uint32_t repeat_count;
    double most_seconds; /* [s] no further repeat after that */
    progress_bar bar;
    bench_rows rows;
} bench_session;

/* state.c: the state after the skipped steps, as tulle_world_save_state gives it: read from the
 * file, or made, and kept there where a file is named. Release it with file_release. Gives an exit
 * code. */
int bench_get_state(bench_session *self, tulle_scene *loaded, memory *heap, file_data *state);

/* about.c: rows about the program, its compiler, the machine. Gives an exit code. */
int bench_describe_machine(bench_session *self);
/* measure.c: rows of times, counts and memory with every number of threads. Gives an exit code. */
int bench_measure(bench_session *self, tulle_scene *loaded);
/* steps.c: makes the timed steps. */
tulle_status bench_make_steps(tulle_world *world, double time_step, uint32_t count,
                              tulle_step_report *reports, tulle_error *error);

/* ---- table.c, compare.c: what the rows say ---- */

/* Markdown tables of times and counts. */
void bench_print_tables(const bench_rows *rows, FILE *stream);
/* Numbers of measures: of all that both have, and of those that got worse: slower times, more
 * memory or instructions, other counts or results. */
typedef struct bench_verdict {
    size_t compared, worse;
} bench_verdict;
/* What differs from the baseline, a line each, and a summary. */
bench_verdict bench_compare(const bench_rows *baseline, const bench_rows *rows, FILE *stream);

#endif
