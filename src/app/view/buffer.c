/* app/view/buffer.c - see buffer.h. */
#include "app/view/buffer.h"

#include "base/memory.h"
#include "io/text/json_quote.h"
#include "io/text/number.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void buffer_release(view_buffer *buffer) {
    memory heap = memory_default();
    memory_release(&heap, buffer->bytes, buffer->capacity);
    *buffer = (view_buffer){0};
}

void buffer_clear(view_buffer *buffer) {
    buffer->count = 0;
    buffer->is_failed = false;
}

unsigned char *buffer_get(const view_buffer *buffer) {
    return buffer->bytes ? buffer->bytes + BUFFER_ROOM : NULL;
}

unsigned char *buffer_extend(view_buffer *buffer, size_t count) {
    if (buffer->is_failed) return NULL;
    memory heap = memory_default();
    size_t const used = buffer->bytes ? BUFFER_ROOM + buffer->count : 0;
    size_t const needed = BUFFER_ROOM + buffer->count + count;
    if (!array_reserve(&heap, (void **)&buffer->bytes, &buffer->capacity, used, needed, 1)) {
        buffer->is_failed = true;
        return NULL;
    }
    unsigned char *const place = buffer->bytes + BUFFER_ROOM + buffer->count;
    buffer->count += count;
    return place;
}

void buffer_put_bytes(view_buffer *buffer, const void *bytes, size_t count) {
    unsigned char *const place = buffer_extend(buffer, count);
    if (place && count > 0) memcpy(place, bytes, count);
}

static void put_little(unsigned char *place, uint64_t value, int byte_count) {
    for (int i = 0; i < byte_count; i++) place[i] = (unsigned char)(value >> 8 * i);
}

static void put_whole(view_buffer *buffer, uint64_t value, int byte_count) {
    unsigned char *const place = buffer_extend(buffer, (size_t)byte_count);
    if (place) put_little(place, value, byte_count);
}

void buffer_put_u8(view_buffer *buffer, unsigned value) { put_whole(buffer, value, 1); }
void buffer_put_u16(view_buffer *buffer, unsigned value) { put_whole(buffer, value, 2); }
void buffer_put_u32(view_buffer *buffer, uint32_t value) { put_whole(buffer, value, 4); }

void buffer_put_f32(view_buffer *buffer, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_whole(buffer, bits, 4);
}

void buffer_put_f64(view_buffer *buffer, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_whole(buffer, bits, 8);
}

void buffer_put_f32s(view_buffer *buffer, const float *values, size_t count) {
    unsigned char *const place = buffer_extend(buffer, 4 * count);
    for (size_t i = 0; place && i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        put_little(place + 4 * i, bits, 4);
    }
}

void buffer_put_u32s(view_buffer *buffer, const uint32_t *values, size_t count) {
    unsigned char *const place = buffer_extend(buffer, 4 * count);
    for (size_t i = 0; place && i < count; i++) put_little(place + 4 * i, values[i], 4);
}

void buffer_align(view_buffer *buffer) {
    while (buffer->count % 4 != 0 && !buffer->is_failed) buffer_put_u8(buffer, 0);
}

void buffer_print(view_buffer *buffer, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int const length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    unsigned char *const place = length < 0 ? NULL : buffer_extend(buffer, (size_t)length + 1);
    if (place) {
        vsnprintf((char *)place, (size_t)length + 1, format, again);
        buffer->count--; /* the final zero */
    } else {
        buffer->is_failed = true;
    }
    va_end(again);
}

static void put_key(view_buffer *buffer, const char *key) {
    if (key) buffer_print(buffer, ",\"%s\":", key);
}

void buffer_json_text(view_buffer *buffer, const char *key, const char *text) {
    put_key(buffer, key);
    if (!text) {
        buffer_print(buffer, "null");
        return;
    }
    buffer_put_u8(buffer, '"');
    char piece[JSON_PIECE_SIZE];
    while (json_take_piece(&text, piece) > 0) buffer_put_bytes(buffer, piece, strlen(piece));
    buffer_put_u8(buffer, '"');
}

void buffer_json_double(view_buffer *buffer, const char *key, double value) {
    put_key(buffer, key);
    char text[NUMBER_TEXT_SIZE];
    if (isfinite(value))
        buffer_put_bytes(buffer, text, number_format_double(value, text));
    else
        buffer_print(buffer, "null");
}

void buffer_json_whole(view_buffer *buffer, const char *key, uint64_t value) {
    put_key(buffer, key);
    buffer_print(buffer, "%llu", (unsigned long long)value);
}

void buffer_json_bool(view_buffer *buffer, const char *key, bool value) {
    put_key(buffer, key);
    buffer_print(buffer, value ? "true" : "false");
}

void buffer_json_doubles(view_buffer *buffer, const char *key, const double *values, size_t count) {
    put_key(buffer, key);
    buffer_put_u8(buffer, '[');
    for (size_t i = 0; i < count; i++) {
        if (i > 0) buffer_put_u8(buffer, ',');
        buffer_json_double(buffer, NULL, values[i]);
    }
    buffer_put_u8(buffer, ']');
}
