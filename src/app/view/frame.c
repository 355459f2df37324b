/* app/view/frame.c - see frame.h.
 *
 * Each object of a document has a grid of its own: a box around where it is, a quarter of its
 * longest side wider all around, cut into 65535 steps along that side. While all vertices stay
 * within the grid, a frame tells by how many steps they moved. An object that leaves its grid gets
 * another. */
#include "app/view/frame.h"

#include <math.h>
#include <string.h>

enum { STATE_MESH, STATE_GRID, STATE_EXACT, PLACE_MAX = 65535 };

static const float MARGIN = 0.25f;     /* of the longest side, on each side of the box */
static const float SIDE_LEAST = 1e-3f; /* [m] so that a grid has steps wherever an object is flat */

/* ---- a frame ---- */

bool frame_prepare(view_frame *frame, const view_document *document) {
    *frame = (view_frame){.heap = memory_default(),
                          .vertex_count = document->vertex_count,
                          .object_count = document->object_count};
    frame->positions =
        memory_allocate_zeroed(&frame->heap, 3 * frame->vertex_count + 1, sizeof(float));
    frame->is_absent = memory_allocate_zeroed(&frame->heap, frame->object_count + 1, 1);
    for (size_t i = 0; frame->positions && i < document->object_count; i++) {
        const view_object *const object = &document->objects[i];
        memcpy(frame->positions + 3 * object->vertex_begin, object->positions,
               3 * object->mesh.vertex_count * sizeof(float));
    }
    return frame->positions && frame->is_absent;
}

void frame_release(view_frame *frame) {
    memory_release(&frame->heap, frame->positions, (3 * frame->vertex_count + 1) * sizeof(float));
    memory_release(&frame->heap, frame->is_absent, frame->object_count + 1);
    for (int k = 0; k < OVERLAY_COUNT; k++) buffer_release(&frame->overlays[k].bytes);
    *frame = (view_frame){0};
}

/* ---- the coder ---- */

bool frame_coder_prepare(frame_coder *coder, const view_document *document) {
    *coder = (frame_coder){.heap = memory_default(),
                           .vertex_count = document->vertex_count,
                           .object_count = document->object_count};
    coder->grids =
        memory_allocate_zeroed(&coder->heap, coder->object_count + 1, sizeof *coder->grids);
    coder->has_state = memory_allocate_zeroed(&coder->heap, coder->object_count + 1, 1);
    coder->places =
        memory_allocate_zeroed(&coder->heap, 3 * coder->vertex_count + 1, sizeof *coder->places);
    return coder->grids && coder->has_state && coder->places;
}

void frame_coder_release(frame_coder *coder) {
    memory_release(&coder->heap, coder->grids, (coder->object_count + 1) * sizeof *coder->grids);
    memory_release(&coder->heap, coder->has_state, coder->object_count + 1);
    memory_release(&coder->heap, coder->places,
                   (3 * coder->vertex_count + 1) * sizeof *coder->places);
    *coder = (frame_coder){0};
}

/* The grid around an object as it is now. Without a step where it has a place that is not finite,
 * or so far away that a float has no such steps there. */
static frame_grid make_grid(const float *positions, size_t count) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    bool is_finite = true;
    for (size_t i = 0; i < 3 * count; i++) {
        is_finite &= isfinite(positions[i]) != 0;
        low[i % 3] = fminf(low[i % 3], positions[i]);
        high[i % 3] = fmaxf(high[i % 3], positions[i]);
    }
    frame_grid grid = {.step = 0.0f};
    if (!is_finite || count == 0) return grid;
    float side = SIDE_LEAST, farthest = 0.0f;
    for (int k = 0; k < 3; k++) {
        side = fmaxf(side, high[k] - low[k]);
        farthest = fmaxf(farthest, fmaxf(fabsf(low[k]), fabsf(high[k])));
    }
    float const step = (1.0f + 2.0f * MARGIN) * side / (float)PLACE_MAX;
    if (!isfinite(step) || step < farthest * 0x1p-20f) return grid;
    grid.step = step;
    for (int k = 0; k < 3; k++)
        grid.low[k] = 0.5f * (low[k] + high[k]) - 0.5f * step * (float)PLACE_MAX;
    return grid;
}

/* Places on the grid; false where a vertex lies outside of it. */
static bool find_places(const frame_grid *grid, const float *positions, size_t count,
                        uint16_t *places) {
    double const inverse = 1.0 / (double)grid->step;
    bool is_inside = grid->step > 0.0f;
    for (size_t i = 0; i < count && is_inside; i++)
        for (size_t k = 0; k < 3; k++) {
            double const place =
                ((double)positions[3 * i + k] - (double)grid->low[k]) * inverse + 0.5;
            is_inside &= place >= 0.0 && place < (double)PLACE_MAX + 1.0;
            places[3 * i + k] = is_inside ? (uint16_t)place : 0;
        }
    return is_inside;
}

static void put_u16s(view_buffer *buffer, const uint16_t *values, size_t count) {
    unsigned char *const to = buffer_extend(buffer, 2 * count);
    for (size_t i = 0; to && i < count; i++) {
        to[2 * i] = (unsigned char)(values[i] & 0xff);
        to[2 * i + 1] = (unsigned char)(values[i] >> 8);
    }
}

/* Blocks of vertices, each with the fewest bytes that hold its moves. */
static void put_delta(view_buffer *buffer, const uint16_t *before, const uint16_t *now,
                      size_t vertex_count) {
    for (size_t begin = 0; begin < 3 * vertex_count; begin += 3 * (size_t)FRAME_BLOCK) {
        size_t const rest = 3 * vertex_count - begin;
        size_t const count = rest < 3 * (size_t)FRAME_BLOCK ? rest : 3 * (size_t)FRAME_BLOCK;
        int least = 0, most = 0;
        for (size_t i = begin; i < begin + count; i++) {
            int const move = (int)now[i] - (int)before[i];
            least = move < least ? move : least;
            most = move > most ? move : most;
        }
        unsigned const width = least == 0 && most == 0 ? 0 : least < -128 || most > 127 ? 2 : 1;
        buffer_put_u8(buffer, width);
        if (width == 2) put_u16s(buffer, now + begin, count);
        unsigned char *const to = width == 1 ? buffer_extend(buffer, count) : NULL;
        for (size_t i = 0; to && i < count; i++)
            to[i] = (unsigned char)((int)now[begin + i] - (int)before[begin + i]);
    }
    buffer_align(buffer);
}

typedef struct object_work {
    const float *positions;
    size_t count; /* vertices */
    frame_grid *grid;
    uint16_t *places, *next; /* what the client has; room for what it gets */
    uint8_t *state;
} object_work;

/* The coding of an object that is there; places of the coder are then those of the frame. */
static void encode_object(object_work work, bool is_exact, view_buffer *buffer, size_t head) {
    unsigned coding = CODING_EXACT;
    if (!is_exact && *work.state == STATE_GRID &&
        find_places(work.grid, work.positions, work.count, work.next)) {
        bool const is_same = memcmp(work.next, work.places, 6 * work.count) == 0;
        coding = is_same ? CODING_UNCHANGED : CODING_DELTA;
        if (!is_same) put_delta(buffer, work.places, work.next, work.count);
    } else if (!is_exact) {
        *work.grid = make_grid(work.positions, work.count);
        if (find_places(work.grid, work.positions, work.count, work.next)) {
            coding = CODING_KEY;
            buffer_put_f32s(buffer, work.grid->low, 3);
            buffer_put_f32(buffer, work.grid->step);
            put_u16s(buffer, work.next, 3 * work.count);
            buffer_align(buffer);
        }
    }
    if (coding == CODING_EXACT) buffer_put_f32s(buffer, work.positions, 3 * work.count);
    *work.state = coding == CODING_EXACT ? STATE_EXACT : STATE_GRID;
    if (coding != CODING_EXACT) memcpy(work.places, work.next, 6 * work.count);
    if (!buffer->is_failed) buffer_get(buffer)[head + 2] = (unsigned char)coding;
}

void frame_encode(frame_coder *coder, const view_document *document, const view_frame *frame,
                  bool is_exact, uint32_t sequence, view_buffer *buffer) {
    document_write_head((view_head){.kind = 2,
                                    .frame = frame->number,
                                    .time = frame->time,
                                    .sequence = sequence,
                                    .count = (uint32_t)document->object_count},
                        buffer);
    uint16_t *const next = memory_allocate(&coder->heap, (3 * coder->vertex_count + 1) * 2);
    if (!next) buffer->is_failed = true;
    for (size_t i = 0; i < document->object_count && next; i++) {
        const view_object *const object = &document->objects[i];
        size_t const begin = 3 * object->vertex_begin, head = buffer->count;
        buffer_put_u16(buffer, (unsigned)i);
        buffer_put_u8(buffer, CODING_UNCHANGED);
        buffer_put_u8(buffer, frame->is_absent[i] ? FRAME_ABSENT : 0);
        buffer_put_u32(buffer, (uint32_t)object->mesh.vertex_count);
        bool const is_as_mesh = coder->has_state[i] == STATE_MESH &&
                                memcmp(frame->positions + begin, object->positions,
                                       3 * object->mesh.vertex_count * sizeof(float)) == 0;
        if (is_as_mesh || frame->is_absent[i]) continue;
        encode_object((object_work){.positions = frame->positions + begin,
                                    .count = object->mesh.vertex_count,
                                    .grid = &coder->grids[i],
                                    .places = coder->places + begin,
                                    .next = next,
                                    .state = &coder->has_state[i]},
                      is_exact, buffer, head);
    }
    memory_release(&coder->heap, next, (3 * coder->vertex_count + 1) * 2);
}
