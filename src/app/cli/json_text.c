/* app/cli/json_text.c - see json_text.h. Based on: RFC 8259; RFC 3629. */
#include "app/cli/json_text.h"

#include "app/cli/shortest_number.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

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

void json_print_text(const char *text) {
    const unsigned char *bytes = (const unsigned char *)text;
    putchar('"');
    while (*bytes) {
        size_t const length = measure_sequence(bytes);
        if (length == 0)
            fputs("\\ufffd", stdout);
        else if (*bytes == '"' || *bytes == '\\')
            printf("\\%c", *bytes);
        else if (*bytes < 0x20)
            printf("\\u%04x", *bytes);
        else
            fwrite(bytes, 1, length, stdout);
        bytes += length > 0 ? length : 1;
    }
    putchar('"');
}

void json_print_double(double value) {
    char text[SHORTEST_NUMBER_SIZE];
    fputs(isfinite(value) ? shortest_number_format(value, text) : "null", stdout);
}
