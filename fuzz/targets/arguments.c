/* fuzz/targets/arguments.c - the command line: a subcommand with the words of the input, one a
 * line.
 *
 * Words that name files find some small ones, in a folder made anew for each input; run and render
 * find none, so they end when they look for their scene or run. Any words lead to one of the
 * documented exit codes. Words that could lead out of the folder, start other programs or ask for
 * long work are left out. */
#define _XOPEN_SOURCE 700
#include "support/mesh_file.h"

#include "app/commands.h"
#include "io/run_support.h"
#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"

#include <fcntl.h>
#include <signal.h>

enum {
    WORDS_MAX = 24,
    TEXT_MAX = 1024, /* [bytes] of an input that count */
    DIGITS_MAX = 2,  /* of a number that says how often something is done */
    FRAMES = 2
};

typedef struct subcommand {
    const char *name;
    int (*main)(int argc, char **argv);
    bool has_files;
} subcommand;

static const subcommand subcommands[] = {
    {"check", app_check, true},     {"info", app_info, true}, {"detect", app_detect, true},
    {"convert", app_convert, true}, {"run", app_run, false},  {"render", app_render, false},
    {"fit", app_fit, true}};
enum { SUBCOMMAND_COUNT = sizeof subcommands / sizeof subcommands[0] };

/* ---- files ---- */

static void put_mesh(const char *name, double height) {
    tulle_mesh mesh = fuzz_make_mesh(0);
    for (size_t i = 0; i < mesh.vertex_count; i++) mesh.positions[3 * i + 2] += height;
    FUZZ_CHECK(tulle_mesh_write(name, tulle_mesh_get_view(&mesh), NULL) == TULLE_OK);
    tulle_mesh_destroy(&mesh);
}

/* Into the current folder. */
static void put_files(void) {
    static bool has_bodies;
    if (!has_bodies) make_bodies();
    has_bodies = true;
    put_mesh("a.obj", 0.0);
    put_mesh("b.obj", 0.1);
    put_mesh("f_0.ply", 0.0);
    put_mesh("f_2.ply", 0.2);
    run_whole("r.run", FRAMES);
    static const double positions[12] = {0};
    tulle_pc2_writer *writer = NULL;
    FUZZ_CHECK(tulle_pc2_writer_open("c.pc2", 4, 0, &writer, NULL) == TULLE_OK);
    FUZZ_CHECK(tulle_pc2_writer_append(writer, positions, NULL) == TULLE_OK);
    FUZZ_CHECK(tulle_pc2_writer_close(writer, NULL) == TULLE_OK);
}

/* ---- words ---- */

static bool has_long_number(const char *word) {
    size_t digits = 0, most = 0;
    for (; *word; word++) {
        digits = *word >= '0' && *word <= '9' ? digits + 1 : 0;
        most = digits > most ? digits : most;
    }
    return most > DIGITS_MAX;
}

/* Takes the text apart in place; false where a word is one to leave out. */
static bool split(char *text, bool has_files, char **words, int *count) {
    *count = 1; /* the subcommand comes first */
    for (char *word = strtok(text, "\n"); word && *count < WORDS_MAX; word = strtok(NULL, "\n")) {
        if (strchr(word, '/') || strstr(word, "..") || strcmp(word, "--plot") == 0) return false;
        if (has_files && has_long_number(word)) return false;
        if (strncmp(word, "-d", 2) == 0 || strncmp(word, "--drape", 7) == 0) return false;
        words[(*count)++] = word;
    }
    words[*count] = NULL;
    return true;
}

/* ---- the call ---- */

/* Calls a subcommand in a folder of its own. What it does with signals is undone. */
static int call(const subcommand *called, int count, char **words) {
    static const int signals[] = {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ};
    enum { SIGNAL_COUNT = sizeof signals / sizeof signals[0] };
    struct sigaction before[SIGNAL_COUNT];
    for (size_t i = 0; i < SIGNAL_COUNT; i++) sigaction(signals[i], NULL, &before[i]);
    int const folder = open(".", O_RDONLY | O_DIRECTORY);
    const char *const work = fuzz_path("work");
    FUZZ_CHECK(folder >= 0 && mkdir(work, 0777) == 0 && chdir(work) == 0);
    if (called->has_files) put_files();
    int const code = called->main(count, words);
    FUZZ_CHECK(fchdir(folder) == 0);
    close(folder);
    remove_tree(work);
    for (size_t i = 0; i < SIGNAL_COUNT; i++) sigaction(signals[i], &before[i], NULL);
    return code;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 1 || size > TEXT_MAX || memchr(data, '\0', size)) return 0;
    const subcommand *const called = &subcommands[data[0] % SUBCOMMAND_COUNT];
    char text[TEXT_MAX + 1], name[32], *words[WORDS_MAX + 1] = {name};
    memcpy(text, data + 1, size - 1);
    text[size - 1] = '\0';
    snprintf(name, sizeof name, "%s", called->name);
    int count;
    if (!split(text, called->has_files, words, &count)) return 0;
    int const code = call(called, count, words);
    FUZZ_CHECK(code == APP_EXIT_FINE || code == APP_EXIT_FALSE || code == APP_EXIT_BAD_INPUT ||
               code == APP_EXIT_CANNOT_GO_ON);
    FUZZ_CHECK(code != APP_EXIT_FALSE || called->main == app_check);
    FUZZ_CHECK(called->has_files || code == APP_EXIT_FINE || code == APP_EXIT_BAD_INPUT);
    return 0;
}

void fuzz_make_seeds(void) {
    /* The first character chooses: its code modulo the number of subcommands. */
    fuzz_put_text_seed("check", "i-t\n1\n--frames=0:last\n--json\nr.run");
    fuzz_put_text_seed("check_together", "i--together\na.obj\n--obstacle\nb.obj\n--list=3");
    fuzz_put_text_seed("info", "ja.obj\nc.pc2\nr.run\nf_0.ply");
    fuzz_put_text_seed("info_scene", "js.yaml\n--json\n--set\ntime.frames=1");
    fuzz_put_text_seed("detect",
                       "ka.obj\nb.obj\n--method\npaper\n--cone=paper\n--alpha-max\n60deg\n"
                       "--thickness=1mm\n--json\n--earliest");
    fuzz_put_text_seed("convert", "lf_*.ply\nout_%02d.vtp\n--pvd=o.pvd\n--up\ny\n--units\nmm\n"
                                  "--frames\n0:2:2");
    fuzz_put_text_seed("convert_run", "lr.run\nx.pc2\n--body=sheet\n--frames=::2\n--subdivide=1");
    fuzz_put_text_seed("run",
                       "ms.yaml\n-o\nout\n-n10\n--set=a=1\n--checkpoint-every\n30s\n--force\n"
                       "--progress=none\n--record\ndebug\n--list-left=x.csv");
    fuzz_put_text_seed("render", "nr.run\n--frames\n0:9\n--size\n64x48\n--samples=4\n--camera\n"
                                 "position=1,2,3,target=0,0,50cm,fov=40deg\n--color=patches\n"
                                 "--fps\n30\n-o\nx_%04d.png");
    fuzz_put_text_seed("fit", "ox.yaml\n--bending-warp\n19mm\n--bending-weft=15mm\n--preset\nwool\n"
                              "--area-density=99gsm\n--shear\n1gf/cm/deg\n--json\n--force");
    fuzz_put_text_seed("help", "i--help");
}
