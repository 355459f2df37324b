/* app/cli/shortest_number.c - see shortest_number.h. */
#include "app/cli/shortest_number.h"

#include <stdio.h>
#include <stdlib.h>

const char *shortest_number_format(double value, char text[SHORTEST_NUMBER_SIZE]) {
    static const int digit_counts[] = {6, 15, 16, 17};
    for (int i = 0; i < 4; i++) {
        snprintf(text, SHORTEST_NUMBER_SIZE, "%.*g", digit_counts[i], value);
        double const again = strtod(text, NULL);
        if (again >= value && again <= value) break;
    }
    return text;
}
