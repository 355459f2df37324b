/* detect/detector/detector_events.c - from what a pass found to what callers read: where the
 * features are nearest at the event's time, along which normal, and how far apart.
 *
 * Coordinates are taken relative to the pair's first point and scaled by powers of two to about 1,
 * so places far from the origin and the smallest and largest doubles do no harm. */
#include "base/parallel.h"
#include "detect/detector/detector_parts.h"

#include <string.h>

enum { EVENTS_PER_CHUNK = 512 }; /* some 100 microseconds */

/* [extent of the pair] Features nearer than this touch: rounding, some 1e-15, would turn the
 * direction between their closest points by more than a thousandth. */
static const double TOUCHING_DISTANCE = 1e-12;
/* Sines below this are rounding: such edges count as parallel, such triangles as lines. */
static const double LEAST_SINE = 1e-14;
/* Coordinates within 2^-LARGE_EXPONENT .. 2^LARGE_EXPONENT are taken as they are. */
enum { LARGE_EXPONENT = 60 };

/* The four points at both ends, relative to where the first point is, times a power of two. */
typedef struct local_pair {
    vec3 start[4], end[4];
    int exponent; /* true differences are these times 2^exponent */
} local_pair;

static vec3 scale_exponent(vec3 a, int exponent) {
    return (vec3){ldexp(a.x, exponent), ldexp(a.y, exponent), ldexp(a.z, exponent)};
}

/* Scales a pair by a power of two so that its largest coordinate is about 1, if it is very large or
 * very small. */
static void scale_pair(local_pair *pair) {
    double most = 0.0;
    for (int k = 0; k < 4; k++) {
        vec3 const a = pair->start[k], b = pair->end[k];
        most = fmax(most, fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z))));
        most = fmax(most, fmax(fabs(b.x), fmax(fabs(b.y), fabs(b.z))));
    }
    int exponent = 0;
    if (most > 0.0) frexp(most, &exponent);
    if (exponent >= -LARGE_EXPONENT && exponent <= LARGE_EXPONENT) return;
    pair->exponent += exponent;
    for (int k = 0; k < 4; k++) {
        pair->start[k] = scale_exponent(pair->start[k], -exponent);
        pair->end[k] = scale_exponent(pair->end[k], -exponent);
    }
}

static local_pair load_local_pair(const detector_pass *pass, const uint32_t vertices[4]) {
    local_pair pair = {.exponent = 0};
    for (int k = 0; k < 4; k++) {
        pair.start[k] = vec3_load(pass->start, vertices[k]);
        pair.end[k] = vec3_load(pass->end, vertices[k]);
    }
    scale_pair(&pair);
    for (int k = 3; k >= 0; k--) {
        pair.start[k] = vec3_sub(pair.start[k], pair.start[0]);
        pair.end[k] = vec3_sub(pair.end[k], pair.end[0]);
    }
    scale_pair(&pair);
    return pair;
}

/* sum w[i] x[i] */
static vec3 combine(const double weights[4], const vec3 points[4]) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++) sum = vec3_add_scaled(sum, points[k], weights[k]);
    return sum;
}

/* The common normal of touching features, to the side from which the first comes: by where its
 * closest point was at the start, else by where it goes. */
static vec3 compute_touching_normal(feature_kind kind, const local_pair *pair, const vec3 points[4],
                                    const double weights[4]) {
    bool const has_face = kind == FEATURE_VERTEX_TRIANGLE;
    vec3 const a = has_face ? vec3_sub(points[2], points[1]) : vec3_sub(points[1], points[0]);
    vec3 const b = has_face ? vec3_sub(points[3], points[1]) : vec3_sub(points[3], points[2]);
    vec3 normal = vec3_cross(vec3_normalize(a), vec3_normalize(b));
    if (vec3_norm(normal) > LEAST_SINE)
        normal = vec3_normalize(normal);
    else /* parallel but for rounding */
        normal = vec3_make(0.0, 0.0, 0.0);
    double const height = vec3_dot(normal, combine(weights, pair->start));
    if (fabs(height) > TOUCHING_DISTANCE) return height < 0.0 ? vec3_neg(normal) : normal;
    double const later = vec3_dot(normal, combine(weights, pair->end));
    return later > TOUCHING_DISTANCE ? vec3_neg(normal) : normal;
}

static void fill_place(feature_kind kind, const local_pair *pair, tulle_detect_event *event) {
    vec3 points[4];
    double extent = 0.0;
    for (int k = 0; k < 4; k++) {
        points[k] = vec3_lerp(pair->start[k], pair->end[k], event->time);
        extent = fmax(extent, vec3_norm(points[k]));
    }
    closest_points const closest = closest_of_pair(kind, points);
    double const distance = sqrt(closest.distance2);
    for (int k = 0; k < 4; k++) event->weights[k] = closest.weights[k];
    vec3 const normal = distance > TOUCHING_DISTANCE * extent
                            ? vec3_scale(closest.difference, 1.0 / distance)
                            : compute_touching_normal(kind, pair, points, closest.weights);
    vec3_store(event->normal, 0, normal);
    event->distance = pair->exponent == 0 ? distance : ldexp(distance, pair->exponent);
}

static void fill_event(const tulle_detector *detector, const detector_pass *pass,
                       const raw_event *raw, tulle_detect_event *event) {
    memset(event, 0, sizeof *event); /* padding too: equal events have equal bytes */
    feature_kind const kind = (feature_kind)raw->kind;
    feature_pair const features = {(uint32_t)(raw->key >> 32), (uint32_t)raw->key};
    bool const has_face = kind == FEATURE_VERTEX_TRIANGLE;
    event->kind = has_face ? TULLE_DETECT_VERTEX_FACE : TULLE_DETECT_EDGE_EDGE;
    event->state = raw->state == TOI_TOUCHING_AT_START ? TULLE_DETECT_TOUCHING_AT_START
                   : raw->state == TOI_HIT             ? TULLE_DETECT_HIT
                                                       : TULLE_DETECT_UNRESOLVED;
    event->face = has_face ? features.second : TULLE_NONE;
    event->time = raw->time;
    feature_pair_vertices(&detector->topo, kind, features, event->vertices);
    const uint32_t *const surface = detector->vertex_surface;
    event->surfaces[0] = surface ? surface[event->vertices[0]] : 0;
    event->surfaces[1] = surface ? surface[event->vertices[3]] : 0;
    local_pair const pair = load_local_pair(pass, event->vertices);
    fill_place(kind, &pair, event);
}

typedef struct fill_context {
    const tulle_detector *detector;
    const detector_pass *pass;
    size_t first;
    tulle_detect_event *events;
} fill_context;

static void fill_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_context *const fill = context;
    for (size_t i = begin; i < end; i++)
        fill_event(fill->detector, fill->pass, &fill->pass->events[fill->first + i],
                   &fill->events[i]);
}

void detector_fill_events(const tulle_detector *detector, const detector_pass *pass, size_t begin,
                          size_t end, tulle_detect_event *events) {
    fill_context context = {.detector = detector, .pass = pass, .first = begin, .events = events};
    parallel_for(end - begin, EVENTS_PER_CHUNK, detector->threads, fill_chunk, &context);
}
