/* io/animation/usd_scene.c - see usd_scene.h: puts together what the prims of a USD file say.
 *
 * Based on: Pixar, Universal Scene Description, schemas UsdGeomMesh, UsdGeomPoints,
 * UsdGeomXformable, UsdGeomPointInstancer; the order of strength of opinions, of which the local
 * ones, those that are inherited and those that are referenced in this file occur here. */
#include "io/animation/usd_scene.h"

#include "base/error.h"
#include "base/sort.h"
#include "io/animation/expansion.h"
#include "io/animation/matrix.h"
#include "io/file_data.h"

#include <math.h>

enum {
    SPEC_MAX = 64,      /* prims that make one together */
    REFERENCE_MAX = 32, /* references that lead on to each other */
    DEPTH_MAX = 200     /* nodes below each other */
};
#define COUNT_LIMIT ((size_t)INT32_MAX)

/* The prims that make a node together: `count` of usd_scene.specs. */
typedef struct spec_range {
    size_t first, count;
} spec_range;

static tulle_status fail_memory(const usd_scene *scene, tulle_error *error) {
    return file_fail_memory(error, scene->layer->text.path);
}

static tulle_status check_size(const usd_scene *scene, uint64_t more, tulle_error *error) {
    uint64_t const size = more + 12 * (uint64_t)scene->vertex_count +
                          scene->nodes.count * sizeof *scene->nodes.data +
                          scene->pieces.count * sizeof *scene->pieces.data +
                          scene->triangles.count * sizeof *scene->triangles.data;
    uint64_t const limit = expansion_get_limit(scene->layer->text.size);
    if (size <= limit) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_LIMIT, scene->layer->text.path, 0, 0,
                        "would take more than %llu MB of memory, which is too many times its size: "
                        "it uses prims too often",
                        (unsigned long long)(limit >> 20) + 1);
}

/* ---- prims that make one ---- */

/* Adds a prim and what it refers to, its own opinions first. */
static tulle_status add_spec(usd_scene *scene, size_t first, uint32_t prim, int depth,
                             tulle_error *error) {
    usd_layer *const layer = scene->layer;
    const usd_prim *const added = &layer->prims.data[prim];
    if (scene->specs.count - first >= SPEC_MAX || depth > REFERENCE_MAX)
        return usd_text_fail(&layer->text, added->place, error,
                             "the prim has too many references, or they lead in a circle");
    if (!ARRAY_RESERVE(layer->text.heap, &scene->specs, 1)) return fail_memory(scene, error);
    scene->specs.data[scene->specs.count++] = prim;
    tulle_status status = TULLE_OK;
    for (int pass = 0; pass < 2; pass++)
        for (uint32_t i = added->first_arc; i != USD_NONE && status == TULLE_OK;
             i = layer->arcs.data[i].next) {
            const usd_arc *const arc = &layer->arcs.data[i];
            if (arc->is_inherited != (pass == 0)) continue;
            uint32_t const target =
                usd_layer_find_prim(layer, usd_layer_get_text(layer, arc->path));
            bool const is_there = target != USD_NONE && target != 0;
            if (is_there)
                status = add_spec(scene, first, target, depth + 1, error);
            else if (arc->is_inherited && layer->passed.classes++ == 0)
                layer->passed.first_class = arc->path;
            else if (!arc->is_inherited)
                status = usd_text_fail(&layer->text, arc->place, error,
                                       "there is no prim <%.100s> in this file",
                                       usd_layer_get_text(layer, arc->path));
        }
    return status;
}

/* The strongest attribute of that name; USD_NONE: there is none. */
static uint32_t find_attribute(const usd_scene *scene, spec_range specs, usd_name name,
                               const char *full_name) {
    uint32_t found = USD_NONE;
    for (size_t i = 0; i < specs.count && found == USD_NONE; i++) {
        found = usd_layer_find_attribute(scene->layer, scene->specs.data[specs.first + i], name,
                                         full_name);
        /* What is only declared says nothing. */
        usd_place place;
        if (found != USD_NONE && name != USD_PROTOTYPES &&
            !usd_find_value(scene->layer, found, &place))
            found = USD_NONE;
    }
    return found;
}

/* Goes to the first value of a word, as "leftHanded"; false where there is none or another. */
static tulle_status is_token(usd_scene *scene, spec_range specs, usd_name name, const char *token,
                             bool *is_so, tulle_error *error) {
    uint32_t const number = find_attribute(scene, specs, name, NULL);
    usd_place place;
    *is_so = false;
    if (!usd_find_value(scene->layer, number, &place)) return TULLE_OK;
    usd_text *const text = &scene->layer->text;
    tulle_status const status = usd_text_seek(text, place, error);
    if (status) return status;
    *is_so = text->kind == USD_STRING && strcmp(text->word.data, token) == 0;
    return TULLE_OK;
}

/* ---- transforms ---- */

/* Takes the name of a step apart: "xformOp:rotateXYZ:arm". */
static bool read_op_name(const char *name, usd_op *op) {
    static const struct {
        const char *name;
        usd_op_kind kind;
        size_t width;
    } kinds[] = {{"translate", USD_TRANSLATE, 3},
                 {"scale", USD_SCALE, 3},
                 {"rotate", USD_ROTATE, 3},
                 {"orient", USD_ORIENT, 4},
                 {"transform", USD_MATRIX, 16}};
    if (strncmp(name, "xformOp:", 8) != 0) return false;
    name += 8;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        size_t const length = strlen(kinds[i].name), axes = strcspn(name, ":");
        if (strncmp(name, kinds[i].name, length) != 0 || axes < length) continue;
        op->kind = kinds[i].kind;
        op->width = kinds[i].width;
        memcpy(op->axes, "XYZ", 4);
        size_t const axis_count = axes - length;
        if (axis_count == 0) return op->kind != USD_ROTATE;
        if (op->kind > USD_ROTATE || (axis_count != 1 && axis_count != 3)) return false;
        memset(op->axes, 0, sizeof op->axes);
        int seen = 0;
        for (size_t k = 0; k < axis_count; k++) {
            op->axes[k] = name[length + k];
            if (op->axes[k] < 'X' || op->axes[k] > 'Z') return false;
            seen |= 1 << (op->axes[k] - 'X');
        }
        op->width = axis_count;
        return axis_count == 1 || (seen == 7 && op->kind == USD_ROTATE);
    }
    return false;
}

/* A word of xformOpOrder, which the text is at. */
static tulle_status add_op(usd_scene *scene, spec_range specs, usd_node *node, tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    const char *name = text->word.data;
    if (text->kind != USD_STRING) return usd_text_fail_word(text, "the name of a step", error);
    if (strcmp(name, "!resetXformStack!") == 0) {
        node->resets = true;
        node->op_count = 0;
        node->first_op = scene->ops.count;
        return TULLE_OK;
    }
    usd_op op = {.is_inverse = strncmp(name, "!invert!", 8) == 0};
    if (op.is_inverse) name += 8;
    if (!read_op_name(name, &op))
        return usd_text_fail_word(text, "a step of a transform that is known", error);
    op.attribute = find_attribute(scene, specs, USD_OP, name);
    if (op.attribute == USD_NONE)
        return usd_text_fail_word(text, "the name of an attribute that has a value", error);
    if (!ARRAY_RESERVE(text->heap, &scene->ops, 1)) return fail_memory(scene, error);
    scene->ops.data[scene->ops.count++] = op;
    node->op_count++;
    if (scene->layer->attributes.data[op.attribute].sample_count > 0) node->is_moving = true;
    return TULLE_OK;
}

static tulle_status read_ops(usd_scene *scene, spec_range specs, usd_node *node,
                             tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    uint32_t const order = find_attribute(scene, specs, USD_OP_ORDER, NULL);
    usd_place place;
    node->first_op = scene->ops.count;
    if (!usd_find_value(scene->layer, order, &place)) return TULLE_OK;
    tulle_status status = usd_text_seek(text, place, error);
    if (status == TULLE_OK) status = usd_text_expect(text, '[', error);
    while (status == TULLE_OK && !usd_text_is_sign(text, ']')) {
        status = add_op(scene, specs, node, error);
        if (status == TULLE_OK) status = usd_text_next(text, error);
        if (status == TULLE_OK && !usd_text_is_sign(text, ']'))
            status = usd_text_expect(text, ',', error);
        if (status == TULLE_OK)
            status = check_size(scene, scene->ops.count * sizeof(usd_op), error);
    }
    if (status == TULLE_OK && !node->is_moving)
        status = usd_node_read_local(scene, node, 0.0, error);
    return status;
}

static tulle_status add_node(usd_scene *scene, uint32_t parent, uint32_t *number,
                             tulle_error *error) {
    tulle_status const status = check_size(scene, sizeof(usd_node), error);
    if (status) return status;
    if (!ARRAY_RESERVE(scene->layer->text.heap, &scene->nodes, 1)) return fail_memory(scene, error);
    *number = (uint32_t)scene->nodes.count;
    usd_node *const node = &scene->nodes.data[scene->nodes.count++];
    *node = (usd_node){.parent = parent};
    memcpy(node->local, MATRIX_IDENTITY, sizeof node->local);
    return TULLE_OK;
}

/* ---- faces ---- */

/* Whole numbers that do not change in time: read to new memory of *count doubles. */
static tulle_status read_constant(usd_scene *scene, uint32_t number, double **values, size_t *count,
                                  tulle_error *error) {
    usd_layer *const layer = scene->layer;
    memory *const heap = layer->text.heap;
    const usd_attribute *const attribute = &layer->attributes.data[number];
    usd_place place;
    *values = NULL;
    *count = 0;
    if (!usd_find_value(layer, number, &place)) return TULLE_OK;
    tulle_status status =
        usd_text_read(&layer->text, place, (usd_numbers){1, NULL, 0}, count, error);
    if (status) return status;
    *values = memory_allocate(heap, *count * sizeof **values);
    double *const others =
        attribute->sample_count > 1 ? memory_allocate(heap, *count * sizeof *others) : NULL;
    size_t found = 0;
    if (!*values || (attribute->sample_count > 1 && !others))
        status = fail_memory(scene, error);
    else
        status =
            usd_text_read(&layer->text, place, (usd_numbers){1, *values, *count}, &found, error);
    for (size_t i = 1; i < attribute->sample_count && status == TULLE_OK; i++) {
        place = layer->samples.data[attribute->first_sample + i].place;
        status =
            usd_text_read(&layer->text, place, (usd_numbers){1, others, *count}, &found, error);
        if (status == TULLE_OK &&
            (found != *count || memcmp(others, *values, *count * sizeof **values) != 0))
            status = usd_text_fail(&layer->text, place, error,
                                   "%s changes in time; all frames must have the same faces",
                                   usd_layer_get_text(layer, attribute->full_name));
    }
    memory_release(heap, others, others ? *count * sizeof *others : 0);
    if (status == TULLE_OK) return status;
    memory_release(heap, *values, *values ? *count * sizeof **values : 0);
    *values = NULL;
    *count = 0;
    return status;
}

/* Arrays of the faces of a mesh. */
typedef struct face_arrays {
    double *counts, *indices, *holes;
    size_t count, index_count, hole_count;
    usd_place count_place, index_place;
    const double *points; /* of the first frame */
} face_arrays;

static tulle_status read_faces(usd_scene *scene, const usd_piece *piece, face_arrays *faces,
                               tulle_error *error) {
    tulle_status status =
        read_constant(scene, piece->face_counts, &faces->counts, &faces->count, error);
    if (status == TULLE_OK)
        status =
            read_constant(scene, piece->face_indices, &faces->indices, &faces->index_count, error);
    if (status == TULLE_OK && piece->holes != USD_NONE)
        status = read_constant(scene, piece->holes, &faces->holes, &faces->hole_count, error);
    if (faces->holes)
        sort_in_place(faces->holes, faces->hole_count, sizeof *faces->holes, compare_doubles);
    usd_find_value(scene->layer, piece->face_counts, &faces->count_place);
    usd_find_value(scene->layer, piece->face_indices, &faces->index_place);
    return status;
}

/* Adds the fan of a face as if the mesh were right-handed: triangles are numbered from its first
 * vertex on until all are cut. */
static tulle_status add_face(usd_scene *scene, const usd_piece *piece, const face_arrays *faces,
                             size_t face, size_t first, tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    size_t const corner_count = (size_t)faces->counts[face];
    if (!ARRAY_RESERVE(text->heap, &scene->triangles, 3 * (corner_count - 2)) ||
        !ARRAY_RESERVE(text->heap, &scene->fans, 1))
        return fail_memory(scene, error);
    for (size_t i = 0; i < corner_count; i++) {
        double const vertex = faces->indices[first + i];
        if (!(vertex >= 0.0 && vertex < (double)piece->vertex_count) || vertex != floor(vertex))
            return usd_text_fail(text, faces->index_place, error,
                                 "corner %zu is vertex %g, but there are only %zu", first + i,
                                 vertex, piece->vertex_count);
    }
    if (corner_count > 3)
        scene->fans.data[scene->fans.count++] = (polygon_fan){
            scene->triangles.count / 3, (uint32_t)(corner_count - 2), (uint32_t)face, false};
    for (size_t i = 2; i < corner_count; i++) {
        size_t const corners[3] = {first, first + i - 1, first + i};
        for (int k = 0; k < 3; k++)
            scene->triangles.data[scene->triangles.count++] = (uint32_t)faces->indices[corners[k]];
    }
    return TULLE_OK;
}

static tulle_status make_triangles(usd_scene *scene, const usd_piece *piece,
                                   const face_arrays *faces, tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    size_t first = 0, next_hole = 0;
    scene->fans.count = 0;
    for (size_t i = 0; i < faces->count; i++) {
        double const count = faces->counts[i];
        if (!(count >= 3.0 && count <= (double)(faces->index_count - first)) ||
            count != floor(count))
            return usd_text_fail(
                text, faces->count_place, error,
                "face %zu has %g corners; a face has 3 at least, and %zu are left here", i, count,
                faces->index_count - first);
        while (next_hole < faces->hole_count && faces->holes[next_hole] < (double)i) next_hole++;
        bool const is_hole = next_hole < faces->hole_count && faces->holes[next_hole] == (double)i;
        tulle_status status = TULLE_OK;
        if (!is_hole) status = add_face(scene, piece, faces, i, first, error);
        if (status == TULLE_OK) status = check_size(scene, 0, error);
        if (status) return status;
        first += (size_t)count;
    }
    if (first != faces->index_count || scene->triangles.count / 3 > COUNT_LIMIT)
        return usd_text_fail(text, faces->index_place, error,
                             "there are %zu corners, but the faces have %zu, or all are too many",
                             faces->index_count, first);
    polygon_list const list = {faces->points, scene->triangles.data, NULL, scene->fans.data,
                               scene->fans.count};
    tulle_status const status = polygons_cut(&scene->cutter, &list, error);
    if (status) return status;
    for (size_t i = 3 * piece->first_triangle; i < scene->triangles.count; i++)
        scene->triangles.data[i] += (uint32_t)piece->first_vertex;
    if (piece->is_left_handed)
        turn_triangles(scene->triangles.data + 3 * piece->first_triangle,
                       scene->triangles.count / 3 - piece->first_triangle);
    return TULLE_OK;
}

/* The faces of points that another piece shows already. */
static tulle_status copy_triangles(usd_scene *scene, usd_piece *piece, const usd_piece *other,
                                   tulle_error *error) {
    size_t const count = 3 * other->triangle_count;
    tulle_status const status = check_size(scene, count * sizeof(uint32_t), error);
    if (status) return status;
    if (!ARRAY_RESERVE(scene->layer->text.heap, &scene->triangles, count))
        return fail_memory(scene, error);
    for (size_t i = 0; i < count; i++)
        scene->triangles.data[scene->triangles.count++] =
            (uint32_t)(scene->triangles.data[3 * other->first_triangle + i] - other->first_vertex +
                       piece->first_vertex);
    return TULLE_OK;
}

static tulle_status cut_faces(usd_scene *scene, const usd_piece *piece, tulle_error *error) {
    memory *const heap = scene->layer->text.heap;
    size_t const size = 3 * piece->vertex_count * sizeof(double);
    bool const is_kept = piece->first_kept != SIZE_MAX;
    double *const points =
        is_kept ? scene->kept.data + piece->first_kept : memory_allocate(heap, size);
    face_arrays faces = {.points = points};
    tulle_status status = points ? TULLE_OK : fail_memory(scene, error);
    if (status == TULLE_OK && !is_kept) /* the value before all samples is the first one */
        status = usd_attribute_read(scene, piece->points, -INFINITY,
                                    (usd_numbers){3, points, piece->vertex_count}, error);
    if (status == TULLE_OK) status = read_faces(scene, piece, &faces, error);
    if (status == TULLE_OK) status = make_triangles(scene, piece, &faces, error);
    memory_release(heap, faces.counts, faces.counts ? faces.count * sizeof(double) : 0);
    memory_release(heap, faces.indices, faces.indices ? faces.index_count * sizeof(double) : 0);
    memory_release(heap, faces.holes, faces.holes ? faces.hole_count * sizeof(double) : 0);
    if (!is_kept) memory_release(heap, points, points ? size : 0);
    return status;
}

static tulle_status read_triangles(usd_scene *scene, usd_piece *piece, const usd_piece *other,
                                   tulle_error *error) {
    piece->first_triangle = scene->triangles.count / 3;
    tulle_status status = TULLE_OK;
    if (other && other->face_counts == piece->face_counts &&
        other->face_indices == piece->face_indices && other->holes == piece->holes &&
        other->is_left_handed == piece->is_left_handed)
        status = copy_triangles(scene, piece, other, error);
    else if (piece->face_counts != USD_NONE && piece->face_indices != USD_NONE)
        status = cut_faces(scene, piece, error);
    piece->triangle_count = scene->triangles.count / 3 - piece->first_triangle;
    return status;
}

/* ---- points ---- */

/* Keeps points that never change, so that they are read once. */
static tulle_status keep_points(usd_scene *scene, usd_piece *piece, tulle_error *error) {
    size_t const count = 3 * piece->vertex_count;
    piece->first_kept = SIZE_MAX;
    if (scene->layer->attributes.data[piece->points].sample_count > 1) return TULLE_OK;
    if (!ARRAY_RESERVE(scene->layer->text.heap, &scene->kept, count))
        return fail_memory(scene, error);
    piece->first_kept = scene->kept.count;
    scene->kept.count += count;
    return usd_attribute_read(
        scene, piece->points, 0.0,
        (usd_numbers){3, scene->kept.data + piece->first_kept, piece->vertex_count}, error);
}

static tulle_status note_mesh(usd_scene *scene, spec_range specs, tulle_error *error) {
    bool is_plain = false;
    usd_passed *const passed = &scene->layer->passed;
    tulle_status const status = is_token(scene, specs, USD_SUBDIVISION, "none", &is_plain, error);
    passed->smooth += !is_plain;
    passed->skins += find_attribute(scene, specs, USD_JOINTS, NULL) != USD_NONE;
    return status;
}

static tulle_status add_piece(usd_scene *scene, uint32_t node, spec_range specs, bool is_mesh,
                              tulle_error *error) {
    usd_layer *const layer = scene->layer;
    usd_piece piece = {.node = node,
                       .points = find_attribute(scene, specs, USD_POINTS, NULL),
                       .face_counts = USD_NONE,
                       .face_indices = USD_NONE,
                       .holes = USD_NONE,
                       .first_vertex = scene->vertex_count};
    usd_place place;
    if (!usd_find_value(layer, piece.points, &place)) return TULLE_OK;
    uint32_t const first = layer->attributes.data[piece.points].piece;
    usd_piece const other = first == USD_NONE ? (usd_piece){0} : scene->pieces.data[first];
    piece.vertex_count = other.vertex_count;
    tulle_status status = TULLE_OK;
    if (first == USD_NONE)
        status = usd_text_read(&layer->text, place, (usd_numbers){3, NULL, 0}, &piece.vertex_count,
                               error);
    if (status == TULLE_OK) status = check_size(scene, 12 * (uint64_t)piece.vertex_count, error);
    if (status || piece.vertex_count == 0) return status;
    if (piece.vertex_count > COUNT_LIMIT - scene->vertex_count)
        return error_set_at(error, TULLE_ERROR_LIMIT, layer->text.path, 0, 0,
                            "its vertices are too many");
    if (is_mesh) {
        piece.face_counts = find_attribute(scene, specs, USD_FACE_COUNTS, NULL);
        piece.face_indices = find_attribute(scene, specs, USD_FACE_INDICES, NULL);
        piece.holes = find_attribute(scene, specs, USD_HOLES, NULL);
        status =
            is_token(scene, specs, USD_ORIENTATION, "leftHanded", &piece.is_left_handed, error);
        if (status == TULLE_OK) status = note_mesh(scene, specs, error);
    }
    if (status == TULLE_OK && first == USD_NONE) status = keep_points(scene, &piece, error);
    if (first != USD_NONE) piece.first_kept = other.first_kept;
    if (status == TULLE_OK)
        status = read_triangles(scene, &piece, first == USD_NONE ? NULL : &other, error);
    if (status) return status;
    if (!ARRAY_RESERVE(layer->text.heap, &scene->pieces, 1)) return fail_memory(scene, error);
    if (first == USD_NONE)
        layer->attributes.data[piece.points].piece = (uint32_t)scene->pieces.count;
    scene->vertex_count += piece.vertex_count;
    scene->pieces.data[scene->pieces.count++] = piece;
    return TULLE_OK;
}

/* ---- nodes ---- */

static tulle_status build(usd_scene *scene, uint32_t parent, spec_range specs, int depth,
                          tulle_error *error);

/* Builds what a prim shows below a node. */
static tulle_status build_prim(usd_scene *scene, uint32_t parent, uint32_t prim, int depth,
                               tulle_error *error) {
    size_t const first = scene->specs.count;
    tulle_status status = add_spec(scene, first, prim, 0, error);
    if (status == TULLE_OK)
        status =
            build(scene, parent, (spec_range){first, scene->specs.count - first}, depth, error);
    scene->specs.count = first;
    return status;
}

/* The prims that an instancer shows: new memory of *count numbers. */
static tulle_status read_prototypes(usd_scene *scene, uint32_t relationship, uint32_t **prims,
                                    size_t *count, tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    ARRAY(uint32_t) found = {0};
    usd_place place;
    tulle_status status = TULLE_OK;
    *prims = NULL;
    *count = 0;
    if (!usd_find_value(scene->layer, relationship, &place)) return TULLE_OK;
    status = usd_text_seek(text, place, error);
    bool const is_list = status == TULLE_OK && usd_text_is_sign(text, '[');
    if (is_list) status = usd_text_next(text, error);
    while (status == TULLE_OK && !(is_list && usd_text_is_sign(text, ']'))) {
        uint32_t const prim =
            text->kind == USD_PATH ? usd_layer_find_prim(scene->layer, text->word.data) : USD_NONE;
        if (prim == USD_NONE || prim == 0)
            status = usd_text_fail_word(text, "the path of a prim of this file", error);
        else if (!ARRAY_RESERVE(text->heap, &found, 1))
            status = fail_memory(scene, error);
        else
            found.data[found.count++] = prim;
        if (status == TULLE_OK) status = usd_text_next(text, error);
        if (!is_list) break;
        if (status == TULLE_OK && !usd_text_is_sign(text, ']'))
            status = usd_text_expect(text, ',', error);
    }
    ARRAY_TRIM(text->heap, &found);
    *prims = found.data;
    *count = found.capacity;
    if (status == TULLE_OK && found.count < found.capacity) /* nothing is named by these */
        for (size_t i = found.count; i < found.capacity; i++) found.data[i] = USD_NONE;
    return status;
}

/* What an instancer shows: prims, and of each instance which one. */
typedef struct prototypes {
    uint32_t *prims;
    size_t prim_count;
    double *indices, *ids; /* no ids: the numbers of the instances are theirs */
    uint8_t *is_hidden;
} prototypes;

/* Finds the instances that are inactive, or invisible at all times. */
static tulle_status find_hidden(usd_scene *scene, spec_range specs, const prototypes *shown,
                                size_t count, tulle_error *error) {
    usd_layer *const layer = scene->layer;
    uint32_t const invisible = find_attribute(scene, specs, USD_INVISIBLE, NULL);
    uint32_t *const named = memory_allocate_zeroed(layer->text.heap, count, sizeof *named);
    if (!named && count > 0) return fail_memory(scene, error);
    tulle_status status = TULLE_OK;
    bool is_explicit = false;
    for (size_t k = 0; k < specs.count && !is_explicit; k++)
        for (size_t i = 0; i < layer->inactive.count && status == TULLE_OK; i++) {
            const usd_inactive *const ids = &layer->inactive.data[i];
            if (ids->prim != scene->specs.data[specs.first + k]) continue;
            is_explicit = is_explicit || ids->is_explicit;
            status = usd_count_named(scene, ids->place, shown->ids, count, named, error);
        }
    for (size_t i = 0; i < count; i++) shown->is_hidden[i] = named[i] > 0, named[i] = 0;
    usd_place place;
    bool const has_value = usd_find_value(layer, invisible, &place);
    size_t const sample_count = has_value ? layer->attributes.data[invisible].sample_count : 0;
    size_t const list_count = sample_count > 0 ? sample_count : has_value;
    for (size_t i = 0; i < list_count && status == TULLE_OK; i++) {
        if (sample_count > 0)
            place = layer->samples.data[layer->attributes.data[invisible].first_sample + i].place;
        status = usd_count_named(scene, place, shown->ids, count, named, error);
    }
    for (size_t i = 0; i < count; i++) {
        if (shown->is_hidden[i] || named[i] == 0) continue;
        shown->is_hidden[i] = named[i] == list_count;
        layer->passed.hidden += shown->is_hidden[i];
        layer->passed.changing += !shown->is_hidden[i];
    }
    memory_release(layer->text.heap, named, count * sizeof *named);
    return status;
}

static tulle_status build_instances(usd_scene *scene, uint32_t node, const usd_instancer *instancer,
                                    const prototypes *shown, int depth, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < instancer->count && status == TULLE_OK; i++) {
        double const index = shown->indices[i];
        if (shown->is_hidden[i]) continue;
        uint32_t instance = USD_NONE, prim = USD_NONE;
        if (index >= 0.0 && index < (double)shown->prim_count && index == floor(index))
            prim = shown->prims[(size_t)index];
        if (prim == USD_NONE)
            return error_set_at(
                error, TULLE_ERROR_PARSE, scene->layer->text.path, 0, 0,
                "instance %zu of an instancer is of prototype %g, which is not there", i, index);
        status = add_node(scene, node, &instance, error);
        if (status) return status;
        scene->instances.data[instancer->first_instance + i] = instance;
        status = build_prim(scene, instance, prim, depth + 1, error);
    }
    return status;
}

static tulle_status add_instancer(usd_scene *scene, uint32_t node, spec_range specs, int depth,
                                  tulle_error *error) {
    memory *const heap = scene->layer->text.heap;
    usd_instancer made = {.positions = find_attribute(scene, specs, USD_POSITIONS, NULL),
                          .orientations = find_attribute(scene, specs, USD_ORIENTATIONS, NULL),
                          .scales = find_attribute(scene, specs, USD_SCALES, NULL),
                          .first_instance = scene->instances.count};
    uint32_t const indices = find_attribute(scene, specs, USD_PROTO_INDICES, NULL);
    uint32_t const ids = find_attribute(scene, specs, USD_IDS, NULL);
    size_t id_count = 0;
    prototypes shown = {0};
    if (indices == USD_NONE) return TULLE_OK;
    tulle_status status = read_prototypes(scene, find_attribute(scene, specs, USD_PROTOTYPES, NULL),
                                          &shown.prims, &shown.prim_count, error);
    if (status == TULLE_OK)
        status = read_constant(scene, indices, &shown.indices, &made.count, error);
    if (status == TULLE_OK) status = check_size(scene, made.count * sizeof(usd_node), error);
    if (status == TULLE_OK && (!ARRAY_RESERVE(heap, &scene->instances, made.count) ||
                               !ARRAY_RESERVE(heap, &scene->instancers, 1)))
        status = fail_memory(scene, error);
    if (status == TULLE_OK && ids != USD_NONE)
        status = read_constant(scene, ids, &shown.ids, &id_count, error);
    if (status == TULLE_OK && id_count > 0 && id_count != made.count)
        status = usd_text_fail(&scene->layer->text, scene->layer->attributes.data[ids].place, error,
                               "an instancer has %zu ids for %zu instances", id_count, made.count);
    if (status == TULLE_OK) shown.is_hidden = memory_allocate_zeroed(heap, made.count, 1);
    if (status == TULLE_OK && !shown.is_hidden && made.count > 0)
        status = fail_memory(scene, error);
    if (status == TULLE_OK) status = find_hidden(scene, specs, &shown, made.count, error);
    if (status == TULLE_OK) {
        for (size_t i = 0; i < made.count; i++)
            scene->instances.data[scene->instances.count++] = USD_NONE;
        scene->instancers.data[scene->instancers.count++] = made;
        status = build_instances(scene, node, &made, &shown, depth, error);
    }
    memory_release(heap, shown.is_hidden, shown.is_hidden ? made.count : 0);
    memory_release(heap, shown.ids, shown.ids ? id_count * sizeof *shown.ids : 0);
    memory_release(heap, shown.indices, shown.indices ? made.count * sizeof *shown.indices : 0);
    memory_release(heap, shown.prims, shown.prim_count * sizeof *shown.prims);
    return status;
}

/* Builds the children that any of the prims has: those of the weakest first. */
static tulle_status build_children(usd_scene *scene, uint32_t node, spec_range specs, int depth,
                                   tulle_error *error) {
    usd_layer *const layer = scene->layer;
    for (size_t i = specs.count; i-- > 0;) {
        uint32_t child = layer->prims.data[scene->specs.data[specs.first + i]].first_child;
        for (; child != USD_NONE; child = layer->prims.data[child].next) {
            const char *const name = usd_layer_get_text(layer, layer->prims.data[child].name);
            size_t const length = strlen(name), first = scene->specs.count;
            bool is_new = true;
            for (size_t k = specs.count; k-- > i + 1 && is_new;)
                is_new = usd_layer_find_child(layer, scene->specs.data[specs.first + k], name,
                                              length) == USD_NONE;
            tulle_status status = TULLE_OK;
            for (size_t k = 0; k < specs.count && is_new && status == TULLE_OK; k++) {
                uint32_t const other =
                    usd_layer_find_child(layer, scene->specs.data[specs.first + k], name, length);
                if (other != USD_NONE) status = add_spec(scene, first, other, 0, error);
            }
            if (is_new && status == TULLE_OK)
                status = build(scene, node, (spec_range){first, scene->specs.count - first},
                               depth + 1, error);
            scene->specs.count = first;
            if (status) return status;
        }
    }
    return TULLE_OK;
}

/* Whether prims are invisible at all times, or guides and stand-ins, which no picture shows. */
static tulle_status is_hidden(usd_scene *scene, spec_range specs, bool *is_so, tulle_error *error) {
    usd_layer *const layer = scene->layer;
    uint32_t const number = find_attribute(scene, specs, USD_VISIBILITY, NULL);
    bool is_guide = false, is_proxy = false;
    tulle_status status = is_token(scene, specs, USD_PURPOSE, "guide", &is_guide, error);
    if (status == TULLE_OK) status = is_token(scene, specs, USD_PURPOSE, "proxy", &is_proxy, error);
    if (status == TULLE_OK)
        status = is_token(scene, specs, USD_VISIBILITY, "invisible", is_so, error);
    size_t const count = number == USD_NONE ? 0 : layer->attributes.data[number].sample_count;
    size_t const first = count > 0 ? layer->attributes.data[number].first_sample : 0;
    bool const begins_hidden = *is_so;
    for (size_t i = 1; i < count && status == TULLE_OK; i++) {
        status = usd_text_seek(&layer->text, layer->samples.data[first + i].place, error);
        bool const is_invisible = strcmp(layer->text.word.data, "invisible") == 0;
        if (is_invisible == begins_hidden) continue;
        layer->passed.changing++;
        *is_so = false;
        break;
    }
    *is_so = *is_so || is_guide || is_proxy;
    return status;
}

static tulle_status build(usd_scene *scene, uint32_t parent, spec_range specs, int depth,
                          tulle_error *error) {
    usd_layer *const layer = scene->layer;
    const uint32_t *const prims = scene->specs.data + specs.first;
    usd_type type = USD_UNTYPED;
    usd_specifier specifier = USD_OVER;
    bool is_inactive = false, is_dropped = false;
    for (size_t i = 0; i < specs.count; i++) {
        const usd_prim *const prim = &layer->prims.data[prims[i]];
        if (type == USD_UNTYPED) type = prim->type;
        if (specifier == USD_OVER) specifier = prim->specifier;
        is_inactive = is_inactive || prim->is_inactive;
    }
    if (depth > DEPTH_MAX)
        return usd_text_fail(&layer->text, layer->prims.data[prims[0]].place, error,
                             "references lead in a circle, or more than %d deep", DEPTH_MAX);
    /* Nothing shows a class, or opinions on a prim that is not there. */
    if (is_inactive || specifier != USD_DEF) return TULLE_OK;
    tulle_status status = is_hidden(scene, specs, &is_dropped, error);
    if (status || is_dropped) {
        layer->passed.hidden += is_dropped;
        return status;
    }
    uint32_t node = USD_NONE;
    status = add_node(scene, parent, &node, error);
    if (status == TULLE_OK && type != USD_SCOPE) {
        usd_node made = scene->nodes.data[node];
        status = read_ops(scene, specs, &made, error);
        scene->nodes.data[node] = made;
    }
    if (status) return status;
    if (type == USD_MESH || type == USD_POINT_CLOUD)
        status = add_piece(scene, node, specs, type == USD_MESH, error);
    if (type == USD_SHAPE) layer->passed.shapes++;
    if (type == USD_INSTANCER) return add_instancer(scene, node, specs, depth, error);
    return status == TULLE_OK ? build_children(scene, node, specs, depth, error) : status;
}

/* ---- frames ---- */

static void use(usd_layer *layer, uint32_t attribute) {
    if (attribute != USD_NONE) layer->attributes.data[attribute].is_used = true;
}

/* Finds the nodes and attributes that move something. */
static void mark_used(usd_scene *scene) {
    for (size_t i = 0; i < scene->pieces.count; i++) {
        use(scene->layer, scene->pieces.data[i].points);
        uint32_t node = scene->pieces.data[i].node;
        for (; node != USD_NONE && !scene->nodes.data[node].is_used;
             node = scene->nodes.data[node].parent)
            scene->nodes.data[node].is_used = true;
    }
    for (size_t i = 0; i < scene->nodes.count; i++) {
        const usd_node *const node = &scene->nodes.data[i];
        for (size_t k = 0; k < node->op_count && node->is_used; k++)
            use(scene->layer, scene->ops.data[node->first_op + k].attribute);
    }
    for (size_t i = 0; i < scene->instancers.count; i++) {
        use(scene->layer, scene->instancers.data[i].positions);
        use(scene->layer, scene->instancers.data[i].orientations);
        use(scene->layer, scene->instancers.data[i].scales);
    }
}

/* ---- the scene ---- */

/* Why there is no mesh, and what helps. */
static tulle_status fail_empty(const usd_layer *layer, tulle_error *error) {
    const usd_passed *const passed = &layer->passed;
    const char *const path = layer->text.path;
    if (passed->other_files > 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, passed->file_place.line,
                            passed->file_place.column,
                            "shows no meshes; @%.100s@ and other files that it refers to are not "
                            "read: write all into one file, as usdcat --flatten does",
                            usd_layer_get_text(layer, passed->first_file));
    if (passed->shapes > 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "shows no meshes; shapes as spheres and curves, of which it has %zu, "
                            "are not read: make meshes of them",
                            passed->shapes);
    if (passed->hidden > 0)
        return error_set_at(
            error, TULLE_ERROR_PARSE, path, 0, 0,
            "shows no meshes; %zu prims are hidden: set visibility or purpose to show them",
            passed->hidden);
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "shows no meshes; it needs a Mesh with points and faces, defined by `def`");
}

tulle_status usd_scene_read(usd_layer *layer, usd_scene *scene, tulle_error *error) {
    *scene = (usd_scene){
        .layer = layer,
        .cutter = {.heap = layer->text.heap, .path = layer->text.path, .place = "face"}};
    tulle_status status = TULLE_OK;
    uint32_t prim = layer->prims.data[0].first_child;
    for (; prim != USD_NONE && status == TULLE_OK; prim = layer->prims.data[prim].next)
        status = build_prim(scene, USD_NONE, prim, 0, error);
    if (status) return status;
    if (scene->vertex_count == 0) return fail_empty(layer, error);
    mark_used(scene);
    status = usd_scene_make_frames(scene, error);
    if (status == TULLE_OK) status = usd_scene_turn(scene, error);
    return status == TULLE_OK ? usd_scene_add_frames(scene, error) : status;
}

void usd_scene_destroy(usd_scene *scene) {
    if (!scene->layer) return;
    memory *const heap = scene->layer->text.heap;
    ARRAY_FREE(heap, &scene->specs);
    ARRAY_FREE(heap, &scene->nodes);
    ARRAY_FREE(heap, &scene->ops);
    ARRAY_FREE(heap, &scene->pieces);
    ARRAY_FREE(heap, &scene->instancers);
    ARRAY_FREE(heap, &scene->instances);
    ARRAY_FREE(heap, &scene->triangles);
    ARRAY_FREE(heap, &scene->fans);
    ARRAY_FREE(heap, &scene->kept);
    ARRAY_FREE(heap, &scene->codes);
    ARRAY_FREE(heap, &scene->frames);
    ARRAY_FREE(heap, &scene->scratch);
    polygon_cutter_destroy(&scene->cutter);
    *scene = (usd_scene){0};
}
