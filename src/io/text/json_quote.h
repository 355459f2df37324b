/* io/text/json_quote.h - a text as JSON has it. */
#ifndef TULLE_IO_TEXT_JSON_QUOTE_H
#define TULLE_IO_TEXT_JSON_QUOTE_H

#include <stddef.h>

enum { JSON_PIECE_SIZE = 8 /* [bytes] of a piece with its final zero */ };

/* Takes a character off *text and writes it as it stands between quotes in JSON: escaped where that
 * must be, U+FFFD for a byte that is no UTF-8. Returns its length, 0 at the end of the text. */
size_t json_take_piece(const char **text, char piece[JSON_PIECE_SIZE]);

#endif
