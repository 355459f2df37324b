/* test/support/comma_locale.h - a locale whose decimal mark is a comma, as a host may have set. */
#ifndef TULLE_TEST_SUPPORT_COMMA_LOCALE_H
#define TULLE_TEST_SUPPORT_COMMA_LOCALE_H

#include "support/test_support.h"

#include <locale.h>

/* Sets one of the machine's locales with a decimal comma. Where there is none, says so and skips
 * the test. */
static inline void use_decimal_comma(void) {
    const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8",  "fr_FR.UTF-8", "fr_FR.utf8",
                                 "da_DK.UTF-8", "pt_BR.UTF-8", "ru_RU.UTF-8"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (setlocale(LC_ALL, names[i]) && localeconv()->decimal_point[0] == ',') return;
    setlocale(LC_ALL, "C");
    print_message("skipped: no locale with a decimal comma is installed\n");
    skip();
}

static inline void use_decimal_point(void) { setlocale(LC_ALL, "C"); }

#endif
