/* support/spring_system.h - matrices like those of cloth, for tests of solvers: springs of random
 * directions and stiffnesses along the edges of a graph, and isotropic ones along its wide edges.
 * Calls assert what must not fail. */
#ifndef TULLE_TEST_SUPPORT_SPRING_SYSTEM_H
#define TULLE_TEST_SUPPORT_SPRING_SYSTEM_H

#include "math/block_matrix.h"
#include "math/matrix_term.h"

/* Uniform in -1 .. 1. */
double random_signed(uint64_t *random);

typedef struct spring_graph {
    size_t vertex_count, edge_count, wide_count;
    uint32_t (*edges)[2];
    uint32_t (*wide)[2]; /* null: from each vertex to the fifth after it */
} spring_graph;

/* Triangulated grid; where has_hole, some vertices in it lack their edges. */
spring_graph spring_graph_make_grid(size_t columns, size_t rows, bool has_hole);

/* Triangulated grids of one size that follow each other. No edge joins two of them. */
typedef struct spring_sheets {
    size_t columns, rows, count; /* of a sheet; sheets */
    size_t wide_count;           /* how many of the ways below wide edges go */
    bool has_hole;               /* in each sheet */
    bool is_crossed;             /* squares of every other row are cut along the other diagonal */
} spring_sheets;
/* Wide edges lead two rows down, two columns right, both, two down and two left, one down and two
 * right, and one down and two left. */
enum { SPRING_WAYS = 6 };
spring_graph spring_graph_make_sheets(const spring_sheets *sheets);
/* Edges between any vertices: also several pieces and high valences. */
spring_graph spring_graph_make_random(size_t vertex_count, size_t edge_count, uint64_t seed);

typedef struct spring_system {
    memory heap;
    spring_graph mesh;
    block_matrix matrix;
    block_pattern patterns[2]; /* that the matrix borrows, */
    double *scalars;           /* as well as these */
    uint8_t *is_fixed;
} spring_system;

/* Takes the graph over. No vertex is fixed. */
spring_system spring_system_make(spring_graph mesh, double stiffness, uint64_t seed);
void spring_system_destroy(spring_system *system);
/* Other values for the matrix. */
void spring_system_fill(spring_system *system, double stiffness, uint64_t seed);

/* The matrix with stiff terms; entries of fixed vertices count as zero. */
typedef struct spring_matrix {
    const matrix_term *terms;
    size_t term_count;
} spring_matrix;
/* y = matrix x */
void spring_system_multiply(const spring_system *system, const spring_matrix *matrix,
                            const double *x, double *y);

#endif
