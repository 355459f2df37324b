/* geom/shapes_net.c - a flat net: crossing strands around real holes, one connected manifold.
 *
 * Lines of vertices run along both sides in periods of one strand (`across` columns) and one hole
 * (`open` columns, as wide as the strand's as far as possible); a vertex is left out where it lies
 * inside a hole along both sides. */
#include "geom/shapes.h"

typedef struct net_axis {
    double size, strand, hole;              /* [m] */
    size_t cells, across, open, line_count; /* line_count: vertices along a whole side */
} net_axis;

static size_t get_period(const net_axis *axis) { return axis->across + axis->open; }

/* Columns of a hole, as a double so that the count cannot overflow. */
static double count_open_columns(const tulle_shape_def *def, int k) {
    double const hole = (def->size[k] - (def->cells[k] + 1.0) * def->strand) / def->cells[k];
    return fmax(1.0, ceil(hole / def->strand * def->strand_resolution - 0.5));
}

static net_axis make_axis(const tulle_shape_def *def, int k) {
    net_axis axis = {.size = def->size[k], .strand = def->strand, .cells = def->cells[k]};
    axis.hole = (axis.size - ((double)axis.cells + 1.0) * axis.strand) / (double)axis.cells;
    axis.across = def->strand_resolution;
    axis.open = (size_t)count_open_columns(def, k);
    axis.line_count = axis.cells * get_period(&axis) + axis.across + 1;
    return axis;
}

static double get_line_coordinate(const net_axis *axis, size_t line) {
    size_t const strand = line / get_period(axis), column = line % get_period(axis);
    double const start = (double)strand * (axis->strand + axis->hole) - 0.5 * axis->size;
    if (line + 1 == axis->line_count) return 0.5 * axis->size;
    if (column <= axis->across)
        return start + axis->strand * ((double)column / (double)axis->across);
    return start + axis->strand +
           axis->hole * ((double)(column - axis->across) / (double)axis->open);
}

/* Whether a line runs through holes. */
static bool is_open_line(const net_axis *axis, size_t line) {
    return line % get_period(axis) > axis->across;
}

/* Whether the columns after a line are those of a hole. */
static bool is_open_column(const net_axis *axis, size_t line) {
    return line % get_period(axis) >= axis->across;
}

/* Lines before `line` that run on a strand all along. */
static size_t count_closed_lines(const net_axis *axis, size_t line) {
    size_t const column = line % get_period(axis), most = axis->across + 1;
    return line / get_period(axis) * most + (column < most ? column : most);
}

/* The line after i; across a hole, the first line of the next strand at once, so that the time
 * taken follows the vertices that there are. */
static size_t get_next_line(const net_axis *axis, size_t i, bool is_across_hole) {
    bool const is_strand_end = i % get_period(axis) == axis->across;
    return is_across_hole && is_strand_end ? i + axis->open : i + 1;
}

/* The vertex on lines (i, j), which must exist. */
static size_t get_vertex(const net_axis axes[2], size_t i, size_t j) {
    size_t const closed = count_closed_lines(&axes[1], j), open = j - closed;
    size_t const open_length = (axes[0].cells + 1) * (axes[0].across + 1);
    size_t const start = closed * axes[0].line_count + open * open_length;
    return start + (is_open_line(&axes[1], j) ? count_closed_lines(&axes[0], i) : i);
}

tulle_status shape_make_net(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error) {
    double lines[2], open[2];
    for (int k = 0; k < 2; k++) {
        open[k] = count_open_columns(def, k);
        lines[k] = def->cells[k] * (def->strand_resolution + open[k]) + def->strand_resolution + 1;
    }
    double const cell_count = (double)def->cells[0] * def->cells[1];
    shape_writer writer;
    tulle_status const status = shape_writer_start(
        &writer, lines[0] * lines[1] - cell_count * (open[0] - 1) * (open[1] - 1),
        2 * ((lines[0] - 1) * (lines[1] - 1) - cell_count * open[0] * open[1]), mesh, error);
    if (status != TULLE_OK) return status;
    net_axis const axes[2] = {make_axis(def, 0), make_axis(def, 1)};
    for (size_t j = 0; j < axes[1].line_count; j++) {
        double const y = get_line_coordinate(&axes[1], j);
        bool const is_open = is_open_line(&axes[1], j);
        for (size_t i = 0; i < axes[0].line_count; i = get_next_line(&axes[0], i, is_open))
            shape_write_vertex(&writer, get_line_coordinate(&axes[0], i), y, 0.0);
    }
    for (size_t j = 0; j + 1 < axes[1].line_count; j++) {
        bool const is_open = is_open_column(&axes[1], j);
        for (size_t i = 0; i + 1 < axes[0].line_count; i = get_next_line(&axes[0], i, is_open)) {
            if (is_open && is_open_column(&axes[0], i)) continue;
            size_t const quad[4] = {get_vertex(axes, i, j), get_vertex(axes, i + 1, j),
                                    get_vertex(axes, i + 1, j + 1), get_vertex(axes, i, j + 1)};
            shape_write_quad(&writer, quad, shape_get_cut(def, i, j));
        }
    }
    return TULLE_OK;
}
