/* base/words.h - the words that scene files, run.json, options and messages have for the values of
 * enums, each list in the order of its enum and with a null at its end. */
#ifndef TULLE_BASE_WORDS_H
#define TULLE_BASE_WORDS_H

extern const char *const method_words[];       /* tulle_detect_method */
extern const char *const cone_words[];         /* tulle_detect_cone */
extern const char *const switch_words[];       /* 0: off, 1: on */
extern const char *const patches_words[];      /* grows_patches_anew of tulle_world_detection */
extern const char *const response_words[];     /* tulle_response */
extern const char *const motion_space_words[]; /* tulle_motion_space */
extern const char *const start_words[];        /* tulle_start_intersections */
extern const char *const pinch_words[];        /* tulle_on_pinch */
extern const char *const integrator_words[];   /* tulle_integrator */
extern const char *const shape_words[];        /* tulle_shape */

#endif
