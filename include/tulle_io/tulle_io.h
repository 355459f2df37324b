/* tulle_io/tulle_io.h - all public headers of libtulle_io. */
#ifndef TULLE_IO_TULLE_IO_H
#define TULLE_IO_TULLE_IO_H
#include "tulle_io/animation.h"
#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"
#include "tulle_io/run.h"
#include "tulle_io/scene.h"
#include "tulle_io/subdivision.h"
#endif
