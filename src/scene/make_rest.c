/* scene/make_rest.c - what a cloth is like at rest: its lengths, folds and the direction of its
 * warp in each triangle. */
#include "scene/rest_shape.h"

#include <math.h>
#include <string.h>

/* How many times longer than at the start cloth may be at rest, and shorter. Beyond, something is
 * mistaken: a unit, a scale. */
static const double MOST_LENGTH_RATIO = 2.0;
/* A direction that lies in a triangle by less than this sine says nothing there. */
static const double LEAST_SINE = 1e-3;

static bool refuse(const rest_work *work, const void *keys, const char *key, const char *text) {
    const schema_head *const head = keys;
    problem_add(work->scene->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, key),
                "%s.%s: %s", head->path, key, text ? text : "no memory for a message");
    return false;
}

const char *name_triangle(const rest_work *work, size_t triangle) {
    return work->lines ? store_text(work->scene, "triangle %zu (line %u of the mesh)", triangle,
                                    work->lines[triangle])
                       : store_text(work->scene, "triangle %zu", triangle);
}

static double *allocate(const rest_work *work, size_t count) {
    double *const numbers = ARENA_NEW(&work->scene->scene->storage, double, count);
    if (!numbers) problem_add_memory(work->scene->problems, work->scene->scene->path);
    return numbers;
}

/* ---- triangles, as two edges from corner 0 ---- */

edge_pair get_start(const rest_work *work, size_t triangle) {
    const uint32_t *const corners = work->cloth->mesh.triangles + 3 * triangle;
    const double *const positions = work->cloth->mesh.positions;
    vec3 const origin = vec3_load(positions, corners[0]);
    return (edge_pair){vec3_sub(vec3_load(positions, corners[1]), origin),
                       vec3_sub(vec3_load(positions, corners[2]), origin)};
}

edge_pair get_texture(const rest_work *work, size_t triangle) {
    const double *const uv = work->corner_uvs + 6 * triangle;
    return (edge_pair){{uv[2] - uv[0], uv[3] - uv[1], 0.0}, {uv[4] - uv[0], uv[5] - uv[1], 0.0}};
}

edge_pair get_rest(const rest_work *work, size_t triangle) {
    const scene_cloth *const cloth = work->cloth;
    if (!cloth->rest_corners && !cloth->rest_positions) return get_start(work, triangle);
    size_t places[3] = {3 * triangle, 3 * triangle + 1, 3 * triangle + 2};
    const double *const from = cloth->rest_corners ? cloth->rest_corners : cloth->rest_positions;
    for (size_t k = 0; !cloth->rest_corners && k < 3; k++)
        places[k] = cloth->mesh.triangles[3 * triangle + k];
    vec3 const origin = vec3_load(from, places[0]);
    return (edge_pair){vec3_sub(vec3_load(from, places[1]), origin),
                       vec3_sub(vec3_load(from, places[2]), origin)};
}

/* ---- texture coordinates ---- */

/* Each triangle must have them, and an area in their plane. */
static bool check_texture(const rest_work *work, const void *keys, const char *key) {
    if (!work->corner_uvs)
        return refuse(work, keys, key,
                      "the mesh has no texture coordinates; OBJ files have them as vt, PLY files "
                      "as s and t of vertices");
    for (size_t t = 0; t < work->cloth->mesh.triangle_count; t++) {
        const char *problem = NULL;
        for (size_t k = 0; k < 6; k++)
            if (!isfinite(work->corner_uvs[6 * t + k]))
                problem = "has a corner without texture coordinates";
        edge_pair const edges = get_texture(work, t);
        double const longest = fmax(vec3_norm(edges.first), vec3_norm(edges.second));
        if (!problem && !(measure_double_area(edges) > 1e-9 * longest * longest))
            problem = "has no area in the plane of the texture coordinates";
        if (!problem) continue;
        const char *const name = name_triangle(work, t);
        return refuse(work, keys, key,
                      name ? store_text(work->scene, "%s %s", name, problem) : NULL);
    }
    return true;
}

/* ---- lengths at rest ---- */

/* Corners in the plane of the texture coordinates. */
static bool lay_out_texture(const rest_work *work, const rest_keys *keys) {
    if (!check_texture(work, keys, "uv")) return false;
    size_t const count = 3 * work->cloth->mesh.triangle_count;
    double *const corners = allocate(work, 3 * count);
    if (!corners) return false;
    for (size_t i = 0; i < count; i++) {
        corners[3 * i] = keys->uv * work->corner_uvs[2 * i];
        corners[3 * i + 1] = keys->uv * work->corner_uvs[2 * i + 1];
        corners[3 * i + 2] = 0.0;
    }
    work->cloth->rest_corners = corners;
    return true;
}

/* Where a rest mesh has other triangles than the mesh itself: the first; the number of triangles
 * where there is none. */
static size_t find_other_triangle(const tulle_mesh *mesh, const tulle_mesh *rest) {
    size_t t = 0;
    while (t < mesh->triangle_count &&
           memcmp(mesh->triangles + 3 * t, rest->triangles + 3 * t, 3 * sizeof(uint32_t)) == 0)
        t++;
    return t;
}

/* A mesh of the same triangles gives the shape at rest; one with vertices of its own gives a
 * pattern, triangle by triangle. */
static bool use_rest_mesh(const rest_work *work, const rest_keys *keys, const tulle_mesh *rest) {
    const tulle_mesh *const mesh = &work->cloth->mesh;
    if (rest->triangle_count != mesh->triangle_count)
        return refuse(work, keys, "file",
                      store_text(work->scene,
                                 "has %zu triangles, the mesh has %zu; triangle by triangle they "
                                 "must be the same cloth",
                                 rest->triangle_count, mesh->triangle_count));
    size_t const other = find_other_triangle(mesh, rest);
    bool const is_shape = rest->vertex_count == mesh->vertex_count && other == mesh->triangle_count;
    if (rest->vertex_count == mesh->vertex_count && !is_shape) {
        const uint32_t *const a = mesh->triangles + 3 * other, *const b =
                                                                   rest->triangles + 3 * other;
        return refuse(
            work, keys, "file",
            store_text(work->scene,
                       "triangle %zu has the vertices %u, %u, %u, in the mesh it has %u, %u, %u",
                       other, b[0], b[1], b[2], a[0], a[1], a[2]));
    }
    size_t const count = is_shape ? mesh->vertex_count : 3 * mesh->triangle_count;
    double *const places = allocate(work, 3 * count);
    if (!places) return false;
    for (size_t i = 0; i < 3 * count; i++) {
        size_t const vertex = is_shape ? i / 3 : rest->triangles[i / 3];
        places[i] = rest->positions[3 * vertex + i % 3];
    }
    if (is_shape)
        work->cloth->rest_positions = places;
    else
        work->cloth->rest_corners = places;
    return true;
}

static bool read_rest(const rest_work *work, const rest_keys *keys) {
    const char *const path = resolve_path(work->scene, keys->file);
    tulle_mesh rest = {0};
    tulle_error error = {0};
    if (!path) return false;
    source_mesh made = {.mesh = &rest};
    if (read_mesh(work->scene, path, TULLE_MESH_ROLE_CLOTH, &made, NULL, &error) != TULLE_OK) {
        problem_add_error(work->scene->problems, schema_place(keys, "file"), keys->head.path,
                          &error);
        return false;
    }
    place_cloth_mesh(work->cloth, &rest);
    bool const is_good =
        use_rest_mesh(work, keys, &rest) &&
        count_mesh(work->scene, &rest, schema_place(keys, "file"), keys->head.path);
    tulle_mesh_destroy(&rest);
    return is_good;
}

static bool shrink(const rest_work *work, double factor) {
    scene_cloth *const cloth = work->cloth;
    size_t const vertex_numbers = 3 * cloth->mesh.vertex_count;
    if (!cloth->rest_corners && !cloth->rest_positions) {
        cloth->rest_positions = allocate(work, vertex_numbers);
        if (!cloth->rest_positions) return false;
        memcpy(cloth->rest_positions, cloth->mesh.positions, vertex_numbers * sizeof(double));
    }
    double *const numbers = cloth->rest_corners ? cloth->rest_corners : cloth->rest_positions;
    size_t const count = cloth->rest_corners ? 9 * cloth->mesh.triangle_count : vertex_numbers;
    for (size_t i = 0; i < count; i++) numbers[i] *= factor;
    return true;
}

/* Shrinks the triangles of regions. They then no longer fit together, so each gets corners of its
 * own. */
static bool shrink_regions(const rest_work *work) {
    scene_cloth *const cloth = work->cloth;
    size_t const triangles = cloth->mesh.triangle_count;
    if (!has_region_shrink(work)) return true;
    if (!cloth->rest_corners) {
        const double *const from =
            cloth->rest_positions ? cloth->rest_positions : cloth->mesh.positions;
        double *const corners = allocate(work, 9 * triangles);
        if (!corners) return false;
        for (size_t i = 0; i < 3 * triangles; i++)
            memcpy(corners + 3 * i, from + 3 * (size_t)cloth->mesh.triangles[i],
                   3 * sizeof(double));
        cloth->rest_corners = corners;
    }
    for (size_t i = 0; i < 9 * triangles; i++) {
        const region_keys *const region = get_region(work, i / 9);
        if (region) cloth->rest_corners[i] *= region->shrink;
    }
    return true;
}

/* Refuses a shape at rest that is of another size than the start. */
static bool check_size(const rest_work *work, const rest_keys *keys) {
    double start = 0.0, rest = 0.0;
    for (size_t t = 0; t < work->cloth->mesh.triangle_count; t++) {
        start += measure_double_area(get_start(work, t));
        rest += measure_double_area(get_rest(work, t));
    }
    double const ratio = sqrt(rest / start);
    if (ratio <= MOST_LENGTH_RATIO && ratio >= 1.0 / MOST_LENGTH_RATIO) return true;
    bool const is_uv = schema_is_given(&rest_map, keys, "uv");
    const char *const advice =
        is_uv ? store_text(work->scene, "with uv: %.4g m it would be as large", keys->uv / ratio)
              : "do both have the same unit?";
    problem_add(work->scene->problems, TULLE_ERROR_INVALID_ARGUMENT, keys->head.place,
                "%s: the cloth is %.3g times as long at rest as at the start, at most %g and at "
                "least %g are allowed; %s",
                keys->head.path, ratio, MOST_LENGTH_RATIO, 1.0 / MOST_LENGTH_RATIO,
                advice ? advice : "");
    return false;
}

/* ---- the warp ---- */

/* The part of the grain in the plane of a triangle; another axis where it has next to none. */
static vec3 lay_grain(edge_pair edges, vec3 grain) {
    vec3 const normal = vec3_normalize(vec3_cross(edges.first, edges.second));
    vec3 const axes[3] = {vec3_normalize(grain), {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    vec3 along = axes[0];
    for (int k = 0; k < 3; k++) {
        along = vec3_add_scaled(axes[k], normal, -vec3_dot(axes[k], normal));
        if (vec3_norm(along) > LEAST_SINE) break;
    }
    return along;
}

/* What a direction in one shape of a triangle is in another: the same sum of its edges. */
static vec3 carry(edge_pair from, edge_pair to, vec3 direction) {
    vec3 const normal = vec3_cross(from.first, from.second);
    double const inverse = 1.0 / vec3_norm2(normal);
    double const a = vec3_dot(normal, vec3_cross(direction, from.second)) * inverse;
    double const b = vec3_dot(normal, vec3_cross(from.first, direction)) * inverse;
    return vec3_add(vec3_scale(to.first, a), vec3_scale(to.second, b));
}

/* Gives each triangle its warp, where the grain alone does not say it. */
static bool lay_warps(const rest_work *work) {
    const cloth_keys *const keys = work->keys;
    scene_cloth *const cloth = work->cloth;
    bool const is_uv = schema_is_given(&cloth_map, keys, "grain_uv");
    bool const is_elsewhere = cloth->rest_corners || cloth->rest_positions;
    if (is_uv && !check_texture(work, keys, "grain_uv")) return false;
    static const char idle[] = "does nothing with membrane: springs, which are the same in every "
                               "direction; leave it out, or set membrane: woven";
    if (is_uv && scene_has_springs(work->scene)) return refuse(work, keys, "grain_uv", idle);
    const region_keys *const regions = keys->regions.items;
    for (size_t i = 0; i < keys->regions.count && scene_has_springs(work->scene); i++)
        if (schema_is_given(&region_map, &regions[i], "grain"))
            return refuse(work, &regions[i], "grain", idle);
    if (!is_uv && !is_elsewhere && !has_region_grain(work)) return true;
    vec3 const grain = vec3_load(keys->grain.value, 0);
    vec3 const grain_uv = {keys->grain_uv.value[0], keys->grain_uv.value[1], 0.0};
    if (is_uv && !(vec3_norm(grain_uv) > 0.0))
        return refuse(work, keys, "grain_uv", "is not a direction; give for example [0, 1]");
    double *const warps = allocate(work, 3 * cloth->mesh.triangle_count);
    if (!warps) return false;
    for (size_t t = 0; t < cloth->mesh.triangle_count; t++) {
        const region_keys *const region = get_region(work, t);
        bool const has_own = region && schema_is_given(&region_map, region, "grain");
        bool const is_laid_out = is_uv && !has_own;
        edge_pair const from = is_laid_out ? get_texture(work, t) : get_start(work, t);
        vec3 const start_grain = has_own ? vec3_load(region->grain.value, 0) : grain;
        vec3 const along = is_laid_out ? grain_uv : lay_grain(from, start_grain);
        vec3_store(warps, t, vec3_normalize(carry(from, get_rest(work, t), along)));
    }
    cloth->warps = warps;
    return true;
}

bool make_rest(const scene_work *scene, const cloth_keys *keys, scene_cloth *cloth) {
    const tulle_mesh_source *const source = &cloth->source;
    rest_work work = {scene, keys, cloth, source->corner_uvs, source->triangle_lines, NULL};
    const rest_keys *const rest = &keys->rest;
    bool const is_uv = schema_is_given(&rest_map, rest, "uv");
    bool is_good = find_regions(&work) && list_creases(&work);
    if (is_good && is_uv) is_good = lay_out_texture(&work, rest);
    if (is_good && schema_is_given(&rest_map, rest, "file")) is_good = read_rest(&work, rest);
    if (is_good && rest->shrink != 1.0) is_good = shrink(&work, rest->shrink);
    if (is_good) is_good = shrink_regions(&work);
    bool const is_given = cloth->rest_corners || cloth->rest_positions;
    if (is_good && is_given) is_good = check_size(&work, rest);
    if (is_good && is_given) is_good = note_odd_rest(&work, rest);
    bool const is_said = schema_is_given(&rest_map, rest, "folds");
    cloth->has_flat_rest = is_said ? rest->folds == REST_FOLDS_FLAT : is_uv;
    return is_good && lay_warps(&work) && make_stiffness(&work);
}
