/* scene/choose_vertices.c - the vertices of a cloth that an entry means: in a box or a sphere,
 * along a line, nearest to a point, near an obstacle, of a part of the mesh file, by their numbers.
 */
#include "scene/scene_data.h"

#include "base/text.h"

#include <math.h>
#include <string.h>

static bool is_in_box(const box_keys *box, const double *p) {
    for (int k = 0; k < 3; k++)
        if (p[k] < box->min.value[k] || p[k] > box->max.value[k]) return false;
    return true;
}

double measure_to_segment(const double a[3], const double b[3], const double p[3]) {
    double along = 0, length = 0, squared = 0;
    for (int k = 0; k < 3; k++) {
        along += (p[k] - a[k]) * (b[k] - a[k]);
        length += (b[k] - a[k]) * (b[k] - a[k]);
    }
    double t = length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
    for (int k = 0; k < 3; k++) {
        double d = p[k] - a[k] - t * (b[k] - a[k]);
        squared += d * d;
    }
    return sqrt(squared);
}

static size_t find_nearest(const tulle_mesh *mesh, const double point[3]) {
    size_t nearest = 0;
    double smallest = INFINITY;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double distance = measure_to_segment(point, point, mesh->positions + 3 * v);
        if (distance < smallest) smallest = distance, nearest = v;
    }
    return nearest;
}

/* ---- numbers ---- */

static bool mark_numbers(const scene_work *work, const tulle_mesh *mesh,
                         const vertex_choice *choice, unsigned char mark, unsigned char *marks) {
    const schema_indices *const numbers = &choice->where->vertices;
    for (size_t i = 0; i < numbers->count; i++) {
        if (numbers->value[i] < mesh->vertex_count) {
            marks[numbers->value[i]] |= mark;
            continue;
        }
        const schema_head *const head = choice->keys;
        problem_add(
            work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(choice->keys, "vertices"),
            "%s.vertices: names vertex %u, must be below %zu, the cloth's number of vertices",
            head->path, (unsigned)numbers->value[i], mesh->vertex_count);
        return false;
    }
    return true;
}

/* ---- parts of the mesh file ---- */

enum {
    LISTED_NAMES = 20,     /* that a message lists */
    COMPARED_PARTS = 10000 /* whose names are compared with one that is nobody's */
};

static bool is_given(const vertex_choice *choice, const char *key) {
    return schema_is_given(choice->map, choice->keys, key);
}

bool names_part(const vertex_choice *choice) {
    return is_given(choice, "group") || is_given(choice, "material");
}

/* The names of a kind of part, each once, as many as a message lists. */
static size_t list_names(const tulle_mesh_source *source, tulle_mesh_part_kind kind,
                         const char *names[LISTED_NAMES]) {
    size_t count = 0;
    for (size_t i = 0; i < source->part_count && count < LISTED_NAMES; i++) {
        size_t known = 0;
        if (source->parts[i].kind != kind) continue;
        while (known < count && strcmp(names[known], source->parts[i].name) != 0) known++;
        if (known == count) names[count++] = source->parts[i].name;
    }
    return count;
}

static const char *find_meant_name(const tulle_mesh_source *source, tulle_mesh_part_kind kind,
                                   const char *name) {
    const char *nearest = NULL;
    for (size_t i = 0; i < source->part_count && i < COMPARED_PARTS; i++) {
        if (source->parts[i].kind != kind) continue;
        const char *const two[2] = {nearest ? nearest : source->parts[i].name,
                                    source->parts[i].name};
        nearest = text_find_nearest(name, two, 2);
    }
    return nearest;
}

static bool refuse_part(const scene_work *work, const scene_cloth *cloth,
                        const vertex_choice *choice, const char *key, const char *name) {
    const char *const path = ((const schema_head *)choice->keys)->path;
    scene_place const place = schema_place(choice->keys, key);
    bool const is_group = strcmp(key, "group") == 0;
    tulle_mesh_part_kind const kind = is_group ? TULLE_MESH_PART_GROUP : TULLE_MESH_PART_MATERIAL;
    const char *names[LISTED_NAMES];
    size_t const count = list_names(&cloth->source, kind, names);
    if (count == 0) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, place,
                    "%s.%s: the mesh has no %s; only OBJ files have them, by the statement%s", path,
                    key, is_group ? "groups" : "materials", is_group ? "s g and o" : " usemtl");
        return false;
    }
    char list[1500] = "";
    for (size_t i = 0, used = 0; i < count && used < sizeof list; i++) {
        int const added = snprintf(list + used, sizeof list - used, "%s%s", i > 0 ? ", " : "",
                                   show_text(names[i]).text);
        used += added > 0 ? (size_t)added : 0;
    }
    bool const is_shown = work->problems->total_count < TULLE_SCENE_PROBLEMS_MAX;
    const char *const meant = is_shown ? find_meant_name(&cloth->source, kind, name) : NULL;
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, place,
                "%s.%s: the mesh file has no '%s'; it has %s%s%s%s%s", path, key,
                show_text(name).text, list, count == LISTED_NAMES ? ", ..." : "",
                meant ? "; did you mean '" : "", meant ? show_text(meant).text : "",
                meant ? "'?" : "");
    return false;
}

bool choose_part(const scene_work *work, const scene_cloth *cloth, const vertex_choice *choice,
                 unsigned char *flags) {
    bool const is_group = is_given(choice, "group");
    tulle_mesh_part_kind const kind = is_group ? TULLE_MESH_PART_GROUP : TULLE_MESH_PART_MATERIAL;
    const char *const name = is_group ? choice->where->group : choice->where->material;
    bool is_found = false;
    for (size_t i = 0; i < cloth->source.part_count; i++) {
        const tulle_mesh_part *const part = &cloth->source.parts[i];
        if (part->kind != kind || strcmp(part->name, name) != 0) continue;
        memset(flags + part->first, 1, part->count);
        is_found = true;
    }
    return is_found || refuse_part(work, cloth, choice, is_group ? "group" : "material", name);
}

static bool mark_part(const scene_work *work, const scene_cloth *cloth, const vertex_choice *choice,
                      unsigned char mark, unsigned char *marks) {
    size_t const count = cloth->mesh.triangle_count;
    unsigned char *const flags = memory_allocate_zeroed(&work->scene->heap, count, 1);
    if (!flags) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    bool const is_good = choose_part(work, cloth, choice, flags);
    for (size_t i = 0; is_good && i < 3 * count; i++)
        if (flags[i / 3]) marks[cloth->mesh.triangles[i]] |= mark;
    memory_release(&work->scene->heap, flags, count);
    return is_good;
}

/* ---- all ---- */

static bool mark_near_obstacle(const scene_work *work, const tulle_mesh *mesh,
                               const near_keys *keys, unsigned char mark, unsigned char *marks) {
    size_t begin, end;
    if (!find_obstacles(work->scene, keys->to, &begin, &end))
        return refuse_obstacle_name(work, keys, "to", keys->to);
    bool is_good = true;
    for (size_t i = begin; is_good && i < end; i++)
        is_good = mark_near(work, mesh, &work->scene->obstacles[i].mesh, keys->within, mark, marks);
    return is_good;
}

bool choose_vertices(const scene_work *work, const scene_cloth *cloth, const vertex_choice *choice,
                     unsigned char mark, unsigned char *marks) {
    const tulle_mesh *const mesh = &cloth->mesh;
    const choice_keys *const where = choice->where;
    if (is_given(choice, "vertices")) return mark_numbers(work, mesh, choice, mark, marks);
    if (names_part(choice)) return mark_part(work, cloth, choice, mark, marks);
    if (is_given(choice, "near")) return mark_near_obstacle(work, mesh, &where->near, mark, marks);
    if (is_given(choice, "nearest")) {
        marks[find_nearest(mesh, where->nearest.value)] |= mark;
        return true;
    }
    bool const is_box = is_given(choice, "box"), is_sphere = is_given(choice, "sphere");
    const double *const from = is_sphere ? where->sphere.center.value : where->line.from.value;
    const double *const to = is_sphere ? from : where->line.to.value;
    double const radius = is_sphere ? where->sphere.radius : where->line.radius;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const double *const p = mesh->positions + 3 * v;
        bool const is_in =
            is_box ? is_in_box(&where->box, p) : measure_to_segment(from, to, p) <= radius;
        if (is_in) marks[v] |= mark;
    }
    return true;
}

bool refuse_empty_choice(const scene_work *work, const tulle_mesh *mesh, const schema_head *head,
                         const char *problem) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh->positions[i]);
    }
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, head->place,
                "%s: %s; the cloth begins within [%g, %g, %g] and [%g, %g, %g]", head->path,
                problem, low[0], low[1], low[2], high[0], high[1], high[2]);
    return false;
}
