/* contact/rows/contact_store.c - see contact_store.h.
 *
 * The store is an array sorted by (kind, first, second). A pair may own several rows, one gathered
 * and some from impacts. Their impulses act on nearly the same points, so the pair carries their
 * sum. State and age are the largest of them; the normal is that of the oldest row. Contacts of
 * equal keys are added in the order in which the heap sort leaves them. */
#include "contact/rows/contact_store.h"

#include "base/hash.h"
#include "base/sort.h"

#include <math.h>
#include <string.h>

static int compare_keys(const void *one, const void *two) {
    const stored_contact *const a = one, *const b = two;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    if (a->first != b->first) return a->first < b->first ? -1 : 1;
    if (a->second != b->second) return a->second < b->second ? -1 : 1;
    return 0;
}

tulle_status reserve_contacts(contact_store *store, memory *heap, size_t row_count) {
    if (row_count <= store->contacts.capacity) return TULLE_OK;
    bool const has_room = ARRAY_RESERVE(heap, &store->contacts, row_count - store->contacts.count);
    return has_room ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status store_contacts(contact_store *store, memory *heap, const row_list *list,
                            const stored_contact *others, size_t other_count, double time_step) {
    tulle_status const status = reserve_contacts(store, heap, list->rows.count + other_count);
    if (status != TULLE_OK) return status;
    stored_contact *const contacts = store->contacts.data;
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        /* a contact that rebounds carries nothing into the next step */
        vec3 const impulse = vec3_scale(row->solve.impulse, row->law.rebound > 0.0 ? 0.0 : 1.0);
        contacts[i] = (stored_contact){
            .kind = (uint32_t)row->frame.kind,
            .first = row->frame.pair.first,
            .second = row->frame.pair.second,
            .is_hard = row->solve.is_hard,
            .state = (uint32_t)row->solve.state,
            .age = row->law.age == UINT32_MAX ? row->law.age : row->law.age + 1,
            .impulse = {impulse.x, impulse.y, impulse.z},
            .normal = {row->frame.normal.x, row->frame.normal.y, row->frame.normal.z},
            .anchor = {row->law.anchor.x, row->law.anchor.y, row->law.anchor.z}};
    }
    bool is_sorted = true;
    for (size_t i = 1; i < list->rows.count; i++)
        is_sorted = is_sorted && compare_keys(&contacts[i - 1], &contacts[i]) < 0;
    if (!is_sorted) sort_by_heap(contacts, list->rows.count, sizeof *contacts, compare_keys);
    /* one contact of each run of equal keys */
    size_t kept = 0;
    for (size_t i = 0; i < list->rows.count; i++) {
        const stored_contact *const next = &contacts[i];
        if (kept == 0 || compare_keys(&contacts[kept - 1], next) != 0) {
            contacts[kept++] = *next;
            continue;
        }
        stored_contact *const last = &contacts[kept - 1];
        for (int k = 0; k < 3; k++) last->impulse[k] += next->impulse[k];
        last->is_hard |= next->is_hard;
        if (next->state > last->state) last->state = next->state;
        if (next->age > last->age) {
            last->age = next->age;
            memcpy(last->normal, next->normal, sizeof last->normal);
            memcpy(last->anchor, next->anchor, sizeof last->anchor);
        }
    }
    /* both are sorted: merged from the end, where there is room */
    size_t const count = kept + other_count;
    for (size_t left = other_count; left > 0;) {
        const stored_contact *const other = &others[left - 1];
        bool const is_row = kept > 0 && compare_keys(&contacts[kept - 1], other) > 0;
        contacts[kept + left - 1] = is_row ? contacts[kept - 1] : *other;
        kept -= is_row;
        left -= !is_row;
    }
    store->contacts.count = count;
    store->time_step = count > 0 ? time_step : 0.0;
    return TULLE_OK;
}

/* Passes over contacts in leaps that double, then looks for the key in the last one by bisection.
 */
const stored_contact *read_contact(contact_reader *reader, feature_kind kind, feature_pair pair) {
    stored_contact const key = {.kind = (uint32_t)kind, .first = pair.first, .second = pair.second};
    const stored_contact *const contacts = reader->store->contacts.data;
    size_t const count = reader->store->contacts.count;
    size_t low = reader->next, high = reader->next;
    for (size_t leap = 1; high < count && compare_keys(&contacts[high], &key) < 0; leap *= 2) {
        low = high + 1;
        high = leap < count - high ? high + leap : count;
    }
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (compare_keys(&contacts[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    reader->next = low;
    return low < count && compare_keys(&contacts[low], &key) == 0 ? &contacts[low] : NULL;
}

uint64_t contact_store_hash(const contact_store *store, uint64_t hash) {
    uint64_t const count = store->contacts.count;
    hash = hash_bytes(hash, &count, sizeof count);
    hash = hash_bytes(hash, &store->time_step, sizeof store->time_step);
    return hash_bytes(hash, store->contacts.data, store->contacts.count * sizeof(stored_contact));
}

/* Block: count (8 bytes), time step (8 bytes), contacts. */
typedef struct store_header {
    uint64_t count;
    double time_step;
} store_header;

size_t contact_store_get_size(const contact_store *store) {
    return sizeof(store_header) + store->contacts.count * sizeof(stored_contact);
}

void contact_store_save(const contact_store *store, void *bytes) {
    store_header const header = {store->contacts.count, store->time_step};
    memcpy(bytes, &header, sizeof header);
    if (header.count > 0)
        memcpy((char *)bytes + sizeof header, store->contacts.data,
               store->contacts.count * sizeof(stored_contact));
}

static bool is_valid_contact(const stored_contact *contact) {
    for (int k = 0; k < 3; k++)
        if (!isfinite(contact->impulse[k]) || !isfinite(contact->normal[k]) ||
            !isfinite(contact->anchor[k]))
            return false;
    return contact->kind <= FEATURE_EDGE_EDGE && contact->is_hard <= 1 &&
           contact->state <= ROW_SLIDES;
}

/* Checks a block without relying on its alignment. */
static bool is_valid_block(const char *bytes, size_t byte_count, store_header *header) {
    if (byte_count < sizeof *header) return false;
    memcpy(header, bytes, sizeof *header);
    if (header->count > (byte_count - sizeof *header) / sizeof(stored_contact)) return false;
    if (byte_count != sizeof *header + header->count * sizeof(stored_contact)) return false;
    if (!isfinite(header->time_step) || header->time_step < 0.0) return false;
    if ((header->count > 0) != (header->time_step > 0.0)) return false;
    stored_contact last = {0}, contact;
    for (size_t i = 0; i < header->count; i++) {
        memcpy(&contact, bytes + sizeof *header + i * sizeof contact, sizeof contact);
        if (!is_valid_contact(&contact) || (i > 0 && compare_keys(&last, &contact) >= 0))
            return false;
        last = contact;
    }
    return true;
}

tulle_status contact_store_load(contact_store *store, memory *heap, const void *bytes,
                                size_t byte_count) {
    store_header header;
    if (!is_valid_block(bytes, byte_count, &header)) return TULLE_ERROR_INVALID_ARGUMENT;
    tulle_status const status = reserve_contacts(store, heap, (size_t)header.count);
    if (status != TULLE_OK) return status;
    if (header.count > 0)
        memcpy(store->contacts.data, (const char *)bytes + sizeof header,
               (size_t)header.count * sizeof(stored_contact));
    store->contacts.count = (size_t)header.count;
    store->time_step = header.time_step;
    return TULLE_OK;
}

bool contact_store_fits(const contact_store *store, const topology *topo) {
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        bool const is_edges = contact->kind == FEATURE_EDGE_EDGE;
        if (contact->first >= (is_edges ? topo->edge_count : topo->vertex_count) ||
            contact->second >= (is_edges ? topo->edge_count : topo->triangle_count))
            return false;
    }
    return true;
}
