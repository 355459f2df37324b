/* io/animation/animation.c - tulle_animation_write: checks the def, chooses the writer, and gives
 * it frames. */
#include "io/animation/animation.h"

#include "base/error.h"
#include "io/file_data.h"
#include "math/quaternion.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define ANIMATION_DEF_COOKIE UINT32_C(0x616e696d)

typedef enum animation_format {
    ANIMATION_GLB,
    ANIMATION_GLTF,
    ANIMATION_USDA,
    ANIMATION_MDD,
    ANIMATION_NPZ,
    ANIMATION_ABC,
    ANIMATION_FORMAT_COUNT
} animation_format;

/* A quaternion this near to length 1 was meant to have it. */
static const double UNIT_TOLERANCE = 1e-6;

tulle_animation_def tulle_animation_def_default(void) {
    return (tulle_animation_def){
        .cookie = ANIMATION_DEF_COOKIE, .frame_rate = 24.0, .meters_per_unit = 1.0};
}

/* ---- frames ---- */

bool animation_is_moving(const tulle_animation_def *def, size_t surface) {
    return def->frame_count > 1 && def->surfaces[surface].motion != TULLE_ANIMATION_STILL;
}

static tulle_status round_positions(animation_job *job, size_t surface, uint32_t frame,
                                    const double *positions, tulle_error *error) {
    const tulle_animation_surface *const s = &job->def->surfaces[surface];
    for (size_t i = 0; i < 3 * s->mesh.vertex_count; i++) {
        float const value = (float)positions[i];
        if (!isfinite(value))
            return error_set_at(
                error, TULLE_ERROR_INVALID_MESH, job->path, 0, 0,
                "%s, frame %u: coordinate %c of vertex %zu is %g, which float cannot hold", s->name,
                frame, "xyz"[i % 3], i / 3, positions[i]);
        job->points[i] = value;
        job->positions[i] = positions[i];
    }
    return TULLE_OK;
}

tulle_status animation_read(animation_job *job, size_t surface, uint32_t frame,
                            tulle_error *error) {
    const tulle_animation_surface *const s = &job->def->surfaces[surface];
    if (s->motion == TULLE_ANIMATION_RIGID)
        return round_positions(job, surface, frame, s->mesh.positions, error);
    tulle_status const status =
        job->def->read(job->def->context, surface, frame, job->positions, error);
    return status ? status : round_positions(job, surface, frame, job->positions, error);
}

tulle_status animation_read_pose(animation_job *job, size_t surface, uint32_t frame, double pose[7],
                                 tulle_error *error) {
    tulle_status const status = job->def->read(job->def->context, surface, frame, pose, error);
    if (status) return status;
    double const length = quaternion_norm(quaternion_load(pose + 3));
    bool is_good = fabs(length - 1.0) <= UNIT_TOLERANCE;
    for (int i = 0; i < 3; i++) is_good = is_good && isfinite((float)pose[i]);
    if (!is_good)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, job->path, 0, 0,
                            "%s, frame %u: the pose is not a translation and a unit quaternion",
                            job->def->surfaces[surface].name, frame);
    for (int i = 3; i < 7; i++) pose[i] /= length;
    return TULLE_OK;
}

void animation_compute_normals(animation_job *job, size_t surface) {
    tulle_mesh_view const mesh = job->def->surfaces[surface].mesh;
    memset(job->sums, 0, 3 * mesh.vertex_count * sizeof(double));
    for (size_t i = 0; i < mesh.triangle_count; i++) {
        const uint32_t *const t = mesh.triangles + 3 * i;
        const float *const a = job->points + 3 * (size_t)t[0];
        double u[3], v[3];
        for (size_t k = 0; k < 3; k++) {
            u[k] = (double)job->points[3 * (size_t)t[1] + k] - (double)a[k];
            v[k] = (double)job->points[3 * (size_t)t[2] + k] - (double)a[k];
        }
        for (size_t k = 0; k < 3; k++) {
            size_t const next = (k + 1) % 3, last = (k + 2) % 3;
            double const component = u[next] * v[last] - u[last] * v[next];
            for (size_t corner = 0; corner < 3; corner++)
                job->sums[3 * (size_t)t[corner] + k] += component;
        }
    }
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        const double *const sum = job->sums + 3 * i;
        double const length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
        /* Of a shorter vector the squares are no normal numbers. */
        bool const has_direction = length > 1e-150 && isfinite(length);
        for (size_t k = 0; k < 3; k++)
            job->normals[3 * i + k] = has_direction ? (float)(sum[k] / length)
                                      : k == 2      ? 1.0f
                                                    : 0.0f;
    }
}

void animation_measure_bounds(const animation_job *job, size_t surface, float low[3],
                              float high[3]) {
    size_t const count = job->def->surfaces[surface].mesh.vertex_count;
    for (size_t k = 0; k < 3; k++) low[k] = high[k] = job->points[k];
    for (size_t i = 3; i < 3 * count; i++) {
        float const value = job->points[i];
        if (value < low[i % 3]) low[i % 3] = value;
        if (value > high[i % 3]) high[i % 3] = value;
    }
}

/* ---- the def ---- */

static tulle_status refuse(tulle_error *error, const char *path, const char *text) {
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0, "%s", text);
}

/* By how much of its largest coordinate a copy of a mesh may differ from its prototype: positions
 * whose pose was taken away are rounded, and files hold them as float. */
static const double COPY_ROUNDING = 1e-6;

static tulle_status check_surface(const char *path, const tulle_animation_def *def, size_t number,
                                  tulle_error *error) {
    const tulle_animation_surface *const s = &def->surfaces[number];
    bool const is_rigid = s->motion == TULLE_ANIMATION_RIGID;
    if (!s->name || !*s->name || s->mesh.vertex_count == 0 || s->mesh.vertex_count > INT32_MAX ||
        s->mesh.triangle_count > INT32_MAX / 3 ||
        (s->mesh.triangle_count > 0 && !s->mesh.triangles) || (is_rigid && !s->mesh.positions) ||
        (unsigned)s->motion > TULLE_ANIMATION_RIGID)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "surface %zu has no name, no vertices, a null array or no motion",
                            number);
    for (int i = 0; i < 3; i++)
        if (!(s->color[i] >= 0.0 && s->color[i] <= 1.0))
            return refuse(error, path, "a color is out of 0 to 1");
    for (size_t i = 0; i < 3 * s->mesh.triangle_count; i++)
        if (s->mesh.triangles[i] >= s->mesh.vertex_count)
            return error_set_at(error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
                                "%s: triangle %zu uses vertex %u, but there are only %zu", s->name,
                                i / 3, s->mesh.triangles[i], s->mesh.vertex_count);
    if (s->prototype == number) return TULLE_OK;
    if (!is_rigid || s->prototype > number ||
        def->surfaces[s->prototype].prototype != s->prototype ||
        def->surfaces[s->prototype].motion != TULLE_ANIMATION_RIGID)
        return refuse(error, path, "a surface names a prototype that is not a surface");
    const tulle_mesh_view *const own = &s->mesh, *const shown = &def->surfaces[s->prototype].mesh;
    bool is_same =
        own->vertex_count == shown->vertex_count && own->triangle_count == shown->triangle_count;
    double largest = 0.0;
    for (size_t i = 0; is_same && i < 3 * own->triangle_count; i++)
        is_same = own->triangles[i] == shown->triangles[i];
    for (size_t i = 0; i < 3 * own->vertex_count; i++)
        largest = fmax(largest, fabs(own->positions[i]));
    for (size_t i = 0; is_same && i < 3 * own->vertex_count; i++)
        is_same = fabs(own->positions[i] - shown->positions[i]) <= COPY_ROUNDING * largest;
    if (!is_same)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "%s: its prototype, surface %zu, has another mesh; a surface with a "
                            "mesh of its own is its own prototype, %zu",
                            s->name, s->prototype, number);
    return TULLE_OK;
}

enum { ARRAY_NAME_LIMIT = 64 /* [bytes] */ };

/* Whether an archive may have an array of that name beside its own. */
static bool is_array_name(const char *name) {
    static const char *const taken[] = {"positions", "triangles",      "times",
                                        "names",     "first_vertices", "first_triangles"};
    size_t const length = strlen(name);
    for (size_t i = 0; i < sizeof taken / sizeof taken[0]; i++)
        if (strcmp(name, taken[i]) == 0) return false;
    return length > 0 && length <= ARRAY_NAME_LIMIT &&
           strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") ==
               length;
}

static tulle_status check_def(const char *path, const tulle_animation_def *def,
                              tulle_error *error) {
    if (!path || !def || def->cookie != ANIMATION_DEF_COOKIE || !def->surfaces || !def->times ||
        !def->read || def->surface_count == 0 || def->frame_count == 0)
        return refuse(error, path,
                      "an animation needs a path, a def from tulle_animation_def_default, "
                      "surfaces, times and a reader");
    if (!(def->frame_rate > 0.0 && def->frame_rate < 1e9) ||
        !(def->meters_per_unit > 0.0 && def->meters_per_unit < 1e9))
        return refuse(error, path, "the frame rate and the unit must be above 0 and below 1e9");
    if (def->vertex_array && (!def->read_vertex_array || !is_array_name(def->vertex_array)))
        return refuse(error, path,
                      "a vertex array needs a reader and a name of letters, digits and _, up to "
                      "64, that no other array has");
    for (uint32_t i = 0; i < def->frame_count; i++)
        if (!isfinite((float)def->times[i]) || (i > 0 && !(def->times[i] > def->times[i - 1])))
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                                "the times of frames must rise, but frame %u is at %g s", i,
                                def->times[i]);
    for (size_t i = 0; i < def->surface_count; i++) {
        tulle_status const status = check_surface(path, def, i, error);
        if (status) return status;
    }
    return TULLE_OK;
}

/* ---- the file ---- */

static animation_format find_format(const char *path) {
    static const char *const extensions[] = {".glb", ".gltf", ".usda", ".mdd", ".npz", ".abc"};
    size_t const length = strlen(path);
    for (int i = 0; i < ANIMATION_FORMAT_COUNT; i++) {
        size_t const tail = strlen(extensions[i]);
        bool is_same = length >= tail;
        for (size_t k = 0; is_same && k < tail; k++) {
            char const c = path[length - tail + k];
            is_same = (c >= 'A' && c <= 'Z' ? (char)(c + 32) : c) == extensions[i][k];
        }
        if (is_same) return (animation_format)i;
    }
    return ANIMATION_FORMAT_COUNT;
}

static tulle_status write_format(animation_job *job, animation_format format, tulle_error *error) {
    switch (format) {
    case ANIMATION_GLB: return gltf_write(job, true, error);
    case ANIMATION_GLTF: return gltf_write(job, false, error);
    case ANIMATION_USDA: return usd_write(job, error);
    case ANIMATION_MDD: return mdd_write(job, error);
    case ANIMATION_NPZ: return npz_write(job, error);
    default: return alembic_write(job, error);
    }
}

tulle_status tulle_animation_write(const char *path, const tulle_animation_def *def,
                                   tulle_error *error) {
    tulle_status status = check_def(path, def, error);
    if (status) return status;
    animation_format const format = find_format(path);
    if (format == ANIMATION_FORMAT_COUNT)
        return error_set_at(
            error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
            "the name of an animation should end in .glb, .gltf, .usda, .mdd, .npz or .abc");
    animation_job job = {.def = def, .path = path, .heap = memory_default()};
    for (size_t i = 0; i < def->surface_count; i++)
        if (def->surfaces[i].mesh.vertex_count > job.vertex_limit)
            job.vertex_limit = def->surfaces[i].mesh.vertex_count;
    size_t const double_size = 3 * job.vertex_limit * sizeof(double);
    size_t const float_size = 3 * job.vertex_limit * sizeof(float);
    job.positions = memory_allocate(&job.heap, double_size);
    job.sums = memory_allocate(&job.heap, double_size);
    job.points = memory_allocate(&job.heap, float_size);
    job.normals = memory_allocate(&job.heap, float_size);
    status = job.positions && job.sums && job.points && job.normals
                 ? write_format(&job, format, error)
                 : file_fail(error, path, ENOMEM, "cannot be written");
    memory_release(&job.heap, job.positions, double_size);
    memory_release(&job.heap, job.sums, double_size);
    memory_release(&job.heap, job.points, float_size);
    memory_release(&job.heap, job.normals, float_size);
    return status;
}
