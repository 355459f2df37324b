/* strips.c - see strips.h. */
#include "validation/strips.h"
#include "support/pins.h"

#include "validation/stage.h"

#include <math.h>

const char *const strips_pattern_names[PATTERN_COUNT] = {"alternating", "alike", "crossed",
                                                         "irregular", "turned by 22.5 degrees"};

static void add_triangle(tulle_mesh *mesh, size_t at, uint32_t a, uint32_t b, uint32_t c) {
    mesh->triangles[3 * at] = a;
    mesh->triangles[3 * at + 1] = b;
    mesh->triangles[3 * at + 2] = c;
}

static void divide_cell(const strip *sample, uint32_t i, uint32_t j, tulle_mesh *mesh) {
    uint32_t const line = sample->columns + 1, a = j * line + i, b = a + 1, c = b + line,
                   d = a + line;
    size_t const cell = (size_t)j * sample->columns + i;
    if (sample->pattern == CROSSED) {
        uint32_t const middle = line * (sample->rows + 1) + (uint32_t)cell;
        uint32_t const around[5] = {a, b, c, d, a};
        for (size_t k = 0; k < 4; k++)
            add_triangle(mesh, 4 * cell + k, around[k], around[k + 1], middle);
        return;
    }
    uint32_t const turn = sample->pattern == ALIKE ? 0 : (i + j) % 2;
    add_triangle(mesh, 2 * cell, a, b, turn ? d : c);
    add_triangle(mesh, 2 * cell + 1, turn ? b : a, c, d);
}

tulle_mesh *strips_make(validation_run *run, const strip *sample) {
    double const length = sample->end - sample->begin;
    if (sample->pattern == TURNED) return strips_make_turned(run, sample);
    if (sample->pattern == IRREGULAR) {
        tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
        def.size[0] = length, def.size[1] = sample->width;
        def.resolution[0] = sample->columns + 1, def.resolution[1] = sample->rows + 1;
        def.is_irregular = 1;
        tulle_mesh *const mesh = validate_make_shape(run, &def);
        stage_move(mesh, 0.5 * (sample->begin + sample->end), 0.0, 0.0);
        return mesh;
    }
    size_t const lattice = (size_t)(sample->columns + 1) * (sample->rows + 1);
    size_t const cells = (size_t)sample->columns * sample->rows;
    bool const is_crossed = sample->pattern == CROSSED;
    tulle_mesh *const mesh =
        validate_make_mesh(run, lattice + (is_crossed ? cells : 0), (is_crossed ? 4 : 2) * cells);
    for (uint32_t j = 0; j <= sample->rows; j++)
        for (uint32_t i = 0; i <= sample->columns; i++) {
            double *const x = mesh->positions + 3 * ((size_t)j * (sample->columns + 1) + i);
            x[0] = sample->begin + length * i / sample->columns;
            x[1] = sample->width * ((double)j / sample->rows - 0.5);
            x[2] = 0.0;
        }
    for (uint32_t j = 0; j < sample->rows; j++)
        for (uint32_t i = 0; i < sample->columns; i++) {
            divide_cell(sample, i, j, mesh);
            if (!is_crossed) continue;
            double *const x = mesh->positions + 3 * (lattice + (size_t)j * sample->columns + i);
            x[0] = sample->begin + length * (i + 0.5) / sample->columns;
            x[1] = sample->width * ((j + 0.5) / sample->rows - 0.5);
            x[2] = 0.0;
        }
    return mesh;
}

tulle_pin strips_pin_between(validation_run *run, const tulle_mesh *mesh, double from, double to) {
    uint32_t *const held = validate_allocate(run, mesh->vertex_count * sizeof *held);
    size_t count = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (mesh->positions[3 * v] >= from - 1e-9 && mesh->positions[3 * v] <= to + 1e-9)
            held[count++] = (uint32_t)v;
    return make_pin(held, count, (double)INFINITY);
}
