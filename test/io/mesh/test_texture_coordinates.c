/* Texture coordinates of OBJ and PLY: of each corner of each triangle, whatever the order of
 * statements; what is wrong with them is no error of the mesh. */
#define _XOPEN_SOURCE 700
#include "io/io_support.h"
#include "tulle_io/mesh_files.h"

#include <math.h>
#include <stdbool.h>

#define NO (double)NAN
enum { MOST_TRIANGLES = 3 };

typedef struct dressed {
    const char *name, *text;
    size_t triangle_count; /* 0: no corner has any */
    double uvs[6 * MOST_TRIANGLES];
} dressed;

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
#define PLY_HEAD(properties)                                                                       \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float " \
    "z\n" properties "element face 1\nproperty list uchar int vertex_indices\nend_header\n"

static const dressed cases[] = {
    {"quad.obj",
     SQUARE "vt 0 0\nvt 2 0\nvt 2 3\nvt 0 3\nf 1/1 2/2 3/3 4/4\n",
     2,
     {0, 0, 2, 0, 2, 3, 0, 0, 2, 3, 0, 3}},
    /* A seam: corners of one vertex differ. Numbers from the end; vt after f; a third number. */
    {"seam.obj",
     SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nf 1/-3/1 2/-2/1 3/-1/1\nvn 0 0 1\nf 1/4 3/5/1 4/6\nvt 5 5\n"
            "vt 6 6 0\nvt 5 6\n",
     2,
     {0, 0, 1, 0, 1, 1, 5, 5, 6, 6, 5, 6}},
    {"some.obj",
     SQUARE "vt 1\nvt x 2\nf 1/1 2 3//1\nf 1/2 3/9 4/-8\n",
     2,
     {1, 0, NO, NO, NO, NO, NO, 2, NO, NO, NO, NO}},
    {"none.obj", SQUARE "vt 1 1\nf 1 2 3\n", 0, {0}},
    {"bare.obj", SQUARE "f 1 2 3\n", 0, {0}},
    {"st.ply",
     PLY_HEAD("property float s\nproperty double t\n") "0 0 0 0 1\n1 0 0 2 3\n1 1 0 4 5\n3 0 1 2\n",
     1,
     {0, 1, 2, 3, 4, 5}},
    {"both.ply",
     PLY_HEAD(
         "property float texture_v\nproperty float u\nproperty float s\n") "0 0 0 1 0 9\n1 0 0 3 2 "
                                                                           "9\n1 1 0 nan 4 9\n3 0 "
                                                                           "1 2\n",
     1,
     {0, 1, 2, 3, 4, NO}},
    {"bare.ply", PLY_HEAD("") "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n", 0, {0}},
};

static void corners_have_those_of_the_file(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const dressed *const wanted = &cases[i];
        put_text(test_path(wanted->name), wanted->text);
        tulle_mesh mesh = {0};
        tulle_mesh_source source;
        tulle_error error = {0};
        if (tulle_mesh_read_source(test_path(wanted->name), &mesh, &source, &error) != TULLE_OK)
            fail_msg("%s:%d:%d: %s", wanted->name, error.line, error.column, error.message);
        if ((source.corner_uvs == NULL) != (wanted->triangle_count == 0))
            fail_msg("%s: has texture coordinates or none", wanted->name);
        for (size_t k = 0; k < 6 * wanted->triangle_count; k++) {
            double const value = source.corner_uvs[k];
            bool const is_same =
                isnan(wanted->uvs[k]) ? isnan(value) : !(fabs(value - wanted->uvs[k]) > 0.0);
            if (!is_same || isnan(value) != isnan(wanted->uvs[k]))
                fail_msg("%s: number %zu is %g, not %g", wanted->name, k, value, wanted->uvs[k]);
        }
        assert_int_equal(source.triangle_count, mesh.triangle_count);
        tulle_mesh_source_destroy(&source);
        assert_null(source.corner_uvs);
        tulle_mesh_destroy(&mesh);
        /* Who does not ask gets the mesh alone. */
        assert_int_equal(tulle_mesh_read(test_path(wanted->name), &mesh, &error), TULLE_OK);
        tulle_mesh_destroy(&mesh);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(corners_have_those_of_the_file)};
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
