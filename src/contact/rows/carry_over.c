/* contact/rows/carry_over.c - see carry_over.h.
 *
 * A vertex slides from triangle to triangle, and an edge from edge to edge. At the rim of a surface
 * a contact of a vertex becomes one of edges. The pair changes, but the contact goes on, and so
 * does its impulse. A contact and a row match when
 *  - they have the vertex in common, and their triangles share an edge or a vertex;
 *  - they have one edge in common, and their other edges share a vertex;
 *  - they have the vertex or one edge in common, and the other features belong to one obstacle: a
 *    vertex may slide by more than a triangle in a step;
 *  - one is of a vertex and a triangle, the other of two edges; one edge ends in the vertex, and
 *    the other in a corner of the triangle.
 *
 * Their normals must agree, so that no impulse goes to another side. Contacts choose in the order
 * of the store. A contact takes the row of its own kind that has most in common with it; of equal
 * ones it takes the row with the nearest normal.
 *
 * Whether the contact was hard is not handed on. A tip is hard on one triangle only. If the mark
 * slid along, cloth that lands on spikes would tear further (lab/contact.md).
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6 (sliding in a determined configuration). */
#include "contact/rows/carry_over.h"

#include "contact/rows/contact_store.h"
#include "contact/rows/stick_anchors.h"

/* Least cosine between the normals of a contact and the row that takes it over. */
static const double LEAST_COSINE = 0.5;
/* Rows of the contact's own kind come before those of the other kind, even where they only share
 * its obstacle. Among rows of one kind the number of common vertices decides. */
enum { SLID_RANK = 5, SAME_KIND_RANK = 10 };

typedef struct heir_search {
    const contact_scene *scene;
    contact_row *const *rows;
    uint32_t *begin, *items; /* candidates around each vertex */
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

/* How well a row fits a contact with the vertices v; 0: not at all. *side is -1 where the row's
 * second feature continues the contact's first one, else 1. */
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

/* The candidate for a contact, as an index of rows, or TULLE_NONE. */
static uint32_t find_heir(const heir_search *search, const stored_contact *contact, double *side) {
    uint32_t v[4];
    feature_pair const pair = {contact->first, contact->second};
    feature_pair_vertices(search->scene->set->topo, (feature_kind)contact->kind, pair, v);
    vec3 const normal = vec3_load(contact->normal, 0);
    int const own_count = contact->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 4;
    uint32_t best = TULLE_NONE;
    int best_rank = 0;
    double best_cosine = 0.0;
    for (int k = 0; k < own_count; k++)
        for (uint32_t i = search->begin[v[k]]; i < search->begin[v[k] + 1]; i++) {
            const contact_row *const row = search->rows[search->items[i]];
            double row_side;
            int const rank =
                row->law.is_old ? 0 : rank_heir(search->scene, contact, v, row, &row_side);
            if (rank == 0 || rank < best_rank) continue;
            double const cosine = row_side * vec3_dot(normal, row->frame.normal);
            if (!(cosine >= LEAST_COSINE) || (rank == best_rank && cosine <= best_cosine)) continue;
            best = search->items[i];
            best_rank = rank;
            best_cosine = cosine;
            *side = row_side;
        }
    return best;
}

tulle_status carry_over_contacts(const contact_scene *scene, const contact_store *store,
                                 contact_row *const *rows, uint8_t *choices, size_t count) {
    if (store->contacts.count == 0 || count == 0) return TULLE_OK;
    const topology *const topo = scene->set->topo;
    arena_mark const mark = arena_get_mark(scene->scratch);
    bool *const is_present = ARENA_NEW_ZEROED(scene->scratch, bool, store->contacts.count);
    uint32_t *const begin = ARENA_NEW_ZEROED(scene->scratch, uint32_t, scene->vertex_count + 2);
    uint32_t *const items = ARENA_NEW(scene->scratch, uint32_t, 4 * count);
    if (!is_present || !begin || !items) {
        arena_release(scene->scratch, mark);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }

    /* Contacts that have a row are marked; rows that have no contact are counted at their vertices.
     */
    contact_reader reader = {.store = store};
    for (size_t i = 0; i < count; i++) {
        const row_frame *const frame = &rows[i]->frame;
        if (choices[i] == ROW_DROPPED) continue;
        for (int k = 0; k < 4 && !rows[i]->law.is_old; k++) begin[frame->vertices[k] + 2]++;
        if (!rows[i]->law.is_old) continue;
        const stored_contact *const contact = read_contact(&reader, frame->kind, frame->pair);
        if (contact) is_present[contact - store->contacts.data] = true;
    }

    /* Those rows are listed at each of their vertices. Of equally good ones the first becomes the
     * heir, so rows that are kept anyway come before reserved ones. */
    for (size_t v = 0; v < scene->vertex_count; v++) begin[v + 2] += begin[v + 1];
    const row_choice choice_order[2] = {ROW_KEPT, ROW_RESERVED};
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < count; i++) {
            if (choices[i] != choice_order[pass] || rows[i]->law.is_old) continue;
            for (int k = 0; k < 4; k++)
                items[begin[rows[i]->frame.vertices[k] + 1]++] = (uint32_t)i;
        }

    /* Each contact that carries load and has no row goes to its heir, if there is one. A contact of
     * another scene's store may name features that do not exist here. */
    heir_search const search = {scene, rows, begin, items};
    double const scale = scene->time_step / store->time_step;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        bool const is_vertex = contact->kind == FEATURE_VERTEX_TRIANGLE;
        bool const is_known =
            contact->first < (is_vertex ? topo->vertex_count : topo->edge_count) &&
            contact->second < (is_vertex ? topo->triangle_count : topo->edge_count);
        bool const has_impulse =
            contact->impulse[0] != 0.0 || contact->impulse[1] != 0.0 || contact->impulse[2] != 0.0;
        if (is_present[i] || !has_impulse || !is_known) continue;
        double side = 1.0;
        uint32_t const heir = find_heir(&search, contact, &side);
        if (heir == TULLE_NONE) continue;
        inherit_contact(scene, rows[heir], contact, scale, side);
        choices[heir] = ROW_KEPT;
    }
    arena_release(scene->scratch, mark);
    return TULLE_OK;
}
