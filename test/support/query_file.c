/* support/query_file.c - see query_file.h. */
#include "support/query_file.h"

#include <gmp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

const char *find_data_path(const char *probe) {
    const char *const folder = getenv("TULLE_DATA_DIR");
    char path[2048];
    snprintf(path, sizeof path, "%s/%s", folder ? folder : "", probe);
    FILE *const file = folder ? fopen(path, "r") : NULL;
    if (!file) return NULL;
    fclose(file);
    return folder;
}

FILE *open_data(const char *name) {
    char path[2048];
    snprintf(path, sizeof path, "%s/%s", getenv("TULLE_DATA_DIR"), name);
    FILE *const file = fopen(path, "r");
    if (!file) print_error("cannot open %s\n", path);
    assert_non_null(file);
    return file;
}

/* Three rationals, each a double exactly, and what follows them, as a truth value or -1. */
static bool read_row(FILE *file, vec3 *point, int *truth) {
    char line[1024];
    if (!fgets(line, sizeof line, file) || line[0] == '\n') return false;
    double x[3];
    char *cursor = line;
    mpq_t value, back;
    mpq_inits(value, back, NULL);
    for (int k = 0; k < 3; k++) {
        for (int part = 0; part < 2; part++) {
            cursor += strspn(cursor, " ,");
            size_t const length = strcspn(cursor, " ,\n");
            char digits[512];
            assert_true(length > 0 && length < sizeof digits);
            memcpy(digits, cursor, length);
            digits[length] = '\0';
            cursor += length;
            mpz_ptr const to = part == 0 ? mpq_numref(value) : mpq_denref(value);
            assert_int_equal(mpz_set_str(to, digits, 10), 0);
        }
        mpq_canonicalize(value);
        x[k] = mpq_get_d(value);
        mpq_set_d(back, x[k]);
        assert_true(mpq_equal(value, back));
    }
    mpq_clears(value, back, NULL);
    cursor += strspn(cursor, " ,");
    *truth = *cursor == '0' || *cursor == '1' ? *cursor - '0' : -1;
    *point = vec3_make(x[0], x[1], x[2]);
    return true;
}

bool read_query(FILE *file, moving_pair *pair, int *truth) {
    for (int i = 0; i < 8; i++) {
        vec3 *const point = i < 4 ? &pair->start[i] : &pair->end[i - 4];
        if (!read_row(file, point, truth)) {
            assert_int_equal(i, 0);
            return false;
        }
    }
    return true;
}

int read_boolean(FILE *file) {
    for (int c = fgetc(file); c != EOF; c = fgetc(file)) {
        if (c != 't' && c != 'f') continue;
        while (fgetc(file) != 'e') {}
        return c == 't';
    }
    return -1;
}
