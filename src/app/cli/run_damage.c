/* app/cli/run_damage.c - see run_damage.h. */
#include "app/cli/run_damage.h"

#include "app/commands.h"
#include "base/error.h"

tulle_status run_damage_report(const char *command, const char *directory, tulle_run_reader *reader,
                               tulle_error *error) {
    const tulle_run_damage *damages = NULL;
    size_t count = 0;
    tulle_status const status = tulle_run_reader_find_damage(reader, &damages, &count, error);
    if (status != TULLE_OK || count == 0) return status;
    for (size_t i = 0; i < count; i++)
        app_print_message(command, "%s/%s: %s", directory, damages[i].file, damages[i].message);
    return error_set_at(error, TULLE_ERROR_PARSE, directory, 0, 0,
                        "%zu of the run's files %s damaged; tulle run --resume continues from "
                        "before the damage if there is such a checkpoint, and makes meshes again",
                        count, count == 1 ? "is" : "are");
}
