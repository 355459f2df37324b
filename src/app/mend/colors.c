/* app/mend/colors.c - see colors.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/mend/colors.h"

#include "base/error.h"
#include "io/file_data.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { PATH_SIZE = 4096 };

static void choose_color(double share, unsigned char color[3]) {
    static const double stops[3][3] = {{215, 215, 215}, {245, 190, 40}, {150, 10, 20}};
    double const place = 2.0 * fmin(fmax(share, 0.0), 1.0);
    size_t const stop = place < 1.0 ? 0 : 1;
    double const part = place - (double)stop;
    for (size_t k = 0; k < 3; k++)
        color[k] = (unsigned char)lround((1.0 - part) * stops[stop][k] + part * stops[stop + 1][k]);
}

/* Lowest byte first. */
static void put_bytes(FILE *file, uint64_t bits, int byte_count) {
    for (int i = 0; i < byte_count; i++) putc((int)(bits >> (8 * i) & 0xff), file);
}

static void put_double(FILE *file, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_bytes(file, bits, 8);
}

static void put_mesh(FILE *file, tulle_mesh_view mesh, const double *departures, double largest) {
    fprintf(file,
            "ply\nformat binary_little_endian 1.0\ncomment departures of tulle mend\n"
            "element vertex %zu\nproperty double x\nproperty double y\nproperty double z\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\n"
            "property double departure\nelement face %zu\n"
            "property list uchar int vertex_indices\nend_header\n",
            mesh.vertex_count, mesh.triangle_count);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        unsigned char color[3];
        choose_color(departures[v] / largest, color);
        for (size_t k = 0; k < 3; k++) put_double(file, mesh.positions[3 * v + k]);
        fwrite(color, 1, 3, file);
        put_double(file, departures[v]);
    }
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        putc(3, file);
        for (size_t k = 0; k < 3; k++) put_bytes(file, mesh.triangles[3 * t + k], 4);
    }
}

tulle_status mend_colors_write(const char *path, tulle_mesh_view mesh, const double *departures,
                               double largest, tulle_error *error) {
    char temporary[PATH_SIZE];
    int const length = snprintf(temporary, sizeof temporary, "%s.%ld.tmp", path, (long)getpid());
    if (length < 0 || length >= PATH_SIZE)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "the path is too long");
    FILE *const file = fopen(temporary, "wb");
    if (!file) return file_fail(error, path, errno, "cannot be written");
    errno = 0;
    put_mesh(file, mesh, departures, largest);
    bool const failed = ferror(file) != 0;
    int code = failed ? (errno ? errno : EIO) : 0;
    if (fclose(file) != 0 && code == 0) code = errno;
    if (code == 0) code = file_rename(temporary, path);
    if (code == 0) return TULLE_OK;
    unlink(temporary);
    return file_fail(error, path, code, "cannot be written");
}
