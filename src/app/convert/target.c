/* app/convert/target.c - see target.h. */
#define _XOPEN_SOURCE 700
#include "app/convert/target.h"

#include "base/error.h"
#include "io/file_data.h"

#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { TEMPORARY_TRIES = 1000 /* leftovers of killed processes to step around */ };

static tulle_status refuse(const char *path, tulle_error *error, const char *text) {
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0, "%s", text);
}

/* ---- before anything is written ---- */

/* The folder of a path, "." for none. False when it does not fit. */
static bool get_folder(const char *path, char folder[NUMBERED_PATH_SIZE]) {
    const char *const slash = strrchr(path, '/');
    size_t const length = slash == path ? 1 : slash ? (size_t)(slash - path) : 0;
    if (length >= NUMBERED_PATH_SIZE) return false;
    snprintf(folder, NUMBERED_PATH_SIZE, "%.*s", (int)length, path);
    if (length == 0) strcpy(folder, ".");
    return true;
}

tulle_status convert_target_check_place(const char *path, tulle_error *error) {
    char folder[NUMBERED_PATH_SIZE];
    struct stat facts;
    if (!get_folder(path, folder)) return refuse(path, error, "the path is too long");
    if (stat(folder, &facts) != 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "cannot be written: its folder: %s", strerror(errno));
    if (!S_ISDIR(facts.st_mode))
        return refuse(path, error, "cannot be written: its folder is a file");
    if (access(folder, W_OK | X_OK) != 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "cannot be written: its folder: %s", strerror(errno));
    if (stat(path, &facts) == 0 && !S_ISREG(facts.st_mode))
        return refuse(path, error, "cannot be written: it exists and is not a regular file");
    return TULLE_OK;
}

static tulle_status check_pvd(const convert_target *target, tulle_error *error) {
    if (!target->pvd_path) return TULLE_OK;
    size_t const length = strlen(target->pvd_path);
    if (length < 5 || strcmp(target->pvd_path + length - 4, ".pvd") != 0)
        return refuse(target->pvd_path, error, "the name after --pvd should end in .pvd");
    if (!target->is_numbered || target->format != CONVERT_VTP)
        return refuse(target->path, error, "--pvd goes with numbered VTP files, as frame_%04d.vtp");
    return convert_target_check_place(target->pvd_path, error);
}

tulle_status convert_target_open(const char *path, const char *pvd_path, convert_target *target,
                                 tulle_error *error) {
    *target = (convert_target){.path = path, .pvd_path = pvd_path};
    target->format = convert_get_format(path);
    target->is_numbered = name_pattern_is_meant(path);
    if (target->format == CONVERT_NONE)
        return refuse(path, error,
                      "the name of the output should end in .obj, .ply, .stl, .vtp, .pc2, .mdd, "
                      ".glb, .gltf, .usda, .npz or .abc");
    if (target->is_numbered) {
        if (convert_is_cache(target->format))
            return refuse(path, error, "a point cache holds all frames, so its name has no number");
        tulle_status const status = name_pattern_read(path, &target->pattern, error);
        if (status != TULLE_OK) return status;
        if (target->pattern.is_any)
            return refuse(path, error,
                          "a * names files that are there; files to be written are named by their "
                          "numbers, as frame_%04d.obj");
    }
    tulle_status const status = convert_target_check_place(path, error);
    return status == TULLE_OK ? check_pvd(target, error) : status;
}

/* Of a .gltf: the path of the .bin that is written beside it. */
static void get_bin_path(char path[NUMBERED_PATH_SIZE]) {
    strcpy(path + strlen(path) - strlen("gltf"), "bin");
}

static tulle_status check_not_read(const char *path, const convert_source *source,
                                   tulle_error *error) {
    if (!convert_source_reads(source, path)) return TULLE_OK;
    return refuse(path, error, "is one of the files that are read; give another name");
}

/* The path of a frame. */
static tulle_status get_path(const convert_target *target, uint32_t frame,
                             char path[NUMBERED_PATH_SIZE], tulle_error *error) {
    if (target->is_numbered
            ? name_pattern_format(&target->pattern, frame, path)
            : snprintf(path, NUMBERED_PATH_SIZE, "%s", target->path) < NUMBERED_PATH_SIZE)
        return TULLE_OK;
    return refuse(target->path, error, "the path is too long");
}

bool convert_target_is_one_mesh(const convert_target *target) {
    return !target->is_numbered && target->format < CONVERT_PC2;
}

tulle_status convert_target_check(const convert_target *target, const convert_source *source,
                                  frame_range frames, tulle_error *error) {
    uint32_t const count = frame_range_get_count(frames);
    if (count > 1 && convert_target_is_one_mesh(target))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, target->path, 0, 0,
                            "is one mesh, but there are %u frames; choose a frame with --frame, or "
                            "name numbered files, as frame_%%04d.obj",
                            count);
    if (source->mesh.triangle_count == 0 && target->format == CONVERT_STL)
        return refuse(target->path, error, "STL holds triangles, but there are none");
    for (uint32_t i = 0; i < count; i++) {
        char path[NUMBERED_PATH_SIZE];
        tulle_status status = get_path(target, frame_range_get(frames, i), path, error);
        if (status == TULLE_OK) status = check_not_read(path, source, error);
        if (status == TULLE_OK && target->format == CONVERT_GLTF) {
            get_bin_path(path);
            status = convert_target_check_place(path, error);
            if (status == TULLE_OK) status = check_not_read(path, source, error);
        }
        if (status != TULLE_OK || !target->is_numbered) return status;
    }
    return TULLE_OK;
}

/* ---- frames ---- */

bool convert_target_is_float(const convert_target *target) {
    return target->format == CONVERT_STL || target->format >= CONVERT_PC2;
}

tulle_status convert_target_measure(convert_target *target, const double *positions,
                                    size_t vertex_count, tulle_error *error) {
    for (size_t i = 0; i < 3 * vertex_count; i++) {
        double const rounded = (double)(float)positions[i];
        if (!isfinite(rounded))
            return error_set_at(error, TULLE_ERROR_INVALID_MESH, target->path, 0, 0,
                                "coordinate %c of vertex %zu is %g, which float cannot hold",
                                "xyz"[i % 3], i / 3, positions[i]);
        target->worst_rounding = fmax(target->worst_rounding, fabs(rounded - positions[i]));
    }
    return TULLE_OK;
}

/* An unused name in the target's folder; links are followed. */
static bool make_temporary(convert_target *target) {
    char resolved[PATH_MAX];
    const char *const final = realpath(target->path, resolved) ? resolved : target->path;
    if (snprintf(target->final, NUMBERED_PATH_SIZE, "%s", final) >= NUMBERED_PATH_SIZE)
        return false;
    for (int try = 0; try < TEMPORARY_TRIES; try++) {
        int const length = snprintf(target->temporary, NUMBERED_PATH_SIZE, "%s.%ld-%d.tmp", final,
                                    (long)getpid(), try);
        if (length < 0 || length >= NUMBERED_PATH_SIZE) break;
        if (access(target->temporary, F_OK) != 0) return true;
    }
    target->temporary[0] = '\0';
    return false;
}

/* Messages name the target, not the temporary file. */
static tulle_status rename_error(const convert_target *target, tulle_status status,
                                 tulle_error *error) {
    if (status != TULLE_OK && error) snprintf(error->file, sizeof error->file, "%s", target->path);
    return status;
}

static tulle_status append_frame(convert_target *target, tulle_mesh_view mesh, tulle_error *error) {
    tulle_status status = TULLE_OK;
    if (!target->writer) {
        if (!make_temporary(target))
            return error_set_at(error, TULLE_ERROR_IO, target->path, 0, 0,
                                "cannot be written: no free temporary name in its directory");
        status = tulle_pc2_writer_open(target->temporary, (uint32_t)mesh.vertex_count, 0,
                                       &target->writer, error);
        if (status == TULLE_OK) tulle_pc2_writer_defer_flush(target->writer);
    }
    if (status == TULLE_OK) status = tulle_pc2_writer_append(target->writer, mesh.positions, error);
    return rename_error(target, status, error);
}

static void count_written(convert_target *target, uint32_t frame) {
    if (target->written_count++ == 0) target->first_number = frame;
    target->last_number = frame;
}

tulle_status convert_target_write(convert_target *target, uint32_t frame, tulle_mesh_view mesh,
                                  tulle_error *error) {
    char path[NUMBERED_PATH_SIZE];
    tulle_status status = get_path(target, frame, path, error);
    if (status == TULLE_OK && convert_target_is_float(target))
        status = convert_target_measure(target, mesh.positions, mesh.vertex_count, error);
    if (status != TULLE_OK) return status;
    switch (target->format) {
    case CONVERT_PC2: status = append_frame(target, mesh, error); break;
    case CONVERT_VTP: status = tulle_vtp_write(path, mesh, NULL, error); break;
    default: status = tulle_mesh_write(path, mesh, error); break;
    }
    if (status == TULLE_OK) count_written(target, frame);
    return status;
}

tulle_status convert_target_write_animation(convert_target *target, frame_range frames,
                                            const tulle_animation_def *def, tulle_error *error) {
    char path[NUMBERED_PATH_SIZE];
    tulle_status status = get_path(target, frames.first, path, error);
    if (status == TULLE_OK) status = tulle_animation_write(path, def, error);
    if (status == TULLE_OK) count_written(target, frames.first);
    return status;
}

/* ---- the end ---- */

static tulle_status finish_cache(convert_target *target, tulle_error *error) {
    tulle_status const status = tulle_pc2_writer_close(target->writer, error);
    target->writer = NULL;
    if (status != TULLE_OK) return rename_error(target, status, error);
    int const code = file_rename(target->temporary, target->final);
    if (code) return file_fail(error, target->path, code, "cannot be written");
    target->temporary[0] = '\0';
    return TULLE_OK;
}

/* Whether two paths have the same folder. */
static bool is_beside(const char *a, const char *b) {
    char folders[2][NUMBERED_PATH_SIZE];
    struct stat facts[2];
    return get_folder(a, folders[0]) && get_folder(b, folders[1]) &&
           stat(folders[0], &facts[0]) == 0 && stat(folders[1], &facts[1]) == 0 &&
           facts[0].st_dev == facts[1].st_dev && facts[0].st_ino == facts[1].st_ino;
}

/* The name by which the collection knows a file, as new memory; null when memory is short. */
static char *make_collection_name(const convert_target *target, const char *path) {
    char resolved[PATH_MAX];
    const char *const slash = strrchr(path, '/');
    if (is_beside(path, target->pvd_path)) return strdup(slash ? slash + 1 : path);
    return strdup(realpath(path, resolved) ? resolved : path);
}

static tulle_status write_collection(const convert_target *target, const convert_source *source,
                                     frame_range frames, tulle_error *error) {
    uint32_t const count = frame_range_get_count(frames);
    char **const names = calloc(count, sizeof *names);
    double *const times = calloc(count, sizeof *times);
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < count && names && times && status == TULLE_OK; i++) {
        char path[NUMBERED_PATH_SIZE];
        uint32_t const frame = frame_range_get(frames, i);
        status = convert_source_find_time(source, frame, &times[i], error);
        if (isnan(times[i])) times[i] = (double)frame;
        if (status == TULLE_OK) status = get_path(target, frame, path, error);
        if (status == TULLE_OK && !(names[i] = make_collection_name(target, path)))
            status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    if (!names || !times)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %u names", count);
    if (status == TULLE_OK)
        status = tulle_pvd_write(target->pvd_path, (const char *const *)names, times, count, error);
    for (uint32_t i = 0; i < count && names; i++) free(names[i]);
    free(names);
    free(times);
    return status;
}

tulle_status convert_target_finish(convert_target *target, const convert_source *source,
                                   frame_range frames, tulle_error *error) {
    if (target->writer) return finish_cache(target, error);
    return target->pvd_path ? write_collection(target, source, frames, error) : TULLE_OK;
}

void convert_target_close(convert_target *target) {
    tulle_pc2_writer_close(target->writer, NULL);
    target->writer = NULL;
    if (target->temporary[0]) unlink(target->temporary);
    target->temporary[0] = '\0';
}

bool convert_target_describe(const convert_target *target, char *text, size_t size) {
    if (target->written_count == 0 || target->writer || target->temporary[0]) return false;
    char first[NUMBERED_PATH_SIZE], last[NUMBERED_PATH_SIZE];
    if (!target->is_numbered || !name_pattern_format(&target->pattern, target->first_number, first))
        snprintf(text, size, "%s", target->path);
    else if (target->written_count == 1)
        snprintf(text, size, "%s", first);
    else if (name_pattern_format(&target->pattern, target->last_number, last))
        snprintf(text, size, "%s to %s, %u files", first, last, target->written_count);
    return true;
}
