/* base/text.h - looking words up: the nearest known word to a mistyped one; texts of strangers that
 * are to be shown; characters of names. */
#ifndef TULLE_BASE_TEXT_H
#define TULLE_BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>

/* Number of edits (insert, delete, replace, swap of neighbours) that turn a into b. Words longer
 * than 63 bytes are compared by their first 63. */
size_t text_edit_distance(const char *a, const char *b);

/* The candidate nearest to word, or null when none is near enough to be what was meant (at most a
 * third of the word's length, and at least one, edits away). Ties go to the first. */
const char *text_find_nearest(const char *word, const char *const *candidates,
                              size_t candidate_count);

/* Puts '?' for the bytes of each control character: those of ASCII, and those that UTF-8 writes as
 * 0xC2 and 0x80 to 0x9F. What is shown so moves no cursor and ends no line. */
void text_hide_controls(char *text);

/* The character of UTF-8 that begins at `text`, which does not end there; *length: of its bytes. */
unsigned text_take_character(const char *text, size_t *length);

/* Drops what a cut left of a last character of UTF-8. */
void text_drop_cut_character(char *text);

/* Whether names may have a character: letters and digits of any script, '-', '_', '.' and ' '. Not
 * signs of ASCII, blanks and line breaks of Unicode, and marks that only turn the direction. */
bool text_is_of_name(unsigned character);

#endif
