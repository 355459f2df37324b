/* scene/units.c - numbers with units. The table below is all that is known about units. */
#include "scene/units.h"

#include "io/text/number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct unit {
    unit_dimension dimension;
    const char *name;
    double factor; /* to SI */
} unit;

#define DEGREE 0.017453292519943295 /* [rad] */
#define TURN 6.283185307179586      /* [rad] */
#define INCH 0.0254                 /* [m] exactly */
#define FOOT 0.3048                 /* [m] exactly */
#define OUNCE 0.028349523125        /* [kg] exactly */
#define GRAM_FORCE 9.80665e-3       /* [N] exactly */

/* The SI unit of each dimension comes first. */
static const unit units[] = {
    {UNIT_NONE, "%", 0.01},
    {UNIT_LENGTH, "m", 1.0},
    {UNIT_LENGTH, "km", 1e3},
    {UNIT_LENGTH, "cm", 1e-2},
    {UNIT_LENGTH, "mm", 1e-3},
    {UNIT_LENGTH, "um", 1e-6},
    {UNIT_LENGTH, "in", INCH},
    {UNIT_LENGTH, "ft", FOOT},
    {UNIT_TIME, "s", 1.0},
    {UNIT_TIME, "ms", 1e-3},
    {UNIT_TIME, "min", 60.0},
    {UNIT_ANGLE, "rad", 1.0},
    {UNIT_ANGLE, "deg", DEGREE},
    {UNIT_ANGLE, "turn", TURN},
    {UNIT_VELOCITY, "m/s", 1.0},
    {UNIT_VELOCITY, "cm/s", 1e-2},
    {UNIT_VELOCITY, "mm/s", 1e-3},
    {UNIT_VELOCITY, "km/h", 1.0 / 3.6},
    {UNIT_VELOCITY, "in/s", INCH},
    {UNIT_VELOCITY, "ft/s", FOOT},
    {UNIT_ACCELERATION, "m/s^2", 1.0},
    {UNIT_ACCELERATION, "cm/s^2", 1e-2},
    {UNIT_ACCELERATION, "ft/s^2", FOOT},
    {UNIT_AREA_DENSITY, "kg/m^2", 1.0},
    {UNIT_AREA_DENSITY, "g/m^2", 1e-3},
    {UNIT_AREA_DENSITY, "gsm", 1e-3},
    {UNIT_AREA_DENSITY, "mg/cm^2", 1e-2},
    {UNIT_AREA_DENSITY, "oz/yd^2", OUNCE / (9.0 * FOOT * FOOT)},
    {UNIT_STIFFNESS, "N/m", 1.0},
    {UNIT_STIFFNESS, "kN/m", 1e3},
    {UNIT_STIFFNESS, "N/mm", 1e3},
    {UNIT_STIFFNESS, "N/cm", 1e2},
    {UNIT_STIFFNESS, "gf/cm", GRAM_FORCE / 1e-2},
    {UNIT_STIFFNESS, "gf/cm/deg", GRAM_FORCE / 1e-2 / DEGREE},
    {UNIT_BENDING, "N m", 1.0},
    {UNIT_BENDING, "mN m", 1e-3},
    {UNIT_BENDING, "uN m", 1e-6},
    {UNIT_BENDING, "N mm", 1e-3},
    {UNIT_BENDING, "gf cm^2/cm", GRAM_FORCE * 1e-2},
    {UNIT_LINE_FORCE, "N/m", 1.0},
    {UNIT_LINE_FORCE, "N/cm", 1e2},
    {UNIT_LINE_FORCE, "gf/cm", GRAM_FORCE / 1e-2},
    {UNIT_LINE_MOMENT, "N", 1.0},
    {UNIT_LINE_MOMENT, "mN", 1e-3},
    {UNIT_LINE_MOMENT, "gf cm/cm", GRAM_FORCE},
    {UNIT_RATE, "1/s", 1.0},
    {UNIT_RATE, "1/min", 1.0 / 60.0},
    {UNIT_DRAG, "kg/m^3", 1.0},
    {UNIT_MASS, "kg", 1.0},
    {UNIT_MASS, "g", 1e-3},
    {UNIT_MASS, "t", 1e3},
    {UNIT_DENSITY, "kg/m^3", 1.0},
    {UNIT_DENSITY, "g/cm^3", 1e3},
    {UNIT_SPIN, "rad/s", 1.0},
    {UNIT_SPIN, "deg/s", DEGREE},
    {UNIT_SPIN, "turn/s", TURN},
    {UNIT_FORCE, "N", 1.0},
    {UNIT_FORCE, "mN", 1e-3},
    {UNIT_FORCE, "kN", 1e3},
    {UNIT_FORCE, "gf", GRAM_FORCE},
    {UNIT_SPRING, "N/m", 1.0},
    {UNIT_SPRING, "N/cm", 1e2},
    {UNIT_SPRING, "N/mm", 1e3},
};
enum { unit_count = sizeof units / sizeof units[0] };

const char *unit_si_name(unit_dimension dimension) {
    if (dimension == UNIT_NONE) return "";
    for (size_t i = 0; i < unit_count; i++)
        if (units[i].dimension == dimension) return units[i].name;
    return "";
}

void unit_list_names(unit_dimension dimension, char *names, size_t capacity) {
    size_t used = 0;
    names[0] = '\0';
    for (size_t i = 0; i < unit_count; i++) {
        if (units[i].dimension != dimension) continue;
        int added =
            snprintf(names + used, capacity - used, "%s%s", used > 0 ? ", " : "", units[i].name);
        if (added < 0 || (size_t)added >= capacity - used) return;
        used += (size_t)added;
    }
}

static const char *skip_digits(const char *text) {
    while (*text >= '0' && *text <= '9') text++;
    return text;
}

/* The end of the decimal number that `text` begins with; null when it begins with none. */
static const char *scan_number(const char *text) {
    if (*text == '+' || *text == '-') text++;
    const char *digits = text;
    text = skip_digits(text);
    size_t digit_count = (size_t)(text - digits);
    if (*text == '.') {
        const char *fraction = ++text;
        text = skip_digits(text);
        digit_count += (size_t)(text - fraction);
    }
    if (digit_count == 0) return NULL;
    if (*text == 'e' || *text == 'E') {
        const char *exponent = text + 1;
        if (*exponent == '+' || *exponent == '-') exponent++;
        if (skip_digits(exponent) != exponent) text = skip_digits(exponent);
    }
    return text;
}

/* Text compared without regard to capitals. */
static bool equals_folded(const char *text, const char *lower) {
    for (; *text && *lower; text++, lower++) {
        char c = *text >= 'A' && *text <= 'Z' ? (char)(*text - 'A' + 'a') : *text;
        if (c != *lower) return false;
    }
    return *text == *lower;
}

static bool is_spelled_not_finite(const char *text) {
    static const char *const words[] = {".nan", "nan", ".inf", "inf", "infinity"};
    if (*text == '+' || *text == '-') text++;
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        if (equals_folded(text, words[i])) return true;
    return false;
}

quantity_state quantity_read(const char *text, unit_dimension dimension, double *value) {
    if (is_spelled_not_finite(text)) return QUANTITY_NOT_FINITE;
    const char *end = scan_number(text);
    if (!end) return QUANTITY_NOT_A_NUMBER;
    double number = 0.0;
    if (number_parse_double(text, (size_t)(end - text), &number) != NUMBER_READ)
        return QUANTITY_NOT_FINITE;
    if (*end == '/' && skip_digits(end + 1) != end + 1) {
        const char *divisor = end + 1;
        end = scan_number(divisor);
        if (!end) return QUANTITY_NOT_A_NUMBER;
        double by = 0.0;
        if (number_parse_double(divisor, (size_t)(end - divisor), &by) != NUMBER_READ)
            return QUANTITY_NOT_FINITE;
        number /= by;
    }
    if (*end && *end != ' ' && *end != '%' && !((*end | 0x20) >= 'a' && (*end | 0x20) <= 'z'))
        return QUANTITY_NOT_A_NUMBER;
    while (*end == ' ') end++;
    double factor = 1.0;
    if (*end) {
        size_t i = 0;
        while (i < unit_count &&
               (units[i].dimension != dimension || strcmp(units[i].name, end) != 0))
            i++;
        if (i == unit_count) return QUANTITY_UNKNOWN_UNIT;
        factor = units[i].factor;
    }
    *value = number * factor;
    return isfinite(*value) ? QUANTITY_READ : QUANTITY_NOT_FINITE;
}

bool integer_read(const char *text, unsigned long long *value) {
    const unsigned long long largest = 1ULL << 53; /* exact as a double, too */
    if (!*text) return false;
    *value = 0;
    for (; *text; text++) {
        if (*text < '0' || *text > '9') return false;
        *value = *value * 10 + (unsigned long long)(*text - '0');
        if (*value > largest) return false;
    }
    return true;
}
