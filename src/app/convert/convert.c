/* app/convert/convert.c - `tulle convert`: meshes, point caches, runs and numbered files from one
 * format to another, with other axes and units, subdivided or not.
 *
 * All that can be wrong with the names, the options and the input's structure is found before the
 * first file is written. Frames go through one by one: read, subdivided and judged, turned and
 * scaled, written. */
#include "app/cli/axes.h"
#include "app/cli/frame_progress.h"
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "app/convert/judge.h"
#include "app/convert/repair.h"
#include "app/convert/rounding.h"
#include "app/convert/scene.h"
#include "app/convert/target.h"
#include "base/error.h"
#include "scene/units.h"

#include "tulle_io/subdivision.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Morph targets from which on viewers of glTF fail or take very long: the layers of a texture that
 * every graphics card of the last years has. */
enum { TARGETS_MANY = 2048 };
enum { FILES_SIZE = 2 * NUMBERED_PATH_SIZE + 64 /* [bytes] of a text that names files */ };

/* The words of the command line. */
typedef struct convert_words {
    const char *mesh, *body, *frame, *frames, *pvd;
    const char *from_up, *up, *from_unit, *unit; /* ups null: as FROM and TO have it */
    const char *fps, *interpolation, *progress, *tolerance;
    int is_double, repairs;
    long levels;
} convert_words;

typedef struct convert_session {
    convert_source source;
    convert_target target;
    axes_change change;
    frame_range frames;
    long levels;                    /* of subdivision; 0: none */
    tulle_subdivision *subdivision; /* null: none */
    convert_judge judge;            /* of subdivided frames */
    uint32_t judged_count;          /* frames that have been judged */
    convert_rounding rounding;      /* what rounding to float does */
    convert_scene scene;            /* where an animation is written */
    convert_repair repair;
    bool repairs;
    bool takes_all;                      /* all bodies of a run are written */
    double *read, *written;              /* positions; the same where there is no subdivision */
    size_t vertex_count, triangle_count; /* of what is written */
    const uint32_t *triangles;
    frame_progress progress;
    bool is_writing; /* a failure is one of the output */
} convert_session;

static const char *const interpolation_choices[] = {"linear", "step", NULL};

static options_outcome read_words(int argc, char **argv, convert_words *words) {
    const option_spec options[] = {
        TEXT_OPTION("mesh", 'm', &words->mesh, "FILE",
                    "the mesh whose points a point cache (.pc2) moves"),
        TEXT_OPTION("body", 'b', &words->body, "NAME", "body of a run (default: its only cloth)"),
        TEXT_OPTION("frame", 0, &words->frame, "N", "number of the one frame to convert, or last"),
        TEXT_OPTION("frames", 0, &words->frames, "RANGE", FRAME_RANGE_HELP),
        INTEGER_OPTION("subdivide", 0, &words->levels, "N", 0, TULLE_SUBDIVISION_LEVELS_MAX,
                       "smooth by N steps of Loop subdivision; each makes four triangles of one"),
        FLAG_OPTION(
            "repair", 0, &words->repairs,
            "make a mesh fit for cloth, and list the repairs: drop triangles without area "
            "and\nduplicates, join boundaries that meet, cut where an edge has three triangles or "
            "a\nvertex several fans, turn triangles alike, leave out loose vertices"),
        TEXT_OPTION(
            "tolerance", 0, &words->tolerance, "LENGTH",
            "with --repair: how far apart boundaries may be that meet, as 0.1mm (default: 0)"),
        CHOICE_OPTION("up", 0, &words->up, "y|z", axes_up_choices,
                      "axis that points up in TO (default: z; of .glb, .gltf and .abc y)"),
        CHOICE_OPTION("from-up", 0, &words->from_up, "y|z", axes_up_choices,
                      "axis that points up in FROM (default: z, as Tulle has it; of .glb, .gltf, "
                      ".abc y; of .usda as\n"
                      "the file says)"),
        CHOICE_OPTION("units", 0, &words->unit, "m|cm|mm|in|ft", axes_unit_choices,
                      "unit of length of TO (default: m)"),
        CHOICE_OPTION(
            "from-units", 0, &words->from_unit, "m|cm|mm|in|ft", axes_unit_choices,
            "unit of length of FROM (default: m, as Tulle has it; of .usda as the file says)"),
        TEXT_OPTION("fps", 0, &words->fps, "N",
                    "frames in a second, where FROM has no times (default: 24)"),
        CHOICE_OPTION("interpolation", 0, &words->interpolation, "linear|step",
                      interpolation_choices,
                      "what .glb and .gltf show between two frames: a smooth transition (default), "
                      "or the\nfirst of the two"),
        FLAG_OPTION("double", 0, &words->is_double,
                    "positions of .npz as float64 (default: float32)"),
        CHOICE_OPTION("progress", 0, &words->progress, "auto|json|none", progress_choices,
                      "how progress is shown on standard error (default: auto)"),
        TEXT_OPTION("pvd", 0, &words->pvd, "FILE.pvd",
                    "also write a ParaView collection of the numbered VTP files with their times"),
    };
    const command_spec command = COMMAND(
        "convert", "FROM TO", options, 2, 2,
        "Converts FROM, a mesh (.obj, .ply, .stl, .vtp), a point cache (.pc2, .mdd), an\n"
        "animation (.glb, .gltf, .usda, .npz, .abc), the directory of a run, or numbered "
        "meshes\n"
        "(frame_%04d.obj or 'frame_*.obj'), to TO, a mesh, a point cache, an animation\n"
        "(.glb, .gltf, .usda, .npz, .abc), or numbered files of meshes (out_%04d.vtp, with the\n"
        "numbers of their frames). A run becomes an animation with all its bodies, or with\nthe "
        "body of --body.\nReports how frames, axes and units were converted, and any losses. A "
        "subdivided\nsurface is judged: intersections are reported, and the exit code stays 0.");
    size_t operand_count = 0;
    return options_parse(&command, argc, argv, &operand_count);
}

/* ---- preparation ---- */

static tulle_status choose_frames(convert_session *session, const convert_words *words,
                                  tulle_error *error) {
    const convert_source *const source = &session->source;
    if (source->needs_frames_named && !words->frame && !words->frames)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "there is no file of number %u; --frames names those to be read",
                            source->gap);
    return frame_range_read(words->frame, words->frames, source->frames, &session->frames, error);
}

static tulle_status make_subdivision(convert_session *session, tulle_error *error) {
    if (session->source.mesh.triangle_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, session->source.path, 0, 0,
                            "--subdivide needs triangles, and there are none%s",
                            session->source.kind == SOURCE_CACHE ? "; give their file by --mesh"
                                                                 : "");
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = (int)session->levels;
    tulle_status status = tulle_subdivision_create(tulle_mesh_get_view(&session->source.mesh), &def,
                                                   &session->subdivision, error);
    if (status == TULLE_OK) status = convert_judge_open(&session->source, &session->judge, error);
    if (status != TULLE_OK) return status;
    session->vertex_count = tulle_subdivision_get_vertex_count(session->subdivision);
    session->triangle_count = tulle_subdivision_get_triangle_count(session->subdivision);
    session->triangles = tulle_subdivision_get_triangles(session->subdivision);
    return TULLE_OK;
}

static tulle_status check_format_options(const convert_session *session, const convert_words *words,
                                         tulle_error *error) {
    convert_format const format = session->target.format;
    const char *text = NULL;
    if (words->is_double && format != CONVERT_NPZ) text = "--double is for .npz";
    if (words->interpolation && format != CONVERT_GLB && format != CONVERT_GLTF)
        text = "--interpolation is for .glb and .gltf";
    if (words->fps && !convert_is_animation(format))
        text = "--fps is for formats that have times: .mdd, .glb, .gltf, .usda, .npz and .abc";
    return text ? error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, session->target.path, 0, 0,
                               "%s", text)
                : TULLE_OK;
}

static tulle_status read_animated(void *context, uint32_t frame, double *positions,
                                  tulle_error *error);

static tulle_status open_scene(convert_session *session, const convert_words *words,
                               tulle_error *error) {
    scene_options const options = {.takes_all = session->takes_all,
                                   .fps = words->fps,
                                   .up = session->change.to.up,
                                   .meters_per_unit = axes_get_meters(words->unit),
                                   .is_stepped = words->interpolation &&
                                                 strcmp(words->interpolation, "step") == 0,
                                   .is_double = words->is_double != 0,
                                   .change = &session->change};
    tulle_status const status = convert_scene_open(
        &session->scene, &session->source, &session->target, &options, session->frames, error);
    if (status != TULLE_OK || session->takes_all) return status;
    tulle_mesh_view const mesh = {NULL, session->vertex_count, session->triangles,
                                  session->triangle_count};
    convert_scene_set_surface(&session->scene, mesh,
                              session->subdivision ? NULL : session->source.described.corner_uvs,
                              read_animated, session);
    return TULLE_OK;
}

/* Where the options do not say: as the file has it that is read; in what is written y is up in
 * glTF and Alembic, z in all else. */
static tulle_status choose_axes(convert_session *session, const convert_words *words,
                                tulle_error *error) {
    convert_format const format = session->target.format;
    bool const is_to_y = format == CONVERT_GLB || format == CONVERT_GLTF || format == CONVERT_ABC;
    const char *const up = is_to_y ? "y" : "z";
    axes_frame from;
    tulle_status const status = convert_source_find_axes(
        &session->source, (axes_frame){words->from_up, words->from_unit}, &from, error);
    if (status != TULLE_OK) return status;
    session->change = axes_change_make(from, (axes_frame){words->up ? words->up : up, words->unit});
    return TULLE_OK;
}

static tulle_status repair_source(convert_session *session, const convert_words *words,
                                  tulle_error *error) {
    double tolerance = 0.0;
    session->repairs = words->repairs != 0;
    if (words->tolerance && !session->repairs)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "--tolerance goes with --repair");
    if (words->tolerance &&
        (quantity_read(words->tolerance, UNIT_LENGTH, &tolerance) != QUANTITY_READ ||
         !(tolerance >= 0.0 && tolerance <= 1.0)))
        return error_set(
            error, TULLE_ERROR_INVALID_ARGUMENT,
            "--tolerance is \"%s\"; it should be a length from 0 to 1 m, with its unit, as 0.1mm",
            words->tolerance);
    if (!session->repairs) return TULLE_OK;
    double const meters = axes_get_meters(session->change.from.unit);
    return convert_repair_source(&session->source, session->frames, tolerance / meters,
                                 &session->repair, error);
}

/* Opens what is read and finds out whether all can be done. */
static tulle_status open_all(convert_session *session, char **operands, const convert_words *words,
                             tulle_error *error) {
    tulle_status status = convert_target_open(operands[1], words->pvd, &session->target, error);
    if (status == TULLE_OK) status = check_format_options(session, words, error);
    if (status != TULLE_OK) return status;
    convert_format const format = session->target.format;
    session->levels = words->levels;
    source_options const options = {.path = operands[0],
                                    .mesh_path = words->mesh,
                                    .body = words->body,
                                    .takes_all = convert_is_scene(format) && words->levels == 0 &&
                                                 !words->repairs};
    status = convert_source_open(&options, &session->source, error);
    if (status == TULLE_OK) status = choose_axes(session, words, error);
    session->takes_all = options.takes_all && !words->body && session->source.kind == SOURCE_RUN;
    if (status == TULLE_OK) status = choose_frames(session, words, error);
    if (status == TULLE_OK) status = repair_source(session, words, error);
    return status == TULLE_OK
               ? convert_target_check(&session->target, &session->source, session->frames, error)
               : status;
}

static tulle_status prepare(convert_session *session, char **operands, const convert_words *words,
                            tulle_error *error) {
    tulle_status status = open_all(session, operands, words, error);
    if (status != TULLE_OK) return status;
    session->vertex_count = session->source.mesh.vertex_count;
    session->triangle_count = session->source.mesh.triangle_count;
    session->triangles = session->source.mesh.triangles;
    if (session->levels > 0) status = make_subdivision(session, error);
    if (status != TULLE_OK) return status;
    session->read = calloc(session->source.mesh.vertex_count, 3 * sizeof(double));
    session->written =
        session->subdivision ? calloc(session->vertex_count, 3 * sizeof(double)) : session->read;
    if (!session->read || !session->written)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices",
                         session->vertex_count);
    return convert_is_animation(session->target.format) ? open_scene(session, words, error)
                                                        : TULLE_OK;
}

static void release(convert_session *session) {
    convert_scene_close(&session->scene);
    convert_target_close(&session->target);
    if (session->subdivision) free(session->written);
    free(session->read);
    convert_judge_close(&session->judge);
    tulle_subdivision_destroy(session->subdivision);
    convert_source_close(&session->source);
}

/* ---- frames ---- */

static tulle_mesh_view view_written(const convert_session *session) {
    return (tulle_mesh_view){session->written, session->vertex_count, session->triangles,
                             session->triangle_count};
}

/* A frame may be read several times, but its first reading comes after those of all before; then it
 * is judged. */
static tulle_status subdivide(convert_session *session, uint32_t frame, tulle_error *error) {
    tulle_status status =
        tulle_subdivision_apply(session->subdivision, session->read, 3, session->written, error);
    if (status != TULLE_OK) return status;
    if ((frame - session->frames.first) / session->frames.step < session->judged_count)
        return TULLE_OK;
    session->judged_count++;
    tulle_mesh_view simulated = tulle_mesh_get_view(&session->source.mesh);
    simulated.positions = session->read;
    subdivided_verdict verdict;
    status = convert_judge_frame(&session->judge, frame, simulated, view_written(session), &verdict,
                                 error);
    if (status == TULLE_OK && verdict.pair_count > 0)
        frame_progress_say(&session->progress, verdict.text);
    return status;
}

static tulle_status check_finite(const convert_session *session, uint32_t frame,
                                 tulle_error *error) {
    for (size_t i = 0; i < 3 * session->vertex_count; i++)
        if (!isfinite(session->written[i]))
            return error_set_at(error, TULLE_ERROR_INVALID_MESH, session->source.path, 0, 0,
                                "frame %u: vertex %zu is too far away for these units", frame,
                                i / 3);
    return TULLE_OK;
}

/* Makes the positions of a frame as they are to be written. */
static tulle_status make_frame(convert_session *session, uint32_t frame, tulle_error *error) {
    tulle_status status = convert_source_read(&session->source, frame, session->read, error);
    if (status == TULLE_OK && session->subdivision) status = subdivide(session, frame, error);
    if (status != TULLE_OK) return status;
    axes_apply(&session->change, session->written, session->vertex_count);
    return check_finite(session, frame, error);
}

static tulle_status read_animated(void *context, uint32_t frame, double *positions,
                                  tulle_error *error) {
    convert_session *const session = context;
    tulle_status const status = make_frame(session, frame, error);
    if (status == TULLE_OK)
        memcpy(positions, session->written, 3 * session->vertex_count * sizeof(double));
    return status;
}

static tulle_status convert_frame(convert_session *session, uint32_t frame, tulle_error *error) {
    session->is_writing = false;
    if (convert_is_animation(session->target.format)) {
        tulle_status const status =
            convert_scene_write(&session->scene, (frame_range){frame, frame, 1}, error);
        session->is_writing = !session->scene.is_reading;
        return status;
    }
    tulle_status const status = make_frame(session, frame, error);
    if (status != TULLE_OK) return status;
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    session->is_writing = true;
    return convert_target_write(&session->target, frame, view_written(session), error);
}

static tulle_status convert_frames(convert_session *session, tulle_error *error) {
    uint32_t const count = frame_range_get_count(session->frames);
    tulle_status status = TULLE_OK;
    if (convert_is_animation(session->target.format) && !session->target.is_numbered) {
        session->scene.progress = &session->progress;
        status = convert_scene_write(&session->scene, session->frames, error);
        session->is_writing = !session->scene.is_reading;
        return status;
    }
    for (uint32_t i = 0; i < count && status == TULLE_OK; i++) {
        status = convert_frame(session, frame_range_get(session->frames, i), error);
        if (status == TULLE_OK) frame_progress_show(&session->progress, i + 1, count);
    }
    if (status != TULLE_OK) return status;
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    session->is_writing = true;
    return convert_target_finish(&session->target, &session->source, session->frames, error);
}

/* Where numbers are rounded to float: whether that leads surfaces through each other. */
static tulle_status judge_rounding(convert_session *session, tulle_error *error) {
    const convert_target *const target = &session->target;
    if (!convert_target_is_float(target) || session->scene.def.is_double ||
        (target->worst_rounding == 0.0 && session->scene.rigid_count == 0) ||
        session->triangle_count == 0)
        return TULLE_OK;
    bool const is_run =
        session->source.kind == SOURCE_RUN && !session->subdivision && !session->repairs;
    rounding_input const input = {
        .source = &session->source,
        .change = &session->change,
        .frames = session->frames,
        .mesh = {NULL, session->vertex_count, session->triangles, session->triangle_count},
        .read = is_run ? NULL : read_animated,
        .context = session,
        .scene = session->scene.bodies ? &session->scene : NULL};
    return convert_rounding_judge(&input, &session->rounding, error);
}

/* ---- report ---- */

static void print_frames(const convert_session *session) {
    frame_range const frames = session->frames;
    uint32_t const count = frame_range_get_count(frames);
    if (session->source.kind == SOURCE_MESH) return;
    if (count == 1)
        printf("  %-11s %u\n", "frame", frames.first);
    else if (frames.step == 1)
        printf("  %-11s %u to %u: %u\n", "frames", frames.first, frames.last, count);
    else
        printf("  %-11s %u to %u in steps of %u: %u\n", "frames", frames.first, frames.last,
               frames.step, count);
    if (session->source.kind == SOURCE_ANIMATION &&
        session->source.animation_info.added_frame_count > 0)
        printf("  %-11s %u of the file's %u are between keys, along the arcs of turns and curves, "
               "and before jumps\n",
               "", session->source.animation_info.added_frame_count,
               session->source.animation_info.frame_count);
    if (count > TARGETS_MANY && !session->target.is_numbered &&
        (session->target.format == CONVERT_GLB || session->target.format == CONVERT_GLTF))
        printf("  %-11s a morph target each, more than most viewers show; --frames A:B:STEP takes "
               "fewer\n",
               "");
    if (count > 1 && session->target.format == CONVERT_PC2 &&
        (frames.first != 0 || frames.step != 1))
        printf("  %-11s the point cache counts them from 0\n", "");
    uint32_t const absent =
        session->takes_all ? 0 : convert_source_count_absent(&session->source, frames);
    if (absent > 0)
        printf("  %-11s in %u of them the body is not in the scene; they are written, too\n", "",
               absent);
}

static void print_bodies(const convert_scene *scene) {
    size_t vertex_count = 0, triangle_count = 0, rigid_count = 0, copy_count = 0;
    for (size_t i = 0; i < scene->count; i++) {
        const tulle_animation_surface *const surface = &scene->surfaces[i];
        rigid_count += surface->motion == TULLE_ANIMATION_RIGID;
        copy_count += surface->prototype != i;
        if (surface->prototype != i) continue;
        vertex_count += surface->mesh.vertex_count;
        triangle_count += surface->mesh.triangle_count;
    }
    printf("  %-11s %zu: %zu move by translation and rotation, %zu share the mesh of another\n",
           "bodies", scene->count, rigid_count, copy_count);
    printf("  %-11s %zu vertices, %zu triangles\n", "meshes", vertex_count, triangle_count);
}

static void print_counts(const convert_session *session) {
    const tulle_mesh *const mesh = &session->source.mesh;
    if (session->takes_all) {
        print_bodies(&session->scene);
        return;
    }
    printf("  %-11s %zu vertices, %zu triangles\n", "mesh", mesh->vertex_count,
           mesh->triangle_count);
    if (!session->subdivision) return;
    printf("  %-11s %ld time%s: %zu vertices, %zu triangles\n", "subdivided", session->levels,
           session->levels == 1 ? "" : "s", session->vertex_count, session->triangle_count);
    char text[SUBDIVIDED_TEXT_SIZE];
    subdivided_totals_describe(&session->judge.totals, text);
    printf("  %-11s %s\n", "judged", text);
}

/* Prints a line of what was lost; the first one has the label. */
#define PRINT_LOSS(count, ...)                                                                     \
    (printf("  %-11s ", (count)++ == 0 ? "loss" : ""), printf(__VA_ARGS__), (void)putchar('\n'))

static void print_animation_losses(const convert_session *session, int *count) {
    const convert_scene *const scene = &session->scene;
    bool const is_gltf =
        session->target.format == CONVERT_GLB || session->target.format == CONVERT_GLTF;
    bool is_rigid = false, has_absent = false;
    for (size_t i = 0; i < scene->count; i++) {
        is_rigid = is_rigid || scene->surfaces[i].motion == TULLE_ANIMATION_RIGID;
        has_absent = has_absent ||
                     (scene->bodies &&
                      convert_source_count_absent(&scene->bodies[i].source, session->frames) > 0);
    }
    if (is_rigid && is_gltf)
        PRINT_LOSS(*count, "places and turns of rigid bodies are rounded to float");
    if (has_absent && session->target.format != CONVERT_USDA)
        PRINT_LOSS(*count, "bodies are written also in frames in which they are not in the scene");
    if (is_gltf && strcmp(session->change.to.unit, "m") != 0)
        PRINT_LOSS(*count, "glTF counts in metres; readers will not know of %s",
                   session->change.to.unit);
    else if (is_gltf && strcmp(session->change.to.up, "y") != 0)
        PRINT_LOSS(*count, "in glTF y points up; readers will not know of z");
}

/* A difference of times as near to others, as a part of them, is the same, told as a float. */
static const double EVEN_TOLERANCE = 1e-4;

/* Of the times of an animation or an MDD file, where they are not written. */
static void print_time_losses(const convert_session *session, int *count) {
    const convert_source *const source = &session->source;
    frame_range const frames = session->frames;
    uint32_t const frame_count = frame_range_get_count(frames);
    bool const has_times = source->kind == SOURCE_CACHE ||
                           (source->kind == SOURCE_ANIMATION && source->animation_info.has_times);
    if (!has_times || frame_count < 2 || convert_is_animation(session->target.format) ||
        session->target.pvd_path)
        return;
    double first = (double)NAN, before = (double)NAN, least = INFINITY, most = -INFINITY;
    for (uint32_t i = 0; i < frame_count; i++) {
        double time = (double)NAN;
        convert_source_find_time(source, frame_range_get(frames, i), &time, NULL);
        if (i == 0) first = time;
        if (i > 0) least = fmin(least, time - before), most = fmax(most, time - before);
        before = time;
    }
    const char *const holder = session->target.format == CONVERT_PC2
                                   ? "the point cache counts frames, without times"
                                   : "numbered files have no times";
    if (isnan(before) || !(least > 0.0)) return; /* there were none that say anything */
    if (most - least > EVEN_TOLERANCE * most)
        PRINT_LOSS(*count,
                   "%s: these frames are not even, but %.3g s to %.3g s apart; .mdd, .npz, .usda "
                   "and glTF keep their times",
                   holder, least, most);
    else
        PRINT_LOSS(*count, "%s: the first one is at %.6g s, and a second has %.6g", holder, first,
                   (frame_count - 1) / (before - first));
}

static void print_losses(const convert_session *session) {
    const convert_source *const source = &session->source;
    const convert_target *const target = &session->target;
    int count = 0;
    if (convert_target_is_float(target) && !session->scene.def.is_double &&
        target->worst_rounding > 0.0)
        PRINT_LOSS(count, "positions are rounded to float, by %.2g %s at most",
                   target->worst_rounding, session->change.to.unit);
    if (session->rounding.is_unknown)
        PRINT_LOSS(count, "whether that leads a surface through another is not known: %s",
                   session->rounding.text);
    if (session->rounding.frame_count > 0)
        PRINT_LOSS(count,
                   "in %u frames surfaces that do not intersect pass through each other when they "
                   "are rounded: in frame %u floats %s. Formats with doubles keep them apart: "
                   ".obj, .ply, .vtp, and .npz with --double",
                   session->rounding.frame_count, session->rounding.first, session->rounding.text);
    if (target->format == CONVERT_STL)
        PRINT_LOSS(count, "each triangle has corners of its own; a reader joins corners with the "
                          "same coordinates to one vertex");
    if (convert_is_cache(target->format) && session->triangle_count > 0)
        PRINT_LOSS(count, "the point cache holds no triangles; keep them in a mesh file");
    if (source->kind != SOURCE_RUN && convert_get_format(source->path) == CONVERT_STL)
        PRINT_LOSS(count, "corners of %zu triangles in the same place became %zu vertices",
                   source->mesh.triangle_count, source->mesh.vertex_count);
    if (source->described.note[0]) PRINT_LOSS(count, "%s", source->described.note);
    print_animation_losses(session, &count);
    print_time_losses(session, &count);
    if (source->kind == SOURCE_ANIMATION)
        PRINT_LOSS(count, "all surfaces became one mesh; normals, texture coordinates, colors and "
                          "names are not read");
    if (source->kind == SOURCE_CACHE && !convert_is_animation(target->format) &&
        (source->cache_info.start_frame != 0.0 || source->cache_info.frame_step != 1.0))
        PRINT_LOSS(count, "the cache began at %g with a frame every %g; that is not kept",
                   source->cache_info.start_frame, source->cache_info.frame_step);
    if (count == 0) PRINT_LOSS(count, "none");
}

static void print_report(const convert_session *session) {
    char files[FILES_SIZE];
    if (convert_target_describe(&session->target, files, sizeof files))
        app_print_names(stdout, "%s\n", files);
    if (session->target.pvd_path) app_print_names(stdout, "%s\n", session->target.pvd_path);
    convert_source_print(&session->source, session->takes_all);
    print_frames(session);
    print_counts(session);
    if (session->repairs) convert_repair_print(&session->repair);
    axes_print(&session->change);
    print_losses(session);
}

static int fail(const convert_session *session, tulle_status status, const tulle_error *error) {
    char files[FILES_SIZE];
    app_print_error("convert", error);
    if (convert_target_describe(&session->target, files, sizeof files))
        app_print_message("convert", "whole and there: %s; nothing else was written", files);
    else if (status == TULLE_ERROR_INTERRUPTED)
        app_print_message("convert", "nothing was written");
    return session->is_writing ? app_exit_for_run(status) : app_exit_for_input(status);
}

int app_convert(int argc, char **argv) {
    convert_words words = {.unit = "m"};
    options_outcome const outcome = read_words(argc, argv, &words);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    convert_session *const session = calloc(1, sizeof *session);
    if (!session) {
        app_print_message("convert", "out of memory");
        return APP_EXIT_OUT_OF_MEMORY;
    }
    tulle_error error = {0};
    interrupt_catch();
    tulle_status status = prepare(session, argv, &words, &error);
    session->progress = frame_progress_begin("convert", words.progress);
    if (status == TULLE_OK) status = convert_frames(session, &error);
    if (status == TULLE_OK) status = judge_rounding(session, &error);
    frame_progress_end(&session->progress, status);
    int code = APP_EXIT_FINE;
    if (status == TULLE_OK) {
        print_report(session);
        code = app_finish_output("convert");
    } else {
        code = fail(session, status, &error);
    }
    release(session);
    free(session);
    return code;
}
