/* io/text/json_write.c - see json_write.h. Based on: RFC 8259. */
#include "io/text/json_write.h"

#include "io/text/json_quote.h"

#include <math.h>
#include <stdio.h>

json_writer json_writer_make(output_file *output) { return (json_writer){.output = output}; }

static void start_line(json_writer *writer) {
    output_text(writer->output, "\n");
    for (int i = 0; i < writer->depth; i++) output_text(writer->output, "  ");
}

static void write_quoted(output_file *output, const char *text) {
    char piece[JSON_PIECE_SIZE];
    output_text(output, "\"");
    while (json_take_piece(&text, piece) > 0) output_text(output, piece);
    output_text(output, "\"");
}

/* Comma, new line and key of the next item. */
static void start_item(json_writer *writer, const char *key) {
    if (writer->has_items) output_text(writer->output, ",");
    if (writer->depth > 0) start_line(writer);
    writer->has_items = true;
    if (!key) return;
    write_quoted(writer->output, key);
    output_text(writer->output, ": ");
}

void json_begin(json_writer *writer, const char *key, char bracket) {
    start_item(writer, key);
    output_write(writer->output, &bracket, 1);
    writer->depth++;
    writer->has_items = false;
}

void json_end(json_writer *writer, char bracket) {
    writer->depth--;
    if (writer->has_items) start_line(writer);
    output_write(writer->output, &bracket, 1);
    writer->has_items = true;
    if (writer->depth == 0) output_text(writer->output, "\n");
}

void json_put_string(json_writer *writer, const char *key, const char *text) {
    start_item(writer, key);
    if (text)
        write_quoted(writer->output, text);
    else
        output_text(writer->output, "null");
}

void json_put_double(json_writer *writer, const char *key, double value) {
    start_item(writer, key);
    if (isfinite(value))
        output_double(writer->output, value);
    else
        output_text(writer->output, "null");
}

void json_put_unsigned(json_writer *writer, const char *key, uint64_t value) {
    start_item(writer, key);
    output_unsigned(writer->output, value);
}

void json_put_bool(json_writer *writer, const char *key, bool value) {
    start_item(writer, key);
    output_text(writer->output, value ? "true" : "false");
}

void json_put_hash(json_writer *writer, const char *key, uint64_t value) {
    char text[20];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)value);
    json_put_string(writer, key, text);
}

void json_put_fields(json_writer *writer, const json_field *fields, size_t count,
                     const void *source) {
    for (size_t i = 0; i < count; i++) {
        const char *const key = fields[i].key;
        const void *const at = (const char *)source + fields[i].offset;
        switch (fields[i].kind) {
        case JSON_DOUBLE: json_put_double(writer, key, *(const double *)at); break;
        case JSON_COUNT: json_put_unsigned(writer, key, *(const uint64_t *)at); break;
        case JSON_WHOLE: json_put_unsigned(writer, key, *(const uint32_t *)at); break;
        case JSON_FLAG: json_put_bool(writer, key, *(const int *)at != 0); break;
        case JSON_HASH: json_put_hash(writer, key, *(const uint64_t *)at); break;
        }
    }
}
