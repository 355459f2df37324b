/* app/convert/judge.h - whether a body intersects once it is subdivided: itself, and, if it is a
 * cloth of a run, the run's obstacles that are there at that frame. */
#ifndef TULLE_APP_CONVERT_JUDGE_H
#define TULLE_APP_CONVERT_JUDGE_H

#include "app/check/subdivided_check.h"
#include "app/convert/source.h"

typedef struct convert_judge {
    convert_source *source;
    tulle_check_body *bodies, *simulated; /* the body, then the obstacles of the frame */
    const char **names;
    double **positions;      /* of each body of the run that moves, or null */
    tulle_mesh_view *meshes; /* of each body of the run */
    size_t run_body_count;   /* 0: nothing is judged but the body itself */
    size_t capacity;         /* of bodies, simulated, names */
    subdivided_totals totals;
} convert_judge;

/* Prepares for the frames of a source, which must outlive the judge. Release with
 * convert_judge_close, also after a failure. */
tulle_status convert_judge_open(convert_source *source, convert_judge *judge, tulle_error *error);
void convert_judge_close(convert_judge *judge);

/* Judges a frame; the body before and after subdivision, in the source's coordinates. A frame that
 * intersects is no error; its sentence is printed to standard error by the caller from `verdict`.
 */
tulle_status convert_judge_frame(convert_judge *judge, uint32_t frame, tulle_mesh_view simulated,
                                 tulle_mesh_view subdivided, subdivided_verdict *verdict,
                                 tulle_error *error);

#endif
