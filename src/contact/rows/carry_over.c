/* contact/rows/carry_over.c - see carry_over.h.
 *
 * A vertex slides from triangle to triangle, an edge from edge to edge, and at the rim of a surface
 * the one contact becomes the other. The pair changes, the contact does not: its impulse goes on.
 * A contact and a row match when
 *  - they have the vertex in common, and their triangles an edge or a vertex;
 *  - they have one edge in common, and the other two a vertex;
 *  - they have the vertex or one edge in common, and the rest is of one obstacle: what slides by
 *    more than a triangle in a step;
 *  - one is of a vertex and a triangle, the other of two edges; one edge ends in the vertex, and
 *    the other in a corner of the triangle.
 *
 * Their normals must agree, so that no impulse goes to another side. Contacts choose in the order
 * of the store; of several rows the one of the same kind with most in common, then the one with the
 * nearest normal.
 * Whether the contact was hard is not handed on: with it cloth that lands on spikes tears further
 * (largest stretch 4.9 against 3.0 over ten places), since a tip is hard on one triangle only.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6 (sliding in a determined configuration). */
#include "contact/rows/carry_over.h"

#include "contact/rows/contact_store.h"
#include "contact/rows/stick_anchors.h"

#include <string.h>

/* Least cosine between the normals of a contact and the row that takes it over. */
static const double LEAST_COSINE = 0.5;
/* Corners in common rank rows of one kind among each other. Rows of the same kind come before those
 * of the other, even where they are further on upon the same obstacle. */
enum { SLID_RANK = 5, SAME_KIND_RANK = 10 };

typedef struct heir_search {
    const contact_scene *scene;
    contact_row *const *rows; /* candidates: the rows, then the reserve */
    size_t count;
    uint32_t *begin, *items; /* candidates without contact around each vertex */
} heir_search;

void inherit_contact(const contact_scene *scene, contact_row *row, const stored_contact *contact,
                     double scale, double side) {
    row->solve.impulse = vec3_scale(vec3_load(contact->impulse, 0), side * scale);
    row->law.is_old = true;
    row->law.old_state = (row_state)contact->state;
    row->law.age = contact->age;
    take_anchor(scene, row, vec3_scale(vec3_load(contact->anchor, 0), side));
}

static int count_common(const uint32_t *a, int a_count, const uint32_t *b, int b_count) {
    int common = 0;
    for (int i = 0; i < a_count; i++)
        for (int j = 0; j < b_count; j++) common += a[i] == b[j];
    return common;
}

/* How much a contact with the vertices v and a row have in common. 0: the row is none for this
 * contact. *side is -1 where the row's second feature is what the contact's first was. */
static int rank_heir(const contact_scene *scene, const stored_contact *contact, const uint32_t v[4],
                     const contact_row *row, double *side) {
    const uint32_t *const r = row->frame.vertices;
    bool const is_vertex = contact->kind == FEATURE_VERTEX_TRIANGLE;
    *side = 1.0;
    if ((feature_kind)contact->kind != row->frame.kind) {
        /* the vertex of the one must belong to an edge of the other */
        const uint32_t *const of_vertex = is_vertex ? v : r, *const of_edges = is_vertex ? r : v;
        for (int k = 0; k < 2; k++) {
            const uint32_t *const edge = of_edges + 2 * k;
            if (of_vertex[0] != edge[0] && of_vertex[0] != edge[1]) continue;
            *side = k == 0 ? 1.0 : -1.0;
            return count_common(of_vertex + 1, 3, of_edges + 2 * (1 - k), 2);
        }
        return 0;
    }
    /* one feature must be the same; the others touch, or are of one obstacle */
    int common = 0, rest = 4;
    if (contact->first == row->frame.pair.first) {
        common = is_vertex ? count_common(v + 1, 3, r + 1, 3) : count_common(v + 2, 2, r + 2, 2);
        rest = 3;
    } else if (!is_vertex && contact->second == row->frame.pair.second) {
        common = count_common(v, 2, r, 2);
        rest = 0;
    }
    if (common > 0) return SAME_KIND_RANK + common;
    bool const is_slid = rest < 4 && v[rest] >= scene->cloth_vertex_count &&
                         scene->vertex_surface[v[rest]] == scene->vertex_surface[r[rest]];
    return is_slid ? SLID_RANK : 0;
}

/* The candidate for a contact, or null. */
static contact_row *find_heir(const heir_search *search, const stored_contact *contact,
                              double *side) {
    uint32_t v[4];
    feature_pair const pair = {contact->first, contact->second};
    feature_pair_vertices(search->scene->set->topo, (feature_kind)contact->kind, pair, v);
    vec3 const normal = vec3_load(contact->normal, 0);
    int const own_count = contact->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 4;
    contact_row *best = NULL;
    int best_rank = 0;
    double best_cosine = 0.0;
    for (int k = 0; k < own_count; k++)
        for (uint32_t i = search->begin[v[k]]; i < search->begin[v[k] + 1]; i++) {
            contact_row *const row = search->rows[search->items[i]];
            double row_side;
            int const rank =
                row->law.is_old ? 0 : rank_heir(search->scene, contact, v, row, &row_side);
            if (rank == 0 || rank < best_rank) continue;
            double const cosine = row_side * vec3_dot(normal, row->frame.normal);
            if (!(cosine >= LEAST_COSINE) || (rank == best_rank && cosine <= best_cosine)) continue;
            best = row;
            best_rank = rank;
            best_cosine = cosine;
            *side = row_side;
        }
    return best;
}

/* Lists the rows without contact at each of their vertices, in ascending order. */
static bool list_candidates(heir_search *search) {
    arena *const scratch = search->scene->scratch;
    size_t const vertex_count = search->scene->vertex_count;
    search->begin = ARENA_NEW_ZEROED(scratch, uint32_t, vertex_count + 2);
    search->items = ARENA_NEW(scratch, uint32_t, 4 * search->count);
    if (!search->begin || !search->items) return false;
    for (size_t i = 0; i < search->count; i++)
        for (int k = 0; k < 4 && !search->rows[i]->law.is_old; k++)
            search->begin[search->rows[i]->frame.vertices[k] + 2]++;
    for (size_t v = 0; v < vertex_count; v++) search->begin[v + 2] += search->begin[v + 1];
    for (size_t i = 0; i < search->count; i++)
        for (int k = 0; k < 4 && !search->rows[i]->law.is_old; k++)
            search->items[search->begin[search->rows[i]->frame.vertices[k] + 1]++] = (uint32_t)i;
    return true;
}

/* Hands each contact of the store that carries load and has no row to its heir, if there is one. */
static void hand_over(const heir_search *search, const contact_store *store,
                      const bool *is_present) {
    const topology *const topo = search->scene->set->topo;
    double const scale = search->scene->time_step / store->time_step;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        bool const is_vertex = contact->kind == FEATURE_VERTEX_TRIANGLE;
        bool const is_known =
            contact->first < (is_vertex ? topo->vertex_count : topo->edge_count) &&
            contact->second < (is_vertex ? topo->triangle_count : topo->edge_count);
        bool const has_impulse =
            contact->impulse[0] != 0.0 || contact->impulse[1] != 0.0 || contact->impulse[2] != 0.0;
        if (is_present[i] || !has_impulse || !is_known) continue;
        double side;
        contact_row *const heir = find_heir(search, contact, &side);
        if (heir) inherit_contact(search->scene, heir, contact, scale, side);
    }
}

tulle_status carry_over_contacts(const contact_scene *scene, const contact_store *store,
                                 contact_row **rows, size_t *count, contact_row *const *reserve,
                                 size_t reserve_count) {
    if (store->contacts.count == 0 || *count + reserve_count == 0) return TULLE_OK;
    arena_mark const mark = arena_get_mark(scene->scratch);
    heir_search search = {.scene = scene, .rows = rows, .count = *count + reserve_count};
    bool *const is_present = ARENA_NEW_ZEROED(scene->scratch, bool, store->contacts.count);
    contact_row **const later = ARENA_NEW(scene->scratch, contact_row *, reserve_count);
    if (reserve_count > 0) memcpy(rows + *count, reserve, reserve_count * sizeof *reserve);
    bool const has_room = is_present && later && list_candidates(&search);
    if (has_room) {
        /* contacts that have a row */
        contact_reader reader = {.store = store};
        for (size_t i = 0; i < *count; i++) {
            if (!rows[i]->law.is_old) continue;
            const stored_contact *const contact =
                read_contact(&reader, rows[i]->frame.kind, rows[i]->frame.pair);
            if (contact) is_present[contact - store->contacts.data] = true;
        }
        hand_over(&search, store, is_present);
        /* rows of the reserve that took a contact are merged into the others from the back, which
         * needs a copy of the later ones only */
        size_t later_count = 0, begin = *count;
        for (size_t i = *count; i < search.count; i++)
            if (rows[i]->law.is_old) later[later_count++] = rows[i];
        *count += later_count;
        for (size_t place = *count; later_count > 0;) {
            const row_frame *const last = begin > 0 ? &rows[begin - 1]->frame : NULL;
            const row_frame *const next = &later[later_count - 1]->frame;
            bool is_later = true;
            if (last && last->kind != next->kind)
                is_later = last->kind < next->kind;
            else if (last && last->pair.first != next->pair.first)
                is_later = last->pair.first < next->pair.first;
            else if (last)
                is_later = last->pair.second < next->pair.second;
            rows[--place] = is_later ? later[--later_count] : rows[--begin];
        }
    }
    arena_release(scene->scratch, mark);
    return has_room ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
