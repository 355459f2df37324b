/* app/fit/write_material.c - the material file: every value, found or taken from the start, with
 * how it was found. */
#define _POSIX_C_SOURCE 200809L
#include "app/commands.h"
#include "app/fit/fit.h"
#include "base/error.h"
#include "base/text.h"
#include "io/text/number.h"

#include "tulle_io/mesh_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What was found is known to a few digits at best, and is written with four. */
static double round_found(double value) {
    char text[NUMBER_TEXT_SIZE];
    snprintf(text, sizeof text, "%.4g", value);
    (void)number_parse_double(text, strlen(text), &value);
    return value;
}

void fit_round_material(tulle_material *material) {
    double const most = sqrt(material->warp.stiffness * material->weft.stiffness);
    material->shear.stiffness = fmin(round_found(material->shear.stiffness), most);
    double *const values[] = {&material->bend_warp,
                              &material->bend_weft,
                              &material->bend_twist,
                              &material->bend_hysteresis_warp,
                              &material->bend_hysteresis_weft,
                              &material->shear_hysteresis,
                              &material->springs.stretch_stiffness,
                              &material->springs.bend_stiffness};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        *values[i] = round_found(*values[i]);
}

static void write_value(FILE *stream, const char *key, double value) {
    char text[NUMBER_TEXT_SIZE];
    number_format_double(value, text);
    fprintf(stream, "%s: %s\n", key, text);
}

static void write_curve(FILE *stream, const char *key, const tulle_curve *curve) {
    char stiffness[NUMBER_TEXT_SIZE], knee[NUMBER_TEXT_SIZE], limit[NUMBER_TEXT_SIZE];
    number_format_double(curve->stiffness, stiffness);
    number_format_double(curve->knee, knee);
    number_format_double(curve->limit, limit);
    fprintf(stream, "%s: {stiffness: %s, knee: %s, limit: %s}\n", key, stiffness, knee, limit);
}

/* The file's name without folder and ending, with '_' for what names of materials cannot have. */
static void write_name(FILE *stream, const char *path) {
    const char *const slash = strrchr(path, '/');
    const char *const base = slash ? slash + 1 : path;
    const char *const point = strrchr(base, '.');
    size_t const length = point && point > base ? (size_t)(point - base) : strlen(base);
    fputs("name: '", stream);
    size_t size = 0;
    for (size_t i = 0; i < length; i += size) {
        unsigned const letter = text_take_character(base + i, &size);
        if (i + size > FIT_NAME_SIZE - 1) break;
        bool const is_fine = text_is_of_name(letter) && letter != ' ' && (letter != '.' || i > 0);
        fprintf(stream, "%.*s", is_fine ? (int)size : 1, is_fine ? base + i : "_");
    }
    fputs("'\n", stream);
}

static void write_measures(FILE *stream, const fit_measures *measures) {
    fputs("source: found by tulle fit", stream);
    if (isfinite(measures->drape)) fprintf(stream, "; drape coefficient %.4g %%", measures->drape);
    static const char *const directions[] = {"warp", "weft"};
    for (int i = 0; i < 2; i++)
        if (isfinite(measures->lengths[i]))
            fprintf(stream, "; bending length along the %s %.4g mm", directions[i],
                    1e3 * measures->lengths[i]);
    if (isfinite(measures->shear)) fprintf(stream, "; shear %.4g N/m", measures->shear);
    fputs("\n", stream);
}

static void write_text(const fit_story *story, FILE *stream) {
    const tulle_material *const material = &story->found->material;
    fputs("# A material file: material: {file: ...} in a scene reads it.\n", stream);
    fit_tell(story, "# ", stream);
    app_print_names(stream,
                    "# Twist, hysteresis and springs are scaled with bending and shear. All else "
                    "is taken from %s.\n",
                    story->start);
    write_name(stream, story->path);
    write_measures(stream, story->measures);
    write_value(stream, "area_density", material->area_density);
    write_curve(stream, "warp", &material->warp);
    write_curve(stream, "weft", &material->weft);
    write_curve(stream, "shear", &material->shear);
    write_value(stream, "poisson", material->poisson);
    write_value(stream, "bend_warp", material->bend_warp);
    write_value(stream, "bend_weft", material->bend_weft);
    write_value(stream, "bend_twist", material->bend_twist);
    write_value(stream, "bend_hysteresis_warp", material->bend_hysteresis_warp);
    write_value(stream, "bend_hysteresis_weft", material->bend_hysteresis_weft);
    write_value(stream, "shear_hysteresis", material->shear_hysteresis);
    write_value(stream, "stretch_damping", material->stretch_damping);
    write_value(stream, "bend_damping", material->bend_damping);
    write_value(stream, "air_damping", material->air_damping);
    write_value(stream, "friction", material->friction);
    if (material->dynamic_friction >= 0.0)
        write_value(stream, "dynamic_friction", material->dynamic_friction);
    write_value(stream, "restitution", material->restitution);
    write_value(stream, "friction_across", material->friction_across);
    fputs("# Of membrane: springs alone; the values above go before them.\n", stream);
    write_value(stream, "stretch", material->springs.stretch_stiffness);
    write_value(stream, "bend", material->springs.bend_stiffness);
    write_value(stream, "stiffening_strain", material->springs.stiffening_strain);
}

/* A comment of YAML that every reader takes: '?' for all but plain ASCII. */
static void make_plain(const char *text, char *plain, size_t size) {
    snprintf(plain, size, "%s", text);
    for (char *at = plain; *at; at++)
        if (*at < 0x20 || *at > 0x7e) *at = '?';
}

tulle_status fit_write_material(const fit_story *story, tulle_error *error) {
    char start[FIT_START_SIZE];
    make_plain(story->start, start, sizeof start);
    fit_story plain = *story;
    plain.start = start;
    char *text = NULL;
    size_t length = 0;
    FILE *const stream = open_memstream(&text, &length);
    bool is_written = stream != NULL;
    if (stream) {
        write_text(&plain, stream);
        is_written = !ferror(stream);
        is_written &= fclose(stream) == 0;
    }
    tulle_status const status = is_written ? tulle_file_write(story->path, text, length, error)
                                           : error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                                                       "out of memory for the material file");
    free(text);
    return status;
}
