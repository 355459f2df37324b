/* io/vtk/vtp_values.h - decodes the values of an array of a VTK XML file: text, base64 or raw
 * bytes, compressed by zlib or not, in either byte order. */
#ifndef TULLE_IO_VTK_VTP_VALUES_H
#define TULLE_IO_VTK_VTP_VALUES_H

#include "io/vtk/vtp_document.h"

/* Decodes exactly `count` values as doubles, which must be finite. `name` is for messages. What the
 * file says of its sizes is checked against what is there before memory is taken. Errors:
 * TULLE_ERROR_PARSE, TULLE_ERROR_LIMIT (zlib data that expand too much, see
 * vtp_bytes.h), TULLE_ERROR_OUT_OF_MEMORY. Release the values with memory_release, count * 8 bytes.
 */
tulle_status vtp_decode_doubles(vtp_document *document, const vtp_array *array, const char *name,
                                uint64_t count, double **values, tulle_error *error);
/* The same for whole numbers, each 0 .. INT64_MAX. */
tulle_status vtp_decode_indices(vtp_document *document, const vtp_array *array, const char *name,
                                uint64_t count, uint64_t **values, tulle_error *error);

#endif
