/* app/info/scene.c - what `tulle info` prints of a scene file: how long it is, what is in it, the
 * contact distance that its world works with, and how well mesh and step suit its fabrics. It makes
 * the world and judges its start, so a scene that it prints can be run. docs/guide/formats.md tells
 * the JSON. */
#include "scene/scene.h"
#include "app/cli/json_text.h"
#include "app/commands.h"
#include "app/info/info.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double MILLIMETRES_PER_METRE = 1000.0;
static const double PERIODS[] = {1.0, 0.1}; /* [s] for which the integrator's own damping is told */
enum { PERIOD_COUNT = sizeof PERIODS / sizeof PERIODS[0] };
/* Edges of this part of the bending length fold about as the fabric does; where cloth curves both
 * ways at once, those of the second: see tulle_fineness. */
static const double FINE_PART = 1.0 / 2.0, FINE_PART_OF_DRAPE = 1.0 / 3.0;

/* A scene and the world made of it, which has started. */
typedef struct scene_facts {
    const tulle_scene *scene;
    const tulle_scene_world *built;
} scene_facts;

static void print_count(const char *key, uint64_t value) { printf(",\"%s\":%" PRIu64, key, value); }

static void print_number(const char *key, double value) {
    printf(",\"%s\":", key);
    json_print_double(stdout, value);
}

static tulle_fineness get_fineness(const scene_facts *facts, size_t cloth) {
    return tulle_cloth_get_fineness(facts->built->world, facts->built->cloths[cloth]);
}

static double get_damping(const scene_facts *facts, double period) {
    double const step = tulle_scene_get_time_step(facts->scene);
    return tulle_world_get_numerical_damping(facts->built->world, step, period);
}

/* [m] The box of a mesh at the start. */
typedef struct mesh_box {
    double low[3], high[3];
} mesh_box;

static mesh_box find_box(tulle_mesh_view mesh) {
    mesh_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
        box.low[i % 3] = fmin(box.low[i % 3], mesh.positions[i]);
        box.high[i % 3] = fmax(box.high[i % 3], mesh.positions[i]);
    }
    return box;
}

/* ---- JSON ---- */

static void print_point(const char *key, const double point[3]) {
    printf(",\"%s\":", key);
    for (int k = 0; k < 3; k++) {
        putchar(k == 0 ? '[' : ',');
        json_print_double(stdout, point[k]);
    }
    putchar(']');
}

/* `,"KEY":[{"name":...},...]` */
static void print_json_bodies(const scene_facts *facts, bool are_obstacles) {
    const tulle_scene *const loaded = facts->scene;
    size_t const count = are_obstacles ? tulle_scene_get_obstacle_count(loaded)
                                       : tulle_scene_get_cloth_count(loaded);
    printf(",\"%s\":[", are_obstacles ? "obstacles" : "cloths");
    for (size_t i = 0; i < count; i++) {
        tulle_mesh_view const mesh = are_obstacles ? tulle_scene_get_obstacle_mesh(loaded, i)
                                                   : tulle_scene_get_cloth_mesh(loaded, i);
        printf("%s{\"name\":", i > 0 ? "," : "");
        json_print_text(stdout, are_obstacles ? tulle_scene_get_obstacle_name(loaded, i)
                                              : tulle_scene_get_cloth_name(loaded, i));
        print_count("vertices", mesh.vertex_count);
        print_count("triangles", mesh.triangle_count);
        if (!are_obstacles) {
            print_number("mean_edge", get_fineness(facts, i).mean_edge);
            print_number("bending_length", get_fineness(facts, i).bending_length);
        }
        mesh_box const box = find_box(mesh);
        print_point("low", box.low);
        print_point("high", box.high);
        putchar('}');
    }
    putchar(']');
}

static void print_json(const scene_facts *facts, double contact_distance) {
    const tulle_scene *const loaded = facts->scene;
    fputs("{\"format\":\"tulle scene\",\"format_version\":1,\"path\":", stdout);
    json_print_text(stdout, tulle_scene_get_path(loaded));
    printf(",\"scene_hash\":\"%016" PRIx64 "\"", tulle_scene_get_hash(loaded));
    print_number("time_step", tulle_scene_get_time_step(loaded));
    print_count("frames", tulle_scene_get_frame_count(loaded));
    print_count("steps_per_frame", tulle_scene_get_steps_per_frame(loaded));
    fputs(",\"numerical_damping\":[", stdout);
    for (size_t i = 0; i < PERIOD_COUNT; i++) {
        printf("%s{\"period\":", i > 0 ? "," : "");
        json_print_double(stdout, PERIODS[i]);
        print_number("ratio", get_damping(facts, PERIODS[i]));
        putchar('}');
    }
    putchar(']');
    print_number("contact_distance", contact_distance);
    print_json_bodies(facts, false);
    print_json_bodies(facts, true);
    puts("}");
}

/* ---- text ---- */

static void print_body(const char *role, const char *name, tulle_mesh_view mesh) {
    app_print_names(stdout, "  %-16s %s: %zu vertices, %zu triangles\n", role, name,
                    mesh.vertex_count, mesh.triangle_count);
    mesh_box const box = find_box(mesh);
    printf("  %-16s from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g) m\n", "", box.low[0], box.low[1],
           box.low[2], box.high[0], box.high[1], box.high[2]);
}

/* How long the edges are, and how long they should be. */
static void print_fineness(tulle_fineness fineness) {
    double const edge = MILLIMETRES_PER_METRE * fineness.mean_edge;
    double const length = MILLIMETRES_PER_METRE * fineness.bending_length;
    printf("  %-16s edges of %.3g mm", "", edge);
    if (length > 0.0) printf(", bending length %.3g mm", length);
    if (length > 0.0 && edge > FINE_PART_OF_DRAPE * length)
        printf("; edges of %.2g mm or less fold as the fabric does, of %.2g mm where it curves "
               "both ways",
               FINE_PART * length, FINE_PART_OF_DRAPE * length);
    putchar('\n');
}

static void print_text(const scene_facts *facts, double contact_distance) {
    const tulle_scene *const loaded = facts->scene;
    app_print_names(stdout, "%s: scene, hash %016" PRIx64 "\n", tulle_scene_get_path(loaded),
                    tulle_scene_get_hash(loaded));
    printf("  %-16s %" PRIu32 " after the start, of %" PRIu32 " steps of %.6g s each\n", "frames",
           tulle_scene_get_frame_count(loaded), tulle_scene_get_steps_per_frame(loaded),
           tulle_scene_get_time_step(loaded));
    printf("  %-16s the integrator adds a damping ratio of", "damping");
    for (size_t i = 0; i < PERIOD_COUNT; i++)
        printf("%s %.2g at a period of %g s", i > 0 ? "," : "", get_damping(facts, PERIODS[i]),
               PERIODS[i]);
    printf("\n  %-16s %.4g mm\n", "contact distance", MILLIMETRES_PER_METRE * contact_distance);
    for (size_t i = 0; i < tulle_scene_get_cloth_count(loaded); i++) {
        print_body("cloth", tulle_scene_get_cloth_name(loaded, i),
                   tulle_scene_get_cloth_mesh(loaded, i));
        print_fineness(get_fineness(facts, i));
    }
    for (size_t i = 0; i < tulle_scene_get_obstacle_count(loaded); i++)
        print_body(tulle_scene_is_obstacle_dynamic(loaded, i)  ? "rigid body"
                   : tulle_scene_is_obstacle_moving(loaded, i) ? "moving obstacle"
                                                               : "obstacle",
                   tulle_scene_get_obstacle_name(loaded, i),
                   tulle_scene_get_obstacle_mesh(loaded, i));
}

int info_print_scene(const char *path, const option_list *overrides, bool is_json) {
    tulle_scene *loaded = NULL;
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) {
        app_print_message("info", "out of memory");
        return APP_EXIT_OUT_OF_MEMORY;
    }
    tulle_status status =
        tulle_scene_load(path, overrides->items, overrides->count, &loaded, problems);
    if (status != TULLE_OK) scene_print_problems(problems, stderr);
    free(problems);
    if (status != TULLE_OK) return app_exit_for_input(status);
    for (size_t i = 0; i < tulle_scene_get_note_count(loaded); i++)
        app_print_message("info", "%s", tulle_scene_get_note(loaded, i));
    double contact_distance = 0.0;
    tulle_scene_world built = {0};
    tulle_error error = {0};
    status = tulle_scene_build_world(loaded, 0, NULL, &built, &error);
    if (status == TULLE_OK)
        status = app_start_world(built.world, tulle_scene_get_path(loaded), &error);
    if (status == TULLE_OK) {
        scene_facts const facts = {loaded, &built};
        tulle_world_get_distances(built.world, &contact_distance, NULL, NULL);
        if (is_json)
            print_json(&facts, contact_distance);
        else
            print_text(&facts, contact_distance);
        const char *const message = tulle_world_last_message(built.world);
        if (message[0]) app_print_message("info", "%s", message);
    } else {
        app_print_error("info", &error);
    }
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(loaded);
    return app_exit_for_input(status);
}
