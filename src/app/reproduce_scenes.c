/* app/reproduce_scenes.c - what --quick makes coarser and shorter, scene by scene. */
#include "app/reproduce.h"

#include <string.h>

static const reproduce_quick quick_scenes[] = {
    {"example_one_low_friction", 60, {"cloth[0].mesh.resolution=[41, 41]"}},
    {"example_one_high_friction", 60, {"cloth[0].mesh.resolution=[41, 41]"}},
    {"animation_1", 30, {NULL}},
    {"animation_2", 30, {NULL}},
    {"animation_3", 30, {NULL}},
    {"animation_4", 30, {NULL}},
    {"animation_5", 30, {NULL}},
    {"animation_6", 30, {NULL}},
    {"rings", 30, {NULL}},
    {"ribbons", 30, {NULL}},
};

const reproduce_quick *reproduce_find_quick(const char *scene) {
    for (size_t i = 0; i < sizeof quick_scenes / sizeof quick_scenes[0]; i++)
        if (strcmp(quick_scenes[i].scene, scene) == 0) return &quick_scenes[i];
    return NULL;
}
