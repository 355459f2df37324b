/* The reader of VTP files: every encoding, byte order, header and type gives the same mesh; files
 * cut short, with bits flipped, or with sizes that are not true are refused without a crash, and
 * without memory beyond a multiple of the file. The files are made here, by an encoder of the
 * test's own; that the reader understands VTK's own files was seen beside it. */
#define _POSIX_C_SOURCE 200809L
#include "io/vtk/vtp_read.h"

#include "support/comma_locale.h"
#include "tulle_io/mesh_files.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <zlib.h>

enum { FILE_MAX = 1 << 16, POINT_COUNT = 6, CORNER_COUNT = 10, POLYGON_COUNT = 3 };

/* A quadrilateral and two triangles: four triangles once they are fans. */
static const double points[3 * POINT_COUNT] = {
    0, 0, 0, 1, 0, -0.0, 1.1, 1, 1e-300, 0.1, 1, 0.3333333333333333, -2, 0.5, 7e200, 3, 3, 3};
static const uint64_t corners[CORNER_COUNT] = {0, 1, 2, 3, 1, 4, 2, 5, 3, 0};
static const uint64_t ends[POLYGON_COUNT] = {4, 7, 10};
static const uint32_t fans[12] = {0, 1, 2, 0, 2, 3, 1, 4, 2, 5, 3, 0};

typedef enum encoding { TEXT, INLINE, RAW, APPENDED_BASE64, ENCODING_COUNT } encoding;

typedef struct file_form {
    encoding encoding;
    int is_big_endian, header_size, is_packed, block_size;
    const char *point_type, *index_type;
    int piece_count;
} file_form;

typedef struct buffer {
    unsigned char bytes[FILE_MAX];
    size_t count;
} buffer;

static buffer file, appended;

static void add(buffer *to, const void *bytes, size_t count) {
    assert_true(to->count + count < FILE_MAX);
    memcpy(to->bytes + to->count, bytes, count);
    to->count += count;
}

static void add_text(buffer *to, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add_text(buffer *to, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    int const length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    add(to, text, (size_t)length);
}

static void add_number(buffer *to, const file_form *form, uint64_t value, int size) {
    for (int i = 0; i < size; i++) {
        int const shift = 8 * (form->is_big_endian ? size - 1 - i : i);
        unsigned char const byte = (unsigned char)(value >> shift);
        add(to, &byte, 1);
    }
}

static void add_base64(buffer *to, const buffer *from) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < from->count; i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; k++)
            bits = bits << 8 | (i + k < from->count ? from->bytes[i + k] : 0);
        for (size_t k = 0; k < 4; k++) {
            char const letter = letters[bits >> (18 - 6 * k) & 63];
            add(to, i + k <= from->count ? &letter : "=", 1);
        }
    }
}

static int get_size(const char *type) {
    if (strstr(type, "64")) return 8;
    if (strstr(type, "32")) return 4;
    return strstr(type, "16") ? 2 : 1;
}

/* The values as the file's bytes, without header. */
static void pack_values(buffer *to, const file_form *form, const char *type, const double *reals,
                        const uint64_t *wholes, size_t count) {
    to->count = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits = reals ? 0 : wholes[i];
        float const single = reals ? (float)reals[i] : 0.0f;
        if (reals && strcmp(type, "Float64") == 0) memcpy(&bits, &reals[i], 8);
        if (reals && strcmp(type, "Float32") == 0) memcpy(&bits, &single, 4);
        add_number(to, form, bits, get_size(type));
    }
}

/* Header and data as the file has them, encoded. */
static void encode(buffer *to, const file_form *form, const buffer *values) {
    static buffer header, data;
    bool const is_raw = form->encoding == RAW;
    header.count = data.count = 0;
    if (!form->is_packed) {
        add_number(&header, form, values->count, form->header_size);
        add(&header, values->bytes, values->count);
    } else {
        size_t const size = (size_t)form->block_size;
        size_t const count = (values->count + size - 1) / size;
        add_number(&header, form, count, form->header_size);
        add_number(&header, form, size, form->header_size);
        add_number(&header, form, values->count % size, form->header_size);
        for (size_t i = 0; i < values->count; i += size) {
            unsigned char packed[FILE_MAX];
            uLongf packed_size = sizeof packed;
            size_t const left = values->count - i;
            assert_int_equal(compress2(packed, &packed_size, values->bytes + i,
                                       (uLong)(left < size ? left : size), 6),
                             Z_OK);
            add_number(&header, form, packed_size, form->header_size);
            add(&data, packed, packed_size);
        }
    }
    if (is_raw) {
        add(to, header.bytes, header.count);
        add(to, data.bytes, data.count);
    } else {
        add_base64(to, &header);
        add_base64(to, &data);
    }
}

static void write_array(const file_form *form, const char *type, const char *name,
                        const double *reals, const uint64_t *wholes, size_t count) {
    static const char *const formats[ENCODING_COUNT] = {"ascii", "binary", "appended", "appended"};
    static buffer values;
    add_text(&file, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"%s\"",
             type, name, reals ? 3 : 1, formats[form->encoding]);
    pack_values(&values, form, type, reals, wholes, count);
    if (form->encoding == RAW || form->encoding == APPENDED_BASE64) {
        add_text(&file, " offset=\"%zu\"/>\n", appended.count);
        encode(&appended, form, &values);
        return;
    }
    add_text(&file, ">\n");
    if (form->encoding == INLINE) encode(&file, form, &values);
    for (size_t i = 0; i < count && form->encoding == TEXT; i++) {
        if (reals)
            add_text(&file, "%.17g\n", reals[i]);
        else
            add_text(&file, "%llu ", (unsigned long long)wholes[i]);
    }
    /* VTK puts such elements beside the data. */
    add_text(&file, "\n<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\"><Value "
                    "index=\"0\">7</Value></InformationKey></DataArray>\n");
}

static void write_piece(const file_form *form) {
    add_text(&file,
             "<Piece NumberOfPoints=\"%d\" NumberOfVerts=\"2\" NumberOfLines=\"1\" "
             "NumberOfStrips=\"0\" NumberOfPolys=\"%d\">\n",
             POINT_COUNT, POLYGON_COUNT);
    add_text(&file, "<PointData><DataArray type=\"String\" Name=\"a\" format=\"ascii\">x &lt; y"
                    "</DataArray></PointData>\n<Points>");
    write_array(form, form->point_type, "Points", points, NULL, 3 * POINT_COUNT);
    add_text(&file, "</Points><Lines><DataArray type=\"Int64\" Name=\"connectivity\" "
                    "format=\"ascii\">0 99</DataArray></Lines><Polys>\n");
    write_array(form, form->index_type, "connectivity", NULL, corners, CORNER_COUNT);
    write_array(form, form->index_type, "offsets", NULL, ends, POLYGON_COUNT);
    add_text(&file, "</Polys></Piece>\n");
}

static void write_file(const file_form *form) {
    file.count = appended.count = 0;
    add_text(&file,
             "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
             "byte_order=\"%s\" header_type=\"%s\"%s>\n<PolyData>\n",
             form->is_big_endian ? "BigEndian" : "LittleEndian",
             form->header_size == 8 ? "UInt64" : "UInt32",
             form->is_packed ? " compressor=\"vtkZLibDataCompressor\"" : "");
    for (int i = 0; i < form->piece_count; i++) write_piece(form);
    add_text(&file, "</PolyData>\n");
    if (appended.count > 0) {
        add_text(&file, "<AppendedData encoding=\"%s\">\n _",
                 form->encoding == RAW ? "raw" : "base64");
        add(&file, appended.bytes, appended.count);
        add_text(&file, "\n</AppendedData>\n");
    }
    add_text(&file, "</VTKFile>\n");
}

static tulle_status read_bytes(const buffer *from, tulle_mesh *mesh, tulle_error *error) {
    tulle_vtp_passed_over passed;
    *mesh = (tulle_mesh){0};
    return vtp_read_memory("a.vtp", (const char *)from->bytes, from->count, mesh, &passed, error);
}

static void expect_mesh(const file_form *form) {
    tulle_mesh mesh;
    tulle_error error = {0};
    if (read_bytes(&file, &mesh, &error) != TULLE_OK)
        fail_msg("encoding %d, big endian %d, header %d, packed %d, %s, %s: line %d: %s",
                 (int)form->encoding, form->is_big_endian, form->header_size, form->is_packed,
                 form->point_type, form->index_type, error.line, error.message);
    size_t const pieces = (size_t)form->piece_count;
    assert_int_equal(mesh.vertex_count, POINT_COUNT * pieces);
    assert_int_equal(mesh.triangle_count, 4 * pieces);
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
        double const expected = points[i % (3 * POINT_COUNT)];
        double const kept =
            strcmp(form->point_type, "Float32") == 0 ? (double)(float)expected : expected;
        assert_memory_equal(&mesh.positions[i], &kept, sizeof kept);
    }
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        assert_int_equal(mesh.triangles[i], fans[i % 12] + POINT_COUNT * (i / 12));
    tulle_mesh_destroy(&mesh);
}

/* An L, and a polygon that crosses itself, which is told. */
static void polygons_are_cut_within(void **unused) {
    (void)unused;
    tulle_mesh mesh;
    tulle_error error = {0};
    tulle_vtp_passed_over passed;
    static const char text[] =
        "<VTKFile type=\"PolyData\" version=\"1.0\"><PolyData><Piece NumberOfPoints=\"6\" "
        "NumberOfPolys=\"2\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
        "format=\"ascii\">0 0 0 2 0 0 2 1 0 1 1 0 1 2 0 0 2 0</DataArray></Points><Polys>"
        "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">1 2 3 4 5 0 0 2 1 5"
        "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">6 10</DataArray>"
        "</Polys></Piece></PolyData></VTKFile>";
    if (vtp_read_memory("l.vtp", text, strlen(text), &mesh, &passed, &error) != TULLE_OK)
        fail_msg("%d: %s", error.line, error.message);
    double area = 0.0;
    for (size_t i = 0; i < 4; i++) {
        const double *const a = mesh.positions + 3 * mesh.triangles[3 * i],
                            *const b = mesh.positions + 3 * mesh.triangles[3 * i + 1],
                            *const c = mesh.positions + 3 * mesh.triangles[3 * i + 2];
        double const part = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert_true(part > 0.1);
        area += 0.5 * part;
    }
    assert_true(area == 3.0);
    assert_string_equal(passed.polygons, "1 polygon crosses itself or has no area (polygon 1)");
    tulle_mesh_destroy(&mesh);
}

static const char *const index_types[] = {"Int8",  "UInt8",  "Int16", "UInt16",
                                          "Int32", "UInt32", "Int64", "UInt64"};

static void every_form_gives_the_mesh(void **unused) {
    (void)unused;
    static const int block_sizes[] = {8, 40, 1 << 15};
    for (int k = 0; k < ENCODING_COUNT * 2 * 2 * 4 * 8; k++) {
        int const packing = k / 16 % 4;
        file_form const form = {.encoding = (encoding)(k % ENCODING_COUNT),
                                .is_big_endian = k / 4 % 2,
                                .header_size = k / 8 % 2 ? 8 : 4,
                                .is_packed = packing > 0,
                                .block_size = packing > 0 ? block_sizes[packing - 1] : 0,
                                .point_type = "Float64",
                                .index_type = index_types[k / 64],
                                .piece_count = 1 + k % 3};
        write_file(&form);
        expect_mesh(&form);
    }
}

static void a_decimal_comma_changes_nothing(void **unused) {
    (void)unused;
    file_form const form = {
        .header_size = 4, .point_type = "Float64", .index_type = "Int64", .piece_count = 1};
    write_file(&form);
    use_decimal_comma();
    expect_mesh(&form);
    use_decimal_point();
}

static void floats_are_read(void **unused) {
    (void)unused;
    /* 7e200 is beyond float: the reader must say so, and where. */
    file_form const form = {.encoding = RAW,
                            .header_size = 4,
                            .point_type = "Float32",
                            .index_type = "Int32",
                            .piece_count = 1};
    write_file(&form);
    tulle_mesh mesh;
    tulle_error error = {0};
    assert_int_equal(read_bytes(&file, &mesh, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "value 14 is not a finite number"));
    /* The third coordinate of point 4 is the 15th number: 1 in its place. */
    size_t at = 0;
    while (memcmp(file.bytes + at, "\n _", 3) != 0) at++;
    at += 3 + 4 + 14 * 4;
    memcpy(file.bytes + at, "\0\0\200\077", 4);
    assert_int_equal(read_bytes(&file, &mesh, &error), TULLE_OK);
    assert_true(mesh.positions[14] == 1.0);
    assert_true(mesh.positions[6] == (double)1.1f);
    tulle_mesh_destroy(&mesh);
}

static void own_files_come_back(void **unused) {
    (void)unused;
    char path[] = "/tmp/tulle-vtp-XXXXXX";
    int const descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    close(descriptor);
    tulle_mesh_view const view = {points, POINT_COUNT, fans, 4};
    assert_int_equal(tulle_vtp_write(path, view, points, NULL), TULLE_OK);
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    if (tulle_vtp_read(path, &mesh, NULL, &error) != TULLE_OK) fail_msg("%s", error.message);
    assert_memory_equal(mesh.positions, points, sizeof points);
    assert_memory_equal(mesh.triangles, fans, sizeof fans);
    tulle_mesh_destroy(&mesh);
    unlink(path);
}

/* ---- faults ---- */

/* Whatever the bytes are: a mesh whose indices are in range and whose numbers are finite, or an
 * error with a message. */
static tulle_status expect_sound(const buffer *from) {
    tulle_mesh mesh;
    tulle_error error = {0};
    tulle_status const status = read_bytes(from, &mesh, &error);
    if (status != TULLE_OK) {
        assert_true(error.message[0] != '\0');
        assert_null(mesh.positions);
        return status;
    }
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) assert_true(isfinite(mesh.positions[i]));
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        assert_true(mesh.triangles[i] < mesh.vertex_count);
    tulle_mesh_destroy(&mesh);
    return status;
}

static file_form make_fault_form(int k) {
    return (file_form){.encoding = (encoding)(k % ENCODING_COUNT),
                       .header_size = k / 8 % 2 ? 8 : 4,
                       .is_packed = k / 4 % 2,
                       .block_size = 64,
                       .point_type = "Float64",
                       .index_type = "Int32",
                       .piece_count = 1};
}

static void truncated_files_are_refused(void **unused) {
    (void)unused;
    for (int k = 0; k < 16; k++) {
        file_form const form = make_fault_form(k);
        write_file(&form);
        static buffer cut;
        size_t const whole = file.count;
        memcpy(cut.bytes, file.bytes, whole);
        /* Behind appended data the closing tags, and the last line end, are not needed. */
        static const char tail[] = "\n</AppendedData>\n</VTKFile>\n";
        bool const is_appended = form.encoding == RAW || form.encoding == APPENDED_BASE64;
        size_t const needed = whole - (is_appended ? sizeof tail - 1 : 1);
        for (size_t count = 0; count < whole; count++) {
            cut.count = count;
            tulle_status const status = expect_sound(&cut);
            if (count < needed && status == TULLE_OK)
                fail_msg("form %d: %zu of %zu bytes are taken for a file", k, count, whole);
        }
    }
}

/* Two bits of each byte in turn, in the long form all. */
static void flipped_bits_do_no_harm(void **unused) {
    (void)unused;
    size_t const step = getenv("TULLE_TEST_LONG") ? 1 : 4;
    size_t refused = 0, tried = 0;
    for (int k = 0; k < 16; k++) {
        file_form const form = make_fault_form(k);
        write_file(&form);
        static buffer flipped;
        memcpy(flipped.bytes, file.bytes, file.count);
        flipped.count = file.count;
        for (size_t i = 0; i < file.count; i++) {
            for (size_t bit = i % step; bit < 8; bit += step) {
                flipped.bytes[i] = (unsigned char)(file.bytes[i] ^ 1u << bit);
                refused += expect_sound(&flipped) != TULLE_OK;
                tried++;
            }
            flipped.bytes[i] = file.bytes[i];
        }
    }
    /* Most of a file is structure or checked by zlib. */
    assert_true(refused > tried / 4);
}

/* Replaces `old` in the file by `new`, and expects a refusal that holds `reason`. */
static void expect_refusal(const file_form *form, const char *old, const char *new,
                           const char *reason) {
    write_file(form);
    static buffer changed;
    changed.count = 0;
    size_t const length = strlen(old);
    size_t at = 0;
    while (at + length <= file.count && memcmp(file.bytes + at, old, length) != 0) at++;
    if (at + length > file.count) fail_msg("there is no \"%s\" in the file", old);
    add(&changed, file.bytes, at);
    add(&changed, new, strlen(new));
    add(&changed, file.bytes + at + length, file.count - at - length);
    tulle_mesh mesh;
    tulle_error error = {0};
    tulle_status const status = read_bytes(&changed, &mesh, &error);
    if (status == TULLE_OK) fail_msg("\"%s\" for \"%s\" is accepted", new, old);
    if (!strstr(error.message, reason))
        fail_msg("\"%s\" for \"%s\": no \"%s\" in: %s", new, old, reason, error.message);
    assert_string_equal(error.file, "a.vtp");
}

static void wrong_sizes_are_named(void **unused) {
    (void)unused;
    for (int k = 0; k < 8; k++) {
        file_form const form = make_fault_form(k);
        static const char *const counts[] = {"7",
                                             "2000000000",
                                             "4000000000",
                                             "9000000000000000000",
                                             "99999999999999999999",
                                             "-1",
                                             "6x",
                                             ""};
        for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
            char changed[80];
            snprintf(changed, sizeof changed, "NumberOfPoints=\"%s\"", counts[i]);
            expect_refusal(&form, "NumberOfPoints=\"6\"", changed, "");
            snprintf(changed, sizeof changed, "NumberOfPolys=\"%s\"", counts[i]);
            expect_refusal(&form, "NumberOfPolys=\"3\"", changed, "");
        }
    }
}

static void refusals_say_why(void **unused) {
    (void)unused;
    file_form const text = make_fault_form(0), raw = make_fault_form(2),
                    packed = make_fault_form(6);
    file_form const base64 = make_fault_form(1);
    expect_refusal(&text, "type=\"PolyData\"", "type=\"UnstructuredGrid\"", "only PolyData");
    expect_refusal(&text, "<VTKFile", "<html", "not a VTK XML file");
    expect_refusal(&text, "<?xml version=\"1.0\"?>",
                   "<!DOCTYPE a [<!ENTITY b \"b\"><!ENTITY c \"&b;&b;\">]>",
                   "document type declaration");
    expect_refusal(&packed, "vtkZLib", "vtkLZ4", "choose ZLib or None");
    expect_refusal(&raw, "LittleEndian", "MiddleEndian", "LittleEndian or BigEndian");
    expect_refusal(&raw, "UInt32\"", "UInt16\"", "UInt32 or UInt64");
    expect_refusal(&raw, "LittleEndian", "BigEndian", "");
    expect_refusal(&text, "NumberOfStrips=\"0\"", "NumberOfStrips=\"1\"", "triangle strips");
    expect_refusal(&text, "NumberOfComponents=\"3\"", "NumberOfComponents=\"2\"", "should have");
    expect_refusal(&text, "\"offsets\"", "\"offset\"", "lacks the array connectivity or offsets");
    expect_refusal(&text, "Float64", "Float16", "Float32 or Float64");
    expect_refusal(&text, "Int32\" Name=\"conn", "Float32\" Name=\"conn", "whole numbers");
    expect_refusal(&text, "0 1 2 3 1 4 2 5 3 0", "0 1 2 3 1 4 2 6 3 0", "value 7 is 6");
    expect_refusal(&text, "0 1 2 3 1 4 2 5 3 0", "0 1 2 3 1 4 2 -5 3 0", "value 7 is -5");
    expect_refusal(&text, "0 1 2 3 1 4 2 5 3 0", "0 1 2 3 1 4 2 5 3", "has 9 values");
    expect_refusal(&text, "0 1 2 3 1 4 2 5 3 0", "0 1 2 3 1 4 2 5 3 0 0", "more than its 10");
    expect_refusal(&text, "0 1 2 3 1 4 2 5 3 0", "0 1 2 3 1 4 x 5 3 0", "value 6 is \"x");
    expect_refusal(&text, "0 1 2 3 1 4 2 5 3 0", "0 1 2 3 1 4 2.5 5 3 0", "value 6 is \"2.5");
    expect_refusal(&text, "4 7 10", "4 6 10", "polygon 1 goes from corner 4 to 6");
    expect_refusal(&text, "4 7 10", "4 3 10", "polygon 1 goes");
    expect_refusal(&text, "4 7 10", "4 7 9999999999", "polygon 2 goes");
    expect_refusal(&text, "4 7 10", "4 7 1000000000", "room for");
    expect_refusal(&text, "1.1000000000000001", "inf", "value 6 is \"inf\", not a finite number");
    expect_refusal(&text, "1.1000000000000001", "1e999",
                   "value 6 is \"1e999\", not a finite number");
    expect_refusal(&text, "1.1000000000000001", "1,5", "value 6 is \"1,5\", not a finite");
    expect_refusal(&text, "</PolyData>", "</Polydata>", "cut short or no XML");
    expect_refusal(&base64, ">\nkA", ">\n?A", "base64");
    expect_refusal(&raw, "offset=\"0\"", "offset=\"999999\"", "its offset is 999999");
    expect_refusal(&raw, "offset=\"0\"", "offset=\"1\"", "its header says");
    expect_refusal(&raw, "<AppendedData", "<AppendedDate", "");
    expect_refusal(&raw, " _", "  ", "underscore");
    expect_refusal(&raw, "offset=\"0\"", "ofset=\"0\"", "has no offset");
}

/* 128 MiB of zeros in 130 KiB would be a mesh of some 5 million points. */
static void little_files_take_little_memory(void **unused) {
    (void)unused;
    static unsigned char zeros[1 << 20];
    static unsigned char packed[1 << 12];
    uLongf packed_size = sizeof packed;
    assert_int_equal(compress2(packed, &packed_size, zeros, sizeof zeros, 9), Z_OK);
    enum { BLOCKS = 48 };
    file_form const form = {.header_size = 4};
    file.count = 0;
    add_text(&file,
             "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" "
             "compressor=\"vtkZLibDataCompressor\"><PolyData><Piece NumberOfPoints=\"%d\" "
             "NumberOfPolys=\"0\"><Points><DataArray type=\"Float64\" "
             "NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points></Piece>"
             "</PolyData><AppendedData encoding=\"raw\">_",
             BLOCKS * (1 << 20) / 24);
    add_number(&file, &form, BLOCKS, 4);
    add_number(&file, &form, sizeof zeros, 4);
    add_number(&file, &form, 0, 4);
    for (int i = 0; i < BLOCKS; i++) add_number(&file, &form, packed_size, 4);
    for (int i = 0; i < BLOCKS; i++) add(&file, packed, packed_size);
    tulle_mesh mesh;
    tulle_error error = {0};
    tulle_status const status = read_bytes(&file, &mesh, &error);
    if (status != TULLE_ERROR_LIMIT && status != TULLE_ERROR_PARSE)
        fail_msg("status %d: %s", (int)status, error.message);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_form_gives_the_mesh),
        cmocka_unit_test(polygons_are_cut_within),
        cmocka_unit_test(a_decimal_comma_changes_nothing),
        cmocka_unit_test(floats_are_read),
        cmocka_unit_test(own_files_come_back),
        cmocka_unit_test(truncated_files_are_refused),
        cmocka_unit_test(flipped_bits_do_no_harm),
        cmocka_unit_test(wrong_sizes_are_named),
        cmocka_unit_test(refusals_say_why),
        cmocka_unit_test(little_files_take_little_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
