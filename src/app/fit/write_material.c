/* app/fit/write_material.c - the material file: every value, found or taken from the start, with
 * how it was found. */
#define _POSIX_C_SOURCE 200809L
#include "app/commands.h"
#include "app/fit/fit.h"
#include "base/error.h"
#include "io/text/number.h"

#include "tulle_io/mesh_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void write_value(FILE *stream, const char *key, double value) {
    char text[NUMBER_TEXT_SIZE];
    number_format_double(value, text);
    fprintf(stream, "%s: %s\n", key, text);
}

/* What was found is known to a few digits at best. */
static void write_found(FILE *stream, const char *key, double value) {
    fprintf(stream, "%s: %.4g\n", key, value);
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
    for (size_t i = 0; i < length && i < FIT_NAME_SIZE - 1; i++) {
        char const letter = base[i];
        bool const is_fine = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                             (letter >= '0' && letter <= '9') || letter == '-' || letter == '_' ||
                             (letter == '.' && i > 0);
        fputc(is_fine ? letter : '_', stream);
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
    app_print_names(stream, "# All other values are those of %s.\n", story->start);
    write_name(stream, story->path);
    write_measures(stream, story->measures);
    write_value(stream, "area_density", material->area_density);
    write_curve(stream, "warp", &material->warp);
    write_curve(stream, "weft", &material->weft);
    tulle_curve shear = material->shear;
    char rounded[NUMBER_TEXT_SIZE];
    snprintf(rounded, sizeof rounded, "%.4g", shear.stiffness);
    (void)number_parse_double(rounded, strlen(rounded), &shear.stiffness);
    write_curve(stream, "shear", &shear);
    write_value(stream, "poisson", material->poisson);
    write_found(stream, "bend_warp", material->bend_warp);
    write_found(stream, "bend_weft", material->bend_weft);
    write_found(stream, "bend_twist", material->bend_twist);
    write_found(stream, "bend_hysteresis_warp", material->bend_hysteresis_warp);
    write_found(stream, "bend_hysteresis_weft", material->bend_hysteresis_weft);
    write_found(stream, "shear_hysteresis", material->shear_hysteresis);
    write_value(stream, "stretch_damping", material->stretch_damping);
    write_value(stream, "bend_damping", material->bend_damping);
    write_value(stream, "air_damping", material->air_damping);
    write_value(stream, "friction", material->friction);
    if (material->dynamic_friction >= 0.0)
        write_value(stream, "dynamic_friction", material->dynamic_friction);
    write_value(stream, "restitution", material->restitution);
    write_value(stream, "friction_across", material->friction_across);
    fputs("# Of membrane: springs alone; the values above go before them.\n", stream);
    write_found(stream, "stretch", material->springs.stretch_stiffness);
    write_found(stream, "bend", material->springs.bend_stiffness);
    write_value(stream, "stiffening_strain", material->springs.stiffening_strain);
}

tulle_status fit_write_material(const fit_story *story, tulle_error *error) {
    char *text = NULL;
    size_t length = 0;
    FILE *const stream = open_memstream(&text, &length);
    bool is_written = stream != NULL;
    if (stream) {
        write_text(story, stream);
        is_written = !ferror(stream);
        is_written &= fclose(stream) == 0;
    }
    tulle_status const status = is_written ? tulle_file_write(story->path, text, length, error)
                                           : error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                                                       "out of memory for the material file");
    free(text);
    return status;
}
