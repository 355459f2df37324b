/* Measures of `tulle bench`: medians, CSV there and back and damaged, and the comparison, which
 * must flag what is worse and nothing else. */
#define _DEFAULT_SOURCE /* mkdtemp */
#include "app/bench/bench.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[] = "/tmp/tulle-bench-XXXXXX";

static const char *name_file(const char *name) {
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* ---- rows to judge ---- */

static void put(bench_rows *rows, bench_row row) {
    if (row.kind != BENCH_ABOUT) {
        strcpy(row.scene, "sphere");
        strcpy(row.size, "2k");
        row.threads = 1;
    }
    assert_true(bench_rows_put(rows, &row));
}

static void put_time(bench_rows *rows, const char *name, double median) {
    bench_row row = {
        .kind = BENCH_TIME, .value = median, .minimum = 0.99 * median, .spread = 0.01 * median};
    snprintf(row.name, sizeof row.name, "%s", name);
    put(rows, row);
}

static bench_rows make_rows(void) {
    bench_rows rows = {0};
    put(&rows, (bench_row){.kind = BENCH_ABOUT, .name = "processor", .text = "one"});
    put(&rows, (bench_row){.kind = BENCH_ABOUT, .name = "compiler", .text = "gcc"});
    put(&rows, (bench_row){.kind = BENCH_HASH, .name = "start", .text = "0123456789abcdef"});
    put(&rows, (bench_row){.kind = BENCH_HASH, .name = "end", .text = "fedcba9876543210"});
    put_time(&rows, "step", 0.0101);
    put_time(&rows, "processor", 0.01);
    put_time(&rows, "solve_motion", 0.006);
    put_time(&rows, "accept_state", 1e-5);
    put(&rows, (bench_row){.kind = BENCH_COUNT, .name = "contacts", .value = 123456789012.0});
    put(&rows, (bench_row){.kind = BENCH_MEMORY, .name = "most_bytes", .value = 1e6});
    put(&rows, (bench_row){.kind = BENCH_MEMORY, .name = "allocator_calls", .value = 0.0});
    put(&rows, (bench_row){.kind = BENCH_INSTRUCTIONS, .name = "steps", .value = 1e8});
    return rows;
}

static bench_row *find(bench_rows *rows, bench_kind kind, const char *name) {
    for (size_t i = 0; i < rows->count; i++)
        if (rows->items[i].kind == kind && strcmp(rows->items[i].name, name) == 0)
            return &rows->items[i];
    fail();
    abort();
}

/* What the comparison of `now` with the rows above says, and its verdict. */
static bench_verdict compare(const bench_rows *now, char text[4096]) {
    bench_rows baseline = make_rows();
    FILE *const stream = fmemopen(text, 4096, "w");
    assert_non_null(stream);
    bench_verdict const verdict = bench_compare(&baseline, now, stream);
    fclose(stream);
    bench_rows_destroy(&baseline);
    return verdict;
}

static void scale(bench_row *row, double factor) {
    row->value *= factor;
    row->minimum *= factor;
    row->spread *= factor;
}

/* ---- tests ---- */

static void samples_are_summarized(void **unused) {
    (void)unused;
    double odd[] = {5.0, 1.0, 3.0, 100.0, 2.0}, even[] = {4.0, 1.0, 2.0, 8.0}, one[] = {7.0};
    bench_row row = {0};
    bench_row_summarize(&row, odd, 5);
    assert_true(row.value == 3.0 && row.minimum == 1.0 && row.spread == 2.0);
    bench_row_summarize(&row, even, 4);
    assert_true(row.value == 3.0 && row.minimum == 1.0 && row.spread == 1.5);
    bench_row_summarize(&row, one, 1);
    assert_true(row.value == 7.0 && row.minimum == 7.0 && row.spread == 0.0);
}

static void a_row_replaces_its_like(void **unused) {
    (void)unused;
    bench_rows rows = make_rows();
    size_t const count = rows.count;
    put_time(&rows, "step", 0.5);
    assert_int_equal(rows.count, count);
    assert_true(find(&rows, BENCH_TIME, "step")->value == 0.5);
    bench_rows_destroy(&rows);
}

static void csv_comes_back(void **unused) {
    (void)unused;
    bench_rows rows = make_rows(), read = {0};
    tulle_error error = {0};
    const char *const path = name_file("rows.csv");
    assert_int_equal(bench_csv_write(path, &rows, &error), TULLE_OK);
    assert_int_equal(bench_csv_read(path, &read, &error), TULLE_OK);
    assert_int_equal(read.count, rows.count);
    for (size_t i = 0; i < rows.count; i++) {
        const bench_row *const a = &rows.items[i], *const b = &read.items[i];
        assert_string_equal(a->text, b->text);
        assert_true(bench_rows_find(&read, a) == b);
        assert_true(b->value > 0.999999 * a->value - 1e-300);
        assert_true(b->value < 1.000001 * a->value + 1e-300);
        assert_true(b->minimum < 1.000001 * a->minimum + 1e-300);
        if (a->kind == BENCH_COUNT) assert_true(a->value == b->value);
    }
    bench_rows_destroy(&rows);
    bench_rows_destroy(&read);
}

static void damaged_csv_is_refused(void **unused) {
    (void)unused;
#define HEAD "scene,size,threads,kind,name,value,minimum,spread\n"
    static const struct {
        const char *text, *message;
        int line;
    } cases[] = {
        {"", "cut off", 1},
        {"a,b\n1,2\n", "no table", 1},
        {HEAD "sphere,2k,1,count,contacts,12,,\nsphere,2k,1,count", "cut off", 3},
        {HEAD "sphere,2k,1,count,contacts,12,\n", "fewer", 2},
        {HEAD "sphere,2k,1,count,contacts,12,,,\n", "more", 2},
        {HEAD "sphere,2k,x,count,contacts,12,,\n", "\"threads\"", 2},
        {HEAD "sphere,2k,1,thyme,contacts,12,,\n", "\"kind\"", 2},
        {HEAD "sphere,2k,1,count,,12,,\n", "\"name\"", 2},
        {HEAD "sphere,2k,1,count,contacts,twelve,,\n", "\"value\"", 2},
        {HEAD "sphere,2k,1,count,contacts,nan,,\n", "\"value\"", 2},
        {HEAD "sphere,2k,1,time,step,1,1,\n", "\"minimum\" and \"spread\"", 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *const path = name_file("damaged.csv");
        FILE *const file = fopen(path, "w");
        assert_non_null(file);
        fputs(cases[i].text, file);
        fclose(file);
        bench_rows rows = {0};
        tulle_error error = {0};
        assert_int_equal(bench_csv_read(path, &rows, &error), TULLE_ERROR_PARSE);
        assert_non_null(strstr(error.message, cases[i].message));
        assert_int_equal(error.line, cases[i].line);
        bench_rows_destroy(&rows);
    }
    bench_rows rows = {0};
    tulle_error error = {0};
    assert_int_equal(bench_csv_read(name_file("missing.csv"), &rows, &error), TULLE_ERROR_IO);
}

static void equal_rows_are_not_flagged(void **unused) {
    (void)unused;
    char text[4096] = "";
    bench_rows now = make_rows();
    bench_verdict const verdict = compare(&now, text);
    assert_int_equal(verdict.worse, 0);
    assert_int_equal(verdict.compared, 8); /* all but those about, the start and a tiny stage */
    assert_non_null(strstr(text, "0 slower, 0 changed"));
    bench_rows_destroy(&now);
}

/* One row changed by a factor, and whether that is worse. */
static void worse_rows_are_flagged(void **unused) {
    (void)unused;
    static const struct {
        bench_kind kind;
        const char *name;
        double factor;
        size_t worse;
        const char *said;
    } cases[] = {
        {BENCH_TIME, "solve_motion", 1.02, 0, "0 slower"},
        {BENCH_TIME, "solve_motion", 1.06, 1,
         "slower:  sphere 2k, 1 thread, solve_motion: 6.36 ms, was 6 ms, 1.060 times"},
        {BENCH_TIME, "solve_motion", 0.9, 0, "faster:  sphere 2k, 1 thread, solve_motion"},
        {BENCH_TIME, "accept_state", 3.0, 0, "0 slower"}, /* a thousandth of the step */
        {BENCH_TIME, "accept_state", 100.0, 1, "slower:  sphere 2k, 1 thread, accept_state"},
        {BENCH_COUNT, "contacts", 1.0 + 1e-9, 1, "changed: sphere 2k, 1 thread, contacts"},
        {BENCH_COUNT, "contacts", 0.5, 1, "changed: sphere 2k, 1 thread, contacts"},
        {BENCH_MEMORY, "most_bytes", 1.04, 0, "0 more"},
        {BENCH_MEMORY, "most_bytes", 1.06, 1, "more:    sphere 2k, 1 thread, most_bytes"},
        {BENCH_INSTRUCTIONS, "steps", 1.004, 0, "0 more"},
        {BENCH_INSTRUCTIONS, "steps", 1.006, 1, "more:    sphere 2k, 1 thread, steps"},
        {BENCH_INSTRUCTIONS, "steps", 0.9, 0, "less:    sphere 2k, 1 thread, steps"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[4096] = "";
        bench_rows now = make_rows();
        scale(find(&now, cases[i].kind, cases[i].name), cases[i].factor);
        bench_verdict const verdict = compare(&now, text);
        if (verdict.worse != cases[i].worse || !strstr(text, cases[i].said))
            fail_msg("case %zu: %zu worse; %s", i, verdict.worse, text);
        bench_rows_destroy(&now);
    }
}

static void other_results_are_flagged(void **unused) {
    (void)unused;
    char text[4096] = "";
    bench_rows now = make_rows();
    find(&now, BENCH_HASH, "end")->text[0] = '0';
    find(&now, BENCH_MEMORY, "allocator_calls")->value = 1.0;
    assert_int_equal(compare(&now, text).worse, 2);
    assert_non_null(strstr(text, "end in another state"));
    assert_non_null(strstr(text, "allocator_calls: 1, was 0"));
    bench_rows_destroy(&now);
}

/* What was measured under other conditions is not judged, and that is said. */
static void other_conditions_are_told(void **unused) {
    (void)unused;
    char text[4096] = "";
    bench_rows now = make_rows();
    scale(find(&now, BENCH_TIME, "solve_motion"), 2.0);
    scale(find(&now, BENCH_INSTRUCTIONS, "steps"), 2.0);
    strcpy(find(&now, BENCH_ABOUT, "processor")->text, "two");
    strcpy(find(&now, BENCH_ABOUT, "compiler")->text, "clang");
    assert_int_equal(compare(&now, text).worse, 0);
    assert_non_null(strstr(text, "another processor"));
    assert_non_null(strstr(text, "another compiler"));
    bench_rows_destroy(&now);

    now = make_rows();
    find(&now, BENCH_HASH, "start")->text[0] = 'f';
    find(&now, BENCH_COUNT, "contacts")->value = 1.0;
    assert_int_equal(compare(&now, text).worse, 0);
    assert_non_null(strstr(text, "starts from another state"));
    bench_rows_destroy(&now);

    now = make_rows();
    scale(find(&now, BENCH_TIME, "step"), 3.0);
    scale(find(&now, BENCH_TIME, "solve_motion"), 3.0);
    assert_int_equal(compare(&now, text).worse, 0);
    assert_non_null(strstr(text, "other work ran beside"));
    scale(find(&now, BENCH_TIME, "processor"), 1.2);
    assert_int_equal(compare(&now, text).worse, 0);
    scale(find(&now, BENCH_TIME, "processor"), 1.1);
    assert_int_equal(compare(&now, text).worse, 1);
    bench_rows_destroy(&now);
}

static int make_folder(void **unused) {
    (void)unused;
    return mkdtemp(folder) ? 0 : 1;
}

static int remove_folder(void **unused) {
    (void)unused;
    unlink(name_file("rows.csv"));
    unlink(name_file("damaged.csv"));
    return rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_summarized),
        cmocka_unit_test(a_row_replaces_its_like),
        cmocka_unit_test(csv_comes_back),
        cmocka_unit_test(damaged_csv_is_refused),
        cmocka_unit_test(equal_rows_are_not_flagged),
        cmocka_unit_test(worse_rows_are_flagged),
        cmocka_unit_test(other_results_are_flagged),
        cmocka_unit_test(other_conditions_are_told),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
