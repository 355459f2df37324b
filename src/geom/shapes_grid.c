/* geom/shapes_grid.c - shapes on a grid of columns and rows: flat sheets, grounds, and slabs (two
 * sheets closed by walls).
 *
 * Sheets lie about the origin, normals up; bumps are value noise of one octave: random heights on a
 * lattice of the wavelength, blended with 6 t^5 - 15 t^4 + 10 t^3, so slopes and curvatures are
 * continuous. Based on: Perlin, Improving Noise, 2002 (the blend). Crests are straight ridges along
 * y with flat flanks; each ridge has a seeded height. */
#include "geom/shapes.h"

/* Of the given height: the lowest crest. */
static const double LOWEST_CREST = 0.7;

static double get_unit(uint64_t bits) { return (double)(bits >> 11) * 0x1p-53; }

static double blend(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

/* 0 .. 1, smooth. Lattice numbers are wrapped to unsigned, which is well defined. */
static double get_bump(const tulle_shape_def *def, double x, double y) {
    double const u = x / def->wavelength, v = y / def->wavelength;
    double const i = floor(u), j = floor(v);
    double const s = blend(u - i), t = blend(v - j);
    uint64_t const a = (uint64_t)(int64_t)i, b = (uint64_t)(int64_t)j;
    double const low = (1.0 - s) * get_unit(shape_hash(def->seed, a, b)) +
                       s * get_unit(shape_hash(def->seed, a + 1, b));
    double const high = (1.0 - s) * get_unit(shape_hash(def->seed, a, b + 1)) +
                        s * get_unit(shape_hash(def->seed, a + 1, b + 1));
    return (1.0 - t) * low + t * high;
}

/* Flanks of a crested ground: an even number, so that it begins and ends in a valley. */
static double count_flanks(const tulle_shape_def *def) {
    return 2.0 * fmax(1.0, ceil(def->size[0] / def->wavelength - 0.5));
}

/* Columns and rows of vertices. Ridges need a column on each crest and in each valley. */
static void get_grid(const tulle_shape_def *def, double counts[2]) {
    counts[0] = def->resolution[0];
    counts[1] = def->resolution[1];
    if (def->shape == TULLE_SHAPE_CRESTED_GROUND) {
        double const flanks = count_flanks(def);
        counts[0] = flanks * fmax(1.0, ceil((counts[0] - 1.0) / flanks)) + 1.0;
    } else if (def->shape == TULLE_SHAPE_BOX) {
        counts[1] = counts[0];
    }
}

/* Height of column i of `count`. */
static double get_crest(const tulle_shape_def *def, size_t i, size_t count) {
    size_t const flanks = (size_t)count_flanks(def), columns = (count - 1) / flanks;
    size_t const flank = i / columns;
    double const along = (double)(i % columns) / (double)columns;
    double const chance = get_unit(shape_hash(def->seed, flank / 2, 0));
    double const height = def->height * (LOWEST_CREST + (1.0 - LOWEST_CREST) * chance);
    return height * (flank % 2 == 0 ? along : 1.0 - along);
}

/* From -size/2 to size/2, exact at both ends. */
static double get_coordinate(double size, size_t i, size_t count) {
    return 0.5 * size * ((2.0 * (double)i - (double)(count - 1)) / (double)(count - 1));
}

static void write_sheet_vertices(shape_writer *writer, const tulle_shape_def *def,
                                 const size_t counts[2], double base, bool has_relief) {
    for (size_t j = 0; j < counts[1]; j++) {
        for (size_t i = 0; i < counts[0]; i++) {
            double const x = get_coordinate(def->size[0], i, counts[0]);
            double const y = get_coordinate(def->size[1], j, counts[1]);
            double z = base;
            if (has_relief && def->shape == TULLE_SHAPE_CRESTED_GROUND)
                z += get_crest(def, i, counts[0]);
            else if (has_relief)
                z += def->height * get_bump(def, x, y);
            shape_write_vertex(writer, x, y, z);
        }
    }
}

/* The quads of a sheet whose first vertex is `first`; reversed: normals down. */
static void write_sheet_triangles(shape_writer *writer, const tulle_shape_def *def,
                                  const size_t counts[2], size_t first, bool is_reversed) {
    for (size_t j = 0; j + 1 < counts[1]; j++) {
        for (size_t i = 0; i + 1 < counts[0]; i++) {
            size_t const a = first + j * counts[0] + i;
            size_t const up[4] = {a, a + 1, a + counts[0] + 1, a + counts[0]};
            size_t const down[4] = {a, a + counts[0], a + counts[0] + 1, a + 1};
            shape_write_quad(writer, is_reversed ? down : up, shape_get_cut(def, i, j));
        }
    }
}

tulle_status shape_make_sheet(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error) {
    double grid[2];
    get_grid(def, grid);
    shape_writer writer;
    tulle_status const status = shape_writer_start(
        &writer, grid[0] * grid[1], 2.0 * (grid[0] - 1.0) * (grid[1] - 1.0), mesh, error);
    if (status != TULLE_OK) return status;
    size_t const counts[2] = {(size_t)grid[0], (size_t)grid[1]};
    bool const has_relief =
        def->shape == TULLE_SHAPE_BUMPY_GROUND || def->shape == TULLE_SHAPE_CRESTED_GROUND;
    write_sheet_vertices(&writer, def, counts, 0.0, has_relief);
    write_sheet_triangles(&writer, def, counts, 0, false);
    return TULLE_OK;
}

/* Vertex k of a sheet's rim, counterclockwise from above, 2 (columns + rows) - 4 of them. */
static size_t get_rim_vertex(const size_t counts[2], size_t k) {
    size_t const columns = counts[0], rows = counts[1], right = columns - 1, top = rows - 1;
    k %= 2 * (right + top);
    if (k < right) return k;
    k -= right;
    if (k < top) return k * columns + right;
    k -= top;
    if (k < right) return top * columns + right - k;
    k -= right;
    return (top - k) * columns;
}

tulle_status shape_make_slab(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error) {
    double grid[2];
    get_grid(def, grid);
    double const rim = 2.0 * (grid[0] + grid[1]) - 4.0;
    shape_writer writer;
    tulle_status const status =
        shape_writer_start(&writer, 2.0 * grid[0] * grid[1],
                           4.0 * (grid[0] - 1.0) * (grid[1] - 1.0) + 2.0 * rim, mesh, error);
    if (status != TULLE_OK) return status;
    size_t const counts[2] = {(size_t)grid[0], (size_t)grid[1]};
    size_t const below = counts[0] * counts[1];
    write_sheet_vertices(&writer, def, counts, 0.5 * def->size[2], def->shape == TULLE_SHAPE_TILE);
    write_sheet_vertices(&writer, def, counts, -0.5 * def->size[2], false);
    write_sheet_triangles(&writer, def, counts, 0, false);
    write_sheet_triangles(&writer, def, counts, below, true);
    for (size_t k = 0; k < (size_t)rim; k++) {
        size_t const from = get_rim_vertex(counts, k), to = get_rim_vertex(counts, k + 1);
        size_t const wall[4] = {below + from, below + to, to, from};
        shape_write_quad(&writer, wall, k % 2 == 0);
    }
    return TULLE_OK;
}
