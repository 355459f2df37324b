/* app/render/camera.c - see camera.h. */
#include "app/render/camera.h"

#include "app/render/options.h"
#include "base/error.h"
#include "scene/units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double ELEVATION_MAX = 1.5533430342749532; /* [rad] 89 degrees */
/* An obstacle of up to this many times the cloths' size is shown whole. */
static const double OBSTACLE_SIZE = 1.6;
static const double NEAR_SHARE = 0.15;     /* of the cloths' diagonal: how far around them counts */
static const double DISTANCE_LEAST = 1e-9; /* [m] from the target */
static const double FIT_MARGIN = 1.1;      /* what is seen leaves this much room around it */
static const double LENGTH_MAX = 1e6;      /* [m] as in scene files */

/* ---- boxes ---- */

picture_bounds picture_bounds_empty(void) {
    double const far = (double)INFINITY;
    return (picture_bounds){{far, far, far}, {-far, -far, -far}};
}

bool picture_bounds_is_empty(const picture_bounds *bounds) {
    return !(bounds->low[0] <= bounds->high[0]);
}

void picture_bounds_add(picture_bounds *bounds, const double *positions, size_t vertex_count) {
    for (size_t i = 0; i < 3 * vertex_count; i++) {
        bounds->low[i % 3] = fmin(bounds->low[i % 3], positions[i]);
        bounds->high[i % 3] = fmax(bounds->high[i % 3], positions[i]);
    }
}

void picture_bounds_join(picture_bounds *bounds, const picture_bounds *other) {
    if (picture_bounds_is_empty(other)) return;
    picture_bounds_add(bounds, other->low, 1);
    picture_bounds_add(bounds, other->high, 1);
}

double picture_bounds_get_diagonal(const picture_bounds *bounds) {
    if (picture_bounds_is_empty(bounds)) return 0.0;
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        double const extent = bounds->high[k] - bounds->low[k];
        sum += extent * extent;
    }
    return sqrt(sum);
}

/* ---- what is to be seen ---- */

/* Directions spread evenly over the sphere: a spiral of equal steps in height.
 * Based on: Alvaro Gonzalez, Measurement of areas on a sphere using Fibonacci and
 * latitude-longitude lattices, 2010. */
static void get_direction(int index, double direction[3]) {
    double const golden_angle = 2.399963229728653; /* [rad] */
    double const z = 1.0 - (2.0 * index + 1.0) / PICTURE_VIEW_POINTS;
    double const radius = sqrt(fmax(0.0, 1.0 - z * z));
    direction[0] = radius * cos(golden_angle * index);
    direction[1] = radius * sin(golden_angle * index);
    direction[2] = z;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

picture_view picture_view_empty(void) { return (picture_view){.bounds = picture_bounds_empty()}; }

void picture_view_add(picture_view *view, const double *positions, size_t vertex_count) {
    if (vertex_count == 0) return;
    bool const is_first = picture_bounds_is_empty(&view->bounds);
    picture_bounds_add(&view->bounds, positions, vertex_count);
    for (int i = 0; i < PICTURE_VIEW_POINTS; i++) {
        double direction[3];
        double *const point = view->points + 3 * (size_t)i;
        get_direction(i, direction);
        const double *farthest = is_first ? positions : point;
        double most = dot(farthest, direction);
        for (size_t k = 0; k < vertex_count; k++) {
            double const height = dot(positions + 3 * k, direction);
            if (height <= most) continue;
            most = height;
            farthest = positions + 3 * k;
        }
        if (farthest != point) memcpy(point, farthest, 3 * sizeof *point);
    }
}

void picture_view_join(picture_view *view, const picture_view *other) {
    if (picture_bounds_is_empty(&other->bounds)) return;
    picture_view_add(view, other->points, PICTURE_VIEW_POINTS);
    picture_bounds_join(&view->bounds, &other->bounds);
}

void picture_view_add_obstacle(picture_view *view, const picture_bounds *cloths,
                               const picture_view *obstacle) {
    if (picture_bounds_is_empty(cloths) || picture_bounds_is_empty(&obstacle->bounds)) return;
    double const diagonal = picture_bounds_get_diagonal(cloths);
    double part[2][3]; /* of the obstacle's box within the cloths' */
    for (int k = 0; k < 3; k++) {
        double const low = obstacle->bounds.low[k], high = obstacle->bounds.high[k];
        if (low > cloths->high[k] + NEAR_SHARE * diagonal) return;
        if (high < cloths->low[k] - NEAR_SHARE * diagonal) return;
        part[0][k] = fmin(fmax(low, cloths->low[k]), fmax(high, cloths->low[k]));
        part[1][k] = fmax(fmin(high, cloths->high[k]), fmin(low, cloths->high[k]));
    }
    if (picture_bounds_get_diagonal(&obstacle->bounds) <= OBSTACLE_SIZE * diagonal)
        picture_view_join(view, obstacle);
    else
        picture_view_add(view, part[0], 2);
}

/* ---- the option's text ---- */

enum { CAMERA_TEXT_MAX = 400 };

/* A key of --camera and the values that follow it. */
typedef struct camera_key {
    const char *name;
    int least_count, most_count;
    unit_dimension units[3];
    const char *example;
} camera_key;

static const camera_key camera_keys[] = {
    {"position", 3, 3, {UNIT_LENGTH, UNIT_LENGTH, UNIT_LENGTH}, "position=1,-2,80cm"},
    {"target", 3, 3, {UNIT_LENGTH, UNIT_LENGTH, UNIT_LENGTH}, "target=0,0,0.5"},
    {"orbit",
     2,
     3,
     {UNIT_ANGLE, UNIT_ANGLE, UNIT_LENGTH},
     "orbit=30deg,20deg or orbit=30deg,20deg,2m"},
    {"fov", 1, 1, {UNIT_ANGLE, UNIT_NONE, UNIT_NONE}, "fov=40deg"},
    {"turn", 1, 1, {UNIT_ANGLE, UNIT_NONE, UNIT_NONE}, "turn=360deg"},
};
enum { CAMERA_KEY_COUNT = sizeof camera_keys / sizeof camera_keys[0] };

static tulle_status fail(tulle_error *error, const char *text, const char *wrong) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "--camera: \"%.80s\": %s", text, wrong);
}

/* Angles need a unit: 30 could be meant either way. */
static bool read_value(const char *text, unit_dimension unit, double *value) {
    double plain;
    if (unit == UNIT_ANGLE && quantity_read(text, UNIT_NONE, &plain) == QUANTITY_READ &&
        plain != 0.0)
        return false;
    return quantity_read(text, unit, value) == QUANTITY_READ &&
           (unit != UNIT_LENGTH || fabs(*value) <= LENGTH_MAX);
}

static tulle_status set_camera(const camera_key *key, const double *values, int count,
                               scene_camera *camera, tulle_error *error) {
    if (strcmp(key->name, "position") == 0) {
        memcpy(camera->position, values, sizeof camera->position);
        camera->has_position = true;
    } else if (strcmp(key->name, "target") == 0) {
        memcpy(camera->target, values, sizeof camera->target);
        camera->has_target = true;
    } else if (strcmp(key->name, "orbit") == 0) {
        camera->azimuth = values[0];
        camera->elevation = values[1];
        camera->has_orbit = true;
        camera->has_distance = count == 3;
        camera->distance = count == 3 ? values[2] : 0.0;
        if (!(fabs(values[1]) <= ELEVATION_MAX))
            return fail(error, key->name, "the elevation should be -89deg to 89deg");
        if (count == 3 && !(values[2] > 0.0))
            return fail(error, key->name, "the distance should be above 0");
    } else if (strcmp(key->name, "fov") == 0) {
        camera->field_of_view = values[0];
        camera->has_field_of_view = true;
        if (!(values[0] >= 0.01 && values[0] <= 3.0))
            return fail(error, key->name, "should be 0.6deg to 170deg");
    } else {
        camera->turn = values[0];
        camera->has_turn = true;
        if (!(fabs(values[0]) <= 1000.0))
            return fail(error, key->name, "should be 1000rad at most");
    }
    return TULLE_OK;
}

/* Reads "key=value" and the values that follow it, up to the next "="; *at is then behind them. Bit
 * k of *is_given stands for key k. */
static tulle_status read_camera_key(char **at, unsigned *is_given, scene_camera *camera,
                                    tulle_error *error) {
    char *const equals = strchr(*at, '=');
    char *const comma = strchr(*at, ',');
    if (!equals || (comma && comma < equals))
        return fail(error, *at,
                    "should be KEY=VALUE, with keys position, target, orbit, fov, turn");
    *equals = '\0';
    const camera_key *key = NULL;
    for (int i = 0; i < CAMERA_KEY_COUNT; i++)
        if (strcmp(camera_keys[i].name, *at) == 0) key = &camera_keys[i];
    if (!key) return fail(error, *at, "should be one of position, target, orbit, fov, turn");
    if (*is_given & 1u << (key - camera_keys)) return fail(error, *at, "is given twice");
    *is_given |= 1u << (key - camera_keys);
    char *value = equals + 1;
    char wrong[160];
    int const length = snprintf(wrong, sizeof wrong, "should be written as %s", key->example);
    if (key->units[0] == UNIT_LENGTH || key->units[2] == UNIT_LENGTH)
        snprintf(wrong + length, sizeof wrong - (size_t)length, "; lengths are at most %g m",
                 LENGTH_MAX);
    double values[3] = {0.0, 0.0, 0.0};
    int count = 0;
    *at = value + strlen(value); /* nothing follows, unless found below */
    for (char *next = value; next && count <= key->most_count; value = next) {
        next = strchr(value, ',');
        char *const next_equals = strchr(value, '=');
        if (next_equals && (!next || next_equals < next)) {
            *at = value;
            break;
        }
        if (next) *next++ = '\0';
        if (count == key->most_count || !read_value(value, key->units[count], &values[count]))
            return fail(error, key->name, wrong);
        count++;
    }
    if (count < key->least_count) return fail(error, key->name, wrong);
    return set_camera(key, values, count, camera, error);
}

tulle_status picture_read_camera(const char *text, scene_camera *camera, tulle_error *error) {
    char copy[CAMERA_TEXT_MAX + 1];
    size_t const length = strlen(text);
    if (length == 0 || length > CAMERA_TEXT_MAX)
        return fail(error, text, "should be KEY=VALUE, as orbit=30deg,20deg");
    memcpy(copy, text, length + 1);
    scene_camera read = *camera;
    read.has_position = read.has_orbit = false;
    unsigned is_given = 0;
    for (char *at = copy; *at;) {
        tulle_status const status = read_camera_key(&at, &is_given, &read, error);
        if (status != TULLE_OK) return status;
    }
    if (text[length - 1] == ',') return fail(error, text, "ends in a comma");
    if (read.has_position && read.has_orbit)
        return fail(error, text, "has a position and an orbit; give one of them");
    *camera = read;
    return TULLE_OK;
}

/* ---- the camera ---- */

scene_camera picture_camera_merge(const scene_camera *first, const scene_camera *second) {
    scene_camera merged = *first;
    bool const has_place = first->has_position || first->has_orbit;
    if (!has_place) {
        merged.has_position = second->has_position;
        merged.has_orbit = second->has_orbit;
        merged.has_distance = second->has_distance;
        merged.distance = second->distance;
        merged.azimuth = second->azimuth;
        merged.elevation = second->elevation;
        memcpy(merged.position, second->position, sizeof merged.position);
    }
    if (!first->has_target && second->has_target) {
        merged.has_target = true;
        memcpy(merged.target, second->target, sizeof merged.target);
    }
    if (!first->has_field_of_view && second->has_field_of_view) {
        merged.has_field_of_view = true;
        merged.field_of_view = second->field_of_view;
    }
    if (!first->has_turn && second->has_turn) {
        merged.has_turn = true;
        merged.turn = second->turn;
    }
    return merged;
}

/* The nearest camera that looks along a direction and sees all points. Let `right` and `up` be the
 * picture's axes and s the slope of an edge of the view. A camera c holds a point p within that
 * edge where c_right + s c_back >= p_right + s p_back; the other three edges follow by symmetry. */
static void fit_points(const picture_view *view, double azimuth, double elevation, double aspect,
                       double slope, render_camera *camera) {
    double const back[3] = {cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth),
                            sin(elevation)};
    double const up[3] = {-sin(elevation) * cos(azimuth), -sin(elevation) * sin(azimuth),
                          cos(elevation)};
    double const right[3] = {-sin(azimuth), cos(azimuth), 0.0};
    double const slopes[2] = {slope * aspect / FIT_MARGIN, slope / FIT_MARGIN};
    double most[2][2], deepest = (double)INFINITY; /* of each axis: towards it and away */
    for (int i = 0; i < 4; i++) most[i / 2][i % 2] = -(double)INFINITY;
    for (size_t i = 0; i < PICTURE_VIEW_POINTS; i++) {
        const double *const point = view->points + 3 * i;
        double const depth = dot(point, back);
        double const across[2] = {dot(point, right), dot(point, up)};
        deepest = fmin(deepest, depth);
        for (int axis = 0; axis < 2; axis++) {
            most[axis][0] = fmax(most[axis][0], across[axis] + slopes[axis] * depth);
            most[axis][1] = fmax(most[axis][1], -across[axis] + slopes[axis] * depth);
        }
    }
    double const place[2] = {0.5 * (most[0][0] - most[0][1]), 0.5 * (most[1][0] - most[1][1])};
    double const distance = fmax((most[0][0] + most[0][1]) / (2.0 * slopes[0]),
                                 (most[1][0] + most[1][1]) / (2.0 * slopes[1]));
    double const away = fmax(distance - deepest, 1e-3); /* [m] all points may be one */
    for (int k = 0; k < 3; k++) {
        double const across = place[0] * right[k] + place[1] * up[k];
        camera->position[k] = across + (deepest + away) * back[k];
        camera->target[k] = across + deepest * back[k];
        camera->up[k] = up[k];
    }
}

/* A camera in a direction from its target: from a middle that stays where it turns or where a
 * target is given, else as near as all can be seen. */
static void place_orbit(const scene_camera *asked, double turn, const picture_view *view,
                        double aspect, render_camera *camera) {
    const double *const low = view->bounds.low, *const high = view->bounds.high;
    double const begin = asked->has_orbit ? asked->azimuth : PICTURE_AZIMUTH;
    double const elevation = asked->has_orbit ? asked->elevation : PICTURE_ELEVATION;
    double const azimuth = begin + turn;
    render_camera const first = render_camera_frame(low, high, begin, elevation, aspect);
    *camera = render_camera_frame(low, high, azimuth, elevation, aspect);
    double const slope_before = tan(0.5 * camera->field_of_view);
    if (asked->has_field_of_view) camera->field_of_view = asked->field_of_view;
    double const slope = tan(0.5 * camera->field_of_view);
    if (!asked->has_target && !asked->has_distance && !asked->has_turn) {
        fit_points(view, azimuth, elevation, aspect, slope, camera);
        return;
    }
    double away[3]; /* one distance for the whole turn: that of its beginning */
    for (int k = 0; k < 3; k++) away[k] = first.position[k] - first.target[k];
    double const distance =
        asked->has_distance ? asked->distance : sqrt(dot(away, away)) * slope_before / slope;
    if (asked->has_target) memcpy(camera->target, asked->target, sizeof camera->target);
    double const back[3] = {cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth),
                            sin(elevation)};
    for (int k = 0; k < 3; k++) camera->position[k] = camera->target[k] + distance * back[k];
}

/* The given position, turned about the vertical through the target. */
static void place_position(const scene_camera *asked, double turn, const picture_bounds *view,
                           render_camera *camera) {
    for (int k = 0; k < 3; k++)
        camera->target[k] =
            asked->has_target ? asked->target[k] : 0.5 * (view->low[k] + view->high[k]);
    double const x = asked->position[0] - camera->target[0];
    double const y = asked->position[1] - camera->target[1];
    camera->position[0] = camera->target[0] + cos(turn) * x - sin(turn) * y;
    camera->position[1] = camera->target[1] + sin(turn) * x + cos(turn) * y;
    camera->position[2] = asked->position[2];
    camera->field_of_view =
        asked->has_field_of_view
            ? asked->field_of_view
            : render_camera_frame(view->low, view->high, 0.0, 0.0, 1.0).field_of_view;
    /* Looking straight up or down, y is up in the picture. */
    double const height = camera->position[2] - camera->target[2];
    bool const is_vertical = hypot(x, y) < 1e-6 * fabs(height);
    camera->up[0] = is_vertical ? -sin(turn) : 0.0;
    camera->up[1] = is_vertical ? cos(turn) : 0.0;
    camera->up[2] = is_vertical ? 0.0 : 1.0;
}

tulle_status picture_make_camera(const scene_camera *asked, const picture_view *view, double aspect,
                                 double share, render_camera *camera, tulle_error *error) {
    static const double somewhere[6] = {-0.5, -0.5, -0.5, 0.5, 0.5, 0.5};
    picture_view seen = *view;
    if (picture_bounds_is_empty(&seen.bounds)) picture_view_add(&seen, somewhere, 2);
    double const turn = asked->has_turn ? share * asked->turn : 0.0;
    if (asked->has_position)
        place_position(asked, turn, &seen.bounds, camera);
    else
        place_orbit(asked, turn, &seen, aspect, camera);
    double distance2 = 0.0;
    for (int k = 0; k < 3; k++) {
        double const step = camera->position[k] - camera->target[k];
        distance2 += step * step;
    }
    if (!(distance2 > DISTANCE_LEAST * DISTANCE_LEAST))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the camera stands at (%g, %g, %g), in its target; move one of them, as "
                         "with --camera orbit=30deg,20deg",
                         camera->position[0], camera->position[1], camera->position[2]);
    return TULLE_OK;
}
