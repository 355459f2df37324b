/* test/support/test_support.h - cmocka with the headers that it needs before it. */
#ifndef TULLE_TEST_SUPPORT_TEST_SUPPORT_H
#define TULLE_TEST_SUPPORT_TEST_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
