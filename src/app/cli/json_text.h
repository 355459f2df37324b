/* app/cli/json_text.h - texts and numbers as JSON has them, on a stream. */
#ifndef TULLE_APP_CLI_JSON_TEXT_H
#define TULLE_APP_CLI_JSON_TEXT_H

#include <stdio.h>

/* In quotes, escaped. Bytes that are no UTF-8 become U+FFFD, so that the document can be read. */
void json_print_text(FILE *stream, const char *text);
/* With the fewest digits that read back to the same double; null for what is not finite. */
void json_print_double(FILE *stream, double value);

#endif
