/* io/text/number.h - decimal numbers as text, the same in every locale, always correctly rounded.
 *
 * number_parse_double reads  [+-] digits [. digits] [e [+-] digits]  in time linear in its length.
 * number_format_double writes 15, 16 or 17 digits: the fewest that read back to the same double.
 * number_format_float writes 6 to 9, the fewest that read back to the same float. */
#ifndef TULLE_IO_TEXT_NUMBER_H
#define TULLE_IO_TEXT_NUMBER_H

#include <stddef.h>
#include <stdint.h>

typedef enum number_outcome {
    NUMBER_READ,
    NUMBER_MALFORMED,   /* the text is no number, or something follows it */
    NUMBER_OUT_OF_RANGE /* larger than the type can hold; underflow to zero is fine */
} number_outcome;

/* The whole of text[0 .. length-1] must be one number. *value is untouched unless NUMBER_READ. */
number_outcome number_parse_double(const char *text, size_t length, double *value);
number_outcome number_parse_integer(const char *text, size_t length, int64_t *value);

enum { NUMBER_TEXT_SIZE = 40 }; /* [bytes] room for any number and a final zero */
/* Writes value ("nan", "inf" and "-inf" for what is not finite); returns the length. */
size_t number_format_double(double value, char text[NUMBER_TEXT_SIZE]);
size_t number_format_float(float value, char text[NUMBER_TEXT_SIZE]);

#endif
