/* app/reproduce_conditions.c - under what something was measured: the build, the processor and the
 * number of threads, as a short name of all three. conditions.csv tells what each name stands for,
 * made/RUN.csv under which ones a run was made. Times of different conditions are not compared.
 *
 * The build is the hash of the program's own file: any change of the program or of how it was
 * compiled is another build. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/whole_file.h"
#include "app/commands.h"
#include "app/reproduce_kept.h"
#include "base/hash.h"
#include "base/parallel.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LINE_SIZE = 1024 };

void reproduce_find_processor(char name[REPRODUCE_MACHINE_SIZE]) {
    snprintf(name, REPRODUCE_MACHINE_SIZE, "not known");
    FILE *const facts = fopen("/proc/cpuinfo", "r");
    char line[LINE_SIZE];
    while (facts && fgets(line, sizeof line, facts)) {
        const char *const colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon) continue;
        snprintf(name, REPRODUCE_MACHINE_SIZE, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
        break;
    }
    if (facts) fclose(facts);
    for (char *c = name; *c; c++) /* the name is a cell of a table */
        if (*c == ',') *c = ';';
}

static tulle_status hash_program(uint64_t *hash, tulle_error *error) {
    char *bytes = NULL;
    size_t count = 0;
    tulle_status const status = whole_file_read("/proc/self/exe", &bytes, &count, error);
    if (status == TULLE_OK) *hash = hash_bytes(HASH_SEED, bytes, count);
    free(bytes);
    return status;
}

/* Adds the row to a table that has a line for its columns, unless it is there. */
static tulle_status note(const reproduce *self, const char *file, const char *columns,
                         const char *row, tulle_error *error) {
    reproduce_kept table = {0};
    tulle_status status = reproduce_kept_open(self, file, columns, &table, error);
    if (status == TULLE_OK && !reproduce_kept_find(&table, row))
        status = reproduce_kept_add(&table, error, "%s", row);
    if (status == TULLE_OK) status = reproduce_kept_save(&table, error);
    reproduce_kept_close(&table);
    return status;
}

int reproduce_find_conditions(reproduce *self) {
    char processor[REPRODUCE_MACHINE_SIZE], row[LINE_SIZE];
    tulle_error error = {0};
    uint64_t build = 0;
    if (hash_program(&build, &error) != TULLE_OK) return reproduce_fail(&error);
    reproduce_find_processor(processor);
    snprintf(self->build, sizeof self->build, "%016" PRIx64, build);
    snprintf(row, sizeof row, "%s,%d,%s\n", self->build, parallel_resolve_threads(self->threads),
             processor);
    uint64_t const all = hash_bytes(HASH_SEED, row, strlen(row));
    snprintf(self->conditions, sizeof self->conditions, "%08" PRIx32, (uint32_t)all);
    char named[LINE_SIZE + REPRODUCE_CONDITIONS_SIZE];
    snprintf(named, sizeof named, "%s,%s", self->conditions, row);
    if (note(self, "conditions.csv", "conditions,build,threads,processor\n", named, &error) !=
        TULLE_OK)
        return reproduce_fail(&error);
    return APP_EXIT_FINE;
}

/* ---- runs ---- */

static const char *const made_columns = "conditions\n";

static tulle_status open_made(const reproduce *self, const reproduce_run *run, reproduce_kept *made,
                              tulle_error *error) {
    char name[REPRODUCE_PATH_SIZE], file[REPRODUCE_PATH_SIZE + 16];
    reproduce_name_run(run, name);
    snprintf(file, sizeof file, "made/%s.csv", name);
    return reproduce_kept_open(self, file, made_columns, made, error);
}

tulle_status reproduce_note_run(const reproduce *self, const reproduce_run *run, bool begins,
                                tulle_error *error) {
    char row[REPRODUCE_CONDITIONS_SIZE + 1];
    reproduce_kept made = {0};
    snprintf(row, sizeof row, "%s\n", self->conditions);
    tulle_status status = open_made(self, run, &made, error);
    bool const is_known = status == TULLE_OK && reproduce_kept_find(&made, "");
    if (status == TULLE_OK && begins) reproduce_kept_forget(&made);
    if (status == TULLE_OK && !begins && !is_known)
        status = reproduce_kept_add(&made, error, "unknown\n");
    if (status == TULLE_OK && !reproduce_kept_find(&made, row))
        status = reproduce_kept_add(&made, error, "%s", row);
    if (status == TULLE_OK) status = reproduce_kept_save(&made, error);
    reproduce_kept_close(&made);
    return status;
}

void reproduce_read_conditions(const reproduce *self, const reproduce_run *run,
                               char conditions[REPRODUCE_CONDITIONS_SIZE]) {
    reproduce_kept made = {0};
    const char *row = NULL;
    snprintf(conditions, REPRODUCE_CONDITIONS_SIZE, "unknown");
    if (open_made(self, run, &made, NULL) == TULLE_OK) row = reproduce_kept_find(&made, "");
    if (row) {
        size_t const length = strcspn(row, "\n");
        bool const is_one = row[length] == '\0' || row[length + 1] == '\0';
        snprintf(conditions, REPRODUCE_CONDITIONS_SIZE, "%.*s", is_one ? (int)length : 5,
                 is_one ? row : "mixed");
    }
    reproduce_kept_close(&made);
}
