/* app/bench/scenes.c - the scenes of `tulle bench`, how each comes to each size of cloth, and when
 * contact is in full swing.
 *
 * Size, materials and obstacles stay as the scene's file has them, only the mesh of the cloth gets
 * finer. A net keeps its holes, which decide what slips through: it gets finer strands and, as far
 * as that alone does not give the number, more or fewer holes. Its numbers are therefore 420,
 * 1,840, 9,945, 41,300 and 146,916; those of all other scenes are within 3 % of the name's.
 * A million particles would simulate for hours until contact is in full swing: `landing` is the
 * scene `sphere` when the cloth has just met it, which all sizes reach in some steps. */
#include "app/bench/bench.h"

#include <string.h>

const bench_size bench_sizes[BENCH_SIZE_COUNT] = {
    {.name = "0.4k", .step_count = 4, .is_quick = true, .is_small = true},
    {.name = "2k", .step_count = 8, .is_small = true},
    {.name = "9.8k", .step_count = 8},
    {.name = "40k", .step_count = 4},
    {.name = "160k", .step_count = 2},
    {.name = "1m", .step_count = 1, .is_apart = true},
};

#define RESOLUTION "cloth[0].mesh.resolution="
#define SQUARE                                                                                     \
    {                                                                                              \
        {RESOLUTION "[20, 20]"}, {RESOLUTION "[45, 45]"}, {RESOLUTION "[99, 99]"},                 \
            {RESOLUTION "[200, 200]"}, {                                                           \
            RESOLUTION "[400, 400]"                                                                \
        }                                                                                          \
    }
#define NET(cells, size, columns)                                                                  \
    {                                                                                              \
        "cloth[0].mesh.cells=[" cells ", " cells "]", "cloth[0].mesh.size=[" size ", " size "]",   \
            "cloth[0].mesh.strand_resolution=" columns                                             \
    }

const bench_scene bench_scenes[] = {
    {"needles", "needles", 45, false, SQUARE},
    {"sphere", "sphere", 72, false, SQUARE},
    {"spikes", "spikes", 54, false, SQUARE},
    {"ribbon",
     "ribbon",
     135,
     false,
     {{RESOLUTION "[201, 2]"},
      {RESOLUTION "[401, 5]"},
      {RESOLUTION "[897, 11]"},
      {RESOLUTION "[1819, 22]"},
      {RESOLUTION "[3639, 44]"}}},
    {"net",
     "net",
     45,
     false,
     {NET("4", "0.4107", "1"), NET("9", "0.904", "1"), NET("12", "1.2", "2"),
      NET("13", "1.2987", "4"), NET("13", "1.2987", "8")}},
    {"boxes", "boxes", 45, false, SQUARE},
    {"hammock",
     "hammock",
     72,
     false,
     {{RESOLUTION "[27, 15]"},
      {RESOLUTION "[59, 34]"},
      {RESOLUTION "[132, 74]"},
      {RESOLUTION "[267, 150]"},
      {RESOLUTION "[535, 299]"}}},
    {"example_one",
     "paper/example_one",
     72,
     false,
     {{RESOLUTION "[25, 16]"},
      {RESOLUTION "[55, 37]"},
      {RESOLUTION "[121, 81]"},
      {RESOLUTION "[245, 163]"},
      {RESOLUTION "[489, 327]"}}},
    {"landing",
     "sphere",
     12,
     true,
     {{RESOLUTION "[20, 20]"},
      {RESOLUTION "[45, 45]"},
      {RESOLUTION "[99, 99]"},
      {RESOLUTION "[200, 200]"},
      {RESOLUTION "[400, 400]"},
      {RESOLUTION "[1000, 1000]"}}},
};
const size_t bench_scene_count = sizeof bench_scenes / sizeof bench_scenes[0];

size_t bench_find_scene(const char *name) {
    size_t i = 0;
    while (i < bench_scene_count && strcmp(bench_scenes[i].name, name) != 0) i++;
    return i;
}

size_t bench_find_size(const char *name) {
    size_t i = 0;
    while (i < BENCH_SIZE_COUNT && strcmp(bench_sizes[i].name, name) != 0) i++;
    return i;
}
