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

enum { LOCK_TRIES = 100 /* at a directory that others remove and make again */ };

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

/* [bytes] of NAME in NAME.DIGITS-DIGITS.tmp, as output_open names what it has not finished; 0: the
 * name is none of these. */
static size_t measure_target(const char *name) {
    static const char digits[] = "0123456789", ending[] = ".tmp";
    size_t at = strlen(name);
    if (at < sizeof ending || strcmp(name + at - (sizeof ending - 1), ending) != 0) return 0;
    at -= sizeof ending - 1;
    for (int number = 0; number < 2; number++) {
        size_t const end = at;
        while (at > 0 && strchr(digits, name[at - 1])) at--;
        if (at == end || at < 2 || name[at - 1] != "-."[number]) return 0;
        at--;
    }
    return at;
}

/* What a writer killed before its run.json was whole leaves; nothing else is there then. */
static bool is_first_leftover(const char *name) {
    size_t const length = strlen(RUN_FILE_RECORD);
    return strncmp(name, RUN_FILE_RECORD, length) == 0 && measure_target(name) == length;
}

tulle_status run_directory_examine(const char *directory, run_directory_kind *kind,
                                   tulle_error *error) {
    *kind = RUN_DIRECTORY_EMPTY;
    DIR *const folder = opendir(directory);
    int code = folder ? 0 : errno;
    while (!code) {
        errno = 0;
        const struct dirent *const entry = readdir(folder);
        code = errno;
        if (!entry) break;
        if (!is_dots(entry->d_name) && !is_first_leftover(entry->d_name))
            *kind = RUN_DIRECTORY_OTHER;
    }
    if (folder) closedir(folder);
    if (code) return file_fail(error, directory, code, "cannot be used as output directory");
    if (tulle_run_is_directory(directory)) *kind = RUN_DIRECTORY_RUN;
    return TULLE_OK;
}

int run_directory_check(const char *directory, int lock) {
    struct stat held, there;
    if (fstat(lock, &held) != 0) return errno;
    if (stat(directory, &there) != 0) return errno == ENOTDIR ? ENOENT : errno;
    return held.st_dev == there.st_dev && held.st_ino == there.st_ino ? 0 : ENOENT;
}

/* 0 or an errno. A file system without locks is written to without one. */
static int lock_folder(int folder) {
    if (flock(folder, LOCK_EX | LOCK_NB) == 0) return 0;
    bool const is_unknown =
        errno == ENOSYS || errno == EOPNOTSUPP || errno == ENOLCK || errno == EINVAL;
    return is_unknown ? 0 : errno;
}

tulle_status run_directory_lock(const char *directory, int *lock, bool *is_made,
                                tulle_error *error) {
    static const char what[] = "cannot be used as output directory";
    *is_made = false;
    for (int try = 0; try < LOCK_TRIES; try++) {
        *lock = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (*lock < 0 && errno == ENOENT) {
            *is_made = mkdir(directory, 0777) == 0;
            if (!*is_made && errno != EEXIST)
                return file_fail(error, directory, errno, "cannot be made");
            continue;
        }
        if (*lock < 0) return file_fail(error, directory, errno, what);
        int code = lock_folder(*lock);
        if (!code) code = run_directory_check(directory, *lock);
        if (!code) return TULLE_OK;
        close(*lock);
        *lock = -1;
        *is_made = false;
        if (code == EWOULDBLOCK)
            return error_set_at(error, TULLE_ERROR_IO, directory, 0, 0,
                                "is locked: another process is writing a run here; wait for it, "
                                "stop it, or choose another directory");
        /* What was opened may be removed, and another made, before it is locked. */
        if (code != ENOENT) return file_fail(error, directory, code, "cannot be locked");
    }
    return file_fail(error, directory, ENOENT, what);
}

/* Names of a run's files, but those in vtp/: first what is no body's, then three of each body, of
 * which one may be empty. Null after the last. */
static const char *get_file_name(const run_record *record, size_t index, char room[RUN_PATH_SIZE]) {
    static const char *const names[] = {
        RUN_FILE_RECORD,   RUN_FILE_SCENE,  RUN_FILE_CHECKPOINT, RUN_FILE_CHECKPOINT_BEFORE,
        RUN_FILE_FRAMES,   RUN_FILE_REPORT, RUN_FILE_DEBUG,      RUN_FILE_BODIES,
        RUN_FILE_CHECKSUMS};
    size_t const count = sizeof names / sizeof names[0];
    if (index < count) return names[index];
    size_t const body = (index - count) / 3;
    if (!record || body >= record->bodies.count) return NULL;
    switch ((index - count) % 3) {
    case 0: return run_record_text(record, record->bodies.data[body].mesh_file);
    case 1: return run_record_text(record, record->bodies.data[body].cache_file);
    default: run_make_pvd_name(record, body, room); return room;
    }
}

static tulle_status check_file(const char *directory, const char *name, mode_t wanted,
                               tulle_error *error) {
    char path[RUN_PATH_SIZE];
    struct stat facts;
    run_join(path, directory, name);
    if (lstat(path, &facts) != 0)
        return errno == ENOENT ? TULLE_OK : file_fail(error, path, errno, "cannot be examined");
    if (S_ISLNK(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0,
                            "is a symbolic link; a run is not written through links, which may "
                            "lead out of its directory: put what it leads to in its place");
    if ((facts.st_mode & S_IFMT) != wanted)
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is not a %s; remove it",
                            wanted == S_IFREG ? "regular file" : "directory");
    return TULLE_OK;
}

tulle_status run_directory_check_files(const char *directory, const run_record *record,
                                       tulle_error *error) {
    char room[RUN_PATH_SIZE];
    tulle_status status =
        record->writes_vtp ? check_file(directory, RUN_FOLDER_VTP, S_IFDIR, error) : TULLE_OK;
    for (size_t i = 0; !status; i++) {
        const char *const name = get_file_name(record, i, room);
        if (!name) break;
        if (*name) status = check_file(directory, name, S_IFREG, error);
    }
    return status;
}

/* Whether the run has a file of this name, given by its first bytes. */
static bool is_run_file(const run_record *record, const char *name, size_t length) {
    char room[RUN_PATH_SIZE];
    for (size_t i = 0;; i++) {
        const char *const own = get_file_name(record, i, room);
        if (!own) return false;
        if (strlen(own) == length && memcmp(own, name, length) == 0) return true;
    }
}

tulle_status run_directory_check_foreign(const char *directory, const run_record *former,
                                         const run_record *record, tulle_error *error) {
    char room[RUN_PATH_SIZE], former_room[RUN_PATH_SIZE], path[RUN_PATH_SIZE];
    for (size_t i = 0;; i++) {
        const char *const name = get_file_name(record, i, room);
        if (!name) return TULLE_OK;
        const char *const likely = get_file_name(former, i, former_room);
        run_join(path, directory, name);
        if (!*name || (likely && strcmp(name, likely) == 0) || access(path, F_OK) != 0 ||
            is_run_file(former, name, strlen(name)))
            continue;
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0,
                            "does not belong to the run that is to be replaced, but the new run "
                            "has a file of this name; move it away, or choose another directory");
    }
}

/* Whether the folder of VTP files is there, and no link to another folder. */
static bool has_vtp_folder(const char *directory) {
    char path[RUN_PATH_SIZE];
    struct stat facts;
    run_join(path, directory, RUN_FOLDER_VTP);
    return lstat(path, &facts) == 0 && S_ISDIR(facts.st_mode);
}

void run_directory_remove_temporaries(const char *directory, const run_record *record) {
    for (int is_vtp = 0; is_vtp < (has_vtp_folder(directory) ? 2 : 1); is_vtp++) {
        char path[RUN_PATH_SIZE];
        run_join(path, directory, is_vtp ? RUN_FOLDER_VTP : ".");
        DIR *const folder = opendir(path);
        if (!folder) continue;
        for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
            size_t const length = measure_target(entry->d_name);
            bool const is_own =
                is_vtp ? length > 4 && memcmp(entry->d_name + length - 4, ".vtp", 4) == 0
                       : length > 0 && is_run_file(record, entry->d_name, length);
            if (is_own) unlinkat(dirfd(folder), entry->d_name, 0);
        }
        closedir(folder);
    }
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

static int clear_vtk(const char *directory, const run_record *record, size_t body, bool has_vtp) {
    char name[RUN_PATH_SIZE];
    run_make_pvd_name(record, body, name);
    int code = remove_file(directory, name);
    if (!has_vtp) return code;
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

static int clear_bodies(const char *directory, const run_record *record, size_t body_count) {
    bool const has_vtp = record->writes_vtp && has_vtp_folder(directory);
    int code = 0;
    for (size_t i = 0; i < body_count && !code; i++) {
        const run_body_record *const body = &record->bodies.data[i];
        code = remove_file(directory, run_record_text(record, body->mesh_file));
        if (!code && !body->is_static)
            code = remove_file(directory, run_record_text(record, body->cache_file));
        if (!code && record->writes_vtp) code = clear_vtk(directory, record, i, has_vtp);
    }
    return code;
}

tulle_status run_directory_clear(const char *directory, const run_record *record, size_t body_count,
                                 tulle_error *error) {
    /* Without checkpoints nobody resumes the rest, and without lines of frames nobody reads it,
     * whatever is left of it. The newest checkpoint goes last, so that none is lost alone. */
    static const char *const first[] = {RUN_FILE_CHECKPOINT_BEFORE, RUN_FILE_CHECKPOINT};
    static const char *const then[] = {RUN_FILE_FRAMES, RUN_FILE_CHECKSUMS, RUN_FILE_REPORT,
                                       RUN_FILE_SCENE};
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_RECORD);
    run_directory_remove_temporaries(directory, record);
    int code = 0;
    for (size_t i = 0; i < sizeof first / sizeof first[0] && !code; i++)
        code = remove_file(directory, first[i]);
    if (!code) code = file_sync_folder(path);
    for (size_t i = 0; i < sizeof then / sizeof then[0] && !code; i++)
        code = remove_file(directory, then[i]);
    if (!code && record) code = clear_bodies(directory, record, body_count);
    if (!code && record && record->kept) code = remove_file(directory, RUN_FILE_DEBUG);
    if (!code && record && transforms_count_bodies(record) > 0)
        code = remove_file(directory, RUN_FILE_BODIES);
    if (record && record->writes_vtp) {
        char vtp[RUN_PATH_SIZE];
        run_join(vtp, directory, RUN_FOLDER_VTP);
        rmdir(vtp); /* stays when the user put something there */
    }
    if (!code) code = file_sync_folder(path);
    return code ? file_fail(error, directory, code, "its former run cannot be removed") : TULLE_OK;
}
