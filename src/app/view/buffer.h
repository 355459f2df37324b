/* app/view/buffer.h - bytes of a message while it is made: numbers in little endian, JSON text.
 *
 * Before the content there is room for the header that libwebsockets writes there. A buffer that
 * met a want of memory says so in is_failed and takes nothing more. */
#ifndef TULLE_APP_VIEW_BUFFER_H
#define TULLE_APP_VIEW_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { BUFFER_ROOM = 32 /* [bytes] before the content */ };

/* Zeroed is empty. Content: bytes + BUFFER_ROOM, `count` bytes. */
typedef struct view_buffer {
    unsigned char *bytes;
    size_t count, capacity; /* [bytes] of the content, of the memory */
    bool is_failed;
} view_buffer;

void buffer_release(view_buffer *buffer);
/* Makes it empty and keeps the memory. */
void buffer_clear(view_buffer *buffer);
unsigned char *buffer_get(const view_buffer *buffer);
/* Room for `count` bytes behind the content, which they then belong to; null without memory. */
unsigned char *buffer_extend(view_buffer *buffer, size_t count);

void buffer_put_bytes(view_buffer *buffer, const void *bytes, size_t count);
void buffer_put_u8(view_buffer *buffer, unsigned value);
void buffer_put_u16(view_buffer *buffer, unsigned value);
void buffer_put_u32(view_buffer *buffer, uint32_t value);
void buffer_put_f32(view_buffer *buffer, float value);
void buffer_put_f64(view_buffer *buffer, double value);
void buffer_put_f32s(view_buffer *buffer, const float *values, size_t count);
void buffer_put_u32s(view_buffer *buffer, const uint32_t *values, size_t count);
/* Zeros up to a multiple of 4 bytes. */
void buffer_align(view_buffer *buffer);

void buffer_print(view_buffer *buffer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* A member of a JSON object with a comma before it; a null key: the value alone, without one. */
void buffer_json_text(view_buffer *buffer, const char *key, const char *text);
/* What is not finite becomes null. */
void buffer_json_double(view_buffer *buffer, const char *key, double value);
void buffer_json_whole(view_buffer *buffer, const char *key, uint64_t value);
void buffer_json_bool(view_buffer *buffer, const char *key, bool value);
void buffer_json_doubles(view_buffer *buffer, const char *key, const double *values, size_t count);

#endif
