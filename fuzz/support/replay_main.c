/* fuzz/support/replay_main.c - gives inputs to a target one by one, without libFuzzer.
 *
 * usage: replay_NAME FILE|FOLDER...   the files, and all files in the folders, in order
 *        replay_NAME                  standard input, once or, under AFL++, again and again
 *        replay_NAME --seeds FOLDER   writes the target's seeds into the folder */
#define _XOPEN_SOURCE 700
#include "support/fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { INPUT_MAX = 1 << 20 /* [bytes] of an input */ };

/* Reads the stream to its end and gives it to the target, in a block of its very size: a read
 * beyond it is then seen by the address sanitizer. */
static int run_stream(FILE *stream, const char *name) {
    static uint8_t input[INPUT_MAX];
    size_t const size = fread(input, 1, sizeof input, stream);
    uint8_t *const data = malloc(size ? size : 1);
    if (ferror(stream) || fgetc(stream) != EOF || !data) {
        fprintf(stderr, "%s: cannot be read, or has over %d bytes\n", name, INPUT_MAX);
        free(data);
        return -1;
    }
    memcpy(data, input, size);
    LLVMFuzzerTestOneInput(data, size);
    free(data);
    return 1;
}

static int run_file(const char *path) {
    FILE *const file = fopen(path, "rb");
    if (!file) {
        perror(path);
        return -1;
    }
    /* The last one that is named is the one that fails. */
    fprintf(stderr, "%s\n", path);
    int const count = run_stream(file, path);
    fclose(file);
    return count;
}

/* The number of inputs that were run, or -1. */
static int run_path(const char *path) {
    struct stat facts;
    if (stat(path, &facts) != 0 || !S_ISDIR(facts.st_mode)) return run_file(path);
    struct dirent **entries;
    int const entry_count = scandir(path, &entries, NULL, alphasort);
    int count = 0;
    for (int i = 0; i < entry_count; i++) {
        char inner[4096];
        int const length = snprintf(inner, sizeof inner, "%s/%s", path, entries[i]->d_name);
        bool const is_hidden = entries[i]->d_name[0] == '.';
        free(entries[i]);
        if (is_hidden || count < 0) continue;
        int const more = length < (int)sizeof inner ? run_path(inner) : -1;
        count = more < 0 ? -1 : count + more;
    }
    if (entry_count >= 0) free(entries);
    return count;
}

int main(int argc, char **argv) {
    if (argc == 3 && strcmp(argv[1], "--seeds") == 0) {
        fuzz_set_seed_folder(argv[2]);
        fuzz_make_seeds();
        return 0;
    }
    if (argc == 1) {
#ifdef __AFL_HAVE_MANUAL_CONTROL
        while (__AFL_LOOP(1000))
#endif
            if (run_stream(stdin, "standard input") < 0) return 2;
        return 0;
    }
    int count = 0;
    for (int i = 1; i < argc; i++) {
        int const more = run_path(argv[i]);
        if (more < 0) return 2;
        count += more;
    }
    printf("%d inputs\n", count);
    return count > 0 ? 0 : 2; /* a corpus that is empty tests nothing */
}
