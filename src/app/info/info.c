/* app/info/info.c - `tulle info`: tells what mesh files, point caches, animations, scene files and
 * run directories hold. */
#include "app/info/info.h"
#include "app/convert/names.h"

#include "app/cli/numbered_files.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "base/error.h"

#include "tulle_io/run.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const char command_name[] = "info";

/* The words of the command line. */
typedef struct info_words {
    int wants_json;
    option_list overrides;
} info_words;

static options_outcome read_words(int argc, char **argv, info_words *words, size_t *path_count) {
    const option_spec options[] = {
        LIST_OPTION("set", 's', &words->overrides, "PATH=VALUE",
                    "change a key of a scene, as cloth[0].mesh.size=[1, 1]; may be repeated"),
        FLAG_OPTION("json", 0, &words->wants_json, "a scene as one JSON object a line"),
    };
    const command_spec command = COMMAND(
        command_name, "FILE|DIR ...", options, 1, SIZE_MAX,
        "Prints what a mesh (.obj, .ply, .stl, .vtp), a point cache (.pc2, .mdd), an animation\n"
        "(.glb, .gltf, .usda, .npz, 'frame_%04d.obj'), a scene (.yaml) or the directory of a run\n"
        "holds: sizes, topology, quality of the triangles, and whether it\n"
        "can be used as cloth or as an obstacle; frames, bodies and contact distance of a scene,\n"
        "whose start is judged; frames, bodies and the end of a run.");
    return options_parse(&command, argc, argv, path_count);
}

static bool has_extension(const char *path, const char *extension) {
    size_t const length = strlen(path);
    size_t const extension_length = strlen(extension);
    return length >= extension_length && strcmp(path + length - extension_length, extension) == 0;
}

static bool is_scene(const char *path) {
    return has_extension(path, ".yaml") || has_extension(path, ".yml");
}

/* The exit code; what went wrong is printed. */
static int print_info(const info_words *words, const char *path) {
    tulle_error error = {0};
    if (is_scene(path)) return info_print_scene(path, &words->overrides, words->wants_json != 0);
    bool const is_run = tulle_run_is_directory(path) != 0;
    struct stat facts;
    tulle_status status = TULLE_OK;
    bool const is_there = stat(path, &facts) == 0;
    bool const is_animation =
        convert_is_scene(convert_get_format(path)) || (!is_there && name_pattern_is_meant(path));
    if (!is_run && is_there && S_ISDIR(facts.st_mode))
        status = error_set_at(&error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                              "this directory holds no run.json; name a run directory or a file");
    else
        status = is_run                                       ? info_print_run(path, &error)
                 : convert_is_cache(convert_get_format(path)) ? info_print_cache(path, &error)
                 : is_animation                               ? info_print_animation(path, &error)
                                                              : info_print_mesh(path, &error);
    if (status != TULLE_OK) app_print_error(command_name, &error);
    return app_exit_for_input(status);
}

int app_info(int argc, char **argv) {
    info_words words = {0};
    size_t path_count = 0;
    options_outcome const outcome = read_words(argc, argv, &words, &path_count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    for (size_t i = 0; i < path_count; i++) {
        if (is_scene(argv[i]) || (!words.wants_json && words.overrides.count == 0)) continue;
        app_print_message(command_name, "%s: --json and --set go with scene files (.yaml)",
                          argv[i]);
        return APP_EXIT_BAD_INPUT;
    }
    int worst = APP_EXIT_FINE;
    for (size_t i = 0; i < path_count; i++) {
        if (i > 0 && !words.wants_json) putchar('\n');
        int const code = print_info(&words, argv[i]);
        if (code > worst) worst = code;
    }
    int const written = app_finish_output(command_name);
    return worst != APP_EXIT_FINE ? worst : written;
}
