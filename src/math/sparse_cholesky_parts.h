/* math/sparse_cholesky_parts.h - the insides of sparse_cholesky, for its files alone.
 *
 * Vertices are numbered by their place in the order of elimination. Each node of the dissection has
 * a front: the dense matrix of its own vertices (columns that are eliminated) and of the later ones
 * that they and those of the fronts below touch. What elimination takes off the later ones is the
 * front's update; it is added to the front above it.
 *
 * Based on: Duff, Reid, The multifrontal solution of indefinite sparse symmetric linear equations,
 * 1983; Liu, The multifrontal method for sparse matrix solution, 1992. */
#ifndef TULLE_MATH_SPARSE_CHOLESKY_PARTS_H
#define TULLE_MATH_SPARSE_CHOLESKY_PARTS_H

#include "math/dissection.h"
#include "math/front_kernel.h"
#include "math/sparse_cholesky.h"

typedef struct cholesky_front {
    uint32_t begin, own, others; /* vertices; own ones are begin .. begin + own - 1 */
    uint32_t parent;
    uint32_t child_begin, child_end; /* into `children` */
    uint32_t run_begin, run_end;     /* into `runs`: where its later vertices are in its parent */
    size_t row_begin;                /* into `rows` */
    size_t panel;                    /* into `columns` */
    size_t update;                   /* into `updates`, or the stack of the task's worker */
    bool keeps_update;               /* in `updates`: another task reads it */
    size_t vector;                   /* into `vectors` */
    size_t entry_begin, entry_end;   /* into `entries` */
} cholesky_front;

/* Block `source` of the pattern goes to a panel. */
typedef struct front_entry {
    uint32_t source;
    uint32_t row, column; /* vertices, in the matrix's numbering */
    uint32_t target;      /* offset of the first number in the panel */
} front_entry;

/* Fronts that one thread works through: a whole tree below a front, or one front above them. */
typedef struct front_task {
    uint32_t begin, end;
} front_task;

struct sparse_cholesky {
    size_t vertex_count;
    uint32_t *order, *places; /* vertex at a place, place of a vertex */
    ARRAY(cholesky_front) fronts;
    ARRAY(uint32_t) children;
    ARRAY(uint32_t) rows; /* later vertices of each front, by place, ascending */
    ARRAY(front_run) runs;
    ARRAY(front_entry) entries;
    ARRAY(front_task) tasks;
    ARRAY(uint32_t) waves; /* into tasks: those of a wave need only those of waves before */
    size_t panel_size, update_size, vector_size;
    size_t largest_panel, largest_stack; /* scratch that each worker needs */
    int16_t *columns;                    /* panel_size: L, see packed_front */
    float *scales, *inverses;            /* 3 * vertex_count, by place */
    float *updates, *vectors;
    float *floors;     /* 3 * vertex_count: least pivots, by place */
    uint8_t *is_fixed; /* vertex_count */
    uint32_t *raised;  /* of each front */
    uint64_t operations, entry_count;
};

static inline front_panel get_panel(const cholesky_front *front, float *columns) {
    size_t const own = 3 * (size_t)front->own, others = 3 * (size_t)front->others;
    return (front_panel){columns, own, others, front_stride(own, others)};
}

static inline packed_front get_packed(const sparse_cholesky *factor, const cholesky_front *front) {
    size_t const own = 3 * (size_t)front->own, others = 3 * (size_t)front->others;
    size_t const place = 3 * (size_t)front->begin;
    return (packed_front){factor->columns + front->panel,
                          factor->scales + place,
                          factor->inverses + place,
                          own,
                          others,
                          front_stride(own, others)};
}

/* sparse_cholesky.c: where a place is in a front, own vertices first; TULLE_NONE: it is not there.
 */
uint32_t find_in_front(const sparse_cholesky *factor, const cholesky_front *front, uint32_t place);

/* sparse_cholesky_tasks.c: cuts the fronts into tasks and waves and places their updates. */
bool plan_tasks(memory *heap, sparse_cholesky *factor);

#endif
