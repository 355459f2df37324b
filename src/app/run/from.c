/* app/run/from.c - `tulle run --from RUN[:FRAME]`: a run that begins with the frames of another one
 * and goes on from the last of them, with the values that the scene has now.
 *
 * Cloth begins with the positions and velocities that the frame has, as floats, rigid bodies with
 * their places and velocities, as doubles. Frames before it are copied to the bit. An obstacle that
 * the other run has not, or that stands still now and did not do so in the same place, is absent in
 * them. Where the steps are others, as many frames a second
 * though, the steps up to there are counted as the scene makes them, and have no reports. */
#define _XOPEN_SOURCE 700
#include "app/run/session.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { NO_BODY = -1 };
/* Part of a frame by which its length may differ: products of a step and a count are rounded. */
static const double INTERVAL_TOLERANCE = 1e-9;

struct run_source {
    const char *path;
    tulle_run_reader *reader;
    const tulle_run_info *info;
    uint32_t frame;      /* the one that is gone on from */
    int *bodies;         /* of each body of the session: its index in the other run, or NO_BODY */
    double **places;     /* of each body, room for 3 * vertex_count; null where it is static */
    double **still;      /* the same, zeros, where the other run has no such body; else null */
    bool is_same;        /* all bodies are those of the other run, in its order */
    bool has_same_steps; /* the steps of the scene are as long as those of the other run */
    tulle_transform *transforms; /* of the rigid bodies of the other run */
};

static tulle_status refuse(const run_source *source, tulle_error *error, const char *words) {
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                        "the run cannot be continued: %s", words);
}

void run_source_close(run_source *source, size_t body_count) {
    if (!source) return;
    for (size_t i = 0; i < body_count; i++) {
        if (source->places) free(source->places[i]);
        if (source->still) free(source->still[i]);
    }
    free(source->transforms);
    free(source->places);
    free(source->still);
    free(source->bodies);
    tulle_run_reader_close(source->reader);
    free((char *)(uintptr_t)source->path);
    free(source);
}

/* ---- which run, which frame ---- */

/* "RUN:12" is frame 12 of RUN; "RUN" its last one. False: no memory. */
static bool split_words(const char *words, char **path, uint64_t *frame) {
    const char *const colon = strrchr(words, ':');
    bool const has_frame = colon && colon > words && colon[1] != '\0' && strlen(colon) <= 10 &&
                           colon[1 + strspn(colon + 1, "0123456789")] == '\0';
    *frame = has_frame ? strtoull(colon + 1, NULL, 10) : UINT64_MAX;
    *path = strndup(words, has_frame ? (size_t)(colon - words) : strlen(words));
    return *path != NULL;
}

static bool is_same_folder(const char *a, const char *b) {
    struct stat first, second;
    return stat(a, &first) == 0 && stat(b, &second) == 0 && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}

static tulle_status check_run(const run_session *session, run_source *source, tulle_error *error) {
    const tulle_run_info *const info = source->info;
    double const step = tulle_scene_get_time_step(session->scene);
    uint32_t const per_frame = tulle_scene_get_steps_per_frame(session->scene);
    const tulle_run_lag *lags;
    size_t lag_count = 0;
    if (is_same_folder(source->path, session->options.directory))
        return refuse(source, error, "it is the directory of the new run; give another directory");
    if (!info->has_velocities)
        return refuse(source, error,
                      "it keeps no velocities; run it with --record velocities, or debug");
    if (source->frame >= info->frame_count)
        return error_set_at(
            error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
            "the run cannot be continued from frame %u: it has %u frames, counted from 0",
            source->frame, info->frame_count);
    if (source->frame >= session->options.frame_count)
        return refuse(source, error, "the scene has no frame after it");
    source->has_same_steps = info->time_step == step && info->steps_per_frame == per_frame;
    double const interval = step * per_frame, former = info->time_step * info->steps_per_frame;
    if (fabs(interval - former) > INTERVAL_TOLERANCE * former)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "the run cannot be continued: its frames are %.9g s apart, but in the "
                            "scene they are %.9g s apart; give time.step and time.steps_per_frame "
                            "so that their product is the first number",
                            former, interval);
    if (tulle_run_reader_get_lags(source->reader, source->frame, &lags, &lag_count) != TULLE_OK ||
        lag_count > 0)
        return refuse(
            source, error,
            "an obstacle lags behind its frames there; choose a frame in which no obstacle lags");
    return TULLE_OK;
}

/* ---- whose body is whose ---- */

static int find_body(const tulle_run_info *info, const tulle_run_body *body) {
    for (size_t i = 0; i < info->body_count; i++)
        if (info->bodies[i].is_obstacle == body->is_obstacle &&
            strcmp(info->bodies[i].name, body->name) == 0)
            return (int)i;
    return NO_BODY;
}

/* A rigid body has the same mesh in the same place: its transforms lead from there. */
static tulle_status check_rigid(const run_source *source, const tulle_run_body *body, int found,
                                tulle_error *error) {
    tulle_mesh_view mesh = {0};
    if (found != NO_BODY && source->info->bodies[found].is_dynamic) {
        tulle_status const status =
            tulle_run_reader_get_mesh(source->reader, (size_t)found, &mesh, error);
        if (status != TULLE_OK) return status;
        if (memcmp(mesh.positions, body->mesh.positions,
                   3 * mesh.vertex_count * sizeof *mesh.positions) == 0)
            return TULLE_OK;
    }
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                        "the run cannot be continued: it has no rigid body '%s' of the same mesh "
                        "in the same place; give it that, or simulate from the start",
                        body->name);
}

static tulle_status match_body(run_session *session, size_t index, tulle_error *error) {
    run_source *const source = session->source;
    const tulle_run_body *const body = &session->bodies[index];
    size_t const count = body->mesh.vertex_count;
    int const found = find_body(source->info, body);
    const tulle_run_body_info *const former =
        found == NO_BODY ? NULL : &source->info->bodies[found];
    bool is_same = former && former->vertex_count == count &&
                   former->triangle_count == body->mesh.triangle_count;
    if (is_same) {
        tulle_mesh_view mesh;
        tulle_status const status =
            tulle_run_reader_get_mesh(source->reader, (size_t)found, &mesh, error);
        if (status != TULLE_OK) return status;
        is_same = memcmp(mesh.triangles, body->mesh.triangles,
                         3 * mesh.triangle_count * sizeof *mesh.triangles) == 0;
        /* frames hold no places of what is static: it stood in the same one, or is another body */
        if (body->is_static)
            is_same &= former->is_static && memcmp(mesh.positions, body->mesh.positions,
                                                   3 * count * sizeof *mesh.positions) == 0;
    }
    if (!is_same && !body->is_obstacle)
        return error_set_at(
            error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
            "the run cannot be continued: it has no cloth '%s' of the same triangles", body->name);
    if (body->is_dynamic) {
        tulle_status const status = check_rigid(source, body, is_same ? found : NO_BODY, error);
        if (status != TULLE_OK) return status;
    }
    source->bodies[index] = is_same ? found : NO_BODY;
    source->is_same &= source->bodies[index] == (int)index;
    if (body->is_static) return TULLE_OK;
    source->places[index] = malloc(3 * count * sizeof(double));
    if (!is_same) source->still[index] = calloc(3 * count, sizeof(double));
    if (!source->places[index] || (!is_same && !source->still[index]))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the run to continue");
    if (!is_same) memcpy(source->places[index], body->mesh.positions, 3 * count * sizeof(double));
    return TULLE_OK;
}

static tulle_status match_bodies(run_session *session, tulle_error *error) {
    run_source *const source = session->source;
    source->bodies = malloc(session->body_count * sizeof *source->bodies);
    source->places = calloc(session->body_count, sizeof *source->places);
    source->still = calloc(session->body_count, sizeof *source->still);
    source->transforms = calloc(source->info->body_count, sizeof *source->transforms);
    if (!source->bodies || !source->places || !source->still || !source->transforms)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the run to continue");
    source->is_same = source->info->body_count == session->body_count;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < session->body_count && status == TULLE_OK; i++)
        status = match_body(session, i, error);
    return status;
}

tulle_status run_source_open(run_session *session, tulle_error *error) {
    run_source *const source = calloc(1, sizeof *source);
    char *path = NULL;
    uint64_t frame;
    session->source = source;
    if (!source || !split_words(session->options.from, &path, &frame))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the run to continue");
    source->path = path;
    tulle_status status = tulle_run_reader_open(path, &source->reader, error);
    if (status != TULLE_OK) return status;
    source->info = tulle_run_reader_get_info(source->reader);
    if (source->info->frame_count == 0) return refuse(source, error, "it has no frame");
    source->frame = frame == UINT64_MAX ? source->info->frame_count - 1
                                        : (uint32_t)(frame < UINT32_MAX ? frame : UINT32_MAX);
    status = check_run(session, source, error);
    return status == TULLE_OK ? match_bodies(session, error) : status;
}

/* ---- the start ---- */

/* Steps up to a frame, as the scene makes them. */
static uint64_t count_steps(const run_session *session, uint32_t frame) {
    return (uint64_t)frame * tulle_scene_get_steps_per_frame(session->scene);
}

/* Reads where the session's bodies are in a frame, into places. */
static tulle_status read_places(const run_session *session, uint32_t frame, tulle_error *error) {
    const run_source *const source = session->source;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < session->body_count && status == TULLE_OK; i++)
        if (source->places[i] && source->bodies[i] != NO_BODY)
            status = tulle_run_reader_read_positions(
                source->reader, frame, (size_t)source->bodies[i], source->places[i], error);
    return status;
}

/* Reads where the session's rigid bodies are in a frame, into session->transforms; how many. */
static tulle_status read_transforms(run_session *session, uint32_t frame, size_t *count,
                                    tulle_error *error) {
    const run_source *const source = session->source;
    *count = 0;
    for (size_t i = 0; i < session->body_count; i++) *count += session->bodies[i].is_dynamic != 0;
    if (*count == 0) return TULLE_OK;
    tulle_status const status =
        tulle_run_reader_read_transforms(source->reader, frame, source->transforms, error);
    size_t next = 0;
    for (size_t i = 0; i < session->body_count && status == TULLE_OK; i++) {
        size_t place = 0;
        if (!session->bodies[i].is_dynamic) continue;
        for (int k = 0; k < source->bodies[i]; k++)
            place += source->info->bodies[k].is_dynamic != 0;
        session->transforms[next++] = source->transforms[place];
    }
    return status;
}

tulle_status run_source_start(run_session *session, tulle_error *error) {
    const run_source *const source = session->source;
    const tulle_run_debug *debug = NULL;
    tulle_moment moment = {.bodies = session->transforms};
    tulle_status status = read_places(session, source->frame, error);
    if (status == TULLE_OK)
        status = read_transforms(session, source->frame, &moment.body_count, error);
    if (status == TULLE_OK)
        status = tulle_run_reader_read_debug(source->reader, source->frame, &debug, error);
    if (status != TULLE_OK) return status;
    if (!debug) return refuse(source, error, "it does not know the velocities of this frame");
    status = tulle_run_reader_get_frame(source->reader, source->frame, &moment.time, NULL, NULL);
    moment.step_count = count_steps(session, source->frame);
    for (size_t i = 0; i < session->built.cloth_count; i++)
        moment.vertex_count += session->bodies[i].mesh.vertex_count;
    double *const joined = malloc(6 * moment.vertex_count * sizeof *joined);
    if (!joined)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the run to continue");
    moment.positions = joined;
    moment.velocities = joined + 3 * moment.vertex_count;
    double *at = joined;
    for (size_t i = 0; i < session->built.cloth_count; i++) {
        size_t const count = 3 * session->bodies[i].mesh.vertex_count;
        memcpy(at, source->places[i], count * sizeof *at);
        memcpy(at + 3 * moment.vertex_count, debug->velocities[source->bodies[i]],
               count * sizeof *at);
        at += count;
    }
    if (status == TULLE_OK) status = tulle_world_start_at(session->built.world, &moment, error);
    if (status != TULLE_OK && error && !error->file[0])
        snprintf(error->file, sizeof error->file, "%s", session->options.scene_path);
    free(joined);
    return status;
}

/* ---- the frames up to there ---- */

/* What explains the frame, for the bodies of the session; null: nothing is known of it. */
static tulle_status map_debug(run_session *session, uint32_t frame, tulle_run_debug *mapped,
                              const tulle_run_debug **debug, tulle_error *error) {
    const run_source *const source = session->source;
    const tulle_run_debug *found = NULL;
    *debug = NULL;
    tulle_status const status = tulle_run_reader_read_debug(source->reader, frame, &found, error);
    bool const is_all = session->options.records_debug;
    if (status != TULLE_OK || !found) return status;
    if (is_all && (!source->info->has_debug || !source->is_same)) return TULLE_OK;
    for (size_t i = 0; i < session->body_count; i++) {
        const double *const own =
            source->bodies[i] == NO_BODY ? NULL : found->velocities[source->bodies[i]];
        /* a body that stood still in the other run, or was not there */
        if (!own && !session->bodies[i].is_static && !source->still[i])
            source->still[i] = calloc(3 * session->bodies[i].mesh.vertex_count, sizeof(double));
        session->velocities[i] = own ? own : source->still[i];
        if (!session->velocities[i] && !session->bodies[i].is_static)
            return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the run to continue");
    }
    *mapped = *found;
    mapped->velocities = session->velocities;
    *debug = mapped;
    return TULLE_OK;
}

static tulle_status copy_frame(run_session *session, uint32_t frame, tulle_error *error) {
    const run_source *const source = session->source;
    tulle_run_debug mapped;
    tulle_run_frame copied = {.positions = session->positions,
                              .is_present = session->is_present,
                              .transforms = session->transforms};
    size_t count = 0;
    tulle_status status = read_places(session, frame, error);
    if (status == TULLE_OK) status = read_transforms(session, frame, &count, error);
    if (status == TULLE_OK) status = map_debug(session, frame, &mapped, &copied.debug, error);
    if (status == TULLE_OK)
        status = tulle_run_reader_get_frame(source->reader, frame, &copied.time, NULL,
                                            &copied.state_hash);
    copied.step = count_steps(session, frame);
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < session->body_count; i++) {
        session->positions[i] = source->places[i];
        session->is_present[i] =
            source->bodies[i] != NO_BODY &&
            tulle_run_reader_is_present(source->reader, frame, (size_t)source->bodies[i]);
    }
    if (copied.debug) copied.velocities = session->velocities;
    const tulle_run_lag *lags;
    count = 0;
    status = tulle_run_reader_get_lags(source->reader, frame, &lags, &count);
    for (size_t i = 0; i < session->body_count; i++)
        for (size_t k = 0; k < count; k++)
            if ((int)lags[k].body == source->bodies[i] && copied.lag_count < session->body_count) {
                session->lags[copied.lag_count] = lags[k];
                session->lags[copied.lag_count++].body = (uint32_t)i;
            }
    copied.lags = session->lags;
    return status == TULLE_OK ? tulle_run_write_frame(session->writer, &copied, error) : status;
}

tulle_status run_source_copy(run_session *session, tulle_error *error) {
    const run_source *const source = session->source;
    const tulle_step_report *reports = NULL;
    size_t report_count = 0, done = 0;
    tulle_status status = TULLE_OK;
    if (source->has_same_steps)
        status = tulle_run_reader_get_reports(source->reader, &reports, &report_count, error);
    for (uint32_t frame = 0; frame <= source->frame && status == TULLE_OK; frame++) {
        size_t const end = (size_t)frame * source->info->steps_per_frame;
        for (; done < end && done < report_count && status == TULLE_OK; done++) {
            tulle_run_outcome_add(&session->outcome, &reports[done]);
            status = tulle_run_write_report(session->writer, &reports[done], error);
        }
        if (status == TULLE_OK) status = copy_frame(session, frame, error);
    }
    snprintf(session->totals.message, sizeof session->totals.message,
             "frames 0 to %u come from the run %.300s, of the scene with the hash %016llx",
             source->frame, source->path, (unsigned long long)source->info->scene_hash);
    return status;
}
