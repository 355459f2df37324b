/* io/run/run_directory.c - see run_directory.h. */
#define _DEFAULT_SOURCE /* flock */
#include "io/run/run_directory.h"

#include "base/error.h"
#include "io/file_data.h"
#include "io/run/run_transforms.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

void run_join(char path[RUN_PATH_SIZE], const char *directory, const char *name) {
    size_t const length = strlen(directory);
    const char *const slash = length > 0 && directory[length - 1] == '/' ? "" : "/";
    int const written =
        snprintf(path, RUN_PATH_SIZE, "%.*s%s%s", RUN_DIRECTORY_MAX, directory, slash, name);
    if (written >= RUN_PATH_SIZE) path[0] = '\0'; /* opens as no file */
}

int tulle_run_is_directory(const char *path) {
    if (!path || strlen(path) > RUN_DIRECTORY_MAX) return 0;
    char record[RUN_PATH_SIZE];
    run_join(record, path, RUN_FILE_RECORD);
    struct stat facts;
    return stat(record, &facts) == 0 && S_ISREG(facts.st_mode);
}

static bool is_dots(const char *name) { return strcmp(name, ".") == 0 || strcmp(name, "..") == 0; }

/* Whether the name ends in .DIGITS-DIGITS.tmp, as those of output_open. */
static bool is_temporary(const char *name) {
    static const char digits[] = "0123456789";
    size_t const length = strlen(name);
    if (length < 8 || strcmp(name + length - 4, ".tmp") != 0) return false;
    size_t at = length - 4;
    size_t const second = at;
    while (at > 0 && strchr(digits, name[at - 1])) at--;
    if (at == second || at == 0 || name[--at] != '-') return false;
    size_t const first = at;
    while (at > 0 && strchr(digits, name[at - 1])) at--;
    return at < first && at > 0 && name[at - 1] == '.';
}

/* What a writer killed before its run.json was whole leaves; nothing else is there then. */
static bool is_first_leftover(const char *name) {
    size_t const length = strlen(RUN_FILE_RECORD);
    return strncmp(name, RUN_FILE_RECORD, length) == 0 && is_temporary(name);
}

tulle_status run_directory_examine(const char *directory, run_directory_kind *kind,
                                   tulle_error *error) {
    if (strlen(directory) > RUN_DIRECTORY_MAX || !*directory)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the output directory's path should have 1 to %d bytes, not %zu",
                         RUN_DIRECTORY_MAX, strlen(directory));
    *kind = RUN_DIRECTORY_MISSING;
    DIR *const folder = opendir(directory);
    if (!folder && errno == ENOENT) return TULLE_OK;
    if (!folder) return file_fail(error, directory, errno, "cannot be used as output directory");
    *kind = RUN_DIRECTORY_EMPTY;
    for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder))
        if (!is_dots(entry->d_name) && !is_first_leftover(entry->d_name))
            *kind = RUN_DIRECTORY_OTHER;
    closedir(folder);
    if (tulle_run_is_directory(directory)) *kind = RUN_DIRECTORY_RUN;
    return TULLE_OK;
}

tulle_status run_directory_lock(const char *directory, int *lock, tulle_error *error) {
    *lock = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (*lock < 0) return file_fail(error, directory, errno, "cannot be opened");
    if (flock(*lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return TULLE_OK;
    close(*lock);
    *lock = -1;
    return error_set_at(error, TULLE_ERROR_IO, directory, 0, 0,
                        "another process is writing a run here; wait for it or stop it");
}

static void remove_temporaries_in(const char *directory) {
    DIR *const folder = opendir(directory);
    if (!folder) return;
    for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder))
        if (is_temporary(entry->d_name)) unlinkat(dirfd(folder), entry->d_name, 0);
    closedir(folder);
}

void run_directory_remove_temporaries(const char *directory) {
    char vtp[RUN_PATH_SIZE];
    run_join(vtp, directory, RUN_FOLDER_VTP);
    remove_temporaries_in(directory);
    remove_temporaries_in(vtp);
}

/* 0 or an errno. */
static int remove_file(const char *directory, const char *name) {
    char path[RUN_PATH_SIZE];
    run_join(path, directory, name);
    return unlink(path) == 0 || errno == ENOENT ? 0 : errno;
}

static int stem_length(const run_record *record, size_t body) {
    return (int)strlen(run_record_text(record, record->bodies.data[body].mesh_file)) - 4;
}

void run_make_vtp_name(const run_record *record, size_t body, long frame,
                       char name[RUN_PATH_SIZE]) {
    const char *const mesh = run_record_text(record, record->bodies.data[body].mesh_file);
    if (frame < 0)
        snprintf(name, RUN_PATH_SIZE, RUN_FOLDER_VTP "/%.*s.vtp", stem_length(record, body), mesh);
    else
        snprintf(name, RUN_PATH_SIZE, RUN_FOLDER_VTP "/%.*s.%06ld.vtp", stem_length(record, body),
                 mesh, frame);
}

void run_make_pvd_name(const run_record *record, size_t body, char name[RUN_PATH_SIZE]) {
    const char *const mesh = run_record_text(record, record->bodies.data[body].mesh_file);
    snprintf(name, RUN_PATH_SIZE, "%.*s.pvd", stem_length(record, body), mesh);
}

static int clear_vtk(const char *directory, const run_record *record, size_t body) {
    char name[RUN_PATH_SIZE];
    run_make_pvd_name(record, body, name);
    int code = remove_file(directory, name);
    run_make_vtp_name(record, body, -1, name);
    if (!code) code = remove_file(directory, name);
    for (long frame = 0; !code; frame++) {
        char path[RUN_PATH_SIZE];
        run_make_vtp_name(record, body, frame, name);
        run_join(path, directory, name);
        if (unlink(path) != 0) return errno == ENOENT || errno == ENOTDIR ? 0 : errno;
    }
    return code;
}

static int clear_bodies(const char *directory, const run_record *record) {
    int code = 0;
    for (size_t i = 0; i < record->bodies.count && !code; i++) {
        const run_body_record *const body = &record->bodies.data[i];
        code = remove_file(directory, run_record_text(record, body->mesh_file));
        if (!code && !body->is_static)
            code = remove_file(directory, run_record_text(record, body->cache_file));
        if (!code && record->writes_vtp) code = clear_vtk(directory, record, i);
    }
    return code;
}

tulle_status run_directory_clear(const char *directory, const run_record *record,
                                 tulle_error *error) {
    /* Without checkpoints nobody resumes the rest, whatever is left of it. */
    static const char *const first[] = {RUN_FILE_CHECKPOINT, RUN_FILE_CHECKPOINT_BEFORE};
    static const char *const last[] = {RUN_FILE_FRAMES, RUN_FILE_REPORT, RUN_FILE_SCENE,
                                       RUN_FILE_RECORD};
    run_directory_remove_temporaries(directory);
    int code = 0;
    for (size_t i = 0; i < sizeof first / sizeof first[0] && !code; i++)
        code = remove_file(directory, first[i]);
    if (!code && record) code = clear_bodies(directory, record);
    if (!code && record && record->records_debug) code = remove_file(directory, RUN_FILE_DEBUG);
    if (!code && record && transforms_count_bodies(record) > 0)
        code = remove_file(directory, RUN_FILE_BODIES);
    if (record && record->writes_vtp) {
        char vtp[RUN_PATH_SIZE];
        run_join(vtp, directory, RUN_FOLDER_VTP);
        rmdir(vtp); /* stays when the user put something there */
    }
    for (size_t i = 0; i < sizeof last / sizeof last[0] && !code; i++)
        code = remove_file(directory, last[i]);
    return code ? file_fail(error, directory, code, "its former run cannot be removed") : TULLE_OK;
}
