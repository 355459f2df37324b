/* world/defs.h - checks of user definitions; each names the owner, the value and its range. */
#ifndef TULLE_WORLD_DEFS_H
#define TULLE_WORLD_DEFS_H

#include "tulle/world.h"

/* Of the values that a saved state must fit; values that only change the solve are left out. */
uint64_t world_def_hash(const tulle_world_def *def);
tulle_status world_def_check(const tulle_world_def *def, tulle_error *error);
/* Values of a material that do not count with this membrane are not looked at. */
tulle_status material_check(const tulle_material *material, tulle_membrane membrane,
                            const char *owner, tulle_error *error);
tulle_status cloth_def_check(const tulle_cloth_def *def, tulle_membrane membrane, const char *owner,
                             tulle_error *error);
tulle_status obstacle_def_check(const tulle_obstacle_def *def, const char *owner,
                                tulle_error *error);

tulle_status contact_law_check(const tulle_contact_law *law, const char *owner, tulle_error *error);

#endif
