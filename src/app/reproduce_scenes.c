/* app/reproduce_scenes.c - what --quick makes coarser and shorter, scene by scene, where stills are
 * taken, and scenes that share a file. */
#include "app/reproduce.h"

#include <string.h>

/* Nets keep their holes, which must not let heads of nails through, and become smaller. Animation 1
 * ends where the net, which has slipped down the slope, meets the small nail. */
static const reproduce_quick quick_scenes[] = {
    {"example_one_low_friction", 300, {"cloth[0].mesh.resolution=[41, 27]"}},
    {"example_one_high_friction", 300, {"cloth[0].mesh.resolution=[41, 27]"}},
    {"animation_1", 45, {"cloth[0].mesh.cells=[10, 10]", "cloth[0].mesh.size=[0.75, 0.75]"}},
    {"animation_2", 80, {"cloth[0].mesh.cells=[12, 12]", "cloth[0].mesh.size=[1.2, 1.2]"}},
    {"animation_3", 150, {"cloth[0].mesh.resolution=[41, 28]"}},
    {"animation_4", 100, {"cloth[0].mesh.resolution=[101, 7]"}},
    {"animation_5", 150, {"cloth[0].mesh.resolution=[41, 28]"}},
    {"animation_6", 150, {"cloth[0].mesh.resolution=[41, 41]"}},
    {"rings", 120, {"cloth[0].mesh.resolution=[50, 14]"}},
    {"ribbons",
     80,
     {"cloth[0].mesh.resolution=[66, 3]", "cloth[1].mesh.resolution=[66, 3]",
      "cloth[2].mesh.resolution=[66, 3]", "cloth[3].mesh.resolution=[66, 3]",
      "cloth[4].mesh.resolution=[66, 3]", "cloth[5].mesh.resolution=[66, 3]",
      "cloth[6].mesh.resolution=[66, 3]", "cloth[7].mesh.resolution=[66, 3]",
      "cloth[8].mesh.resolution=[66, 3]"}},
};
enum { QUICK_COUNT = sizeof quick_scenes / sizeof quick_scenes[0] };

const reproduce_quick *reproduce_find_quick(const char *scene) {
    for (size_t i = 0; i < QUICK_COUNT; i++)
        if (strcmp(quick_scenes[i].scene, scene) == 0) return &quick_scenes[i];
    return NULL;
}

/* The frames of whole runs in which there is most to see: cloth on its way, and the end. */
static const struct {
    const char *scene;
    double places[REPRODUCE_STILLS];
} still_places[] = {
    {"example_one_low_friction", {30.0 / 2400.0, 60.0 / 2400.0, 1.0}},
    {"example_one_high_friction", {30.0 / 2400.0, 60.0 / 2400.0, 1.0}},
    {"animation_1", {20.0 / 150.0, 80.0 / 150.0, 1.0}},
    {"animation_2", {14.0 / 150.0, 26.0 / 150.0, 1.0}},
    {"animation_3", {30.0 / 200.0, 60.0 / 200.0, 1.0}},
    {"animation_4", {40.0 / 200.0, 70.0 / 200.0, 1.0}},
    {"animation_5", {20.0 / 200.0, 40.0 / 200.0, 1.0}},
    {"animation_6", {50.0 / 300.0, 180.0 / 300.0, 1.0}},
    {"rings", {60.0 / 150.0, 75.0 / 150.0, 1.0}},
    {"ribbons", {20.0 / 150.0, 40.0 / 150.0, 1.0}},
};
static const double other_places[REPRODUCE_STILLS] = {0.3, 0.6, 1.0};

const double *reproduce_find_still_places(const char *scene) {
    for (size_t i = 0; i < sizeof still_places / sizeof still_places[0]; i++)
        if (strcmp(still_places[i].scene, scene) == 0) return still_places[i].places;
    return other_places;
}

/* About what a step of each scene took, in the mean of whole and of quick runs. */
static const struct {
    const char *scene;
    double cost; /* [us] for each triangle of cloth */
} costs[] = {
    {"example_one_low_friction", 15.0},
    {"example_one_high_friction", 10.0},
    {"animation_1", 250.0},
    {"animation_2", 80.0},
    {"animation_3", 25.0},
    {"animation_4", 40.0},
    {"animation_5", 16.0},
    {"animation_6", 20.0},
    {"rings", 30.0},
    {"ribbons", 60.0},
};

double reproduce_get_cost(const char *scene) {
    for (size_t i = 0; i < sizeof costs / sizeof costs[0]; i++)
        if (strcmp(costs[i].scene, scene) == 0) return costs[i].cost;
    return 1.0;
}

/* One file, run with other values, stands for several scenes. */
static const reproduce_shared shared_files[] = {
    {"example_one_low_friction", "example_one", NULL},
    {"example_one_high_friction", "example_one", "cloth[0].material.friction=1.28"},
};

const reproduce_shared *reproduce_find_shared(const char *scene) {
    for (size_t i = 0; i < sizeof shared_files / sizeof shared_files[0]; i++)
        if (strcmp(shared_files[i].scene, scene) == 0) return &shared_files[i];
    return NULL;
}
