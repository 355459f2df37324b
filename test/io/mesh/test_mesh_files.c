/* OBJ, PLY and STL: what is read from hand-made files, round trips, messages of malformed ones. */
#define _XOPEN_SOURCE 700
#include "base/hash.h"
#include "io/bytes.h"

#include "io/io_support.h"
#include "tulle_io/mesh_files.h"

#include <math.h>

/* Reads a file with that text and expects these positions and triangles. */
static void assert_mesh(const char *path, const double *positions, size_t vertex_count,
                        const uint32_t *triangles, size_t triangle_count) {
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    tulle_status const status = tulle_mesh_read(path, &mesh, &error);
    if (status) fail_msg("%s:%d:%d: %s", path, error.line, error.column, error.message);
    assert_int_equal(mesh.vertex_count, vertex_count);
    assert_int_equal(mesh.triangle_count, triangle_count);
    for (size_t i = 0; i < 3 * vertex_count; i++) assert_true(mesh.positions[i] == positions[i]);
    for (size_t i = 0; i < 3 * triangle_count; i++)
        assert_int_equal(mesh.triangles[i], triangles[i]);
    tulle_mesh_destroy(&mesh);
}

static const double square[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const uint32_t square_fan[] = {0, 1, 2, 0, 2, 3};

static void assert_square(const char *name, const char *text) {
    put_text(test_path(name), text);
    assert_mesh(test_path(name), square, 4, square_fan, 2);
}

static void obj_in_many_dresses(void **state) {
    (void)state;
    assert_square("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    assert_square("b.OBJ", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1"); /* no last end */
    assert_square("c.obj", "# comment\r\nmtllib x.mtl\r\n\r\no thing\r\n"
                           "v 0 0 0\r\nv +1.0 0. 0\r\nv\t1e0  10E-1\t.0 \r\nv 0 1 0 1.0\r\n"
                           "vt 0 0\r\nvn 0 0 1\r\ng a b\r\nusemtl red\r\ns off\r\n"
                           "f 1/1 2/1/1 3//1 # fan\r\nf 1/1/ 3/ 4\r\nl 1 2\r\n");
    assert_square("d.obj", "v 0 0 0 1 0 0\rv 1 0 0 # right\rv 1 1 0\rv 0 1 0\rf 1 2 3\rf 1 3 4\r");
    assert_square("e.obj", "f 1 2 3\nf 1 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n");
    assert_square("f.obj", "v 0 \\\n 0 0\nv 1 0 0\\\r\n\nv 1 1 0\nv 0 1 0\nf 1 2\\\n 3 4\\");
}

/* An L with a corner on a straight side, before its vertices; its texture coordinates go along. A
 * polygon that crosses itself and one that is not flat keep their fans, and are told. */
static void polygons_are_cut_within(void **state) {
    (void)state;
    static const char *const heads[2] = {
        "f 5/5 6/6 7/7 1/1 2/2 3/3 4/4\nf 1 6 2 4\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\n"
        "v 0 2 0\nv 0 0.7 0\nv 1 1 1\nvt 0 0\nvt 2 0\nvt 2 1\nvt 1 1\nvt 1 2\nvt 0 2\n"
        "vt 0 0.7\nf 1 2 8 6\n",
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float "
        "z\nproperty float s\nproperty float t\nelement face 3\nproperty list uchar int "
        "vertex_index\nend_header\n0 0 0 0 0\n2 0 0 2 0\n2 1 0 2 1\n1 1 0 1 1\n1 2 0 1 2\n"
        "0 2 0 0 2\n0 0.7 0 0 0.7\n1 1 1 nan nan\n7 4 5 6 0 1 2 3\n4 0 5 1 3\n4 0 1 7 5\n"};
    static const char *const notes[2] = {
        "1 polygon is not flat (line 18), 1 polygon crosses itself "
        "or has no area (line 2)",
        "1 polygon is not flat (line 22), 1 polygon crosses itself "
        "or has no area (line 21)"};
    for (int i = 0; i < 2; i++) {
        const char *const path = test_path(i == 0 ? "l.obj" : "l.ply");
        put_text(path, heads[i]);
        tulle_mesh mesh = {0};
        tulle_mesh_source source;
        tulle_error error = {0};
        if (tulle_mesh_read_source(path, &mesh, &source, &error))
            fail_msg("%d: %s", error.line, error.message);
        assert_int_equal(mesh.triangle_count, 9);
        assert_string_equal(source.note, notes[i]);
        assert_true(source.has_passed_shape);
        double area = 0.0;
        for (size_t t = 0; t < 5; t++) {
            const double *x[3];
            for (size_t k = 0; k < 3; k++) {
                x[k] = mesh.positions + 3 * mesh.triangles[3 * t + k];
                double const u = source.corner_uvs[6 * t + 2 * k];
                double const v = source.corner_uvs[6 * t + 2 * k + 1];
                assert_true((float)u == (float)x[k][0] && (float)v == (float)x[k][1]);
            }
            double const part = (x[1][0] - x[0][0]) * (x[2][1] - x[0][1]) -
                                (x[1][1] - x[0][1]) * (x[2][0] - x[0][0]);
            assert_true(part > 0.1);
            area += 0.5 * part;
        }
        assert_true(fabs(area - 3.0) < 1e-6);
        tulle_mesh_source_destroy(&source);
        tulle_mesh_destroy(&mesh);
    }
}

/* As modellers and garment programs write them: kinds, numbers and first lines are noted. */
static void obj_statements_of_other_tools_are_noted(void **state) {
    (void)state;
    static const struct {
        const char *text, *note;
        int has_passed_shape;
    } cases[] = {
        {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "", 0},
        {"mtllib a.mtl\no x\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\n"
         "g front\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/1/1\ns off\nf 1//1 3//1 4//1\n",
         "passed over: 1 'mtllib' (line 1), 1 'o' (line 2), 1 'vn' (line 9), 1 "
         "'g' (line 10), 1 'usemtl' (line 11), 2 's' (line 12)",
         0},
        {"\xef\xbb\xbfv 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nl 1 2 \\\r\n3\r\nseam 1 2\r\n"
         "p 1\r\nl 3 4\r\nstitch 0.5 1 2\r\nf 1 2 3 4\r\n",
         "passed over: 2 'l' (the first in line 5), 1 'seam' (line 7), 1 'p' (line 8), 1 'stitch' "
         "(line 10)",
         1},
        {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nk1\nk2\nk3\nk4\nk5\nk6\nk7\nk8\nk9\nk10\nk11\nk12\n"
         "k13 x\nk1\nk14 x\nf 1 2 3 4\n",
         "passed over: 2 'k1' (the first in line 5), 1 'k2' (line 6), 1 'k3' (line 7), 1 'k4' "
         "(line "
         "8), 1 'k5' (line 9), 1 'k6' (line 10), 1 'k7' (line 11), 1 'k8' (line 12), 1 'k9' (line "
         "13), 1 'k10' (line 14), 1 'k11' (line 15), 1 'k12' (line 16), 2 of other kinds (line 17)",
         1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_square("noted.obj", cases[i].text);
        tulle_mesh mesh = {0};
        tulle_mesh_source source;
        assert_int_equal(tulle_mesh_read_source(test_path("noted.obj"), &mesh, &source, NULL),
                         TULLE_OK);
        assert_string_equal(source.note, cases[i].note);
        assert_int_equal(source.has_passed_shape, cases[i].has_passed_shape);
        tulle_mesh_source_destroy(&source);
        assert_null(source.vertex_lines);
        tulle_mesh_destroy(&mesh);
    }
}

/* Colors say nothing of the shape, whatever they are. */
static void colors_need_not_be_finite(void **state) {
    (void)state;
    assert_square("nan.obj", "v 0 0 0 nan nan nan\nv 1 0 0 -nan(ind) NaN +inf\n"
                             "v 1 1 0 1.#QNAN -1.#IND 1e999 1\nv 0 1 0 1\nf 1 2 3 4\n");
    tulle_mesh mesh = {0};
    tulle_mesh_source source;
    tulle_error error = {0};
    assert_int_equal(tulle_mesh_read_source(test_path("nan.obj"), &mesh, &source, &error), 0);
    assert_string_equal(source.note, "passed over: 3 'color of v' (the first in line 1)");
    assert_false(source.has_passed_shape);
    tulle_mesh_source_destroy(&source);
    tulle_mesh_destroy(&mesh);
    put_text(test_path("nan.obj"), "v 0 0 0 red\n");
    assert_int_equal(tulle_mesh_read(test_path("nan.obj"), &mesh, &error), TULLE_ERROR_PARSE);
    put_text(test_path("nan.obj"), "v 0 nan 0 1 1 1\n");
    assert_int_equal(tulle_mesh_read(test_path("nan.obj"), &mesh, &error), TULLE_ERROR_PARSE);
    assert_square("nan.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                             "property float y\nproperty float z\nproperty float red\n"
                             "element face 1\nproperty list uchar float uv\n"
                             "property list uchar int vertex_index\nend_header\n"
                             "0 0 0 nan\n1 0 0 nan\n1 1 0 inf\n0 1 0 0\n2 nan nan 4 0 1 2 3\n");
}

/* With a mark or without, either byte first. */
static void utf16_is_told(void **state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
    static const char *const names[] = {"u.obj", "u.ply", "u.stl"};
    for (int i = 0; i < 12; i++) {
        char wide[2 * sizeof text + 2] = {0};
        size_t const begin = i % 2 ? 2 : 0, last = i / 2 % 2 ? 1 : 0;
        if (begin) memcpy(wide, last ? "\xfe\xff" : "\xff\xfe", 2);
        for (size_t k = 0; k + 1 < sizeof text; k++) wide[begin + 2 * k + last] = text[k];
        put_file(test_path(names[i / 4]), wide, begin + 2 * (sizeof text - 1));
        tulle_mesh mesh = {0};
        tulle_error error = {0};
        assert_int_equal(tulle_mesh_read(test_path(names[i / 4]), &mesh, &error),
                         TULLE_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, "UTF-16"));
    }
}

/* Which triangles have a name by g, o and usemtl: a g has several names, an o and a usemtl one of
 * several words; each ends those of its kind. */
static void obj_parts_have_names(void **state) {
    (void)state;
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\no My  Shirt\t2 # cut\ng left  upper\n"
        "usemtl #ff00\nf 1 2 3 4\ng\nusemtl red \\\nwool\nf 1 2 3\ng empty\ng upper # x\n"
        "o\nf 2 3 4\nf 1 2 4\nusemtl last\n";
    static const struct {
        const char *name;
        tulle_mesh_part_kind kind;
        size_t first, count;
    } parts[] = {
        {"left", TULLE_MESH_PART_GROUP, 1, 2},        {"upper", TULLE_MESH_PART_GROUP, 1, 2},
        {"#ff00", TULLE_MESH_PART_MATERIAL, 1, 2},    {"My Shirt 2", TULLE_MESH_PART_GROUP, 1, 3},
        {"red wool", TULLE_MESH_PART_MATERIAL, 3, 3}, {"upper", TULLE_MESH_PART_GROUP, 4, 2}};
    put_text(test_path("parts.obj"), text);
    tulle_mesh mesh = {0};
    tulle_mesh_source source;
    assert_int_equal(tulle_mesh_read_source(test_path("parts.obj"), &mesh, &source, NULL),
                     TULLE_OK);
    assert_int_equal(mesh.triangle_count, 6);
    assert_int_equal(source.part_count, sizeof parts / sizeof parts[0]);
    for (size_t i = 0; i < source.part_count; i++) {
        assert_string_equal(source.parts[i].name, parts[i].name);
        assert_int_equal(source.parts[i].kind, parts[i].kind);
        assert_int_equal(source.parts[i].first, parts[i].first);
        assert_int_equal(source.parts[i].count, parts[i].count);
    }
    tulle_mesh_source_destroy(&source);
    tulle_mesh_destroy(&mesh);
    /* Without faces, or without names, nothing has a name. */
    static const char *const without[] = {"v 0 0 0\ng a\nusemtl b\n",
                                          "v 0 0 0\nv 1 0 0\nv 1 1 0\ng\nusemtl\nf 1 2 3\n"};
    for (size_t i = 0; i < 2; i++) {
        put_text(test_path("parts.obj"), without[i]);
        assert_int_equal(tulle_mesh_read_source(test_path("parts.obj"), &mesh, &source, NULL),
                         TULLE_OK);
        assert_true(source.part_count == 0 && !source.parts && !source.part_names);
        tulle_mesh_source_destroy(&source);
        tulle_mesh_destroy(&mesh);
    }
}

/* Many names and many statements: each name ends once, so the time grows with the file. */
static void obj_parts_cost_no_more_than_their_text(void **state) {
    (void)state;
    enum { NAME_COUNT = 200000 };
    char *const text = malloc(NAME_COUNT * 16 + 100), *end = text;
    assert_non_null(text);
    end += sprintf(end, "v 0 0 0\nv 1 0 0\nv 1 1 0\ng");
    for (int i = 0; i < NAME_COUNT; i++) end += sprintf(end, " n");
    end += sprintf(end, "\n");
    for (int i = 0; i < NAME_COUNT; i++) end += sprintf(end, "usemtl m\n");
    sprintf(end, "f 1 2 3\n");
    put_text(test_path("names.obj"), text);
    free(text);
    tulle_mesh mesh = {0};
    tulle_mesh_source source;
    assert_int_equal(tulle_mesh_read_source(test_path("names.obj"), &mesh, &source, NULL),
                     TULLE_OK);
    assert_int_equal(source.part_count, NAME_COUNT + 1);
    tulle_mesh_source_destroy(&source);
    tulle_mesh_destroy(&mesh);
}

/* What is wrong with a mesh is told with the lines of its file; other formats have none. */
static void obj_lines_are_kept_for_messages(void **state) {
    (void)state;
    put_text(test_path("lines.obj"), "# head\nv 0 0 0\nv 1 0 0\n\nv 1 1 0\nv 0 1 0\n"
                                     "f 1 2 \\\n3 4\nf 3 2 1\nf 1 3 4\n");
    tulle_mesh mesh = {0};
    tulle_mesh_source source;
    tulle_error error = {0};
    assert_int_equal(tulle_mesh_read_source(test_path("lines.obj"), &mesh, &source, &error),
                     TULLE_OK);
    uint32_t const vertex_lines[] = {2, 3, 5, 6}, triangle_lines[] = {7, 7, 9, 10};
    assert_int_equal(mesh.triangle_count, 4);
    assert_memory_equal(source.vertex_lines, vertex_lines, sizeof vertex_lines);
    assert_memory_equal(source.triangle_lines, triangle_lines, sizeof triangle_lines);
    tulle_mesh_lines const lines = {source.vertex_lines, source.triangle_lines};
    for (int role = 0; role < 2; role++) {
        assert_int_equal(tulle_mesh_validate_lines(tulle_mesh_get_view(&mesh),
                                                   (tulle_mesh_role)role, lines, &error),
                         TULLE_ERROR_INVALID_MESH);
        assert_int_equal(error.line, 9);
        assert_string_equal(error.message,
                            "triangle 2 (line 9) has the same three vertices as triangle 0 (line "
                            "7) (first vertex 2 (line 5) at (1, 1, 0)) (and 1 more like it); "
                            "remove duplicate triangles");
    }
    tulle_mesh_duplicates found;
    assert_int_equal(tulle_mesh_drop_duplicates(&mesh, source.triangle_lines, &found, &error),
                     TULLE_OK);
    assert_int_equal(found.count, 2);
    assert_int_equal(found.dropped, 2);
    assert_int_equal(found.original, 0);
    assert_int_equal(found.dropped_line, 9);
    assert_int_equal(found.original_line, 7);
    assert_int_equal(mesh.triangle_count, 2);
    assert_memory_equal(mesh.triangles, square_fan, sizeof square_fan);
    assert_int_equal(source.triangle_lines[1], 7);
    assert_int_equal(tulle_mesh_drop_duplicates(&mesh, NULL, &found, &error), TULLE_OK);
    assert_int_equal(found.count, 0);
    assert_int_equal(tulle_mesh_validate(tulle_mesh_get_view(&mesh), TULLE_MESH_ROLE_CLOTH, &error),
                     TULLE_OK);
    tulle_mesh_source_destroy(&source);
    assert_int_equal(tulle_mesh_write(test_path("lines.ply"), tulle_mesh_get_view(&mesh), &error),
                     TULLE_OK);
    tulle_mesh_destroy(&mesh);
    assert_int_equal(tulle_mesh_read_source(test_path("lines.ply"), &mesh, &source, &error),
                     TULLE_OK);
    assert_null(source.vertex_lines);
    assert_string_equal(source.note, "");
    tulle_mesh_destroy(&mesh);
}

/* One convex face with very many corners on one very long line, and numbers of very many digits. */
static void long_lines_are_read_in_linear_time(void **state) {
    (void)state;
    size_t const corner_count = 100000;
    char *const text = malloc(corner_count * 64);
    size_t length = 0;
    for (size_t i = 0; i < corner_count; i++)
        length += (size_t)sprintf(text + length, "v %zu 0.%025zu 0\n", i, i * i);
    text[length++] = 'f';
    for (size_t i = 1; i <= corner_count; i++) length += (size_t)sprintf(text + length, " %zu", i);
    put_file(test_path("long.obj"), text, length);
    free(text);
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_mesh_read(test_path("long.obj"), &mesh, NULL), TULLE_OK);
    assert_int_equal(mesh.vertex_count, corner_count);
    assert_int_equal(mesh.triangle_count, corner_count - 2);
    assert_int_equal(mesh.triangles[3 * (corner_count - 3) + 1], corner_count - 2);
    tulle_mesh_destroy(&mesh);
}

static void ply_text_with_other_elements(void **state) {
    (void)state;
    assert_square("a.ply", "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x\n"
                           "element camera 1\nproperty list uchar float matrix\nproperty int id\n"
                           "element vertex 4\nproperty uchar red\nproperty float x\n"
                           "property double y\nproperty int z\nproperty list int short extra\n"
                           "element face 1\nproperty float area\n"
                           "property list uchar int vertex_index\n"
                           "element edge 2\nproperty int a\nend_header\n"
                           "3 1 2 3 7\n"
                           "255 0 0 0 0\n255 1 0 0 1 5\n\n0 1 1.0 0 2 5 6\n0 0 1e0 0 0\n"
                           "0.5 4 0 1 2 3\n9\n8");
    put_text(test_path("windows.ply"),
             "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty int8 x\r\n"
             "property uint16 y\r\nproperty float64 z\r\nelement face 2\r\n"
             "property list uint8 uint32 vertex_indices\r\nend_header\r\n"
             "0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n3 0 1 2\r\n3 0 2 3\r\n");
    assert_mesh(test_path("windows.ply"), square, 4, square_fan, 2);
}

/* ---- binary PLY of every type ---- */

typedef struct byte_writer {
    unsigned char bytes[4096];
    size_t count;
    int is_big_endian;
} byte_writer;

static void add_bytes(byte_writer *writer, uint64_t value, size_t size) {
    for (size_t i = 0; i < size; i++) {
        size_t const shift = 8 * (writer->is_big_endian ? size - 1 - i : i);
        writer->bytes[writer->count++] = (unsigned char)(value >> shift);
    }
}

static void add_typed(byte_writer *writer, int type, double value) {
    static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    uint64_t bits = (uint64_t)(int64_t)value;
    if (type == 8) {
        float const single = (float)value;
        uint32_t word;
        memcpy(&word, &single, 4);
        bits = word;
    } else if (type == 9) {
        memcpy(&bits, &value, 8);
    }
    add_bytes(writer, bits, sizes[type]);
}

static void ply_binary_of_every_type_and_order(void **state) {
    (void)state;
    static const char *const names[] = {"char", "uchar", "short",  "ushort", "int",
                                        "uint", "int64", "uint64", "float",  "double"};
    for (int variant = 0; variant < 2 * 10 * 8; variant++) {
        int const type = variant / 2 % 10;
        int const index_type = variant / 20;
        byte_writer writer = {.is_big_endian = variant % 2};
        writer.count = (size_t)sprintf(
            (char *)writer.bytes,
            "ply\nformat binary_%s_endian 1.0\nelement skipped 2\nproperty short s\n"
            "property list ushort double l\nelement vertex 4\nproperty %s x\nproperty %s y\n"
            "property float w\nproperty %s z\nelement face 1\n"
            "property list %s %s vertex_indices\nproperty uchar c\nend_header\n",
            variant % 2 ? "big" : "little", names[type], names[type], names[type],
            names[index_type], names[index_type]);
        for (int i = 0; i < 2; i++) {
            add_bytes(&writer, 77, 2);
            add_bytes(&writer, (uint64_t)i, 2);
            if (i) add_typed(&writer, 9, 1.5);
        }
        double negative[12];
        for (int i = 0; i < 4; i++) {
            for (int axis = 0; axis < 3; axis++) {
                double const sign = type % 2 == 0 || type >= 8 ? -1.0 : 1.0;
                negative[3 * i + axis] = sign * square[3 * i + axis];
                if (axis == 2) add_typed(&writer, 8, 9.0);
                add_typed(&writer, type, negative[3 * i + axis]);
            }
        }
        add_typed(&writer, index_type, 4);
        for (int i = 0; i < 4; i++) add_typed(&writer, index_type, i);
        add_bytes(&writer, 1, 1);
        put_file(test_path("typed.ply"), writer.bytes, writer.count);
        assert_mesh(test_path("typed.ply"), negative, 4, square_fan, 2);
    }
}

static void stl_corners_are_merged(void **state) {
    (void)state;
    const char *const text =
        "solid some name\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n"
        "   vertex 1 1 0\n  endloop\n endfacet\n facet normal nan nan nan\r\n  outer loop\r\n"
        "   vertex -0.0 0 0\r\n   vertex 1 1 0\r\n   VERTEX 0 1e0 0\r\n  endloop\r\n endfacet\r\n"
        "endsolid some name";
    assert_square("a.stl", text);
    assert_square("no_extension", text);
    unsigned char bytes[84 + 100] = "solid is how some binary files begin too";
    bytes[80] = 2;
    for (size_t i = 0; i < 6; i++)
        for (size_t axis = 0; axis < 3; axis++)
            bytes_store_float(bytes + 84 + 50 * (i / 3) + 12 + 12 * (i % 3) + 4 * axis,
                              (float)square[3 * square_fan[i] + axis]);
    put_file(test_path("b.stl"), bytes, sizeof bytes);
    assert_mesh(test_path("b.stl"), square, 4, square_fan, 2);
}

/* ---- round trips ---- */

static tulle_mesh make_random_mesh(uint64_t seed) {
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_mesh_create(200, 300, &mesh, NULL), TULLE_OK);
    for (size_t i = 0; i < 600; i++)
        mesh.positions[i] =
            ldexp(random_uniform(&seed) - 0.5, (int)(random_uniform(&seed) * 60) - 30);
    for (size_t i = 0; i < 900; i++)
        mesh.triangles[i] = i < 200 ? (uint32_t)i : (uint32_t)(random_uniform(&seed) * 200.0);
    return mesh;
}

static void meshes_survive_writing(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        tulle_mesh mesh = make_random_mesh(seed);
        const char *const names[] = {"trip.obj", "trip.ply"};
        for (int i = 0; i < 2; i++) {
            const char *const path = test_path(names[i]);
            assert_int_equal(tulle_mesh_write(path, tulle_mesh_get_view(&mesh), NULL), TULLE_OK);
            assert_mesh(path, mesh.positions, 200, mesh.triangles, 300);
        }
        /* STL numbers vertices anew, in order of use, and keeps floats. */
        const char *const path = test_path("trip.stl");
        assert_int_equal(tulle_mesh_write(path, tulle_mesh_get_view(&mesh), NULL), TULLE_OK);
        tulle_mesh read = {0};
        assert_int_equal(tulle_mesh_read(path, &read, NULL), TULLE_OK);
        assert_int_equal(read.vertex_count, 200);
        assert_int_equal(read.triangle_count, 300);
        for (size_t i = 0; i < 900; i++)
            for (size_t axis = 0; axis < 3; axis++)
                assert_true(read.positions[3 * (size_t)read.triangles[i] + axis] ==
                            (double)(float)mesh.positions[3 * (size_t)mesh.triangles[i] + axis]);
        tulle_mesh_destroy(&read);
        tulle_mesh_destroy(&mesh);
    }
}

static void unwritable_meshes_create_nothing(void **state) {
    (void)state;
    assert_int_equal(mkdir(test_path("none"), 0777), 0);
    double positions[] = {0, 0, 0, 1, 0, 0, 0, 1, NAN};
    uint32_t triangles[] = {0, 1, 2};
    tulle_mesh_view const mesh = {positions, 3, triangles, 1};
    tulle_error error;
    assert_int_equal(tulle_mesh_write(test_path("none/a.obj"), mesh, &error),
                     TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "coordinate z of vertex 2"));
    positions[8] = 1e300; /* finite, but not as the float of an STL file */
    assert_int_equal(tulle_mesh_write(test_path("none/a.stl"), mesh, &error),
                     TULLE_ERROR_INVALID_MESH);
    triangles[1] = 3;
    assert_int_equal(tulle_mesh_write(test_path("none/a.obj"), mesh, &error),
                     TULLE_ERROR_INVALID_MESH);
    triangles[1] = 1;
    assert_int_equal(tulle_mesh_write(test_path("none/a.xyz"), mesh, &error),
                     TULLE_ERROR_UNSUPPORTED);
    assert_int_equal(count_files(test_path("none")), 0);
    assert_int_equal(tulle_mesh_write(test_path("missing/a.obj"), mesh, &error), TULLE_ERROR_IO);
}

/* ---- malformed files ---- */

typedef struct bad_file {
    const char *name, *text;
    int line, column;
    const char *message; /* part of it */
} bad_file;

#define PLY_START "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
#define PLY_REST                                                                                   \
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
#define STL_START "solid\nfacet normal 0 0 1\nouter loop\n"

static const bad_file bad_files[] = {
    {"e.obj", "", 0, 0, "is empty"},
    {"c.obj", "# only a comment\n", 0, 0, "holds no vertices"},
    {"x.obj", "v 0 0 0\nv 1 x 0\n", 2, 5, "y: \"x\" should be a finite number"},
    {"m.obj", "v 0 0\nv 1 1 0\n", 1, 6, "z is missing"},
    {"n.obj", "v 0 0 nan\n", 1, 7, "z: \"nan\" should be a finite number"},
    {"i.obj", "v 0 -inf 0\n", 1, 5, "should be a finite number"},
    {"big.obj", "v 0 1e999 0\n", 1, 5, "too large"},
    {"t.obj", "v 0 0 0 red\n", 1, 9, "only numbers"},
    {"w.obj", "vertex 1 2 3\nface 1 2 3\n", 0, 0, "holds no vertices"},
    {"r.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n", 5, 7, "there is no vertex 4"},
    {"r2.obj", "f 1 2 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 1, 7, "there is no vertex 9"},
    {"z.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", 4, 3, "there is no vertex \"0\""},
    {"neg.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", 4, 7, "there is no vertex \"-4\""},
    {"huge.obj", "v 0 0 0\nf 1 2 4294967297\n", 2, 7, "there is no vertex"},
    {"hug2.obj", "v 0 0 0\nf 1 2 99999999999999999999\n", 2, 7, "there is no vertex"},
    {"two.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", 3, 6, "at least 3 corners, this has 2"},
    {"s.obj", "v 0 0 0\nf 1/1/1/1 1 1\n", 2, 3, "should be a corner"},
    {"s2.obj", "v 0 0 0\nf 1/a 1 1\n", 2, 3, "should be a corner"},
    {"s3.obj", "v 0 0 0\nf 1.0 1 1\n", 2, 3, "should be a corner"},
    {"p.ply", "plyx\n", 1, 1, "begins with the line \"ply\""},
    {"f.ply", "ply\nformat utf8 1.0\n", 2, 8, "the format should be"},
    {"v.ply", "ply\nformat ascii 2.0\n", 2, 14, "version should be 1.0"},
    {"h.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", 4, 1, "ends within the header"},
    {"k.ply", "ply\nformat ascii 1.0\nelemnt vertex 3\n", 3, 1, "\"elemnt\" is not a keyword"},
    {"c.ply", "ply\nformat ascii 1.0\nelement vertex -3\n", 3, 16, "a name and a count"},
    {"c2.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n", 3, 16, "a count"},
    {"y.ply", "ply\nformat ascii 1.0\nproperty float x\n", 3, 9, "needs an element before"},
    {"ty.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty real x\n", 4, 10, "be a type"},
    {"lf.ply", PLY_START "property list float int a\n", 6, 20, "should have an integer type"},
    {"cf.ply", PLY_START "element face 1\nproperty list uchar float vertex_indices\n", 7, 27,
     "the corners of faces should have an integer type"},
    {"dup.ply", PLY_START "property float x\n", 6, 16, "property x is given twice"},
    {"noz.ply", PLY_START "end_header\n1 2\n", 6, 11, "no property z"},
    {"nof.ply", "ply\nformat ascii 1.0\nend_header\n", 3, 11, "one element vertex"},
    {"no.ply", PLY_START "property float z\nelement face 1\nproperty int a\nend_header\n", 9, 11,
     "no property list vertex_indices"},
    {"emp.ply",
     "ply\nformat ascii 1.0\nelement a 9\nelement vertex 1\nproperty int x\n"
     "property int y\nproperty int z\nend_header\n",
     8, 11, "has no properties"},
    {"ind.ply", PLY_START PLY_REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", 13, 6,
     "face 0, vertex_indices: 3 should be a whole number from 0 to 2"},
    {"ine.ply", PLY_START PLY_REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", 13, 6, "-1 should be"},
    {"inf.ply", PLY_START PLY_REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 0.5\n", 13, 6, "0.5 should be"},
    {"lin.ply", PLY_START PLY_REST "0 0 0\n1 0\n0 1 0\n3 0 1 2\n", 11, 4, "z is missing"},
    {"mor.ply", PLY_START PLY_REST "0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n", 11, 7, "more values"},
    {"two.ply", PLY_START PLY_REST "0 0 0\n1 0 0\n0 1 0\n2 0 1 2\n", 13, 2, "at least 3 corners"},
    {"nan.ply", PLY_START PLY_REST "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", 11, 3, "finite number"},
    {"end.ply", PLY_START PLY_REST "0 0 0\n1 0 0\n0 1 0\n", 13, 1, "the file ends here"},
    {"mid.ply", PLY_START PLY_REST "0 0 0\n1 0 0 \n        ", 12, 9, "the file ends here"},
    {"aft.ply", PLY_START PLY_REST "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", 0, 0, "follows"},
    {"n.stl", STL_START "vertex 0 0 0\nvertex 1 0 0\nvertex 0 nan 0\n", 6, 10, "finite number"},
    {"m.stl", STL_START "vertex 0 0 0\nvertex 1 0 0\nendloop\n", 6, 1, "should be \"vertex\""},
    {"e.stl", STL_START "vertex 0 0 0\nvertex 1 0 0", 5, 13, "the file ends where \"vertex\""},
    {"o.stl", "solid\nfacet normal 0 0\n", 2, 17, "a normal needs 3 numbers, this has 2"},
    {"v.stl", "solid\nendsolid\n", 0, 0, "holds no vertices"},
    {"u.stl", "solid\n", 2, 1, "\"facet\" or \"endsolid\""},
    {"b.stl", "neither of them", 0, 0, "neither a text STL"},
    {"unknown.dat", "some words", 0, 0, "its format is not known"},
    {"a.fbx", "some words", 0, 0, "is an FBX file, which is not read; export a mesh as .ply"},
    {"a.usdz", "some words", 0, 0, "is a packed USD file, which is not read"},
    {"a.glb", "some words", 0, 0, "is an animation, and a mesh is wanted here"},
};

static void messages_name_the_place(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof bad_files / sizeof bad_files[0]; i++) {
        const bad_file *const bad = &bad_files[i];
        const char *const path = test_path(bad->name);
        put_text(path, bad->text);
        tulle_mesh mesh = {0};
        tulle_error error = {0};
        tulle_status const status = tulle_mesh_read(path, &mesh, &error);
        if (status != (i < sizeof bad_files / sizeof bad_files[0] - 4 ? TULLE_ERROR_PARSE
                                                                      : TULLE_ERROR_UNSUPPORTED) ||
            error.status != status || error.line != bad->line || error.column != bad->column ||
            strcmp(error.file, path) != 0 || !strstr(error.message, bad->message))
            fail_msg("%s: got status %d, %d:%d: %s", bad->name, status, error.line, error.column,
                     error.message);
        assert_null(mesh.positions);
    }
}

/* More kinds of element, or more properties, than a header may have; and strips. */
static void headers_of_ply_have_limits(void **state) {
    (void)state;
    static const struct {
        const char *begin, *end, *message;
        int count, bad_line; /* lines of the header after the first two; the one that is refused */
        tulle_status status;
    } cases[] = {
        {"element e", " 0", "more than 32 kinds of element", 40, 35, TULLE_ERROR_PARSE},
        {"property int p", "", "more than 256 properties", 300, 260, TULLE_ERROR_PARSE},
        {"element tristrips ", "", "triangle strips cannot be read; convert them to faces", 1, 3,
         TULLE_ERROR_UNSUPPORTED},
    };
    const char *const path = test_path("limits.ply");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        FILE *const file = fopen(path, "w");
        assert_non_null(file);
        fputs("ply\nformat ascii 1.0\n", file);
        if (cases[i].begin[0] == 'p') fputs("element other 0\n", file);
        for (int k = 0; k < cases[i].count; k++)
            fprintf(file, "%s%d%s\n", cases[i].begin, k, cases[i].end);
        fclose(file);
        tulle_mesh mesh = {0};
        tulle_error error = {0};
        assert_int_equal(tulle_mesh_read(path, &mesh, &error), cases[i].status);
        assert_int_equal(error.line, cases[i].bad_line);
        assert_non_null(strstr(error.message, cases[i].message));
        assert_null(mesh.positions);
    }
}

static void what_is_no_file_is_refused(void **state) {
    (void)state;
    tulle_mesh mesh = {0};
    tulle_error error;
    assert_int_equal(tulle_mesh_read(test_path("missing.obj"), &mesh, &error), TULLE_ERROR_IO);
    assert_string_equal(error.file, test_path("missing.obj"));
    assert_non_null(strstr(error.message, "cannot be opened: No such file"));
    assert_int_equal(tulle_mesh_read(test_folder, &mesh, &error), TULLE_ERROR_IO);
    assert_int_equal(tulle_mesh_read("/dev/zero", &mesh, &error), TULLE_ERROR_IO);
    assert_int_equal(mkfifo(test_path("pipe.obj"), 0666), 0);
    assert_int_equal(tulle_mesh_read(test_path("pipe.obj"), &mesh, &error), TULLE_ERROR_IO);
    assert_int_equal(tulle_mesh_read(NULL, &mesh, &error), TULLE_ERROR_INVALID_ARGUMENT);
    put_text(test_path("sparse.stl"), "x");
    assert_int_equal(truncate(test_path("sparse.stl"), (off_t)1 << 35), 0);
    assert_int_equal(tulle_mesh_read(test_path("sparse.stl"), &mesh, &error), TULLE_ERROR_LIMIT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(obj_in_many_dresses),
        cmocka_unit_test(colors_need_not_be_finite),
        cmocka_unit_test(utf16_is_told),
        cmocka_unit_test(polygons_are_cut_within),
        cmocka_unit_test(obj_statements_of_other_tools_are_noted),
        cmocka_unit_test(obj_parts_have_names),
        cmocka_unit_test(obj_parts_cost_no_more_than_their_text),
        cmocka_unit_test(obj_lines_are_kept_for_messages),
        cmocka_unit_test(long_lines_are_read_in_linear_time),
        cmocka_unit_test(ply_text_with_other_elements),
        cmocka_unit_test(headers_of_ply_have_limits),
        cmocka_unit_test(ply_binary_of_every_type_and_order),
        cmocka_unit_test(stl_corners_are_merged),
        cmocka_unit_test(meshes_survive_writing),
        cmocka_unit_test(unwritable_meshes_create_nothing),
        cmocka_unit_test(messages_name_the_place),
        cmocka_unit_test(what_is_no_file_is_refused),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
