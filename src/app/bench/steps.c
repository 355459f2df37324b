/* app/bench/steps.c - the timed steps and nothing else, in a file of its own so that the call stays
 * a call: callgrind counts the instructions within it (bench/bench.py names it). */
#include "app/bench/bench.h"

tulle_status bench_make_steps(tulle_world *world, double time_step, uint32_t count,
                              tulle_step_report *reports, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < count && status == TULLE_OK; i++)
        status = tulle_world_step(world, time_step, &reports[i], error);
    return status;
}
