/* app/view/message.h - what a page asks for: JSON text to a struct in which every number is in its
 * range, and back. A line of a session is such a message, too. */
#ifndef TULLE_APP_VIEW_MESSAGE_H
#define TULLE_APP_VIEW_MESSAGE_H

#include "app/view/buffer.h"

enum {
    MESSAGE_TEXT_MAX = 1 << 20, /* [bytes] of a message that brings a scene's text */
    MESSAGE_SMALL_MAX = 1 << 16 /* [bytes] of all others */
};

typedef enum request_type {
    REQUEST_NONE,
    REQUEST_FRAMES,
    REQUEST_GOT,
    REQUEST_FOLLOW,
    REQUEST_EXACT,
    REQUEST_OVERLAYS,
    REQUEST_SERIES,
    REQUEST_PICK,
    REQUEST_PINS,
    REQUEST_RUN,
    REQUEST_PAUSE,
    REQUEST_STEP,
    REQUEST_RESET,
    REQUEST_REWIND,
    REQUEST_GRAB,
    REQUEST_DRAG,
    REQUEST_LET_GO,
    REQUEST_CUT_PIN,
    REQUEST_MOVE,
    REQUEST_SET,
    REQUEST_SAVE_SESSION,
    REQUEST_TEXT,
    REQUEST_CHECK,
    REQUEST_SAVE,
    REQUEST_SCHEMA,
    REQUEST_EXAMPLES,
    REQUEST_EXAMPLE,
    REQUEST_COUNT
} request_type;

typedef enum setting_kind {
    SETTING_GRAVITY,
    SETTING_WIND,
    SETTING_GUSTS,
    SETTING_MATERIAL,
    SETTING_FRICTION,
    SETTING_COUNT
} setting_kind;

enum { REQUEST_NAME_SIZE = 64, REQUEST_VALUES_MAX = 4 };

/* Fields count for the types that have them. */
typedef struct view_request {
    request_type type;
    bool has_id;
    uint64_t id;
    uint32_t frame, from, count, stride, sequence;
    bool is_exact;
    uint32_t object, triangle, vertex, grab;
    uint64_t step; /* of rewind */
    double weights[3], point[3], position[3], rotation[4];
    double force, rate, speed;
    unsigned overlays;         /* as bits */
    uint64_t columns, to_step; /* of series */
    uint64_t from_step;
    uint32_t buckets;
    setting_kind what;
    double values[REQUEST_VALUES_MAX];
    uint32_t value_count;
    char name[REQUEST_NAME_SIZE]; /* value of a material, example */
    char *text;                   /* of check and save; release by request_release */
    size_t text_length;
} view_request;

typedef enum request_outcome {
    REQUEST_READ,
    REQUEST_REFUSED, /* the message is whole, but what it asks for cannot be: id is filled */
    REQUEST_BAD      /* no JSON object with a type, or too long: the connection ends */
} request_outcome;

enum { REASON_SIZE = 512 };
/* Reads `length` bytes; `reason` says why not. */
request_outcome request_read(const char *text, size_t length, view_request *request,
                             char reason[REASON_SIZE]);
void request_release(view_request *request);
/* A live command as a member list without braces: "type":...,; reads back to the same. */
void request_write(const view_request *request, view_buffer *buffer);

#endif
