/* base/status_text.c - the words of statuses. */
#include "tulle/base.h"

const char *tulle_status_text(tulle_status status) {
    switch (status) {
    case TULLE_OK: return "no error";
    case TULLE_ERROR_INVALID_ARGUMENT: return "invalid argument";
    case TULLE_ERROR_OUT_OF_MEMORY: return "out of memory";
    case TULLE_ERROR_IO: return "file error";
    case TULLE_ERROR_DISK_FULL: return "disk full";
    case TULLE_ERROR_PARSE: return "malformed file";
    case TULLE_ERROR_INVALID_MESH: return "unusable mesh";
    case TULLE_ERROR_INTERSECTING_START: return "intersecting start";
    case TULLE_ERROR_PINCHED: return "cloth pinched between obstacles";
    case TULLE_ERROR_STEP_FAILED: return "step failed";
    case TULLE_ERROR_LIMIT: return "limit exceeded";
    case TULLE_ERROR_INTERRUPTED: return "interrupted";
    case TULLE_ERROR_UNSUPPORTED: return "unsupported";
    case TULLE_STATUS_COUNT: break;
    }
    return "unknown status";
}
