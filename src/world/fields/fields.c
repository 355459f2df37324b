/* world/fields/fields.c - see fields.h. */
#include "world/fields/fields.h"

#include "base/error.h"
#include "base/hash.h"

#include <stdio.h>
#include <string.h>

size_t field_size(const field *row) {
    static const size_t sizes[] = {[FIELD_DOUBLE] = sizeof(double),
                                   [FIELD_INT] = sizeof(int),
                                   [FIELD_ENUM] = sizeof(int),
                                   [FIELD_U8] = 1,
                                   [FIELD_U32] = sizeof(uint32_t),
                                   [FIELD_U64] = sizeof(uint64_t),
                                   [FIELD_SIZE] = sizeof(size_t),
                                   [FIELD_LENGTH] = sizeof(size_t),
                                   [FIELD_HOST] = 0};
    return row->kind == FIELD_STRUCT ? row->inner->size : sizes[row->kind];
}

void fields_set_defaults(const field_table *table, void *def) {
    memset(def, 0, table->size);
    if (table->cookie) memcpy(def, &table->cookie, sizeof table->cookie);
    for (size_t r = 0; r < table->row_count; r++) {
        const field *const row = &table->rows[r];
        char *const at = (char *)def + row->offset;
        if (row->kind == FIELD_STRUCT && !row->is_array && !row->is_pointer)
            fields_set_defaults(row->inner, at);
        for (size_t k = 0; k < row->count && k < 4; k++) {
            double const value = row->fallback[k];
            if (value == 0.0) continue;
            switch (row->kind) {
            case FIELD_DOUBLE: ((double *)(void *)at)[k] = value; break;
            case FIELD_U64: ((uint64_t *)(void *)at)[k] = (uint64_t)value; break;
            case FIELD_SIZE: ((size_t *)(void *)at)[k] = (size_t)value; break;
            default: ((uint32_t *)(void *)at)[k] = (uint32_t)value;
            }
        }
    }
}

/* ---- ranges ---- */

/* Number k of a row. The sign of an enum counts, whatever its type. */
static double get_number(const field *row, const void *at, size_t k) {
    switch (row->kind) {
    case FIELD_DOUBLE: return ((const double *)at)[k];
    case FIELD_U8: return ((const unsigned char *)at)[k];
    case FIELD_U32: return ((const uint32_t *)at)[k];
    case FIELD_U64: return (double)((const uint64_t *)at)[k];
    case FIELD_SIZE:
    case FIELD_LENGTH: return (double)((const size_t *)at)[k];
    default: return ((const int *)at)[k];
    }
}

/* A def within a def: what it is called there. */
typedef struct field_check {
    const char *owner, *without;
    char path[96]; /* as "pins[2].motion." */
    tulle_error *error;
} field_check;

static tulle_status refuse(const field_check *check, const field *row, size_t k, double value) {
    char place[40] = "";
    if (row->is_array)
        snprintf(place, sizeof place, " of %s %zu", row->item, k / row->count);
    else if (row->count > 1)
        snprintf(place, sizeof place, "[%zu]", k);
    return error_set(check->error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: %s%s%s is %g%s%s; it must be %s", check->owner, check->path, row->name,
                     place, value, row->unit ? " " : "", row->unit ? row->unit : "", row->range);
}

static tulle_status check_def(const field_check *check, const field_table *table, const void *def);

/* The items of a row: structs. */
static tulle_status check_structs(const field_check *check, const field *row, const char *items,
                                  size_t count) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        field_check inner = *check;
        char place[24] = "";
        if (row->is_array) snprintf(place, sizeof place, "[%zu]", i);
        snprintf(inner.path, sizeof inner.path, "%.32s%.32s%s.", check->path, row->name, place);
        status = check_def(&inner, row->inner, items + i * row->inner->size);
    }
    return status;
}

static tulle_status check_def(const field_check *check, const field_table *table, const void *def) {
    for (size_t r = 0; r < table->row_count; r++) {
        const field *const row = &table->rows[r];
        const void *at = (const char *)def + row->offset;
        size_t count = 1;
        const char *const without = check->without;
        if (without && strcmp(row->group ? row->group : row->name, without) == 0) continue;
        if (row->is_array) {
            memcpy(&count, (const char *)def + row->length, sizeof count);
            memcpy(&at, at, sizeof at);
            if (!at && count > 0 && row->kind == FIELD_STRUCT)
                return error_set(check->error, TULLE_ERROR_INVALID_ARGUMENT,
                                 "%s: %s%s has %zu items, but the array is null", check->owner,
                                 check->path, row->name, count);
        } else if (row->is_pointer) {
            memcpy(&at, at, sizeof at);
        }
        if (!at || (row->kind != FIELD_STRUCT && !row->range)) continue;
        if (row->kind == FIELD_STRUCT) {
            tulle_status const status = check_structs(check, row, at, count);
            if (status != TULLE_OK) return status;
            continue;
        }
        for (size_t k = 0; k < count * row->count; k++) {
            double const value = get_number(row, at, k);
            if ((value >= row->least && value <= row->most) || (row->takes_zero && value == 0.0))
                continue;
            return refuse(check, row, k, value);
        }
    }
    return TULLE_OK;
}

tulle_status fields_check(const field_table *table, const void *def, const char *owner,
                          const char *without, tulle_error *error) {
    field_check const check = {.owner = owner, .without = without, .error = error};
    return check_def(&check, table, def);
}

uint64_t fields_hash(const field_table *table, const void *def, const char *without,
                     uint64_t hash) {
    for (size_t r = 0; r < table->row_count; r++) {
        const field *const row = &table->rows[r];
        const void *const place = (const char *)def + row->offset;
        const char *at = place;
        size_t count = 1;
        char word[64];
        snprintf(word, sizeof word, " %s ", row->name);
        bool const is_free = without && strstr(without, word);
        if (is_free || (row->group && strcmp(row->group, "the host's") == 0)) continue;
        if (row->is_array) {
            memcpy(&count, (const char *)def + row->length, sizeof count);
            memcpy(&at, place, sizeof at);
        } else if (row->is_pointer) {
            memcpy(&at, place, sizeof at);
        }
        if (!at) count = 0;
        hash = hash_bytes(hash, &count, sizeof count);
        for (size_t i = 0; row->kind == FIELD_STRUCT && i < count; i++)
            hash = fields_hash(row->inner, at + i * row->inner->size, without, hash);
        if (row->kind < FIELD_STRUCT && count > 0)
            hash = hash_bytes(hash, at, count * row->count * field_size(row));
    }
    return hash;
}
