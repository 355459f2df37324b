/* app/run/lags.c - which obstacles lag behind their frames at a frame of the run, by how much and
 * where; and, apart from the judgement of the run, where cloth crosses them as they are drawn. */
#include "app/run/session.h"
#include "base/error.h"
#include "tulle/check.h"
#include "tulle/query.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Counts pairs of cloth with an obstacle as it is drawn. */
static tulle_status count_crossings(const run_session *session, size_t body, const double *drawn,
                                    uint64_t *count, tulle_error *error) {
    size_t const cloth_count = session->built.cloth_count;
    tulle_check_body *const bodies = calloc(cloth_count + 1, sizeof *bodies);
    if (!bodies)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory to judge drawn surfaces");
    for (size_t i = 0; i <= cloth_count; i++) {
        size_t const source = i < cloth_count ? i : body;
        bodies[i].mesh = session->bodies[source].mesh;
        bodies[i].mesh.positions = i < cloth_count ? session->positions[i] : drawn;
        bodies[i].is_obstacle = i == cloth_count;
    }
    tulle_check_result result = {0};
    tulle_status const status = tulle_check_intersections(bodies, cloth_count + 1,
                                                          session->options.threads, &result, error);
    *count = 0;
    for (size_t i = 0; i < result.pair_count; i++) *count += result.pairs[i].body_b == cloth_count;
    tulle_check_result_destroy(&result);
    free(bodies);
    return status;
}

static tulle_status measure_lag(const run_session *session, size_t obstacle, double *drawn,
                                tulle_run_lag *lag, tulle_error *error) {
    const tulle_scene_world *const built = &session->built;
    size_t const body = built->cloth_count + obstacle;
    size_t const vertex_count = session->bodies[body].mesh.vertex_count;
    tulle_target const target = {drawn, 3 * vertex_count * sizeof *drawn, 0, TULLE_NUMBER_DOUBLE};
    tulle_status const status = tulle_object_copy_values(
        built->world, tulle_object_from_obstacle(built->obstacles[obstacle]),
        TULLE_VALUES_DRAWN_POSITIONS, &target, error);
    if (status != TULLE_OK) return status;
    const double *const lagging = session->positions[body];
    *lag = (tulle_run_lag){.body = (uint32_t)body};
    double largest2 = 0.0;
    for (size_t v = 0; v < vertex_count; v++) {
        double size2 = 0.0;
        for (size_t k = 3 * v; k < 3 * v + 3; k++)
            size2 += (lagging[k] - drawn[k]) * (lagging[k] - drawn[k]);
        if (!(size2 > largest2)) continue;
        largest2 = size2;
        lag->vertex = (uint32_t)v;
    }
    lag->lag = sqrt(largest2);
    if (!(largest2 > 0.0) || !session->is_present[body]) return TULLE_OK;
    return count_crossings(session, body, drawn, &lag->drawn_crossings, error);
}

tulle_status run_measure_lags(run_session *session, tulle_error *error) {
    size_t most = 0;
    session->lag_count = 0;
    for (size_t i = session->built.cloth_count; i < session->body_count; i++)
        if (session->bodies[i].mesh.vertex_count > most)
            most = session->bodies[i].mesh.vertex_count;
    double *const drawn = malloc((3 * most + 1) * sizeof *drawn);
    if (!drawn)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory to judge drawn surfaces");
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < session->built.obstacle_count && status == TULLE_OK; i++) {
        tulle_run_lag *const lag = &session->lags[session->lag_count];
        if (session->bodies[session->built.cloth_count + i].is_static) continue;
        status = measure_lag(session, i, drawn, lag, error);
        session->lag_count += status == TULLE_OK && lag->lag > 0.0;
    }
    free(drawn);
    return status;
}
