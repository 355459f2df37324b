/* tulle/events.h - what happens in a world, as events that the host polls after its steps: contacts
 * that begin and end, bodies and cloths that fall asleep, pinches.
 *
 * A host watches kinds of events. After each accepted step the world finds the things that began or
 * ended since it last looked, and puts events into a queue. The order is fixed: contacts by pair,
 * events of objects by number, events of the world, attachments by id. So it is the same for any
 * number of threads and on every machine. Contacts that exist when watching begins give no event. A
 * step that fails gives none.
 *
 * Events follow from the states alone, and the queue is not part of a state. tulle_world_load_state
 * empties the queue. The next step then gives the events since the loaded state: a host that rolls
 * back and makes the same steps gets the same events again. Watching changes no bit of a step. It
 * costs a sort of the contacts and, for overstretch, a look at each triangle.    */
#ifndef TULLE_EVENTS_H
#define TULLE_EVENTS_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What has happened. */
typedef enum tulle_event_kind {
    /* contacts of two objects together press with more than the watch's contact_force */
    TULLE_EVENT_CONTACT_BEGIN,
    TULLE_EVENT_CONTACT_END,       /* they no longer do */
    TULLE_EVENT_SLEEP,             /* a body or a cloth has fallen asleep */
    TULLE_EVENT_WAKE,              /* it is awake again, also by a call of the host */
    TULLE_EVENT_PINCH_BEGIN,       /* cloth has no room: an obstacle lags, as on_pinch says */
    TULLE_EVENT_PINCH_END,         /* the pinch is over */
    TULLE_EVENT_OVERSTRETCH_BEGIN, /* a yarn of a cloth is longer than its material holds */
    TULLE_EVENT_OVERSTRETCH_END,   /* no yarn is any longer */
    TULLE_EVENT_APPEAR,            /* an obstacle has come into the scene */
    TULLE_EVENT_LEAVE,             /* it has left */
    TULLE_EVENT_UNTANGLED,         /* nothing is left of what intersected from the start */
    /* an attachment holds no vertex any more: they broke off, it was released, or one of its two
     * sides has gone */
    TULLE_EVENT_ATTACHMENT_END,
    TULLE_EVENT_KIND_COUNT /* number of the kinds above */
} tulle_event_kind;

/* An event. Objects are numbered as in tulle_contact; UINT32_MAX stands for none. */
typedef struct tulle_event {
    tulle_event_kind kind; /* what has happened */
    /* the object of the event. Of a contact: the lower number. Of an attachment: its cloth.
     * UINT32_MAX: all pins and obstacles (of a pinch), the world (untangled), cloth that was
     * removed */
    uint32_t object_a;
    /* of a contact: the other object, which may equal object_a; otherwise UINT32_MAX */
    uint32_t object_b;
    uint32_t attachment; /* the id of an attachment that ended; else 0 */
    uint64_t step;       /* index of the step in which it happened, from 0 */
    double time;         /* [s] of the world at the end of that step */
    double force;        /* [N] normal force between the two where contact begins; else 0 */
} tulle_event;

/* What to watch. Made by tulle_event_watch_default. */
typedef struct tulle_event_watch {
    unsigned kinds; /* 1 .. 4095, default 4095: a sum of 1 << tulle_event_kind, of one at least */
    double contact_force; /* [N] 0 .. 1e300: the least normal force, a mean over the last substep */
    size_t capacity;      /* 1 .. 16777216, default 1024: events that the queue holds */
} tulle_event_watch;
/* All kinds, any force above 0, room for 1024 events. */
TULLE_API tulle_event_watch tulle_event_watch_default(void);

/* Begins to watch, with an empty queue. A later call replaces the watch. A null `watch` ends it.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a world that has not started, a value of the watch),
 * TULLE_ERROR_OUT_OF_MEMORY; the former watch is then kept. */
TULLE_API tulle_status tulle_world_watch_events(tulle_world *world, const tulle_event_watch *watch,
                                                tulle_error *error);
/* Moves the oldest events, at most `capacity`, from the queue to `events`; `*count` gets their
 * number. `*lost`, which may be null, gets the number of events that were dropped since the last
 * call because the queue was full; the newest are dropped. `events` may be null where `capacity` is
 * 0. Error: TULLE_ERROR_INVALID_ARGUMENT (null, a world that watches nothing). */
TULLE_API tulle_status tulle_world_poll_events(tulle_world *world, tulle_event *events,
                                               size_t capacity, size_t *count, uint64_t *lost,
                                               tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
