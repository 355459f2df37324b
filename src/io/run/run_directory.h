/* io/run/run_directory.h - the directory of a run as the file system sees it: what is in it, its
 * lock, and clearing it. */
#ifndef TULLE_IO_RUN_RUN_DIRECTORY_H
#define TULLE_IO_RUN_RUN_DIRECTORY_H

#include "io/run/run_record.h"

enum {
    RUN_PATH_SIZE = 4096,    /* [bytes] of any path in a run directory, with the zero */
    RUN_DIRECTORY_MAX = 3500 /* [bytes] of the directory's own path */
};

typedef enum run_directory_kind {
    RUN_DIRECTORY_EMPTY,
    RUN_DIRECTORY_RUN,  /* holds a run.json */
    RUN_DIRECTORY_OTHER /* holds other things only */
} run_directory_kind;

/* path = directory/name. The directory must be at most RUN_DIRECTORY_MAX bytes long. */
void run_join(char path[RUN_PATH_SIZE], const char *directory, const char *name);
/* Keeps other processes from writing here until *lock, a descriptor, is closed. A directory that is
 * missing is made first: *is_made. What is looked at before that may be another's a moment later.
 */
tulle_status run_directory_lock(const char *directory, int *lock, bool *is_made,
                                tulle_error *error);
/* 0 where the path still leads to the directory that is locked; else an errno. ENOENT: it leads
 * elsewhere or nowhere, as a directory may be removed and made again under its writer, who has no
 * right to the new one. */
int run_directory_check(const char *directory, int lock);
/* Of a directory that is locked. */
tulle_status run_directory_examine(const char *directory, run_directory_kind *kind,
                                   tulle_error *error);
/* Refuses a directory in which a file of the record's run is a link, which may lead out of it, or
 * no regular file. What is missing is fine. */
tulle_status run_directory_check_files(const char *directory, const run_record *record,
                                       tulle_error *error);
/* Refuses a directory where a name of the record's run is that of a file that is no file of the
 * former run, which the record is to replace. */
tulle_status run_directory_check_foreign(const char *directory, const run_record *former,
                                         const run_record *record, tulle_error *error);
/* Removes what writers of the record's run left that were killed: NAME.NUMBER-NUMBER.tmp, where the
 * run has a file NAME. Without a record, of the files that every run has. */
void run_directory_remove_temporaries(const char *directory, const run_record *record);
/* Removes the files of the run that the record describes (null: only those that every run has), of
 * its first body_count bodies, but run.json; all is off the disk when it returns. Files that are
 * not there are fine. */
tulle_status run_directory_clear(const char *directory, const run_record *record, size_t body_count,
                                 tulle_error *error);

/* Names of VTK files. frame < 0: of a static body. */
void run_make_vtp_name(const run_record *record, size_t body, long frame, char name[RUN_PATH_SIZE]);
void run_make_pvd_name(const run_record *record, size_t body, char name[RUN_PATH_SIZE]);

#endif
