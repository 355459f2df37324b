/* geom/mass_properties.c - see mass_properties.h.
 *
 * A closed surface is a sum of signed tetrahedra from a reference point to its triangles, a shell a
 * sum of triangles. The second moments of a simplex with the corners x_k and the measure m are
 *     integral x x^T = m / ((d + 1) (d + 2)) (sum x_k x_k^T + (sum x_k) (sum x_k)^T),
 * d = 3 or 2; the reference point is the middle of the bounds, so that little cancels. Principal
 * axes by Jacobi's rotations.
 *
 * Whether a piece is turned right follows from its winding number: a point of it lies inside no
 * other piece, or, of a cavity, inside one.
 *
 * Based on: Lien, Kajiya, A symbolic method for calculating the integral properties of arbitrary
 * nonconvex polyhedra, 1984 (signed tetrahedra); van Oosterom, Strackee, The solid angle of a plane
 * triangle, 1983 (winding number); Jacobi 1846. */
#include "geom/mass_properties.h"

#include "base/error.h"
#include "geom/topology.h"
#include "geom/union_find.h"

/* A moment under this share of the largest is none: the body is a line or a point. */
static const double LEAST_MOMENT_SHARE = 1e-12;
enum {
    PIECES_MAX = 4096, /* each piece is tested against each other */
    JACOBI_SWEEPS = 40 /* Jacobi's method converges in less than ten */
};

static const double PI = 3.14159265358979323846;

/* Sums about the reference point, for unit density. */
typedef struct moment_sums {
    double measure;
    vec3 first;
    double second[6]; /* xx, xy, xz, yy, yz, zz */
} moment_sums;

typedef struct body_survey {
    tulle_mesh_view mesh;
    const char *name;
    vec3 reference;
    topology topo;
    int32_t *balances;    /* per edge: triangles one way round less those the other */
    uint32_t *use_counts; /* per edge */
    uint32_t *pieces;     /* per vertex: the smallest vertex of its piece */
    double *volumes;      /* per vertex that a piece is named by [m^3] */
    vec3 *bounds;         /* two for each such vertex: least and largest coordinates */
    tulle_error *error;
} body_survey;

static void add_simplex(moment_sums *sums, const vec3 *corners, int count, double measure,
                        int dimension) {
    vec3 total = {0.0, 0.0, 0.0};
    for (int k = 0; k < count; k++) total = vec3_add(total, corners[k]);
    double const points = dimension + 1.0;
    sums->measure += measure;
    sums->first = vec3_add_scaled(sums->first, total, measure / points);
    double const factor = measure / (points * (points + 1.0));
    double products[6] = {total.x * total.x, total.x * total.y, total.x * total.z,
                          total.y * total.y, total.y * total.z, total.z * total.z};
    for (int k = 0; k < count; k++) {
        vec3 const a = corners[k];
        double const own[6] = {a.x * a.x, a.x * a.y, a.x * a.z, a.y * a.y, a.y * a.z, a.z * a.z};
        for (int i = 0; i < 6; i++) products[i] += own[i];
    }
    for (int i = 0; i < 6; i++) sums->second[i] += factor * products[i];
}

/* Corners relative to the reference point. */
static void get_corners(const body_survey *survey, size_t triangle, vec3 corners[3]) {
    for (int k = 0; k < 3; k++)
        corners[k] = vec3_sub(
            vec3_load(survey->mesh.positions, survey->mesh.triangles[3 * triangle + (size_t)k]),
            survey->reference);
}

static double get_cone_volume(const vec3 corners[3]) {
    return vec3_dot(corners[0], vec3_cross(corners[1], corners[2])) / 6.0;
}

static moment_sums add_up(const body_survey *survey, mass_distribution where) {
    moment_sums sums = {0};
    for (size_t t = 0; t < survey->mesh.triangle_count; t++) {
        vec3 corners[3];
        get_corners(survey, t, corners);
        if (where == MASS_IN_VOLUME) {
            add_simplex(&sums, corners, 3, get_cone_volume(corners), 3);
        } else {
            vec3 const normal =
                vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
            add_simplex(&sums, corners, 3, 0.5 * vec3_norm(normal), 2);
        }
    }
    return sums;
}

static vec3 choose_reference(tulle_mesh_view mesh) {
    vec3 least = vec3_load(mesh.positions, mesh.triangles[0]), most = least;
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++) {
        vec3 const x = vec3_load(mesh.positions, mesh.triangles[i]);
        least = vec3_make(fmin(least.x, x.x), fmin(least.y, x.y), fmin(least.z, x.z));
        most = vec3_make(fmax(most.x, x.x), fmax(most.y, x.y), fmax(most.z, x.z));
    }
    return vec3_lerp(least, most, 0.5);
}

static bool allocate_survey(memory *heap, body_survey *survey) {
    size_t const edges = survey->topo.edge_count, vertices = survey->mesh.vertex_count;
    survey->balances = memory_allocate_zeroed(heap, edges, sizeof *survey->balances);
    survey->use_counts = memory_allocate_zeroed(heap, edges, sizeof *survey->use_counts);
    survey->pieces = memory_allocate_zeroed(heap, vertices, sizeof *survey->pieces);
    survey->volumes = memory_allocate_zeroed(heap, vertices, sizeof *survey->volumes);
    survey->bounds = memory_allocate_zeroed(heap, vertices, 2 * sizeof *survey->bounds);
    return survey->balances && survey->use_counts && survey->pieces && survey->volumes &&
           survey->bounds;
}

static void release_survey(memory *heap, body_survey *survey) {
    size_t const edges = survey->topo.edge_count, vertices = survey->mesh.vertex_count;
    memory_release(heap, survey->balances, edges * sizeof *survey->balances);
    memory_release(heap, survey->use_counts, edges * sizeof *survey->use_counts);
    memory_release(heap, survey->pieces, vertices * sizeof *survey->pieces);
    memory_release(heap, survey->volumes, vertices * sizeof *survey->volumes);
    memory_release(heap, survey->bounds, vertices * 2 * sizeof *survey->bounds);
    topology_destroy(heap, &survey->topo);
}

/* Every edge must be passed as often one way as the other. */
static tulle_status check_closed(const body_survey *survey) {
    const topology *const topo = &survey->topo;
    for (size_t t = 0; t < topo->triangle_count; t++) {
        for (size_t k = 0; k < 3; k++) {
            uint32_t const from = topo->triangles[3 * t + k],
                           to = topo->triangles[3 * t + (k + 1) % 3];
            uint32_t const edge = topo->triangle_edges[3 * t + k];
            survey->balances[edge] += from < to ? 1 : -1;
            survey->use_counts[edge]++;
        }
    }
    for (size_t e = 0; e < topo->edge_count; e++) {
        if (survey->balances[e] == 0) continue;
        bool const is_turned = survey->use_counts[e] % 2 == 0;
        return error_set(
            survey->error, TULLE_ERROR_INVALID_MESH,
            is_turned ? "%s: the triangles at the edge of vertices %u and %u are oriented in "
                        "opposite ways; turn them so that all normals point outwards"
                      : "%s: the mesh is open at the edge of vertices %u and %u; a body with a "
                        "density needs a closed mesh. Close it, or give the mass of its surface",
            survey->name, topo->edges[2 * e], topo->edges[2 * e + 1]);
    }
    return TULLE_OK;
}

static bool is_piece(const body_survey *survey, size_t vertex) {
    const uint32_t *const begin = survey->topo.vertex_triangles.begin;
    return survey->pieces[vertex] == vertex && begin[vertex + 1] > begin[vertex];
}

static bool box_holds(const vec3 box[2], vec3 x) {
    return box[0].x <= x.x && x.x <= box[1].x && box[0].y <= x.y && x.y <= box[1].y &&
           box[0].z <= x.z && x.z <= box[1].z;
}

static void find_pieces(body_survey *survey) {
    const topology *const topo = &survey->topo;
    union_find_reset(survey->pieces, survey->mesh.vertex_count);
    for (size_t t = 0; t < topo->triangle_count; t++)
        for (size_t k = 1; k < 3; k++)
            union_find_join(survey->pieces, topo->triangles[3 * t], topo->triangles[3 * t + k]);
    for (size_t v = 0; v < survey->mesh.vertex_count; v++) {
        uint32_t const piece = union_find_root(survey->pieces, (uint32_t)v);
        vec3 const x = vec3_load(survey->mesh.positions, v);
        vec3 *const box = survey->bounds + 2 * (size_t)piece;
        if (piece == v) box[0] = box[1] = x;
        box[0] = vec3_make(fmin(box[0].x, x.x), fmin(box[0].y, x.y), fmin(box[0].z, x.z));
        box[1] = vec3_make(fmax(box[1].x, x.x), fmax(box[1].y, x.y), fmax(box[1].z, x.z));
    }
    for (size_t t = 0; t < topo->triangle_count; t++) {
        vec3 corners[3];
        get_corners(survey, t, corners);
        survey->volumes[union_find_root(survey->pieces, topo->triangles[3 * t])] +=
            get_cone_volume(corners);
    }
}

/* How often the other pieces wind around vertex `point`, which names its piece. */
static double compute_winding(const body_survey *survey, uint32_t point) {
    vec3 const x = vec3_load(survey->mesh.positions, point);
    bool is_near = false;
    for (size_t v = 0; v < survey->mesh.vertex_count && !is_near; v++)
        is_near = v != point && is_piece(survey, v) && box_holds(survey->bounds + 2 * v, x);
    if (!is_near) return 0.0;
    double angle = 0.0;
    for (size_t t = 0; t < survey->mesh.triangle_count; t++) {
        const uint32_t *const corner = survey->mesh.triangles + 3 * t;
        uint32_t const piece = union_find_root(survey->pieces, corner[0]);
        if (piece == point || !box_holds(survey->bounds + 2 * (size_t)piece, x)) continue;
        vec3 const a = vec3_sub(vec3_load(survey->mesh.positions, corner[0]), x);
        vec3 const b = vec3_sub(vec3_load(survey->mesh.positions, corner[1]), x);
        vec3 const c = vec3_sub(vec3_load(survey->mesh.positions, corner[2]), x);
        double const la = vec3_norm(a), lb = vec3_norm(b), lc = vec3_norm(c);
        double const below =
            la * lb * lc + vec3_dot(a, b) * lc + vec3_dot(b, c) * la + vec3_dot(c, a) * lb;
        angle += 2.0 * atan2(vec3_dot(a, vec3_cross(b, c)), below);
    }
    return angle / (4.0 * PI);
}

static tulle_status check_piece(const body_survey *survey, uint32_t piece) {
    bool const is_inside = compute_winding(survey, piece) > 0.5;
    bool const is_cavity = !(survey->volumes[piece] > 0.0);
    if (is_inside == is_cavity) return TULLE_OK;
    return error_set(survey->error, TULLE_ERROR_INVALID_MESH,
                     is_cavity
                         ? "%s: the piece with vertex %u is inside out; turn its triangles so that "
                           "normals point outwards"
                         : "%s: the piece with vertex %u overlaps another or lies inside it, and "
                           "would count twice; join them, remove it, or turn it if it is a cavity",
                     survey->name, piece);
}

/* Pieces are named by their smallest vertices. */
static tulle_status check_pieces(const body_survey *survey) {
    size_t count = 0;
    for (size_t v = 0; v < survey->mesh.vertex_count; v++) count += is_piece(survey, v);
    if (count > PIECES_MAX)
        return error_set(survey->error, TULLE_ERROR_LIMIT,
                         "%s: a body may have %d separate pieces, this one has %zu", survey->name,
                         PIECES_MAX, count);
    for (uint32_t v = 0; v < survey->mesh.vertex_count; v++) {
        if (!is_piece(survey, v)) continue;
        tulle_status const status = check_piece(survey, v);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

static tulle_status check_solid(memory *heap, body_survey *survey) {
    tulle_mesh_view const mesh = survey->mesh;
    tulle_status status =
        topology_build(heap, mesh.triangles, mesh.triangle_count, mesh.vertex_count, &survey->topo);
    if (status == TULLE_OK && !allocate_survey(heap, survey)) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status != TULLE_OK)
        error_set(survey->error, status, "%s: no memory left for its mass", survey->name);
    if (status == TULLE_OK) status = check_closed(survey);
    if (status == TULLE_OK) {
        find_pieces(survey);
        status = check_pieces(survey);
    }
    release_survey(heap, survey);
    return status;
}

/* Turns the symmetric a so that a[i][j] vanishes, and the columns of v with it. */
static void rotate_pair(double a[3][3], double v[3][3], int i, int j) {
    if (a[i][j] == 0.0) return;
    double const theta = (a[j][j] - a[i][i]) / (2.0 * a[i][j]);
    double const t = copysign(1.0, theta) / (fabs(theta) + sqrt(theta * theta + 1.0));
    double const c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int k = 0; k < 3; k++) {
        double const p = a[k][i], q = a[k][j];
        a[k][i] = c * p - s * q;
        a[k][j] = s * p + c * q;
    }
    for (int k = 0; k < 3; k++) {
        double const p = a[i][k], q = a[j][k];
        a[i][k] = c * p - s * q;
        a[j][k] = s * p + c * q;
    }
    a[i][j] = a[j][i] = 0.0;
    for (int k = 0; k < 3; k++) {
        double const p = v[k][i], q = v[k][j];
        v[k][i] = c * p - s * q;
        v[k][j] = s * p + c * q;
    }
}

/* The rotation whose matrix has the columns u, v and u x v. */
static quaternion make_rotation(vec3 x, vec3 y) {
    vec3 const z = vec3_cross(x, y);
    double const squares[4] = {1.0 + x.x + y.y + z.z, 1.0 + x.x - y.y - z.z, 1.0 - x.x + y.y - z.z,
                               1.0 - x.x - y.y + z.z};
    int largest = 0;
    for (int k = 1; k < 4; k++)
        if (squares[k] > squares[largest]) largest = k;
    double const twice = sqrt(squares[largest]), f = 0.5 / twice;
    quaternion q = {0.5 * twice, (y.z - z.y) * f, (z.x - x.z) * f, (x.y - y.x) * f};
    if (largest == 1)
        q = (quaternion){(y.z - z.y) * f, 0.5 * twice, (y.x + x.y) * f, (z.x + x.z) * f};
    if (largest == 2)
        q = (quaternion){(z.x - x.z) * f, (y.x + x.y) * f, 0.5 * twice, (z.y + y.z) * f};
    if (largest == 3)
        q = (quaternion){(x.y - y.x) * f, (z.x + x.z) * f, (z.y + y.z) * f, 0.5 * twice};
    return quaternion_normalize(q);
}

/* Principal moments, ascending, and axes of a body with the covariance c about its centre. */
static void compute_principal_axes(const double c[6], mass_properties *result) {
    double const trace = c[0] + c[3] + c[5];
    double a[3][3] = {
        {trace - c[0], -c[1], -c[2]}, {-c[1], trace - c[3], -c[4]}, {-c[2], -c[4], trace - c[5]}};
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < JACOBI_SWEEPS; sweep++) {
        if (a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0) break;
        rotate_pair(a, v, 0, 1);
        rotate_pair(a, v, 0, 2);
        rotate_pair(a, v, 1, 2);
    }
    int order[3] = {0, 1, 2};
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2 - i; k++) {
            if (a[order[k]][order[k]] <= a[order[k + 1]][order[k + 1]]) continue;
            int const swapped = order[k];
            order[k] = order[k + 1];
            order[k + 1] = swapped;
        }
    }
    result->moments =
        vec3_make(a[order[0]][order[0]], a[order[1]][order[1]], a[order[2]][order[2]]);
    result->axes = make_rotation(vec3_make(v[0][order[0]], v[1][order[0]], v[2][order[0]]),
                                 vec3_make(v[0][order[1]], v[1][order[1]], v[2][order[1]]));
}

tulle_status mass_properties_compute(memory *heap, tulle_mesh_view mesh, mass_distribution where,
                                     const char *name, mass_properties *result,
                                     tulle_error *error) {
    if (mesh.triangle_count == 0)
        return error_set(error, TULLE_ERROR_INVALID_MESH, "%s: a body needs triangles", name);
    body_survey survey = {
        .mesh = mesh, .name = name, .reference = choose_reference(mesh), .error = error};
    if (where == MASS_IN_VOLUME) {
        tulle_status const status = check_solid(heap, &survey);
        if (status != TULLE_OK) return status;
    }
    moment_sums sums = add_up(&survey, where);
    double const m = sums.measure;
    vec3 const shift = vec3_scale(sums.first, m > 0.0 ? 1.0 / m : 0.0);
    double const lever[6] = {shift.x * shift.x, shift.x * shift.y, shift.x * shift.z,
                             shift.y * shift.y, shift.y * shift.z, shift.z * shift.z};
    for (int i = 0; i < 6; i++) sums.second[i] -= m * lever[i];
    *result = (mass_properties){.measure = m, .centre = vec3_add(survey.reference, shift)};
    compute_principal_axes(sums.second, result);
    vec3 const moments = result->moments;
    if (m > 0.0 && isfinite(moments.z) && moments.x > LEAST_MOMENT_SHARE * moments.z)
        return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_MESH,
                     "%s: its principal moments of inertia are %g, %g and %g for a unit density; a "
                     "body needs extent in space",
                     name, moments.x, moments.y, moments.z);
}
