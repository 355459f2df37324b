/* base/text.c - edit distance between words, for "did you mean"; characters of UTF-8.
 *
 * Takes a word and the known words, gives the known word with the fewest edits.
 *
 * Based on: R. Lowrance and R. Wagner, An extension of the string-to-string correction problem,
 * 1975, in the restricted form where no part of a word is edited twice. */
#include "base/text.h"

#include <string.h>

enum { WORD_MAX = 63 }; /* [bytes] longer words are no one's typing error */

static size_t minimum(size_t a, size_t b) { return a < b ? a : b; }

static size_t clipped_length(const char *word) {
    size_t length = 0;
    while (length < WORD_MAX && word[length]) length++;
    return length;
}

size_t text_edit_distance(const char *a, const char *b) {
    size_t const length_a = clipped_length(a);
    size_t const length_b = clipped_length(b);
    /* Row i holds the distances from the first i letters of a to every beginning of b. */
    size_t rows[3][WORD_MAX + 1];
    for (size_t j = 0; j <= length_b; j++) rows[0][j] = j;
    for (size_t i = 1; i <= length_a; i++) {
        size_t *const row = rows[i % 3];
        const size_t *const above = rows[(i + 2) % 3];
        const size_t *const two_above = rows[(i + 1) % 3];
        row[0] = i;
        for (size_t j = 1; j <= length_b; j++) {
            size_t const replaced = above[j - 1] + (a[i - 1] != b[j - 1]);
            row[j] = minimum(replaced, minimum(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = minimum(row[j], two_above[j - 2] + 1);
        }
    }
    return rows[length_a % 3][length_b];
}

const char *text_find_nearest(const char *word, const char *const *candidates,
                              size_t candidate_count) {
    size_t const length = clipped_length(word);
    size_t best_distance = (length < 3 ? 1 : length / 3) + 1;
    const char *best = NULL;
    for (size_t i = 0; i < candidate_count; i++) {
        size_t const distance = text_edit_distance(word, candidates[i]);
        if (distance < best_distance) {
            best_distance = distance;
            best = candidates[i];
        }
    }
    return best;
}

/* Length of the control character at `text`; 0: it is another. */
static size_t measure_control(const char *text) {
    unsigned char const first = (unsigned char)text[0];
    if (first == 0xc2 && (unsigned char)text[1] >= 0x80 && (unsigned char)text[1] < 0xa0) return 2;
    return first < 0x20 || first == 0x7f ? 1 : 0;
}

void text_hide_controls(char *text) {
    for (; *text; text++) memset(text, '?', measure_control(text));
}

unsigned text_take_character(const char *text, size_t *length) {
    const unsigned char *const byte = (const unsigned char *)text;
    size_t const wanted = byte[0] < 0xc0 ? 1 : byte[0] < 0xe0 ? 2 : byte[0] < 0xf0 ? 3 : 4;
    unsigned character = wanted == 1 ? byte[0] : byte[0] & (0x7fu >> wanted);
    for (*length = 1; *length < wanted && (byte[*length] & 0xc0) == 0x80; ++*length)
        character = character << 6 | (byte[*length] & 0x3fu);
    return character;
}

void text_drop_cut_character(char *text) {
    size_t const end = strlen(text);
    size_t begin = end;
    while (begin > 0 && ((unsigned char)text[begin - 1] & 0xc0) == 0x80) begin--;
    if (begin == 0 || (unsigned char)text[begin - 1] < 0xc0) return;
    unsigned char const first = (unsigned char)text[--begin];
    if (end - begin < (first < 0xe0 ? 2u : first < 0xf0 ? 3u : 4u)) text[begin] = '\0';
}

bool text_is_of_name(unsigned character) {
    static const struct {
        unsigned first, last;
    } refused[] = {{0x7f, 0xa0},     {0x1680, 0x1680}, {0x2000, 0x200b},  {0x200e, 0x200f},
                   {0x2028, 0x202f}, {0x205f, 0x206f}, {0x3000, 0x3000},  {0xd800, 0xdfff},
                   {0xfeff, 0xfeff}, {0xfff0, 0xffff}, {0xe0000, 0xe0fff}};
    if (character < 0x7f)
        return (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') ||
               (character >= '0' && character <= '9') || character == '-' || character == '_' ||
               character == '.' || character == ' ';
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
        if (character >= refused[i].first && character <= refused[i].last) return false;
    return true;
}
