/* app/detect/report.h - what `tulle detect` prints to standard output, as text or as one JSON
 * document; docs/guide/detect.md tells both. */
#ifndef TULLE_APP_DETECT_REPORT_H
#define TULLE_APP_DETECT_REPORT_H

#include "app/detect/passes.h"

typedef struct detect_report {
    const char *start_path, *end_path;
    uint64_t crossing_count; /* pairs of triangles that intersect at the start */
    bool has_list;
} detect_report;

void detect_report_text(const detect_report *report, const detect_passes *passes);
void detect_report_json(const detect_report *report, const detect_passes *passes);

/* The words that options, text and JSON have for the values, ending with a null. */
extern const char *const detect_kind_names[];  /* by tulle_detect_kind */
extern const char *const detect_state_names[]; /* by tulle_detect_state */
extern const char *const detect_stage_names[]; /* by detect_stage */

/* After how many events of a list to look whether standard output still takes them. */
enum { DETECT_LIST_STRIDE = 4096 };

#endif
