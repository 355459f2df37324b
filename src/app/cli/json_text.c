/* app/cli/json_text.c - see json_text.h. */
#include "app/cli/json_text.h"

#include "io/text/json_quote.h"
#include "io/text/number.h"

#include <math.h>

void json_print_text(FILE *stream, const char *text) {
    char piece[JSON_PIECE_SIZE];
    fputc('"', stream);
    while (json_take_piece(&text, piece) > 0) fputs(piece, stream);
    fputc('"', stream);
}

void json_print_double(FILE *stream, double value) {
    char text[NUMBER_TEXT_SIZE] = "null";
    if (isfinite(value)) number_format_double(value, text);
    fputs(text, stream);
}
