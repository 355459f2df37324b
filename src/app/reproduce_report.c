/* app/reproduce_report.c - report.html: one page, well-formed as XML, without links out of it, of
 * all that the directory of the results holds. Tables show the text of the CSV files as it is;
 * plots are set in as SVG, stills as data URIs. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/whole_file.h"
#include "app/commands.h"
#include "app/reproduce.h"
#include "base/parallel.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

enum { LINE_SIZE = 1024 };
static const double GIB = 1073741824.0; /* [bytes] */

static const char style[] =
    "body{font:15px/1.5 'DejaVu Sans',Helvetica,sans-serif;color:#222;background:#fff;"
    "max-width:980px;margin:2em auto;padding:0 1em}"
    "h1{font-size:1.7em}h2{font-size:1.3em;margin-top:2.4em;border-top:1px solid #ccc;"
    "padding-top:1em}h3{font-size:1em;margin:1.4em 0 .3em}"
    "table{border-collapse:collapse;font-size:12px;display:block;overflow-x:auto}"
    "th,td{border:1px solid #ddd;padding:2px 7px;text-align:right;white-space:nowrap}"
    "th{background:#f2f2f2;white-space:normal}td:first-child,th:first-child{text-align:left}"
    "tr:nth-child(even) td{background:#fafafa}svg{max-width:100%;height:auto}"
    ".stills{display:flex;flex-wrap:wrap;gap:6px}.stills figure{margin:0;width:32%}"
    ".stills img{width:100%;height:auto}figcaption{font-size:12px;color:#555}"
    ".bad{color:#b00020;font-weight:bold}dt{font-weight:bold}dd{margin:0 0 .6em 1.2em}";

/* Text as HTML has it; what XML cannot hold becomes '?'. */
static void write_escaped(FILE *page, const char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        unsigned char const c = (unsigned char)text[i];
        if (c == '&')
            fputs("&amp;", page);
        else if (c == '<')
            fputs("&lt;", page);
        else if (c == '>')
            fputs("&gt;", page);
        else if (c == '"')
            fputs("&quot;", page);
        else
            fputc(c < ' ' || c > '~' ? '?' : c, page);
    }
}

static void write_text(FILE *page, const char *text) { write_escaped(page, text, strlen(text)); }

/* ---- tables ---- */

/* Cells of one line; columns' names with blanks, so that they can be broken. */
static void write_row(FILE *page, const char *line, bool is_head) {
    fputs("<tr>", page);
    for (;;) {
        size_t const length = strcspn(line, ",\r\n");
        fputs(is_head ? "<th>" : "<td>", page);
        for (size_t i = 0; i < length; i++)
            if (is_head && line[i] == '_')
                fputc(' ', page);
            else
                write_escaped(page, line + i, 1);
        fputs(is_head ? "</th>" : "</td>", page);
        if (line[length] != ',') break;
        line += length + 1;
    }
    fputs("</tr>\n", page);
}

static void write_table(FILE *page, const char *path, const char *file, const char *caption) {
    FILE *const table = fopen(path, "r");
    char line[LINE_SIZE];
    if (!table) return;
    fputs("<h3>", page);
    write_text(page, caption);
    fprintf(page, " (%s)</h3>\n<table id=\"%.*s\">\n", file, (int)strcspn(file, "."), file);
    for (bool is_head = true; fgets(line, sizeof line, table); is_head = false)
        write_row(page, line, is_head);
    fputs("</table>\n", page);
    fclose(table);
}

/* ---- plots ---- */

/* Where the text begins with one of gnuplot's ways to name an element; its length. */
static size_t find_name(const char *text) {
    static const char *const ways[] = {" id='", " id=\"", "href='#", "href=\"#", "url(#"};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++)
        if (strncmp(text, ways[i], strlen(ways[i])) == 0) return strlen(ways[i]);
    return 0;
}

/* A file that is not whole would break the page. */
static void leave_out(reproduce *self, const char *file) {
    app_print_message("reproduce",
                      "%s is not whole and left out of the report; without it, it is "
                      "made again",
                      file);
    self->is_lacking = true;
}

/* The SVG element of a whole file, or null: nothing but blanks is behind its end. */
static const char *find_svg(const char *text) {
    static const char end[] = "</svg>";
    const char *const from = strstr(text, "<svg");
    const char *last = NULL;
    for (const char *at = from; at && (at = strstr(at, end)); at++) last = at;
    const char *const rest = last ? last + sizeof end - 1 : "?";
    return rest[strspn(rest, " \r\n\t")] == '\0' ? from : NULL;
}

/* The SVG element; the names within it get the file's in front, so that those of several plots on
 * one page differ. */
static void write_plot(reproduce *self, FILE *page, const char *path, const reproduce_item *item) {
    char *bytes = NULL;
    size_t count = 0;
    if (whole_file_read(path, &bytes, &count, NULL) != TULLE_OK) return;
    const char *from = find_svg(bytes);
    if (!from) leave_out(self, item->file);
    if (from) {
        fputs("<h3>", page);
        write_text(page, item->caption);
        fprintf(page, " (%s)</h3>\n", item->file);
    }
    while (from && *from) {
        size_t const way = find_name(from);
        if (way > 0)
            fprintf(page, "%.*s%.*s_", (int)way, from, (int)strcspn(item->file, "."), item->file);
        else
            fputc(*from, page);
        from += way > 0 ? way : 1;
    }
    free(bytes);
}

/* ---- stills ---- */

static void write_base64(FILE *page, const unsigned char *bytes, size_t count) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < count; i += 3) {
        size_t const left = count - i;
        unsigned const group = (unsigned)bytes[i] << 16 |
                               (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0) |
                               (left > 2 ? (unsigned)bytes[i + 2] : 0);
        fputc(digits[group >> 18], page);
        fputc(digits[group >> 12 & 63], page);
        fputc(left > 1 ? digits[group >> 6 & 63] : '=', page);
        fputc(left > 2 ? digits[group & 63] : '=', page);
    }
}

static void write_still(reproduce *self, FILE *page, const reproduce_run *run, uint32_t frame) {
    char file[REPRODUCE_PATH_SIZE], path[REPRODUCE_PATH_SIZE], name[REPRODUCE_PATH_SIZE];
    char *bytes = NULL;
    size_t count = 0;
    reproduce_name_still(run, frame, file);
    reproduce_make_path(self, path, "%s", file);
    reproduce_name_run(run, name);
    if (whole_file_read(path, &bytes, &count, NULL) != TULLE_OK) return;
    if (!reproduce_is_whole_picture(bytes, count)) {
        leave_out(self, file);
        free(bytes);
        return;
    }
    fprintf(page, "<figure><img alt=\"%s, frame %u\" src=\"data:image/png;base64,", name,
            (unsigned)frame);
    write_base64(page, (const unsigned char *)bytes, count);
    fprintf(page, "\"/><figcaption>%s, frame %u</figcaption></figure>\n", name, (unsigned)frame);
    free(bytes);
}

static void write_stills(reproduce *self, FILE *page, const reproduce_figure *figure) {
    for (size_t i = 0; i < figure->run_count; i++) {
        uint32_t frames[REPRODUCE_STILLS];
        if (!reproduce_find_stills(self, &figure->runs[i], frames)) continue;
        fputs("<div class=\"stills\">\n", page);
        for (int k = 0; k < REPRODUCE_STILLS; k++)
            write_still(self, page, &figure->runs[i], frames[k]);
        fputs("</div>\n", page);
    }
}

/* ---- the page ---- */

static void write_settings(const reproduce *self, FILE *page) {
    char processor[REPRODUCE_MACHINE_SIZE];
    struct utsname system = {0};
    reproduce_find_processor(processor);
    (void)uname(&system);
    fprintf(page,
            "<h2>Settings and machine</h2>\n<table>\n"
            "<tr><th>Tulle</th><td>%d.%d.%d, build %s, compiler %s</td></tr>\n"
            "<tr><th>sizes</th><td>%s</td></tr>\n<tr><th>threads</th><td>%d</td></tr>\n"
            "<tr><th>processor</th><td>",
            TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR, TULLE_VERSION_PATCH, self->build, __VERSION__,
            self->is_quick ? "--quick: coarse cloth and short runs" : "those of the scene files",
            parallel_resolve_threads(self->threads));
    write_text(page, processor);
    fprintf(page, "; %ld of them, %.1f GiB of memory", sysconf(_SC_NPROCESSORS_ONLN),
            (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE) / GIB);
    fputs("</td></tr>\n<tr><th>system</th><td>", page);
    write_text(page, system.sysname);
    fputc(' ', page);
    write_text(page, system.release);
    fputs("</td></tr>\n<tr><th>the paper's</th><td>one 1.5 GHz Pentium 4, 1 GB, double "
          "precision</td></tr>\n</table>\n",
          page);
}

/* What whoever made the results has to say of them: each line of notes.txt. */
static void write_notes(const reproduce *self, FILE *page) {
    char path[REPRODUCE_PATH_SIZE], line[LINE_SIZE];
    reproduce_make_path(self, path, "notes.txt");
    FILE *const notes = fopen(path, "r");
    while (notes && fgets(line, sizeof line, notes)) {
        fputs("<p>", page);
        write_escaped(page, line, strcspn(line, "\r\n"));
        fputs("</p>\n", page);
    }
    if (notes) fclose(notes);
}

/* Sums of what the judge found in some of the runs. */
typedef struct judged_sums {
    size_t runs;
    unsigned long long frames, bad_frames;
} judged_sums;

static void write_sums(FILE *page, const judged_sums *sums, const char *rules) {
    if (sums->runs == 0) return;
    fprintf(page,
            "<p>%zu runs by %s, %llu frames, each judged with exact arithmetic: <span%s>%llu with "
            "intersections</span>.</p>\n",
            sums->runs, rules, sums->frames, sums->bad_frames > 0 ? " class=\"bad\"" : "",
            sums->bad_frames);
}

/* What the judge found over all runs, and what is missing. */
static void write_verdict(const reproduce *self, FILE *page) {
    const reproduce_run *runs[REPRODUCE_RUNS_MAX];
    size_t const count = reproduce_list_runs(runs);
    judged_sums sums[2] = {{0}};
    for (size_t i = 0; i < count; i++) {
        reproduce_verdict verdict;
        if (!reproduce_read_verdict(self, runs[i], &verdict)) continue;
        judged_sums *const of = &sums[runs[i]->method && strcmp(runs[i]->method, "paper") == 0];
        of->runs++;
        of->frames += verdict.frame_count;
        of->bad_frames += verdict.bad_frame_count;
    }
    write_sums(page, &sums[0], "rules that miss nothing");
    write_sums(page, &sums[1], "the paper's rules, which skip patches without proof");
    for (size_t i = 0; i < count; i++) {
        bool const is_repeated = i > 0 && strcmp(runs[i]->scene, runs[i - 1]->scene) == 0;
        if (is_repeated || reproduce_has_scene(self, runs[i])) continue;
        fprintf(page, "<p class=\"bad\">The scene %s.yaml was missing.</p>\n", runs[i]->scene);
    }
}

static bool ends_with(const char *text, const char *end) {
    size_t const length = strlen(text), wanted = strlen(end);
    return length >= wanted && strcmp(text + length - wanted, end) == 0;
}

/* Whether anything of the figure was made. */
static bool is_made(const reproduce *self, const reproduce_figure *figure) {
    char path[REPRODUCE_PATH_SIZE];
    struct stat facts;
    reproduce_make_path(self, path, "%s", figure->items[0].file ? figure->items[0].file : "");
    if (figure->items[0].file) return stat(path, &facts) == 0;
    for (size_t i = 0; i < figure->run_count; i++)
        if (reproduce_has_run(self, &figure->runs[i])) return true;
    return false;
}

static void write_figure(reproduce *self, FILE *page, const reproduce_figure *figure) {
    if (!is_made(self, figure)) return;
    fprintf(page,
            "<section id=\"section_%s\">\n<h2>%s</h2>\n<dl>\n<dt>The paper</dt><dd>%s</dd>\n"
            "<dt>Here</dt><dd>%s</dd>\n<dt>What differs, and why</dt><dd>%s</dd>\n</dl>\n",
            figure->name, figure->title, figure->paper, figure->ours, figure->differences);
    for (int i = 0; i < REPRODUCE_ITEMS_MAX && figure->items[i].file; i++) {
        const reproduce_item *const item = &figure->items[i];
        char path[REPRODUCE_PATH_SIZE];
        reproduce_make_path(self, path, "%s", item->file);
        if (ends_with(item->file, ".svg"))
            write_plot(self, page, path, item);
        else
            write_table(page, path, item->file, item->caption);
    }
    if (figure->has_stills) write_stills(self, page, figure);
    fputs("</section>\n", page);
}

int reproduce_write_report(reproduce *self) {
    reproduce_table page;
    char path[REPRODUCE_PATH_SIZE];
    if (!reproduce_table_begin(&page)) return APP_EXIT_OUT_OF_MEMORY;
    fprintf(
        page.stream,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"/>"
        "<title>The paper again</title>\n<style>%s</style></head>\n<body>\n"
        "<h1>Dynamic Interaction between Deformable Surfaces and Nonsmooth Objects, again</h1>\n"
        "<p>The experiments of Wong and Baciu, IEEE Transactions on Visualization and Computer "
        "Graphics 11(3), 2005, made again with Tulle.</p>\n",
        style);
    write_verdict(self, page.stream);
    write_notes(self, page.stream);
    write_settings(self, page.stream);
    reproduce_make_path(self, path, "conditions.csv");
    write_table(page.stream, path, "conditions.csv", "Conditions that things were measured under");
    reproduce_make_path(self, path, "runs.csv");
    write_table(page.stream, path, "runs.csv", "Runs");
    for (size_t i = 0; i < reproduce_figure_count; i++)
        write_figure(self, page.stream, &reproduce_figures[i]);
    fputs("</body>\n</html>\n", page.stream);
    return reproduce_table_end(self, &page, "report.html");
}
