/* io/text/json_write.h - writes JSON text, indented, into an output file. Keys are null inside
 * arrays.
 */
#ifndef TULLE_IO_TEXT_JSON_WRITE_H
#define TULLE_IO_TEXT_JSON_WRITE_H

#include "io/output_file.h"
#include "io/text/json_read.h"

#include <stdbool.h>

typedef struct json_writer {
    output_file *output;
    int depth;
    bool has_items; /* of the object or array at hand */
} json_writer;

json_writer json_writer_make(output_file *output);
/* bracket: '{' or '['. */
void json_begin(json_writer *writer, const char *key, char bracket);
/* bracket: '}' or ']'; ends the text with a line end at depth 0. */
void json_end(json_writer *writer, char bracket);
/* UTF-8 goes through as it is, what is none becomes U+FFFD; null text is written as null. */
void json_put_string(json_writer *writer, const char *key, const char *text);
/* What is not finite is written as null. */
void json_put_double(json_writer *writer, const char *key, double value);
void json_put_unsigned(json_writer *writer, const char *key, uint64_t value);
void json_put_bool(json_writer *writer, const char *key, bool value);
/* As a string of 16 hexadecimal digits: readers with doubles keep it whole. */
void json_put_hash(json_writer *writer, const char *key, uint64_t value);
/* As json_take_fields reads them. */
void json_put_fields(json_writer *writer, const json_field *fields, size_t count,
                     const void *source);

#endif
