/* app/view/editing.c - the scene's text beside the picture: read, checked, saved, loaded anew. The
 * only file that is written is the scene that the program was started with. */
#include "app/view/assets.h"
#include "app/view/session.h"
#include "app/view/session_file.h"
#include "base/error.h"
#include "base/hash.h"
#include "io/file_data.h"
#include "scene/scene.h"

#include "tulle_io/mesh_files.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *get_path(const view_session *session) { return session->options->paths[0]; }

/* ---- problems ---- */

/* A problem in another file, as a mesh, names it. */
static void write_problems(const char *path, const tulle_scene_problems *problems,
                           view_buffer *buffer) {
    buffer_print(buffer, "[");
    for (size_t i = 0; i < problems->count; i++) {
        const tulle_error *const problem = &problems->list[i];
        bool const is_here = strcmp(problem->file, path) == 0;
        view_buffer text = {0};
        if (!is_here) buffer_print(&text, "%s: ", problem->file);
        buffer_print(&text, "%s", problem->message);
        buffer_put_u8(&text, 0);
        buffer_print(buffer, "%s{\"line\":%d,\"column\":%d", i > 0 ? "," : "",
                     is_here ? problem->line : 0, is_here ? problem->column : 0);
        buffer_json_text(buffer, "message",
                         text.is_failed ? problem->message : (const char *)buffer_get(&text));
        buffer_print(buffer, "}");
        buffer_release(&text);
    }
    buffer_print(buffer, "]");
}

/* ---- the document of a scene ---- */

static tulle_status describe_scene(view_document *document, const tulle_scene *scene,
                                   tulle_error *error) {
    size_t const cloths = tulle_scene_get_cloth_count(scene);
    size_t const obstacles = tulle_scene_get_obstacle_count(scene);
    if (!document_begin(document, cloths + obstacles))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < cloths && status == TULLE_OK; i++)
        status = document_add(document, tulle_scene_get_cloth_name(scene, i), ROLE_CLOTH,
                              tulle_scene_get_cloth_mesh(scene, i), error);
    for (size_t i = 0; i < obstacles && status == TULLE_OK; i++) {
        bool const is_body = tulle_scene_is_obstacle_dynamic(scene, i) != 0;
        status = document_add(document, tulle_scene_get_obstacle_name(scene, i),
                              is_body ? ROLE_BODY : ROLE_OBSTACLE,
                              tulle_scene_get_obstacle_mesh(scene, i), error);
        if (status == TULLE_OK)
            document->objects[cloths + i].is_static = !tulle_scene_is_obstacle_moving(scene, i);
    }
    for (size_t i = 0; i < document->object_count; i++) {
        scene_object_facts const facts = scene_get_object_facts(scene, i);
        view_object *const object = &document->objects[i];
        object->material = document_copy_text(document, facts.material);
        object->thickness = facts.thickness;
        object->pin_count = facts.pin_count;
    }
    tulle_wind wind;
    scene_get_weather(scene, document->gravity, &wind);
    memcpy(document->wind, wind.velocity, sizeof document->wind);
    document->gust_strength = wind.gust_strength;
    document->step_seconds = tulle_scene_get_time_step(scene);
    document->frame_seconds = document->step_seconds * tulle_scene_get_steps_per_frame(scene);
    document->is_live = true;
    return status;
}

/* Looks are read from the file, which has the scene's text by now. */
static void dress(view_document *document, const char *path, tulle_scene_problems *problems) {
    scene_picture picture = scene_picture_default();
    (void)scene_read_picture(path, &picture, problems);
    document_finish(document, &picture);
    scene_picture_destroy(&picture);
}

static void finish_document(view_session *session, const char *problems) {
    view_document *const document = &session->document;
    document->kind = KIND_SCENE;
    document->is_editable = true;
    const char *const path = get_path(session), *const slash = strrchr(path, '/');
    document->title = document->name = slash ? slash + 1 : path;
    size_t const size = strlen(problems) + 1;
    char *const copy = ARENA_NEW(&document->storage, char, size);
    document->problems = copy ? memcpy(copy, problems, size) : NULL;
}

/* Begins the simulation of a scene, which is owned by it then. */
static tulle_status begin_live(view_session *session, tulle_scene *scene, tulle_error *error) {
    live_options options = {.scene = scene,
                            .document = &session->document,
                            .threads = session->options->threads,
                            .wake = session->wake,
                            .context = session->wake_context};
    if (session->replayed) {
        tulle_status const status =
            session_file_check(session->replayed, scene, &options.script, error);
        if (status != TULLE_OK) {
            tulle_scene_destroy(scene);
            return status;
        }
    }
    session->scene_count++;
    session->live = live_start(&options);
    return session->live ? TULLE_OK
                         : error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                                     "there is no memory, or no room for temporary files");
}

tulle_status editing_open(view_session *session, const char *path, tulle_error *error) {
    memory heap = memory_default();
    tulle_scene_problems *const problems = memory_allocate(&heap, sizeof *problems);
    tulle_scene *scene = NULL;
    if (!problems) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    tulle_status status = tulle_scene_load(path, NULL, 0, &scene, problems);
    bool const is_there = access(path, R_OK) == 0;
    if (status != TULLE_OK && (!is_there || session->options->replay)) {
        *error = problems->list[0];
        memory_release(&heap, problems, sizeof *problems);
        return status;
    }
    view_buffer text = {0};
    write_problems(path, problems, &text);
    buffer_put_u8(&text, 0);
    const char *const list = text.is_failed ? "[]" : (const char *)buffer_get(&text);
    if (scene) {
        status = describe_scene(&session->document, scene, error);
        dress(&session->document, path, problems);
        finish_document(session, list);
        if (status == TULLE_OK)
            status = begin_live(session, scene, error);
        else
            tulle_scene_destroy(scene);
    } else { /* it opens all the same, to be mended */
        scene_print_problems(problems, stderr);
        status = document_begin(&session->document, 0) ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
        document_finish(&session->document, NULL);
        finish_document(session, list);
    }
    buffer_release(&text);
    memory_release(&heap, problems, sizeof *problems);
    return status;
}

/* ---- check and save ---- */

typedef struct text_job {
    view_job head;
    memory heap;
    view_request request; /* owns the text */
    uint32_t client;
    uint64_t known, found; /* hashes of the file: as the page knows it, as it is; 0: not, gone */
    const char *path;
    tulle_scene_problems problems;
    tulle_scene *scene; /* of a text that was saved */
    tulle_status status;
    tulle_error error;
} text_job;

/* Whether someone else wrote the file after the page read it. A page that asks again means it. */
static bool has_other_text(text_job *job) {
    file_data file = {0};
    tulle_error error = {0};
    if (job->known == 0 ||
        file_load(&job->heap, job->path, MESSAGE_TEXT_MAX, &file, &error) != TULLE_OK)
        return false;
    job->found = hash_bytes(HASH_SEED, file.bytes, file.byte_count);
    file_release(&job->heap, &file);
    return job->found != job->known;
}

static tulle_status save_text(text_job *job) {
    if (has_other_text(job))
        return error_set(&job->error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the file has changed since it was read here; nothing was written. Save "
                         "again to replace what it holds now");
    tulle_status const status =
        tulle_file_write(job->path, job->request.text, job->request.text_length, &job->error);
    if (status == TULLE_OK)
        job->found = hash_bytes(HASH_SEED, job->request.text, job->request.text_length);
    return status;
}

static void work_on_text(view_job *head) {
    text_job *const job = (text_job *)head;
    tulle_scene *scene = NULL;
    job->status = scene_load_text(job->path, job->request.text, job->request.text_length, &scene,
                                  &job->problems);
    if (job->status == TULLE_OK && job->request.type == REQUEST_SAVE) job->status = save_text(job);
    if (job->status == TULLE_OK && job->request.type == REQUEST_SAVE)
        job->scene = scene;
    else
        tulle_scene_destroy(scene);
}

/* The saved scene in place of the one before; all clients begin anew. */
static tulle_status replace_scene(view_session *session, tulle_scene *scene,
                                  tulle_scene_problems *problems, tulle_error *error) {
    worker_drop_all(session->worker);
    live_stop(session->live);
    session->live = NULL;
    if (session->replayed) {
        memory heap = memory_default();
        memory_release(&heap, session->replayed, session->replayed_size + 1);
        session->replayed = NULL;
    }
    series_clear(&session->live_rows);
    frame_release(&session->frame);
    document_destroy(&session->document);
    tulle_status status = describe_scene(&session->document, scene, error);
    dress(&session->document, get_path(session), problems);
    finish_document(session, "[]");
    session->state_version = 0;
    bool is_good = frame_prepare(&session->frame, &session->document);
    for (size_t i = 0; i < session->client_count; i++)
        if (!client_begin_document(session->clients[i], &session->document)) is_good = false;
    if (status == TULLE_OK && !is_good)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    if (status == TULLE_OK) return begin_live(session, scene, error);
    tulle_scene_destroy(scene);
    return status;
}

static void finish_text(view_job *head, void *owner) {
    text_job *const job = (text_job *)head;
    view_session *const session = owner;
    bool const is_save = job->request.type == REQUEST_SAVE;
    view_client *const client = session_find_client(session, job->client);
    if (job->scene) {
        job->status = replace_scene(session, job->scene, &job->problems, &job->error);
        job->scene = NULL;
    }
    if (!client) return;
    if (job->found != 0) client->text_hash = job->found;
    if (job->status != TULLE_OK && job->problems.count == 0) {
        client_push_error(client, &job->request, job->error.message);
        return;
    }
    view_buffer buffer = {0};
    bool const is_saved = is_save && job->status == TULLE_OK;
    client_begin_answer(&job->request, is_saved ? "saved" : "problems", &buffer);
    buffer_print(&buffer, ",\"list\":");
    write_problems(job->path, &job->problems, &buffer);
    buffer_print(&buffer, "}");
    client_push(client, &buffer, false);
}

static void release_text(view_job *head) {
    text_job *const job = (text_job *)head;
    memory heap = job->heap;
    request_release(&job->request);
    tulle_scene_destroy(job->scene);
    memory_release(&heap, job, sizeof *job);
}

static void take_text(view_session *session, view_client *client, view_request *request) {
    memory heap = memory_default();
    text_job *const job = memory_allocate_zeroed(&heap, 1, sizeof *job);
    if (!job) {
        client_push_error(client, request, "out of memory");
        return;
    }
    job->head = (view_job){.work = work_on_text, .finish = finish_text, .release = release_text};
    job->heap = heap;
    job->request = *request;
    job->client = client->number;
    job->known = client->text_hash;
    job->path = get_path(session);
    request->text = NULL; /* the job has it */
    if (!worker_post(session->worker, &job->head))
        client_push_error(client, request, "too much is asked for at once");
}

/* ---- texts ---- */

static void answer_text(view_session *session, view_client *client, const view_request *request) {
    memory heap = memory_default();
    file_data file = {0};
    tulle_error error = {0};
    if (file_load(&heap, get_path(session), MESSAGE_TEXT_MAX, &file, &error) != TULLE_OK) {
        client_push_error(client, request, error.message);
        return;
    }
    view_buffer buffer = {0};
    client_begin_answer(request, "text", &buffer);
    buffer_json_text(&buffer, "name", session->document.name);
    buffer_json_text(&buffer, "text", file.bytes);
    buffer_print(&buffer, "}");
    client_push(client, &buffer, false);
    client->text_hash = hash_bytes(HASH_SEED, file.bytes, file.byte_count);
    file_release(&heap, &file);
}

/* The keys are those of the program, so they are written down once. */
static const view_buffer *get_schema(void) {
    static view_buffer schema; /* lives as long as the program */
    FILE *const file = schema.count == 0 ? tmpfile() : NULL;
    if (!file) return &schema;
    scene_print_schema(file);
    long const size = ftell(file);
    rewind(file);
    unsigned char *const place = size > 0 ? buffer_extend(&schema, (size_t)size) : NULL;
    if (!place || fread(place, 1, (size_t)size, file) != (size_t)size) buffer_release(&schema);
    fclose(file);
    return &schema;
}

static void answer_schema(view_client *client, const view_request *request) {
    view_buffer buffer = {0};
    const view_buffer *const schema = get_schema();
    if (schema->count == 0) {
        client_push_error(client, request, "there is no room for a temporary file");
        return;
    }
    client_begin_answer(request, "schema", &buffer);
    buffer_print(&buffer, ",\"keys\":");
    buffer_put_bytes(&buffer, buffer_get(schema), schema->count);
    buffer_print(&buffer, "}");
    client_push(client, &buffer, false);
}

static const char example_folder[] = "examples/";

static void answer_examples(view_client *client, const view_request *request) {
    view_buffer buffer = {0};
    const char *separator = "";
    const view_asset *asset;
    client_begin_answer(request, "examples", &buffer);
    buffer_print(&buffer, ",\"names\":[");
    for (size_t i = 0; (asset = assets_get(i)); i++) {
        if (strncmp(asset->name, example_folder, sizeof example_folder - 1) != 0) continue;
        buffer_print(&buffer, "%s", separator);
        buffer_json_text(&buffer, NULL, asset->name + sizeof example_folder - 1);
        separator = ",";
    }
    buffer_print(&buffer, "]}");
    client_push(client, &buffer, false);
}

static void answer_example(view_client *client, const view_request *request) {
    const view_asset *asset;
    for (size_t i = 0; (asset = assets_get(i)); i++) {
        if (strncmp(asset->name, example_folder, sizeof example_folder - 1) != 0 ||
            strcmp(asset->name + sizeof example_folder - 1, request->name) != 0)
            continue;
        view_buffer buffer = {0}, text = {0};
        buffer_put_bytes(&text, asset->bytes, (size_t)(asset->end - asset->bytes));
        buffer_put_u8(&text, 0);
        client_begin_answer(request, "text", &buffer);
        buffer_json_text(&buffer, "name", request->name);
        buffer_json_text(&buffer, "text", text.is_failed ? "" : (const char *)buffer_get(&text));
        buffer_print(&buffer, "}");
        client_push(client, &buffer, false);
        buffer_release(&text);
        return;
    }
    client_push_error(client, request, "there is no such example");
}

void editing_take_request(view_session *session, view_client *client, view_request *request) {
    if (!session->document.is_editable) {
        client_push_error(client, request, "this scene cannot be edited");
        return;
    }
    switch (request->type) {
    case REQUEST_TEXT: answer_text(session, client, request); break;
    case REQUEST_CHECK:
    case REQUEST_SAVE: take_text(session, client, request); break;
    case REQUEST_SCHEMA: answer_schema(client, request); break;
    case REQUEST_EXAMPLES: answer_examples(client, request); break;
    default: answer_example(client, request); break;
    }
}
