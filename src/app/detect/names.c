/* app/detect/names.c - the words of report.h. */
#include "app/detect/report.h"

const char *const detect_kind_names[] = {"vertex_face", "edge_edge", NULL};
const char *const detect_state_names[] = {"hit", "touching_at_start", "unresolved", NULL};
const char *const detect_stage_names[] = {"patches", "trees",  "search", "traversal", "filter",
                                          "impact",  "events", "total",  NULL};
