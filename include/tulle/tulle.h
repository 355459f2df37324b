/* tulle/tulle.h - all public headers of libtulle. */
#ifndef TULLE_TULLE_H
#define TULLE_TULLE_H
#include "tulle/attach.h"
#include "tulle/base.h"
#include "tulle/bodies.h"
#include "tulle/check.h"
#include "tulle/detect.h"
#include "tulle/events.h"
#include "tulle/live.h"
#include "tulle/mesh.h"
#include "tulle/objects.h"
#include "tulle/paper.h"
#include "tulle/query.h"
#include "tulle/record.h"
#include "tulle/shapes.h"
#include "tulle/threads.h"
#include "tulle/world.h"
#endif
