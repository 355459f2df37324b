/* io/text/json_quote.c - see json_quote.h. Based on: RFC 8259; RFC 3629. */
#include "io/text/json_quote.h"

#include <stdio.h>
#include <string.h>

/* Bytes of the UTF-8 sequence that begins here; 0 when there is none. */
static size_t measure_sequence(const unsigned char *text) {
    /* Lead bytes from `first` on, up to the next row's; the second byte lies in second_low ..
     * second_high, so that neither longer forms than needed nor surrogates pass. */
    static const struct {
        unsigned char first, second_low, second_high, length;
    } rows[] = {{0x00, 0x00, 0x00, 1}, {0x80, 1, 0, 0},       {0xc2, 0x80, 0xbf, 2},
                {0xe0, 0xa0, 0xbf, 3}, {0xe1, 0x80, 0xbf, 3}, {0xed, 0x80, 0x9f, 3},
                {0xee, 0x80, 0xbf, 3}, {0xf0, 0x90, 0xbf, 4}, {0xf1, 0x80, 0xbf, 4},
                {0xf4, 0x80, 0x8f, 4}, {0xf5, 1, 0, 0}};
    size_t row = sizeof rows / sizeof rows[0] - 1;
    while (text[0] < rows[row].first) row--;
    if (rows[row].length < 2) return rows[row].length;
    if (text[1] < rows[row].second_low || text[1] > rows[row].second_high) return 0;
    for (size_t i = 2; i < rows[row].length; i++)
        if ((text[i] & 0xc0) != 0x80) return 0;
    return rows[row].length;
}

size_t json_take_piece(const char **text, char piece[JSON_PIECE_SIZE]) {
    const unsigned char *const bytes = (const unsigned char *)*text;
    if (!*bytes) return 0;
    size_t const length = measure_sequence(bytes);
    *text += length > 0 ? length : 1;
    if (length == 0)
        strcpy(piece, "\\ufffd");
    else if (*bytes == '"' || *bytes == '\\')
        snprintf(piece, JSON_PIECE_SIZE, "\\%c", *bytes);
    else if (*bytes == '\n')
        strcpy(piece, "\\n");
    else if (*bytes < 0x20 || *bytes == 0x7f)
        snprintf(piece, JSON_PIECE_SIZE, "\\u%04x", *bytes);
    else
        snprintf(piece, JSON_PIECE_SIZE, "%.*s", (int)length, (const char *)bytes);
    return strlen(piece);
}
