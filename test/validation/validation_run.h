/* validation_run.h - the inside of a run, shared by the files of the harness; experiments do
 * without. */
#ifndef TULLE_TEST_VALIDATION_RUN_H
#define TULLE_TEST_VALIDATION_RUN_H

#include "validation/validation.h"
#include "validation/validation_progress.h"

#include <setjmp.h>
#include <stdio.h>

typedef enum row_verdict {
    VERDICT_FINE,
    VERDICT_OFF,
    VERDICT_SKIPPED,
    VERDICT_TOLD,
    VERDICT_OPEN /* off, as is known, in a quick run */
} row_verdict;

enum { VALIDATION_TEXT = 256 };
typedef struct validation_row {
    const char *experiment;                                           /* its name */
    char what[VALIDATION_TEXT], unit[16], reference[VALIDATION_TEXT]; /* reference: or the reason */
    char expected[48];                                                /* "<= 1e-06" */
    double measured;
    row_verdict verdict;
} validation_row;

typedef struct validation_table {
    validation_row *rows;
    size_t count, capacity;
} validation_table;

/* Sums over all steps of all experiments. */
typedef struct validation_totals {
    uint64_t steps, contacts, rescues, judged, crossing;
    double smallest_gap_share; /* of the minimum gap in force */
} validation_totals;

/* A world of the run with what the judge must know. */
enum { VALIDATION_BODIES = 64, VALIDATION_WORLDS = 64 };
typedef struct validation_world {
    tulle_world *world;
    double minimum_gap;                        /* [m] */
    tulle_mesh_view cloths[VALIDATION_BODIES]; /* of meshes that the run owns */
    tulle_mesh_view obstacles[VALIDATION_BODIES];
    tulle_cloth_id cloth_ids[VALIDATION_BODIES];
    tulle_obstacle_id obstacle_ids[VALIDATION_BODIES];
    size_t cloth_count, obstacle_count;
} validation_world;

/* One thing to be released with the run. */
typedef struct validation_block {
    struct validation_block *next;
    tulle_mesh mesh;
    void *bytes;
    void *object; /* of another module, with what releases it */
    void (*release)(void *object);
} validation_block;

struct validation_run {
    const experiment *experiment;
    const validation_options *options;
    tulle_world_def def; /* of all worlds */
    validation_table *table;
    validation_totals *totals;
    const char *plot_directory; /* null: no plots */
    validation_world worlds[VALIDATION_WORLDS];
    size_t world_count;
    validation_block *blocks;
    FILE *plot_data;
    validation_progress progress;
    jmp_buf leave;
};

/* The experiment of the rows that hold for all together. */
extern const experiment validation_all;

/* Runs one experiment and releases what it made. False: it was interrupted, its rows are none. */
bool validation_run_experiment(validation_run *run);
/* Adds the rows that hold for all experiments together. */
void validation_report_totals(validation_run *run);
void validation_add_row(validation_table *table, const validation_row *row);
/* Ends the file of the plot that is open, if one is. */
void validation_end_plot(validation_run *run);

#endif
