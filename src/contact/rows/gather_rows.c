/* contact/rows/gather_rows.c - stage 5, see gather_rows.h.
 *
 * A pair that is near at the start gets a row with the frame of the start. A pair whose predicted
 * path comes within the contact distance gets a row with the frame of that time, so that the row
 * pushes where the impact will be. Rows only shape the response: stages 8 and 9 catch impacts
 * without a row.
 */
#include "contact/rows/gather_rows.h"

#include "contact/pairs/apart_pairs.h"
#include "contact/pairs/near_pairs.h"
#include "contact/pairs/pair_filter.h"
#include "contact/pairs/pair_rules.h"
#include "contact/rows/choose_rows.h"
#include "geom/distance.h"

/* A tied vertex has no rows with cloth nearer to its place, at rest, than this many of the largest
 * contact distance: so far a fold cannot bring anything else to it. */
static const double TIED_REACH = 2.0;

typedef struct gathering {
    const contact_scene *scene;
    const double *predicted;
    const vertex_record *paths, *rest_shape;    /* x0 -> predicted, and the rest shape */
    const double *ways;                         /* [m] vertex_count: length of each path */
    pair_tables tables;                         /* of the paths */
    double largest_contact, largest_separation; /* [m] with rounding slack */
} gathering;

/* Whether one side of a pair is held rigidly near the other: the tie keeps their distance, and a
 * row would pull against it for ever. Bodies are stiff, so all of a body is kept away. Cloth may
 * fold onto the vertex that it holds; only rows near the place at rest are left out. */
static bool pair_is_tied(const contact_scene *scene, feature_kind kind, feature_pair pair) {
    if (!scene->tied_surfaces) return false;
    uint32_t vertices[4];
    feature_pair_vertices(scene->set->topo, kind, pair, vertices);
    int const first_count = kind == FEATURE_EDGE_EDGE ? 2 : 1;
    for (int side = 0; side < 2; side++) {
        uint32_t const holder = vertices[side == 0 ? 3 : 0];
        bool is_tied = true;
        vec3 points[4];
        for (int k = 0; k < 4; k++) {
            bool const is_held = (k < first_count) == (side == 0);
            is_tied =
                is_tied &&
                (!is_held || (vertices[k] < scene->cloth_vertex_count &&
                              scene->tied_surfaces[vertices[k]] == scene->vertex_surface[holder]));
            if (is_tied)
                points[k] = vec3_load(is_held ? scene->tied_places : scene->rest, vertices[k]);
        }
        double const reach = TIED_REACH * scene->largest_contact;
        if (is_tied && (holder >= scene->cloth_vertex_count ||
                        closest_of_pair(kind, points).distance2 < reach * reach))
            return true;
    }
    return false;
}

/* The time of an event is 0 for a pair that is near at the start. For another one it is when the
 * pair's path first comes within the contact distance. Two edges that touch at an end are no event:
 * their contact is left to the vertex's own rows (admissible_rows.h). */
static void measure_touches(const void *context, feature_kind kind, pair_event *events,
                            size_t count, scan_verdict *verdicts) {
    const gathering *const work = context;
    const contact_scene *const scene = work->scene;
    const topology *const topo = scene->set->topo;
    if (count == 0) return;
    double distances[SCAN_MOST];
    bool is_at_end[SCAN_MOST];
    feature_pair pairs[SCAN_MOST];
    for (size_t i = 0; i < count; i++) pairs[i] = events[i].pair;
    TULLE_PICK_KERNEL(measure_distances)
    (topo, work->paths, kind, pairs, count, &(pair_measures){distances, is_at_end});

    /* Most pairs neither start near each other nor go far enough to come near: they are done. Only
     * pairs of one surface need their distance in the rest shape. */
    uint8_t kept[SCAN_MOST], folded[SCAN_MOST];
    feature_pair folded_pairs[SCAN_MOST];
    bool is_slow[SCAN_MOST];
    size_t kept_count = 0, folded_count = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t vertices[4];
        feature_pair_vertices(topo, kind, pairs[i], vertices);
        events[i].distance = distances[i];
        events[i].time = 0.0;
        verdicts[i] = SCAN_DROP;
        /* the sides come nearer by at most the longest way of each */
        double w[4];
        for (int k = 0; k < 4; k++) w[k] = work->ways[vertices[k]];
        double const later = w[2] > w[3] ? w[2] : w[3], earlier = w[0] > w[1] ? w[0] : w[1];
        double const approach =
            kind == FEATURE_EDGE_EDGE ? earlier + later : w[0] + (w[1] > later ? w[1] : later);
        is_slow[i] = distances[i] - approach > work->largest_contact;
        if (is_slow[i] && distances[i] >= work->largest_separation) continue;
        kept[kept_count++] = (uint8_t)i;
        if (scene->vertex_surface[vertices[0]] != scene->vertex_surface[vertices[3]]) continue;
        folded_pairs[folded_count] = pairs[i];
        folded[folded_count++] = (uint8_t)i;
    }
    double rest[SCAN_MOST], at_rest[SCAN_MOST];
    bool unused[SCAN_MOST];
    TULLE_PICK_KERNEL(measure_distances)
    (topo, work->rest_shape, kind, folded_pairs, folded_count, &(pair_measures){at_rest, unused});
    for (size_t k = 0; k < folded_count; k++) rest[folded[k]] = at_rest[k];

    /* near pairs; those of the others that may come near make a query */
    apart_query far = {.kind = kind, .count = 0};
    uint8_t indices[SCAN_MOST]; /* of the query's pairs among the events */
    for (size_t k = 0; k < kept_count; k++) {
        size_t const i = kept[k];
        uint32_t vertices[4];
        feature_pair_vertices(topo, kind, pairs[i], vertices);
        pair_distances const limits = compute_pair_distances(scene, kind, vertices, &rest[i]);
        bool const is_near = !(distances[i] >= limits.separation);
        verdicts[i] = is_near && !is_at_end[i]                  ? SCAN_EVENT
                      : distances[i] < work->largest_separation ? SCAN_DROP_NEAR
                                                                : SCAN_DROP;
        if (is_near || is_slow[i]) continue;
        indices[far.count] = (uint8_t)i;
        far.pairs[far.count] = pairs[i];
        far.separations[far.count++] = limits.contact;
    }

    /* those of the query that approach */
    bool is_apart[SCAN_MOST];
    if (far.count > 0) mark_apart(&work->tables, &far, is_apart);
    for (size_t k = 0; k < far.count; k++) {
        if (is_apart[k]) continue;
        size_t const i = indices[k];
        double const contact = far.separations[k];
        uint32_t vertices[4];
        moving_pair paths;
        feature_pair_vertices(topo, kind, pairs[i], vertices);
        load_points(scene->x0, vertices, paths.start);
        load_points(work->predicted, vertices, paths.end);
        if (prove_apart(kind, &paths, contact) == APART_BY_DIRECTION) continue;
        toi_result const result = time_of_impact(kind, &paths, contact);
        events[i].time = result.lower_bound;
        if (result.state != TOI_SEPARATED) verdicts[i] = SCAN_EVENT;
    }
    for (size_t k = 0; k < kept_count; k++) {
        size_t const i = kept[k];
        if (verdicts[i] != SCAN_DROP && pair_is_ignored(scene, kind, pairs[i]))
            verdicts[i] = SCAN_DROP;
        if (verdicts[i] == SCAN_EVENT && pair_is_tied(scene, kind, pairs[i]))
            verdicts[i] = distances[i] < work->largest_separation ? SCAN_DROP_NEAR : SCAN_DROP;
    }
}

tulle_status gather_rows(const contact_scene *scene, const contact_store *store,
                         const double *predicted, pair_source *source, row_list *list) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    double const slack = compute_rounding_slack(scene, predicted);
    double *const ways = ARENA_NEW(scene->scratch, double, scene->vertex_count);
    for (size_t i = 0; ways && i < scene->vertex_count; i++)
        ways[i] = vec3_norm(vec3_sub(vec3_load(predicted, i), vec3_load(scene->x0, i)));
    gathering work = {.scene = scene,
                      .predicted = predicted,
                      .paths = make_records(scene, scene->x0, predicted),
                      .rest_shape = make_records(scene, scene->rest, scene->rest),
                      .ways = ways,
                      .largest_contact = scene->largest_contact + slack,
                      .largest_separation = scene->largest_separation + slack};
    pair_scan const scan = {.records = work.paths,
                            .at_start = work.largest_separation,
                            .at_end = work.largest_contact,
                            .measure = measure_touches,
                            .context = &work,
                            .notes_near_pairs = true};
    bool const has_memory =
        work.rest_shape && work.ways && make_feature_tables(scene, work.paths, &work.tables);
    pair_events found;
    list->rows.count = 0;
    tulle_status status = has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) status = scan_pairs(scene, source->pairs, &scan, &found);
    if (status == TULLE_OK) status = note_near_pairs(scene, &found, &list->near_pairs);
    if (status == TULLE_OK) {
        source->near_pairs = &list->near_pairs;
        status = choose_rows(scene, store, predicted, &found, list);
    }
    list->gathered_count = list->rows.count;
    list->push_out_cut = 0.0;
    arena_release(scene->scratch, mark);
    return status;
}

void row_list_destroy(row_list *list, memory *heap) {
    ARRAY_FREE(heap, &list->rows);
    ARRAY_FREE(heap, &list->near_pairs.pairs);
    list->gathered_count = 0;
}
