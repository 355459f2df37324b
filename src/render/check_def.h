/* render/check_def.h - refuses what cannot be drawn. */
#ifndef TULLE_RENDER_CHECK_DEF_H
#define TULLE_RENDER_CHECK_DEF_H

#include "render/render.h"

/* TULLE_ERROR_INVALID_ARGUMENT or TULLE_ERROR_LIMIT with a message that says what is wrong. */
tulle_status render_check_def(const render_frame_def *def, tulle_error *error);

#endif
