/* world/events.c - events for the host (tulle/events.h).
 *
 * A look at a state gives marks, a set of bits for each object, and the pairs of objects that
 * press on each other. Both follow from the state alone. What a look finds is held against the
 * look before; the differences go into a queue of fixed size. Looks that need memory come before a
 * step is accepted, so that a failure leaves the world as it was. */
#include "base/error.h"
#include "base/sort.h"
#include "step/lag/lag.h"
#include "world/change/change.h"
#include "world/fields/fields.h"
#include "world/record/record.h"

#include <math.h>
#include <string.h>

/* A pair of objects that touch. */
typedef struct touching_pair {
    uint64_t key; /* the lower object, then the other one */
    double force; /* [N] */
} touching_pair;

typedef ARRAY(touching_pair) pair_array;

/* What an object is. The last entry of the marks is the world's own. */
enum { IS_ASLEEP = 1, IS_PINCHED = 2, IS_OVERSTRETCHED = 4, IS_PRESENT = 8, IS_TANGLED = 16 };

/* An attachment that holds something, and the surface of its cloth; UINT32_MAX: it has gone. */
typedef struct held_attachment {
    uint32_t number, cloth;
} held_attachment;
typedef ARRAY(held_attachment) held_list;

struct world_events {
    tulle_event_watch watch;
    uint8_t *marks;          /* surface_count + 1, as of the last look */
    pair_array pairs, found; /* of the last look, and of the one that is being made; ascending */
    held_list held, holding; /* the same */
    tulle_event *queue;      /* a ring of watch.capacity */
    size_t first, count;
    uint64_t lost;
};

static bool is_watched(const world_events *events, tulle_event_kind kind) {
    return (events->watch.kinds >> kind & 1u) != 0;
}

/* ---- a look ---- */

/* The load [N s] of one contact. */
typedef struct contact_load {
    uint64_t key, index;
    double load;
} contact_load;

static int compare_loads(const void *one, const void *two) {
    const contact_load *const a = one, *const b = two;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

tulle_status world_find_touching(tulle_world *world, const motion_state *state,
                                 tulle_error *error) {
    world_events *const events = world->events;
    if (!events) return TULLE_OK;
    const contact_store *const store = &state->contacts;
    size_t const count = store->contacts.count;
    events->found.count = events->holding.count = 0;
    if (!ARRAY_RESERVE(&world->heap, &events->holding, state->ties.count) ||
        !ARRAY_MATCH(&world->heap, &events->holding, &events->held))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for events");
    for (size_t i = 0; i < state->ties.count; i++) {
        const world_tie *const tie = &state->ties.data[i];
        size_t const last = events->holding.count;
        if (last > 0 && events->holding.data[last - 1].number == tie->number) continue;
        events->holding.data[events->holding.count++] =
            (held_attachment){tie->number, world->model.vertex_surface[tie->vertex]};
    }
    if (!is_watched(events, TULLE_EVENT_CONTACT_BEGIN) &&
        !is_watched(events, TULLE_EVENT_CONTACT_END))
        return TULLE_OK;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    contact_load *const loads = ARENA_NEW(&world->work.scratch, contact_load, count);
    bool has_memory = loads || count == 0;
    for (size_t i = 0; has_memory && i < count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        uint32_t v[4];
        feature_pair_vertices(&world->model.topo, (feature_kind)contact->kind,
                              (feature_pair){contact->first, contact->second}, v);
        uint64_t const a = world->model.vertex_surface[v[0]], b = world->model.vertex_surface[v[3]];
        double const load = vec3_dot(vec3_load(contact->impulse, 0), vec3_load(contact->normal, 0));
        loads[i] = (contact_load){a < b ? a << 32 | b : b << 32 | a, i, fmax(load, 0.0)};
    }
    if (has_memory) sort_by_heap(loads, count, sizeof *loads, compare_loads);
    for (size_t i = 0; has_memory && i < count;) {
        touching_pair pair = {loads[i].key, 0.0};
        for (; i < count && loads[i].key == pair.key; i++) pair.force += loads[i].load;
        pair.force /= store->time_step;
        if (!(pair.force > events->watch.contact_force)) continue;
        has_memory = ARRAY_RESERVE(&world->heap, &events->found, 1);
        if (has_memory) events->found.data[events->found.count++] = pair;
    }
    arena_release(&world->work.scratch, mark);
    return has_memory ? TULLE_OK
                      : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for events");
}

/* What an object is now; surface_count stands for the world. */
static uint8_t find_marks(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->model.cloths.count;
    if (surface < cloth_count) {
        bool const is_asked = is_watched(world->events, TULLE_EVENT_OVERSTRETCH_BEGIN) ||
                              is_watched(world->events, TULLE_EVENT_OVERSTRETCH_END);
        const surface_range *const range = &world->work.surfaces[surface];
        int cloth_marks = 0;
        for (size_t t = range->triangle_begin; is_asked && t < range->triangle_end; t++) {
            if (!cloth_is_overstretched(world->model.cloth_model, world->now.positions, t))
                continue;
            cloth_marks = IS_OVERSTRETCHED;
            break;
        }
        if (surface < world->model.cloth_rest_count && world->now.cloth_rests[surface].is_asleep)
            cloth_marks |= IS_ASLEEP;
        return (uint8_t)cloth_marks;
    }
    size_t const obstacle = surface - cloth_count; /* all of them for the world */
    int marks = step_is_held(&world->model, &world->now, obstacle) ? IS_PINCHED : 0;
    if (obstacle == world->model.obstacles.count)
        return (uint8_t)(marks | (world->ignored.count > 0 ? IS_TANGLED : 0));
    if (world->now.is_present[obstacle]) marks |= IS_PRESENT;
    uint32_t const body =
        world->model.surface_bodies ? world->model.surface_bodies[surface] : TULLE_NONE;
    if (body != TULLE_NONE && world->now.rests[body].state == BODY_SLEEPS) marks |= IS_ASLEEP;
    return (uint8_t)marks;
}

/* ---- what has changed ---- */

static void add_event(tulle_world *world, tulle_event_kind kind, uint64_t key, double force) {
    world_events *const events = world->events;
    if (!is_watched(events, kind)) return;
    if (events->count == events->watch.capacity) {
        events->lost++;
        return;
    }
    size_t const at = (events->first + events->count++) % events->watch.capacity;
    events->queue[at] = (tulle_event){.kind = kind,
                                      .object_a = (uint32_t)(key >> 32),
                                      .object_b = (uint32_t)key,
                                      .step = world->now.step_count - 1,
                                      .time = world->now.time,
                                      .force = force};
}

/* What was found takes the place of what was before. */
static void swap_looks(world_events *events) {
    pair_array const old = events->pairs;
    events->pairs = events->found;
    events->found = old;
    held_list const held = events->held;
    events->held = events->holding;
    events->holding = held;
}

/* Attachments that held something at the last look and hold nothing now; both lists ascend. */
static void tell_attachments(tulle_world *world) {
    world_events *const events = world->events;
    size_t k = 0;
    for (size_t i = 0; i < events->held.count; i++) {
        held_attachment const was = events->held.data[i];
        while (k < events->holding.count && events->holding.data[k].number < was.number) k++;
        if (k < events->holding.count && events->holding.data[k].number == was.number) continue;
        size_t const count = events->count;
        add_event(world, TULLE_EVENT_ATTACHMENT_END, (uint64_t)was.cloth << 32 | UINT32_MAX, 0.0);
        if (events->count > count)
            events->queue[(events->first + count) % events->watch.capacity].attachment = was.number;
    }
}

void world_tell_events(tulle_world *world) {
    static const struct {
        uint8_t mark;
        tulle_event_kind begin, end;
    } changes[] = {
        {IS_ASLEEP, TULLE_EVENT_SLEEP, TULLE_EVENT_WAKE},
        {IS_PINCHED, TULLE_EVENT_PINCH_BEGIN, TULLE_EVENT_PINCH_END},
        {IS_OVERSTRETCHED, TULLE_EVENT_OVERSTRETCH_BEGIN, TULLE_EVENT_OVERSTRETCH_END},
        {IS_PRESENT, TULLE_EVENT_APPEAR, TULLE_EVENT_LEAVE},
        {IS_TANGLED, TULLE_EVENT_KIND_COUNT, TULLE_EVENT_UNTANGLED},
    };
    world_events *const events = world->events;
    if (!events) return;
    size_t i = 0, k = 0;
    while (i < events->pairs.count || k < events->found.count) {
        uint64_t const was = i < events->pairs.count ? events->pairs.data[i].key : UINT64_MAX;
        uint64_t const is = k < events->found.count ? events->found.data[k].key : UINT64_MAX;
        if (was < is) add_event(world, TULLE_EVENT_CONTACT_END, was, 0.0);
        if (is < was) add_event(world, TULLE_EVENT_CONTACT_BEGIN, is, events->found.data[k].force);
        i += was <= is;
        k += is <= was;
    }
    for (size_t s = 0; s <= world->model.surface_count; s++) {
        uint8_t const was = events->marks[s], is = find_marks(world, s);
        uint64_t const object = s < world->model.surface_count ? s : UINT32_MAX;
        events->marks[s] = is;
        for (size_t c = 0; was != is && c < sizeof changes / sizeof changes[0]; c++) {
            if (((was ^ is) & changes[c].mark) == 0) continue;
            bool const begins = (is & changes[c].mark) != 0;
            add_event(world, begins ? changes[c].begin : changes[c].end, object << 32 | UINT32_MAX,
                      0.0);
        }
    }
    tell_attachments(world);
    swap_looks(events);
}

void world_restart_events(tulle_world *world) {
    world_events *const events = world->events;
    if (!events) return;
    events->first = events->count = 0;
    events->lost = 0;
    swap_looks(events);
    for (size_t s = 0; s <= world->model.surface_count; s++)
        events->marks[s] = find_marks(world, s);
}

/* ---- objects that come and go ---- */

/* The object that was this one before; the world stays what it is. */
static uint32_t map_object(const world_change *change, uint32_t object) {
    return object == UINT32_MAX ? UINT32_MAX : change->targets[object];
}

/* Events of what has gone are dropped, all others call objects by their new numbers. */
static void renumber_queue(const world_change *change, world_events *events) {
    size_t kept = 0;
    for (size_t i = 0; i < events->count; i++) {
        tulle_event event = events->queue[(events->first + i) % events->watch.capacity];
        uint32_t const a = event.object_a, b = event.object_b;
        event.object_a = map_object(change, a);
        event.object_b = map_object(change, b);
        bool const has_gone = (a != UINT32_MAX && event.object_a == TULLE_NONE) ||
                              (b != UINT32_MAX && event.object_b == TULLE_NONE);
        if (!has_gone) events->queue[(events->first + kept++) % events->watch.capacity] = event;
    }
    events->count = kept;
}

tulle_status world_carry_events(tulle_world *world, tulle_error *error) {
    const world_change *const change = world->change;
    world_events *const events = change->before->events;
    size_t const count = world->model.surface_count;
    size_t const count_before = change->before->model.surface_count;
    if (!events) return TULLE_OK;
    uint8_t *const marks = memory_allocate_zeroed(&world->heap, count + 1, 1);
    if (!marks) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for events");
    world->events = events;
    for (size_t s = 0; s < count; s++)
        marks[s] = change->sources[s] == TULLE_NONE ? find_marks(world, s)
                                                    : events->marks[change->sources[s]];
    marks[count] = events->marks[count_before];
    memory_release(&world->heap, events->marks, count_before + 1);
    events->marks = marks;
    size_t kept = 0;
    for (size_t i = 0; i < events->pairs.count; i++) {
        touching_pair pair = events->pairs.data[i];
        uint64_t const a = map_object(change, (uint32_t)(pair.key >> 32));
        uint64_t const b = map_object(change, (uint32_t)pair.key);
        pair.key = a << 32 | b;
        if (a != TULLE_NONE && b != TULLE_NONE) events->pairs.data[kept++] = pair;
    }
    events->pairs.count = kept;
    for (size_t i = 0; i < events->held.count; i++) {
        uint32_t *const cloth = &events->held.data[i].cloth;
        *cloth = map_object(change, *cloth); /* the next step tells of what has ended */
    }
    renumber_queue(change, events);
    return TULLE_OK;
}

/* ---- calls ---- */

static void destroy_events(tulle_world *world, world_events *events) {
    memory *const heap = &world->heap;
    if (!events) return;
    memory_release(heap, events->marks, world->model.surface_count + 1);
    memory_release(heap, events->queue, events->watch.capacity * sizeof *events->queue);
    ARRAY_FREE(heap, &events->pairs);
    ARRAY_FREE(heap, &events->found);
    ARRAY_FREE(heap, &events->held);
    ARRAY_FREE(heap, &events->holding);
    memory_release(heap, events, sizeof *events);
}

void world_release_events(tulle_world *world) {
    destroy_events(world, world->events);
    world->events = NULL;
}

tulle_event_watch tulle_event_watch_default(void) {
    tulle_event_watch watch;
    fields_set_defaults(&event_watch_fields, &watch);
    return watch;
}

tulle_status tulle_world_watch_events(tulle_world *world, const tulle_event_watch *watch,
                                      tulle_error *error) {
    if (!world || !world->is_started)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         world ? "call tulle_world_start before events are watched"
                               : "the world is null");
    if (!watch) {
        world_release_events(world);
        WORLD_RECORD(world, .kind = RECORD_WATCH);
        return TULLE_OK;
    }
    if (watch->kinds == 0 || watch->capacity == 0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the watch of events has no %s; null ends the watch; begin with "
                         "tulle_event_watch_default",
                         watch->kinds == 0 ? "kinds" : "capacity");
    tulle_status const checked = fields_check(&event_watch_fields, watch, "events", NULL, error);
    if (checked != TULLE_OK) return checked;
    memory *const heap = &world->heap;
    world_events *const before = world->events;
    world_events *const events = memory_allocate_zeroed(heap, 1, sizeof *events);
    if (!events) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for events");
    events->watch = *watch;
    events->marks = memory_allocate_zeroed(heap, world->model.surface_count + 1, 1);
    events->queue = memory_allocate(heap, watch->capacity * sizeof *events->queue);
    world->events = events;
    tulle_status const status =
        events->marks && events->queue
            ? world_find_touching(world, &world->now, error)
            : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for events");
    if (status == TULLE_OK)
        world_restart_events(world);
    else
        world->events = before;
    destroy_events(world, status == TULLE_OK ? before : events);
    if (status == TULLE_OK)
        WORLD_RECORD(world, .kind = RECORD_WATCH, .numbers = {1}, .def.watch = *watch);
    return status;
}

tulle_status tulle_world_poll_events(tulle_world *world, tulle_event *events, size_t capacity,
                                     size_t *count, uint64_t *lost, tulle_error *error) {
    if (count) *count = 0;
    if (!world || !world->events || !count || (!events && capacity > 0))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         world && !world->events
                             ? "the world watches no events; call tulle_world_watch_events"
                             : "the world, the count or the place for events is null");
    world_events *const own = world->events;
    for (; *count < capacity && own->count > 0; own->count--) {
        events[(*count)++] = own->queue[own->first];
        own->first = (own->first + 1) % own->watch.capacity;
    }
    if (lost) {
        *lost = own->lost;
        own->lost = 0;
    }
    return TULLE_OK;
}
