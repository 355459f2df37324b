/* geom/shapes_rings.c - shapes made of rings about the z axis: disc, tube, cape and the solids of
 * revolution.
 *
 * A shape is a row of rings, each with its own radius, height and number of vertices; a ring of one
 * vertex is a pole. Between neighbours a zipper of triangles takes the shorter diagonal at each
 * step; where both are equal, the cut alternates or is random. Rings run so that (direction along
 * the profile) x (direction of rising angle) points outwards: from the top of a solid downwards,
 * and from the centre of a flat shape outwards. */
#include "base/error.h"
#include "geom/shapes.h"

static const double FULL_TURN = 6.283185307179586; /* [rad] */
/* [rad] A sector this close to a full turn is sewn up: its sides would touch. */
static const double SEAM_ANGLE = 1e-6;

typedef struct ring {
    double radius, z; /* [m] */
    size_t count;     /* vertices; 1: a pole */
} ring;

typedef struct ring_row {
    size_t ring_count;
    double start, angle;             /* [rad] first vertex, and the sector that a ring spans */
    bool is_sector;                  /* rings are open arcs */
    bool is_cyclic;                  /* the last ring joins the first */
    double profile[6][2];            /* (radius, z) of the corners of a lathed solid */
    size_t profile_count, long_side; /* long_side: corner after which rows are inserted */
} ring_row;

static size_t scale_count(uint32_t count, double factor, size_t least) {
    size_t const scaled = (size_t)floor(count * factor + 0.5);
    return scaled > least ? scaled : least;
}

/* A solid given by its profile: poles at both ends; the side after corner long_side is divided into
 * resolution[1] - 1 rows. */
static ring get_lathe_ring(const tulle_shape_def *def, const ring_row *row, size_t k) {
    size_t const rows = def->resolution[1] - 1, first = row->long_side;
    size_t corner = k <= first ? k : first;
    double along = 0.0;
    if (k > first && k < first + rows)
        along = (double)(k - first) / (double)rows;
    else if (k >= first + rows)
        corner = k - rows + 1;
    const double *const from = row->profile[corner];
    const double *const to = row->profile[along > 0.0 ? corner + 1 : corner];
    return (ring){(1.0 - along) * from[0] + along * to[0], (1.0 - along) * from[1] + along * to[1],
                  k == 0 || k + 1 == row->ring_count ? 1 : def->resolution[0]};
}

static ring get_disc_ring(const tulle_shape_def *def, size_t k) {
    double const part = (double)k / (double)def->resolution[0];
    if (k == 0) return (ring){0.0, 0.0, 1};
    return (ring){def->radius * part, 0.0, scale_count(def->resolution[1], part, 3)};
}

static ring get_cape_ring(const tulle_shape_def *def, const ring_row *row, size_t k) {
    double const part = (double)k / (double)(def->resolution[1] - 1);
    double const radius = (1.0 - part) * def->inner_radius + part * def->radius;
    size_t const edges = scale_count(def->resolution[0] - 1, radius / def->radius, 1);
    if (row->is_sector) return (ring){radius, 0.0, edges + 1};
    return (ring){radius, 0.0, edges > 3 ? edges : 3};
}

static ring get_hemisphere_ring(const tulle_shape_def *def, const ring_row *row, size_t k) {
    double const polar = 0.25 * FULL_TURN * (double)k / (double)def->resolution[1];
    if (k == 0) return (ring){0.0, def->radius, 1};
    if (k + 1 == row->ring_count) return (ring){0.0, 0.0, 1};
    if (k == def->resolution[1]) return (ring){def->radius, 0.0, def->resolution[0]};
    return (ring){def->radius * sin(polar), def->radius * cos(polar),
                  scale_count(def->resolution[0], sin(polar), 3)};
}

/* Rows of a sceptre's head, from its top to the leg: as high as its columns are wide. */
static size_t count_head_rows(const tulle_shape_def *def) {
    return def->resolution[0] < 6 ? 3 : def->resolution[0] / 2;
}

/* A ball down to where it is as wide as the leg, the leg in resolution[1] - 1 rows, the base. */
static ring get_sceptre_ring(const tulle_shape_def *def, const ring_row *row, size_t k) {
    size_t const head_rows = count_head_rows(def);
    double const radius = def->head_radius, centre = def->height - radius;
    double const neck = centre - sqrt(radius * radius - def->radius * def->radius);
    if (k == 0) return (ring){0.0, def->height, 1};
    if (k + 1 == row->ring_count) return (ring){0.0, 0.0, 1};
    if (k >= head_rows) {
        double const along = (double)(k - head_rows) / (double)(def->resolution[1] - 1);
        return (ring){def->radius, (1.0 - along) * neck, def->resolution[0]};
    }
    double const last = 0.5 * FULL_TURN - asin(def->radius / radius);
    double const polar = last * (double)k / (double)head_rows;
    return (ring){radius * sin(polar), centre + radius * cos(polar), def->resolution[0]};
}

static ring get_ring(const tulle_shape_def *def, const ring_row *row, size_t k) {
    switch (def->shape) {
    case TULLE_SHAPE_DISC: return get_disc_ring(def, k);
    case TULLE_SHAPE_CAPE: return get_cape_ring(def, row, k);
    case TULLE_SHAPE_HEMISPHERE: return get_hemisphere_ring(def, row, k);
    case TULLE_SHAPE_SCEPTRE: return get_sceptre_ring(def, row, k);
    case TULLE_SHAPE_TUBE: {
        double const part = (double)k / (double)(def->resolution[1] - 1);
        return (ring){def->radius, (0.5 - part) * def->height, def->resolution[0]};
    }
    case TULLE_SHAPE_TORUS: {
        double const around = FULL_TURN * (double)k / (double)def->resolution[1];
        return (ring){def->radius + def->inner_radius * sin(around),
                      def->inner_radius * cos(around), def->resolution[0]};
    }
    default: return get_lathe_ring(def, row, k);
    }
}

static void add_corner(ring_row *row, double radius, double z) {
    double *const corner = row->profile[row->profile_count++];
    corner[0] = radius;
    corner[1] = z;
}

/* The profile from the top pole to the bottom pole. */
static void make_profile(const tulle_shape_def *def, ring_row *row) {
    double const radius = def->radius, height = def->height;
    add_corner(row, 0.0, height);
    row->long_side = def->shape == TULLE_SHAPE_CONE ? 0 : 1;
    if (def->shape == TULLE_SHAPE_CYLINDER) add_corner(row, radius, height);
    if (def->shape == TULLE_SHAPE_NEEDLE) add_corner(row, radius, height - def->tip_height);
    if (def->shape == TULLE_SHAPE_NAIL) {
        add_corner(row, def->head_radius, height);
        add_corner(row, def->head_radius, height - def->head_height);
        add_corner(row, radius, height - def->head_height);
        row->long_side = 3;
    }
    add_corner(row, radius, 0.0);
    add_corner(row, 0.0, 0.0);
    row->ring_count = row->profile_count + def->resolution[1] - 2;
}

static ring_row make_row(const tulle_shape_def *def) {
    ring_row row = {.angle = FULL_TURN};
    switch (def->shape) {
    case TULLE_SHAPE_DISC: row.ring_count = (size_t)def->resolution[0] + 1; break;
    case TULLE_SHAPE_TUBE: row.ring_count = def->resolution[1]; break;
    case TULLE_SHAPE_CAPE:
        row.ring_count = def->resolution[1];
        row.is_sector = def->angle < FULL_TURN - SEAM_ANGLE;
        row.angle = row.is_sector ? def->angle : FULL_TURN;
        row.start = -0.5 * row.angle;
        break;
    case TULLE_SHAPE_HEMISPHERE: row.ring_count = (size_t)def->resolution[1] + 2; break;
    case TULLE_SHAPE_SCEPTRE: row.ring_count = count_head_rows(def) + def->resolution[1] + 1; break;
    case TULLE_SHAPE_TORUS:
        row.ring_count = def->resolution[1];
        row.is_cyclic = true;
        break;
    default: make_profile(def, &row); break;
    }
    return row;
}

/* Edges along a ring: none at a pole. */
static size_t count_edges(const ring_row *row, ring r) {
    return r.count == 1 ? 0 : row->is_sector ? r.count - 1 : r.count;
}

static void write_ring(shape_writer *writer, const ring_row *row, ring r) {
    size_t const edges = count_edges(row, r);
    for (size_t i = 0; i < r.count; i++) {
        double const part = edges > 0 ? (double)i / (double)edges : 0.0;
        double const angle = row->start + row->angle * part;
        shape_write_vertex(writer, r.radius * cos(angle), r.radius * sin(angle), r.z);
    }
}

/* Triangles between ring k, whose first vertex is first[0], and the next one at first[1]. */
static void zip_rings(shape_writer *writer, const tulle_shape_def *def, const ring_row *row,
                      size_t k, const size_t first[2]) {
    size_t const next = k + 1 == row->ring_count ? 0 : k + 1;
    ring const rings[2] = {get_ring(def, row, k), get_ring(def, row, next)};
    size_t const edges[2] = {count_edges(row, rings[0]), count_edges(row, rings[1])};
    size_t at[2] = {0, 0};
    while (at[0] < edges[0] || at[1] < edges[1]) {
        bool is_first = at[1] == edges[1];
        if (at[0] < edges[0] && at[1] < edges[1]) {
            /* Middles of the two edges that could be taken: the earlier gives the shorter cut. */
            uint64_t const own = (2 * (uint64_t)at[0] + 1) * edges[1];
            uint64_t const other = (2 * (uint64_t)at[1] + 1) * edges[0];
            is_first = own == other ? shape_get_cut(def, at[0], k) : own < other;
        }
        size_t const a = first[0] + at[0] % rings[0].count, b = first[1] + at[1] % rings[1].count;
        if (is_first) {
            at[0]++;
            shape_write_triangle(writer, a, b, first[0] + at[0] % rings[0].count);
        } else {
            at[1]++;
            shape_write_triangle(writer, a, b, first[1] + at[1] % rings[1].count);
        }
    }
}

/* Adds up what will be written; stops early where the limit is passed anyway. */
static void count_row(const tulle_shape_def *def, const ring_row *row, double counts[2]) {
    size_t edges_prev = 0;
    counts[0] = counts[1] = 0.0;
    for (size_t k = 0; k < row->ring_count; k++) {
        ring const r = get_ring(def, row, k);
        size_t const edges = count_edges(row, r);
        counts[0] += (double)r.count;
        if (k > 0) counts[1] += (double)(edges_prev + edges);
        edges_prev = edges;
    }
    if (row->is_cyclic) counts[1] += (double)(edges_prev + count_edges(row, get_ring(def, row, 0)));
}

tulle_status shape_make_rings(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error) {
    ring_row const row = make_row(def);
    /* Counting takes a moment for each ring: the limit comes first. A row of rings of resolution[]
     * vertices has half as many at least. */
    double counts[2] = {0.5 * def->resolution[0] * def->resolution[1], 0.0};
    if (counts[0] <= 2.0 * SHAPE_VERTEX_LIMIT && row.ring_count <= SHAPE_VERTEX_LIMIT)
        count_row(def, &row, counts);
    else
        counts[0] = 2.0 * counts[0];
    shape_writer writer;
    tulle_status const status = shape_writer_start(&writer, counts[0], counts[1], mesh, error);
    if (status != TULLE_OK) return status;
    for (size_t k = 0; k < row.ring_count; k++) write_ring(&writer, &row, get_ring(def, &row, k));
    size_t first[2] = {0, 0};
    for (size_t k = 0; k + 1 < row.ring_count; k++) {
        first[1] = first[0] + get_ring(def, &row, k).count;
        zip_rings(&writer, def, &row, k, first);
        first[0] = first[1];
    }
    if (row.is_cyclic) {
        first[1] = 0;
        zip_rings(&writer, def, &row, row.ring_count - 1, first);
    }
    return TULLE_OK;
}
