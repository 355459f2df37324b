/* math/kernels/grid_kernel.c - see grid_kernel.h. Each lane works on a vertex of its own, so all
 * widths give the same bits. */
#include "math/grid_kernel.h"

#include "math/diagonal_lanes.h"

void TULLE_KERNEL(grid_sum_rows)(const line_sum *sum) {
    for (size_t c = 0; c < sum->column_count; c += DIAGONAL_ROWS) {
        lanes3 line = {{0.0F}, {0.0F}, {0.0F}};
        for (size_t row = 0; row < sum->row_count; row++) {
            size_t const at = row * sum->column_count + c;
            lanes3 const r = load3(sum->vectors + at, sum->number_step);
            if (sum->is_free) {
                lanes16 const part = load16(sum->is_free + at) * sum->parts[row];
                line.x += r.x * part;
                line.y += r.y * part;
                line.z += r.z * part;
            } else {
                add_scaled(&line, r, sum->parts[row]);
            }
        }
        store3(sum->line + c, sum->line_stride, line);
    }
}

/* What a spread adds to the sixteen vertices from `at` on. */
SINGLE_INLINE lanes3 blend_lines(const line_spread *spread, size_t at) {
    lanes3 sum = {{0.0F}, {0.0F}, {0.0F}};
    add_scaled(&sum, load3(spread->lower + at, spread->line_stride), spread->share);
    add_scaled(&sum, load3(spread->upper + at, spread->line_stride), 1.0F - spread->share);
    if (!spread->is_free) return sum;
    lanes16 const is_free = load16(spread->is_free + at);
    return (lanes3){sum.x * is_free, sum.y * is_free, sum.z * is_free};
}

void TULLE_KERNEL(grid_add_lines)(const line_spread *spread) {
    size_t const count = spread->count, step = spread->number_step;
    size_t at = 0;
    for (; at + DIAGONAL_ROWS <= count; at += DIAGONAL_ROWS) {
        lanes3 to = load3(spread->vectors + at, step);
        add_scaled(&to, blend_lines(spread, at), 1.0F);
        store3(spread->vectors + at, step, to);
    }
    if (at == count) return;
    /* The last few, by way of sixteen. */
    lanes3 const sum = blend_lines(spread, at);
    const lanes16 *const of_numbers[3] = {&sum.x, &sum.y, &sum.z};
    for (size_t k = 0; k < 3; k++) {
        float rest[DIAGONAL_ROWS];
        memcpy(rest, of_numbers[k], sizeof rest);
        float *const to = spread->vectors + k * step + at;
        for (size_t i = 0; i < count - at; i++) to[i] += rest[i];
    }
}

void TULLE_KERNEL(grid_take_step)(const single_vectors *vectors, size_t begin, size_t end) {
    size_t const stride = vectors->number_step;
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS)
        store3(
            vectors->direction + row, stride,
            multiply_block(vectors->inverse + row, stride, load3(vectors->residual + row, stride)));
}

SINGLE_INLINE lanes3 get_left(const single_vectors *vectors, size_t row) {
    size_t const stride = vectors->number_step;
    lanes3 left = load3(vectors->residual + row, stride);
    add_scaled(&left, load3(vectors->product + row, stride), -1.0F);
    return left;
}

void TULLE_KERNEL(grid_leave)(const single_vectors *vectors, size_t begin, size_t end) {
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS)
        store3(vectors->product + row, vectors->number_step, get_left(vectors, row));
}

/* In double precision, since the residual may be as small as it likes. */
typedef double doubles16 __attribute__((vector_size(128)));
SINGLE_INLINE void add_products(doubles16 *sum, lanes16 a, lanes16 b) {
    *sum += __builtin_convertvector(a, doubles16) * __builtin_convertvector(b, doubles16);
}

double TULLE_KERNEL(grid_end_step)(const single_vectors *vectors, size_t begin, size_t end) {
    size_t const stride = vectors->number_step;
    doubles16 dot = {0.0};
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS) {
        lanes3 to = multiply_block(vectors->inverse + row, stride, get_left(vectors, row));
        add_scaled(&to, load3(vectors->direction + row, stride), 1.0F);
        store3(vectors->preconditioned + row, stride, to);
        lanes3 const residual = load3(vectors->residual + row, stride);
        add_products(&dot, to.x, residual.x);
        add_products(&dot, to.y, residual.y);
        add_products(&dot, to.z, residual.z);
    }
    double sum = 0.0;
    for (size_t lane = 0; lane < DIAGONAL_ROWS; lane++) sum += dot[lane];
    return sum;
}
