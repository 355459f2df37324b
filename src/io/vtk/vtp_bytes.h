/* io/vtk/vtp_bytes.h - the bytes of a binary array of a VTK XML file, wherever they stand: inline
 * or appended, as base64 or raw, compressed by zlib or not. */
#ifndef TULLE_IO_VTK_VTP_BYTES_H
#define TULLE_IO_VTK_VTP_BYTES_H

#include "io/vtk/vtp_document.h"

/* Times the size of the file that zlib data may expand to: meshes shrink by 2 to 50, and nothing is
 * to fill the memory from a small file. */
#define VTP_EXPANSION_LIMIT 128u

/* Gives the byte_count bytes of the array, which must be as many as the file says, in its byte
 * order. Release them with memory_release. Errors as vtp_decode_doubles. */
tulle_status vtp_read_bytes(vtp_document *document, const vtp_array *array, const char *name,
                            uint64_t byte_count, unsigned char **bytes, tulle_error *error);
/* A number of 1, 2, 4 or 8 bytes in the file's byte order. */
uint64_t vtp_load_number(const vtp_document *document, const unsigned char *bytes, size_t size);

/* An error that names the array and its line. */
tulle_status vtp_fail(const vtp_document *document, const vtp_array *array, const char *name,
                      tulle_error *error, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
tulle_status vtp_fail_memory(const vtp_document *document, const vtp_array *array, const char *name,
                             tulle_error *error);

#endif
