/* What a page may say: each form with all its fields, limits of numbers, what is left out, and that
 * a command which is written is read again to the same. Sessions line by line. The guard of tokens
 * and names. Plots. */
#include "app/view/guard.h"
#include "app/view/message.h"
#include "app/view/series.h"
#include "app/view/session_file.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

static view_request request;
static char reason[REASON_SIZE];

static request_outcome read_text(const char *text) {
    return request_read(text, strlen(text), &request, reason);
}

static void test_commands_come_back(void **state) {
    (void)state;
    static const char *const texts[] = {
        "{\"type\":\"grab\",\"id\":7,\"object\":3,\"triangle\":4294967295,\"weights\":[0.2,0.3,0.5]"
        ","
        "\"point\":[1e-300,-1e6,0.1],\"force\":0.3}",
        "{\"type\":\"drag\",\"grab\":9,\"point\":[0.1,0.2,0.30000000000000004]}",
        "{\"type\":\"let_go\",\"grab\":0}",
        "{\"type\":\"cut_pin\",\"object\":65535,\"vertex\":17}",
        ("{\"type\":\"move\",\"object\":1,\"position\":[1,2,3],\"rotation\":[0.6,0,0.8,0],"
         "\"force\":"
         "4}"),
        "{\"type\":\"set\",\"what\":\"gravity\",\"value\":[0,0,-9.81]}",
        "{\"type\":\"set\",\"what\":\"wind\",\"value\":[1,2,3]}",
        "{\"type\":\"set\",\"what\":\"gusts\",\"value\":0.5}",
        "{\"type\":\"set\",\"what\":\"friction\",\"object\":2,\"value\":0.3}",
        "{\"type\":\"set\",\"what\":\"material\",\"object\":2,\"value\":\"a \\\"b\\\" c\"}"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        view_buffer buffer = {0};
        if (read_text(texts[i]) != REQUEST_READ) fail_msg("%s: %s", texts[i], reason);
        view_request first = request;
        first.has_id = false;
        first.id = 0;
        buffer_print(&buffer, "{");
        request_write(&first, &buffer);
        buffer_print(&buffer, "}");
        buffer_put_u8(&buffer, 0);
        if (read_text((const char *)buffer_get(&buffer)) != REQUEST_READ)
            fail_msg("%s: %s", (const char *)buffer_get(&buffer), reason);
        assert_memory_equal(&first, &request, sizeof request);
        buffer_release(&buffer);
    }
}

static void test_defaults_and_ids(void **state) {
    (void)state;
    assert_int_equal(read_text(" {\"x\":[{}],\"type\":\"run\"} "), REQUEST_READ);
    assert_false(request.has_id);
    assert_true(request.speed == 1.0);
    assert_int_equal(read_text("{\"type\":\"frames\",\"from\":3}"), REQUEST_READ);
    assert_int_equal(request.from, 3);
    assert_int_equal(request.count, 1);
    assert_int_equal(request.stride, 1);
    assert_false(request.is_exact);
    assert_int_equal(
        read_text("{\"type\":\"frames\",\"id\":9007199254740991,\"from\":0,\"exact\":true}"),
        REQUEST_READ);
    assert_true(request.has_id && request.id == 9007199254740991u && request.is_exact);
    assert_int_equal(
        read_text("{\"type\":\"overlays\",\"names\":[\"gaps\",\"contacts\",\"gaps\"]}"),
        REQUEST_READ);
    assert_int_equal(request.overlays, 1 << 0 | 1 << 4);
    assert_int_equal(read_text("{\"type\":\"series\",\"names\":[\"contacts\"]}"), REQUEST_READ);
    assert_true(request.columns == UINT64_C(1) << series_find("contacts"));
    assert_true(request.to_step == 9007199254740991u && request.buckets == 512);
    assert_int_equal(read_text("{\"type\":\"check\",\"text\":\"a\\nb\"}"), REQUEST_READ);
    assert_string_equal(request.text, "a\nb");
    request_release(&request);
    assert_null(request.text);
}

static void test_refusals(void **state) {
    (void)state;
    static const char *const refused[] = {
        "{\"type\":\"what\"}",
        "{\"type\":\"run\",\"id\":-1}",
        "{\"type\":\"run\",\"id\":0.5}",
        "{\"type\":\"run\",\"speed\":-0.1}",
        "{\"type\":\"run\",\"speed\":1e400}",
        "{\"type\":\"run\",\"speed\":\"fast\"}",
        "{\"type\":\"step\",\"count\":0}",
        "{\"type\":\"step\",\"count\":1.5}",
        "{\"type\":\"step\",\"count\":1000001}",
        "{\"type\":\"rewind\",\"step\":9007199254740992}",
        "{\"type\":\"frames\",\"from\":0,\"exact\":1}",
        "{\"type\":\"drag\",\"grab\":1,\"point\":[0,0]}",
        "{\"type\":\"drag\",\"grab\":1,\"point\":[0,0,1e7]}",
        "{\"type\":\"drag\",\"grab\":1,\"point\":[0,0,null]}",
        "{\"type\":\"drag\",\"grab\":4294967296,\"point\":[0,0,0]}",
        "{\"type\":\"move\",\"object\":0,\"position\":[0,0,0],\"rotation\":[1,1,0,0]}",
        "{\"type\":\"grab\",\"object\":0,\"triangle\":0,\"weights\":[1,1,0],\"point\":[0,0,0]}",
        "{\"type\":\"set\",\"what\":\"material\",\"value\":1}",
        "{\"type\":\"set\",\"what\":\"material\",\"value\":\"\\u00e9\"}",
        "{\"type\":\"set\",\"what\":\"gravity\",\"value\":\"down\"}",
        "{\"type\":\"set\",\"what\":\"gravity\",\"value\":[1,2,3,4]}",
        "{\"type\":\"set\",\"what\":\"gusts\",\"value\":-1}",
        "{\"type\":\"series\",\"names\":[\"contact\"]}",
        "{\"type\":\"overlays\",\"names\":{}}",
        "{\"type\":\"check\",\"text\":[]}",
        ("{\"type\":\"example\",\"name\":"
         "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\"}")};
    static const char *const bad[] = {"",
                                      "{",
                                      "[]",
                                      "{}",
                                      "\"type\"",
                                      "{\"type\":3}",
                                      "{\"type\":\"run\"}{}",
                                      "{\"type\":\"run\",\"type\":\"run\"}"};
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        request_outcome const outcome = read_text(refused[i]);
        /* A number too large for a double is no JSON that we read. */
        bool const is_right =
            outcome == REQUEST_REFUSED || (strstr(refused[i], "1e400") && outcome == REQUEST_BAD);
        if (!is_right || !reason[0])
            fail_msg("%s: outcome %d, \"%s\"", refused[i], (int)outcome, reason);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        if (read_text(bad[i]) != REQUEST_BAD || !reason[0]) fail_msg("%s is taken", bad[i]);
    static char text[MESSAGE_TEXT_MAX + 64];
    memset(text, ' ', sizeof text - 1);
    memcpy(text, "{\"type\":\"run\"}", 14);
    assert_int_equal(request_read(text, MESSAGE_SMALL_MAX, &request, reason), REQUEST_READ);
    assert_int_equal(request_read(text, MESSAGE_SMALL_MAX + 1, &request, reason), REQUEST_BAD);
    memcpy(text, "{\"type\":\"check\",\"text\":\"\"}", 26);
    assert_int_equal(request_read(text, MESSAGE_TEXT_MAX, &request, reason), REQUEST_READ);
    request_release(&request);
    assert_int_equal(request_read(text, MESSAGE_TEXT_MAX + 1, &request, reason), REQUEST_BAD);
}

static void test_session_lines(void **state) {
    (void)state;
    session_line line;
    tulle_error error = {0};
    static const char text[] = "{\"at\":5,\"type\":\"let_go\",\"grab\":2}\n"
                               "{\"at\":9,\"type\":\"end\",\"hash\":\"00000000000000ff\"}\n";
    const char *const second = session_file_read_line(text, &line, &error);
    assert_non_null(second);
    assert_true(line.at == 5 && !line.is_end && line.request.type == REQUEST_LET_GO &&
                line.request.grab == 2);
    assert_non_null(session_file_read_line(second, &line, &error));
    assert_true(line.at == 9 && line.is_end && line.hash == 255);
    static const char *const bad[] = {"",
                                      "\n",
                                      "[]\n",
                                      "{\"type\":\"let_go\",\"grab\":2}\n",
                                      "{\"at\":-1,\"type\":\"end\"}\n",
                                      "{\"at\":1,\"type\":\"end\"}\n",
                                      "{\"at\":1,\"type\":\"drag\"}\n",
                                      "{\"at\":1}\n"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        error = (tulle_error){0};
        if (session_file_read_line(bad[i], &line, &error) || !error.message[0])
            fail_msg("%s is taken", bad[i]);
    }
}

static void test_guard(void **state) {
    (void)state;
    view_guard guard = {.token = "0123456789abcdef0123456789abcdef",
                        .names = {"127.0.0.1", "[::1]", "machine"},
                        .name_count = 3,
                        .port = 8080};
    assert_string_equal(guard_match_path(&guard, "/0123456789abcdef0123456789abcdef/"), "");
    assert_string_equal(guard_match_path(&guard, "/0123456789abcdef0123456789abcdef/a/b"), "a/b");
    static const char *const strange[] = {"",
                                          "/",
                                          "//",
                                          "/0123456789abcdef0123456789abcdef",
                                          "/0123456789abcdef0123456789abcdeF/",
                                          "/0123456789abcdef0123456789abcde//",
                                          "x0123456789abcdef0123456789abcdef/",
                                          "/1123456789abcdef0123456789abcdef/app.js"};
    for (size_t i = 0; i < sizeof strange / sizeof strange[0]; i++)
        assert_null(guard_match_path(&guard, strange[i]));
    assert_true(guard_allows_host(&guard, "127.0.0.1:8080") &&
                guard_allows_host(&guard, "[::1]:8080"));
    assert_true(guard_allows_host(&guard, "MACHINE:8080"));
    assert_false(guard_allows_host(&guard, "machine") ||
                 guard_allows_host(&guard, "machine:80801"));
    assert_false(guard_allows_host(&guard, "") || guard_allows_host(&guard, "machine:8080.x"));
    assert_true(guard_allows_origin(&guard, "http://machine:8080"));
    assert_false(guard_allows_origin(&guard, "https://machine:8080") ||
                 guard_allows_origin(&guard, "null"));
    assert_false(guard_allows_origin(&guard, "http://machine:8080/") ||
                 guard_allows_origin(&guard, ""));
    guard.port = 80;
    assert_true(guard_allows_host(&guard, "machine") && guard_allows_host(&guard, "machine:80"));
    char first[GUARD_TOKEN_SIZE];
    assert_true(guard_make_token(&guard));
    memcpy(first, guard.token, sizeof first);
    assert_true(guard_make_token(&guard));
    assert_int_equal(strlen(first), 32);
    assert_int_equal(strspn(first, "0123456789abcdef"), 32);
    assert_string_not_equal(first, guard.token);
}

static void test_series(void **state) {
    (void)state;
    series_table table = {.heap = memory_default()};
    for (uint64_t step = 0; step < 1000; step++) {
        tulle_step_report report = {.step = step,
                                    .contacts = step % 10,
                                    .kinetic_energy = -(double)step,
                                    .smallest_gap = (double)INFINITY};
        series_row const row = series_make_row(&report);
        series_add(&table, &row, true);
    }
    view_buffer buffer = {0};
    series_request asked = {UINT64_C(1) << series_find("contacts") |
                                UINT64_C(1) << series_find("smallest_gap"),
                            101, 200, 5};
    buffer_print(&buffer, "{");
    series_write(&table, asked, &buffer);
    buffer_put_u8(&buffer, 0);
    assert_string_equal(
        (const char *)buffer_get(&buffer),
        "{,\"names\":[\"contacts\",\"smallest_gap\"],\"steps\":[101,121,141,161,181],"
        "\"low\":{\"contacts\":[0,0,0,0,0],\"smallest_gap\":[null,null,null,null,null]},"
        "\"high\":{\"contacts\":[9,9,9,9,9],\"smallest_gap\":[null,null,null,null,null]}");
    buffer_release(&buffer);
    /* A rewind takes back the rows of later steps. */
    tulle_step_report report = {.step = 499};
    series_row const row = series_make_row(&report);
    series_add(&table, &row, true);
    assert_int_equal(table.rows.count, 500);
    /* A long time is thinned out, its beginning and its end stay. */
    for (uint64_t step = 500; step < 300000; step++) {
        report.step = step;
        series_row const next = series_make_row(&report);
        series_add(&table, &next, true);
    }
    assert_in_range(table.rows.count, SERIES_STEP_MAX / 2, SERIES_STEP_MAX);
    assert_int_equal(table.rows.data[0].step, 1);
    assert_int_equal(table.rows.data[table.rows.count - 1].step, 300000);
    for (size_t i = 1; i < table.rows.count; i++)
        assert_true(table.rows.data[i].step > table.rows.data[i - 1].step);
    series_clear(&table);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_commands_come_back),
                                       cmocka_unit_test(test_defaults_and_ids),
                                       cmocka_unit_test(test_refusals),
                                       cmocka_unit_test(test_session_lines),
                                       cmocka_unit_test(test_guard),
                                       cmocka_unit_test(test_series)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
