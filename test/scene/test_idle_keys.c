/* Keys that do nothing beside the others of a scene: each is refused with its place and what to
 * do. Its default may stand there, as in a canonical text, and an override may leave a key of the
 * file without a use. */
#define _POSIX_C_SOURCE 200809L
#include "scene_text.h"

#include <stdbool.h>

#define TIME "time: {frames: 3}\n"
#define SHEET "cloth:\n  - mesh: {shape: rectangle, size: [2, 2], resolution: [3, 3]}\n"
#define BOX "obstacles:\n  - mesh: {shape: box, size: [1, 1, 1]}\n    translate: [0, 0, -2]\n"
#define SPRINGS "membrane: springs\n"
#define WOVEN_ALONE                                                                                \
    "does nothing with membrane: springs, whose values are stretch, stiffening_strain and bend"

static const struct {
    const char *text;
    int line, column;
    const char *message; /* its beginning */
} idle[] = {
    {TIME SHEET "wind: {velocity: [1, 0, 0], gust_length: 2}\n", 4, 29,
     "wind.gust_length: does nothing without the key 'gust_strength'; give that, too, or leave "
     "this out"},
    {TIME SHEET "wind: {gust_time: 2 s}\n", 4, 8,
     "wind.gust_time: does nothing without the key 'gust_strength'"},
    {TIME SHEET "wind: {seed: 3}\n", 4, 8,
     "wind.seed: does nothing without the key 'gust_strength'"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, seed: 3}\n", 3, 30,
     "cloth[0].mesh.seed: does nothing without the key 'irregular'"},
    {TIME SHEET "contact: {motion_space: cone}\n", 4, 11,
     "contact.motion_space: does nothing with response: coupled; set response: paper, or leave "
     "this out"},
    {TIME SHEET "contact: {start_intersections: ignore, untangle_limit: 5}\n", 4, 40,
     "contact.untangle_limit: does nothing with start_intersections: ignore; set "
     "start_intersections: untangle"},
    {TIME SHEET "solver: {sleep_time: 2 s}\n", 4, 10,
     "solver.sleep_time: does nothing without the key 'sleep_speed'"},
    {TIME SHEET SPRINGS "on_overstretch: stop\n", 5, 1,
     "on_overstretch: does nothing with membrane: springs; set membrane: woven"},
    {TIME SHEET "    pins: [{vertices: [0], eased: true}]\n", 4, 28,
     "cloth[0].pins[0].eased: does nothing without the key 'keyframes'"},
    {TIME SHEET "    pins: [{vertices: [0], pivot: [0, 0, 1]}]\n", 4, 28,
     "cloth[0].pins[0].pivot: does nothing without the key 'keyframes'"},
    {TIME SHEET "    pattern: plain\n    pattern_size: 1\n", 5, 5,
     "cloth[0].pattern_size: does nothing with pattern: plain; set pattern: weave or check"},
    {TIME SHEET BOX "    dynamic: {sleep_time: 2}\n", 7, 15,
     "obstacles[0].dynamic.sleep_time: does nothing without the key 'sleep_speed'"},
    {TIME SHEET BOX "    grain: [0, 1, 0]\n", 7, 5,
     "obstacles[0].grain: does nothing without the key 'friction_across'"},
    {TIME SHEET BOX "    appears: 1\n    copies: {row: {count: 2, offset: [3, 0, 0]}, order: "
                    "last-to-first}\n",
     8, 50, "obstacles[0].copies.order: does nothing without the key 'stagger'"},
    {TIME SHEET BOX "    copies: {row: {count: 2, offset: [3, 0, 0]}, stagger: 1}\n", 7, 59,
     "obstacles[0].copies.stagger: does nothing without motion, appears or disappears"},
    {TIME SHEET BOX "    dynamic: {density: 9}\n    motion: {keyframes: [{time: 0}, {time: 1}]}\n",
     7, 5,
     "obstacles[0].dynamic.start: is 0 s, and the motion begins at 0 s: the body never follows it"},
    {TIME SHEET BOX
     "    dynamic: {start: 1, spin: [1, 0, 0]}\n    motion: {keyframes: [{time: 0}, {time: 1}]}\n",
     7, 31,
     "obstacles[0].dynamic.spin: does nothing: at its start (1 s) the body keeps the velocity of "
     "its motion"},
    {TIME SPRINGS SHEET "    material: {poisson: 0.3}\n", 5, 25,
     "cloth[0].material.poisson: " WOVEN_ALONE "; give these, or set membrane: woven"},
    {TIME SPRINGS SHEET "    material: {warp: {stiffness: 900}}\n", 5, 22,
     "cloth[0].material.warp: " WOVEN_ALONE},
    {TIME SPRINGS SHEET "    material: {shear_hysteresis: 1}\n", 5, 34,
     "cloth[0].material.shear_hysteresis: " WOVEN_ALONE},
    {TIME SPRINGS SHEET "    regions: [{vertices: [0-8], grain: [0, 1, 0]}]\n", 5, 40,
     "cloth[0].regions[0].grain: does nothing with membrane: springs"},
    /* what may stand there */
    {TIME SHEET "wind: {gust_strength: 0, gust_length: 2, gust_time: 3, seed: 4}\n", 0, 0, NULL},
    {TIME SHEET "wind: {gust_length: 0.5, gust_time: 500 ms, seed: auto}\n", 0, 0, NULL},
    {TIME "cloth:\n  - mesh: {shape: rectangle, irregular: false, seed: 3}\n", 0, 0, NULL},
    {TIME SHEET "obstacles:\n  - {mesh: {shape: bumpy-ground, seed: 3}, translate: [0, 0, -2]}\n",
     0, 0, NULL},
    {TIME SHEET "contact: {motion_space: polyhedral, untangle_limit: 2000}\n", 0, 0, NULL},
    {TIME SHEET "contact: {response: paper, motion_space: cone}\n", 0, 0, NULL},
    {TIME SHEET "contact: {start_intersections: untangle, untangle_limit: 5}\n", 0, 0, NULL},
    {TIME SHEET "solver: {sleep_speed: 0, sleep_time: 2 s}\n", 0, 0, NULL},
    {TIME SHEET "    pins: [{vertices: [0], eased: false}]\n    pattern_size: 1\n", 0, 0, NULL},
    {TIME SHEET BOX "    friction_across: 1\n    grain: [0, 1, 0]\n", 0, 0, NULL},
    {TIME SHEET BOX "    appears: 1\n    copies: {row: {count: 2, offset: [3, 0, 0]}, stagger: 1, "
                    "order: last-to-first}\n",
     0, 0, NULL},
    {TIME SHEET BOX "    dynamic: {start: 1}\n    motion: {keyframes: [{time: 0}, {time: 1}]}\n", 0,
     0, NULL},
    {TIME SHEET BOX "    dynamic: {velocity: [1, 0, 0]}\n    motion: {keyframes: [{time: 0}]}\n", 0,
     0, NULL},
    {TIME SPRINGS SHEET "    material: {stretch: 900, bend: 1e-5, stiffening_strain: 0.1}\n", 0, 0,
     NULL},
};

static void idle_keys_are_refused(void **state) {
    (void)state;
    static tulle_scene_problems problems;
    for (size_t i = 0; i < sizeof idle / sizeof idle[0]; i++) {
        tulle_scene_destroy(load_good(TIME SHEET)); /* what is refused leaves no trace */
        write_text_file("s.yaml", idle[i].text);
        char path[128];
        snprintf(path, sizeof path, "%s/s.yaml", folder_path);
        tulle_scene *loaded = NULL;
        tulle_status const status = tulle_scene_load(path, NULL, 0, &loaded, &problems);
        tulle_scene_destroy(loaded);
        const tulle_error *const first = &problems.list[0];
        const char *const wanted = idle[i].message;
        bool const is_refused =
            wanted && first->line == idle[i].line && first->column == idle[i].column &&
            strncmp(first->message, wanted, strlen(wanted)) == 0 && problems.count == 1;
        if ((status == TULLE_OK) != !wanted || (wanted && !is_refused))
            fail_msg("%s: status %d, %d:%d: %s", idle[i].text, (int)status, first->line,
                     first->column, first->message);
    }
}

/* A comparison changes one key, and leaves the others as they are. */
static void overrides_may_leave_keys_idle(void **state) {
    (void)state;
    static const char *const texts[][2] = {
        {TIME SHEET "    material: {poisson: 0.3}\n", "membrane=springs"},
        {TIME SHEET "contact: {response: paper, motion_space: cone}\n", "contact.response=coupled"},
        {TIME SHEET "contact: {start_intersections: untangle, untangle_limit: 5}\n",
         "contact.start_intersections=refuse"},
        {TIME SHEET "on_overstretch: stop\n", "membrane=springs"},
    };
    static tulle_scene_problems problems;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        write_text_file("s.yaml", texts[i][0]);
        char path[128];
        snprintf(path, sizeof path, "%s/s.yaml", folder_path);
        tulle_scene *loaded = NULL;
        if (tulle_scene_load(path, &texts[i][1], 1, &loaded, &problems) != TULLE_OK)
            fail_msg("%s with %s: %s", texts[i][0], texts[i][1], problems.list[0].message);
        tulle_scene_destroy(loaded);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(idle_keys_are_refused),
        cmocka_unit_test(overrides_may_leave_keys_idle),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
