/* tulle/tulle.h - all public headers. */
#ifndef TULLE_TULLE_H
#define TULLE_TULLE_H
#include "tulle/base.h"
#include "tulle/check.h"
#include "tulle/detect.h"
#include "tulle/io.h"
#include "tulle/mesh.h"
#include "tulle/run.h"
#include "tulle/shapes.h"
#include "tulle/world.h"
#endif
