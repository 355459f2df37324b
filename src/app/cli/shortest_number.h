/* app/cli/shortest_number.h - a double in the fewest digits that read back to it. */
#ifndef TULLE_APP_CLI_SHORTEST_NUMBER_H
#define TULLE_APP_CLI_SHORTEST_NUMBER_H

enum { SHORTEST_NUMBER_SIZE = 32 };

/* Writes and returns text: 0.1, 1e-05, 0.30000000000000004. */
const char *shortest_number_format(double value, char text[SHORTEST_NUMBER_SIZE]);

#endif
