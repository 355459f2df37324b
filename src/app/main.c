/* app/main.c - the program `tulle`: finds the subcommand and hands over to it. */
#define _POSIX_C_SOURCE 200809L
#include "app/commands.h"
#include "base/text.h"

#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

typedef struct subcommand {
    const char *name;
    int (*main)(int argc, char **argv);
    const char *summary;
} subcommand;

/* The subcommands; ends with a null name. */
static const subcommand subcommands[] = {
    {"run", app_run, "simulates a scene and writes what comes of it to a directory"},
    {"check", app_check, "whether triangles intersect, in meshes and in every frame of runs"},
    {"detect", app_detect, "what collides while a surface moves from one state to the next"},
    {"info", app_info, "what a mesh, a scene, a point cache or a run holds"},
    {"render", app_render, "pictures and films of a run"},
    {"convert", app_convert, "meshes, point caches and runs from one format to another"},
    {"mend", app_mend, "an animation of cloth from any tool, without its intersections"},
    {"fit", app_fit,
     "the material file of a fabric from its drape coefficient and bending lengths"},
    {"view", app_view, "a run, meshes or a live scene in a browser: see it, hold it, pull it"},
    {"replay", app_replay, "the recorded calls of a program that embeds the library, again"},
    {NULL, NULL, NULL},
};

enum { SUBCOMMAND_MAX = sizeof subcommands / sizeof subcommands[0], LARGE_BLOCK_BYTES = 1 << 20 };

static void print_help(FILE *stream) {
    fputs("usage: tulle SUBCOMMAND ...\n\n"
          "Cloth simulation in which no surface ever passes through another.\n\nsubcommands:\n",
          stream);
    for (const subcommand *entry = subcommands; entry->name; entry++)
        fprintf(stream, "  %-10s %s\n", entry->name, entry->summary);
    fputs(
        "\n`tulle SUBCOMMAND --help` describes one of them; `tulle --version` prints the version.\n"
        "Exit codes: 0 fine, 1 check found intersections, mend left some, replay a difference,\n"
        "2 bad usage or input, 3 the run failed, 4 out of memory, 130 interrupted.\n",
        stream);
}

static int refuse(const char *name) {
    const char *names[SUBCOMMAND_MAX + 2] = {"help", "--help", "--version"};
    size_t count = 3;
    for (const subcommand *entry = subcommands; entry->name; entry++) names[count++] = entry->name;
    const char *const nearest = text_find_nearest(name, names, count);
    const char *const kind = name[0] == '-' ? "option" : "subcommand";
    if (nearest)
        app_print_names(stderr, "tulle: unknown %s \"%s\"; did you mean \"%s\"?\n", kind, name,
                        nearest);
    else
        app_print_names(stderr, "tulle: unknown %s \"%s\"; `tulle --help` lists them\n", kind,
                        name);
    return APP_EXIT_BAD_INPUT;
}

/* Large blocks go back to the system when they are released: otherwise what a scene needs only
 * while it starts stays with the process, in pieces. */
static void return_large_blocks(void) {
#ifdef __GLIBC__
    (void)mallopt(M_MMAP_THRESHOLD, LARGE_BLOCK_BYTES);
#endif
}

/* Opens what the caller closed of standard input, output and error. A file of ours would get that
 * descriptor otherwise, and messages would be written into it. */
static bool open_standard_files(void) {
    for (int file = STDIN_FILENO; file <= STDERR_FILENO; file++)
        if (fcntl(file, F_GETFD) == -1 && open("/dev/null", O_RDWR) != file) return false;
    return true;
}

/* No setlocale: in the C locale printf, too, writes the point that files and JSON need. */
int main(int argc, char **argv) {
    if (!open_standard_files()) return APP_EXIT_CANNOT_GO_ON;
    return_large_blocks();
    if (argc < 2) {
        print_help(stderr);
        return APP_EXIT_BAD_INPUT;
    }
    const char *const name = argv[1];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0) {
        print_help(stdout);
        return app_finish_output("help");
    }
    if (strcmp(name, "--version") == 0) {
        printf("tulle %d.%d.%d\n", TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR, TULLE_VERSION_PATCH);
        return app_finish_output("version");
    }
    for (const subcommand *entry = subcommands; entry->name; entry++) {
        if (strcmp(name, entry->name) == 0) return entry->main(argc - 1, argv + 1);
    }
    return refuse(name);
}
