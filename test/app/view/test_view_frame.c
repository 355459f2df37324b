/* Frames over the wire: what a page decodes is within half a step of where the vertices are, or
 * exact to the bit, in whatever order exact, rounded, absent and far away come; and what the coder
 * says is unchanged has not changed. The decoder below is written from web/PROTOCOL.md. */
#include "app/view/frame.h"
#include "base/hash.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

enum { OBJECTS = 4, ROUNDS = 300 };
static const size_t vertex_counts[OBJECTS] = {1, 63, 64, 200};

/* What a page has of an object. */
typedef struct decoded {
    float low[3], step;
    uint16_t places[600];
    float positions[600];
    bool is_on_grid, is_absent;
    unsigned coding;
} decoded;

static decoded page[OBJECTS];

static uint32_t read_u32(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static float read_f32(const unsigned char *at) {
    uint32_t const bits = read_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint16_t read_u16(const unsigned char *at) { return (uint16_t)(at[0] | at[1] << 8); }

/* The bytes of an object behind its head; how many they are. */
static size_t decode_object(const unsigned char *at, unsigned coding, size_t count,
                            decoded *object) {
    size_t used = 0;
    if (coding == 1) {
        for (size_t i = 0; i < 3 * count; i++) object->positions[i] = read_f32(at + 4 * i);
        object->is_on_grid = false;
        return 12 * count;
    }
    if (coding == 2) {
        for (size_t k = 0; k < 3; k++) object->low[k] = read_f32(at + 4 * k);
        object->step = read_f32(at + 12);
        for (size_t i = 0; i < 3 * count; i++) object->places[i] = read_u16(at + 16 + 2 * i);
        used = 16 + 6 * count;
        object->is_on_grid = true;
    }
    if (coding == 3) {
        assert_true(object->is_on_grid);
        for (size_t begin = 0; begin < 3 * count; begin += 192) {
            size_t const end = begin + 192 < 3 * count ? begin + 192 : 3 * count;
            unsigned const width = at[used++];
            assert_true(width <= 2);
            for (size_t i = begin; i < end && width > 0; i++, used += width)
                object->places[i] = width == 2
                                        ? read_u16(at + used)
                                        : (uint16_t)(object->places[i] + (signed char)at[used]);
        }
    }
    for (size_t i = 0; i < 3 * count && object->is_on_grid; i++)
        object->positions[i] = object->low[i % 3] + object->step * (float)object->places[i];
    return (used + 3) / 4 * 4;
}

static void decode(const view_buffer *buffer, uint32_t sequence) {
    const unsigned char *const bytes = buffer_get(buffer);
    size_t at = 24;
    assert_false(buffer->is_failed);
    assert_int_equal(bytes[0], 2);
    assert_int_equal(bytes[1], 1);
    assert_int_equal(read_u32(bytes + 16), sequence);
    assert_int_equal(read_u32(bytes + 20), OBJECTS);
    for (size_t i = 0; i < OBJECTS; i++) {
        assert_int_equal(at % 4, 0);
        assert_int_equal(read_u16(bytes + at), i);
        assert_int_equal(read_u32(bytes + at + 4), vertex_counts[i]);
        page[i].coding = bytes[at + 2];
        page[i].is_absent = bytes[at + 3] & 1;
        at += 8;
        at += decode_object(bytes + at, page[i].coding, vertex_counts[i], &page[i]);
    }
    assert_int_equal(at, buffer->count);
}

static void begin_document(view_document *document) {
    assert_true(document_begin(document, OBJECTS));
    for (size_t i = 0; i < OBJECTS; i++) {
        double positions[600];
        uint32_t const corners[3] = {0, 0, 0};
        for (size_t k = 0; k < 3 * vertex_counts[i]; k++) positions[k] = 0.01 * (double)(k % 97);
        tulle_mesh_view const mesh = {positions, vertex_counts[i], corners, 0};
        assert_int_equal(document_add(document, "thing", ROLE_OBSTACLE, mesh, NULL), TULLE_OK);
    }
    document_finish(document, NULL);
}

/* [m] Largest error that the coding of an object may have: half a step, and the rounding of single
 * precision at its places. */
static double get_limit(const decoded *object, const float *truth, size_t count) {
    double farthest = 0.0;
    for (size_t i = 0; i < 3 * count; i++) farthest = fmax(farthest, fabs((double)truth[i]));
    if (!object->is_on_grid) return 0.0;
    return 0.5 * (double)object->step + 2.0 * farthest * 0x1p-24 +
           65536.0 * (double)object->step * 0x1p-24;
}

static void check_frame(const view_frame *frame, const view_document *document, bool is_exact) {
    for (size_t i = 0; i < OBJECTS; i++) {
        const float *const truth = frame->positions + 3 * document->objects[i].vertex_begin;
        assert_int_equal(page[i].is_absent, frame->is_absent[i] != 0);
        if (frame->is_absent[i]) continue;
        if (is_exact) assert_memory_equal(page[i].positions, truth, 12 * vertex_counts[i]);
        double const limit = get_limit(&page[i], truth, vertex_counts[i]);
        for (size_t k = 0; k < 3 * vertex_counts[i]; k++) {
            if (!isfinite(truth[k])) {
                assert_memory_equal(&page[i].positions[k], &truth[k], 4);
                continue;
            }
            double const error = fabs((double)page[i].positions[k] - (double)truth[k]);
            if (!(error <= limit))
                fail_msg("object %zu, coordinate %zu: off by %g, limit %g", i, k, error, limit);
        }
    }
}

/* A frame in which objects stand, creep, jump, stretch, shrink, fly away, vanish. */
static void move(view_frame *frame, const view_document *document, uint64_t *chance) {
    for (size_t i = 0; i < OBJECTS; i++) {
        float *const x = frame->positions + 3 * document->objects[i].vertex_begin;
        size_t const count = 3 * vertex_counts[i];
        uint64_t const kind = random_next(chance) % 12;
        frame->is_absent[i] = random_next(chance) % 10 == 0;
        double const scale = kind == 1   ? 1e-5
                             : kind == 2 ? 1e-3
                             : kind == 3 ? 0.1
                             : kind == 4 ? 30.0
                                         : 0.0;
        for (size_t k = 0; k < count && scale > 0.0; k++)
            x[k] += (float)(scale * (random_uniform(chance) - 0.5));
        if (kind == 5) x[random_next(chance) % count] += 0.002f;
        for (size_t k = 0; k < count && (kind == 6 || kind == 7); k++)
            x[k] = x[k] * (kind == 6 ? 0.01f : 3.0f) + (kind == 7 ? 0.5f : 0.0f);
        if (kind == 8) x[random_next(chance) % count] = 1e9f;
        if (kind == 9 && random_next(chance) % 4 == 0) x[random_next(chance) % count] = NAN;
        if (kind == 9 && random_next(chance) % 4 == 0) x[random_next(chance) % count] = INFINITY;
        for (size_t k = 0; k < count && kind == 10; k++)
            x[k] = (float)(random_uniform(chance) + (double)(random_next(chance) % 2) * 1e5);
        for (size_t k = 0; k < count && (kind == 11 || !(fabsf(x[k]) < 1e12f)); k++) x[k] = 0.0f;
    }
}

static void test_random_frames(void **state) {
    (void)state;
    view_document document;
    begin_document(&document);
    size_t seen[4] = {0};
    for (uint64_t seed = 1; seed <= 10; seed++) {
        uint64_t chance = seed;
        view_frame frame;
        frame_coder coder;
        assert_true(frame_prepare(&frame, &document) && frame_coder_prepare(&coder, &document));
        memset(page, 0, sizeof page);
        for (size_t i = 0; i < OBJECTS; i++)
            memcpy(page[i].positions, document.objects[i].positions, 12 * vertex_counts[i]);
        for (uint32_t round = 0; round < ROUNDS; round++) {
            bool const is_exact = random_next(&chance) % 8 == 0;
            view_buffer buffer = {0};
            if (round > 0) move(&frame, &document, &chance);
            frame_encode(&coder, &document, &frame, is_exact, round, &buffer);
            decode(&buffer, round);
            check_frame(&frame, &document, is_exact);
            for (size_t i = 0; i < OBJECTS; i++) seen[page[i].coding]++;
            buffer_release(&buffer);
        }
        frame_release(&frame);
        frame_coder_release(&coder);
    }
    for (int coding = 0; coding < 4; coding++) assert_true(seen[coding] > 300);
    document_destroy(&document);
}

/* What creeps by less than 128 steps costs a byte a coordinate; what stands still costs none. */
static void test_sizes(void **state) {
    (void)state;
    view_document document;
    view_frame frame;
    frame_coder coder;
    size_t sizes[3];
    begin_document(&document);
    assert_true(frame_prepare(&frame, &document) && frame_coder_prepare(&coder, &document));
    for (int round = 0; round < 4; round++) {
        view_buffer buffer = {0};
        for (size_t i = 0; i < 3 * document.vertex_count && (round == 1 || round == 3); i++)
            frame.positions[i] += round == 1 ? 1e-7f : 1e-4f;
        frame_encode(&coder, &document, &frame, false, 1, &buffer);
        if (round > 0) sizes[round - 1] = buffer.count;
        buffer_release(&buffer);
    }
    size_t const heads = 24 + 8 * OBJECTS;
    assert_in_range(sizes[0], heads + 6 * document.vertex_count,
                    heads + 6 * document.vertex_count + 19 * OBJECTS);
    assert_int_equal(sizes[1], heads);
    assert_in_range(sizes[2], heads + 3 * document.vertex_count,
                    heads + 3 * document.vertex_count + 10 * OBJECTS);
    frame_release(&frame);
    frame_coder_release(&coder);
    document_destroy(&document);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_random_frames),
                                       cmocka_unit_test(test_sizes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
