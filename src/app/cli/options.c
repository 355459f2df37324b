/* app/cli/options.c - reads the options of a subcommand by its table and prints its help.
 *
 * In: a table of options and the words of the command line. Out: the options' values and the
 * operands, or one message that names the word at fault and what would be right. */
#include "app/cli/options.h"

#include "app/commands.h"
#include "base/text.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SUGGESTION_MAX = 64, /* names among which a mistyped one is looked up */
    HELP_COLUMN = 28     /* column where the help of an option begins */
};

/* The words that are still to be read. */
typedef struct word_cursor {
    const command_spec *command;
    char **words;
    int next, count;
} word_cursor;

static bool set_integer(const command_spec *command, const option_spec *option, const char *text) {
    char *end = NULL;
    errno = 0;
    long const number = strtol(text, &end, 10);
    if (errno || end == text || *end || number < option->minimum || number > option->maximum) {
        app_print_message(command->name, "--%s: \"%s\" should be a whole number from %ld to %ld",
                          option->name, text, option->minimum, option->maximum);
        return false;
    }
    *(long *)option->value = number;
    return true;
}

static bool set_choice(const command_spec *command, const option_spec *option, const char *text) {
    for (const char *const *choice = option->choices; *choice; choice++) {
        if (strcmp(*choice, text) == 0) {
            *(const char **)option->value = *choice;
            return true;
        }
    }
    char names[256] = "";
    for (const char *const *choice = option->choices; *choice; choice++) {
        size_t const used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", *choice);
    }
    app_print_message(command->name, "--%s: \"%s\" should be one of: %s", option->name, text,
                      names);
    return false;
}

static bool append_to_list(const command_spec *command, const option_spec *option,
                           const char *text) {
    option_list *const list = option->value;
    if (list->count == OPTION_LIST_MAX) {
        app_print_message(command->name, "--%s is given more than %d times", option->name,
                          OPTION_LIST_MAX);
        return false;
    }
    list->items[list->count++] = text;
    return true;
}

static bool set_value(const command_spec *command, const option_spec *option, const char *text) {
    switch (option->kind) {
    case OPTION_FLAG: *(int *)option->value = 1; return true;
    case OPTION_TEXT: *(const char **)option->value = text; return true;
    case OPTION_CHOICE: return set_choice(command, option, text);
    case OPTION_INTEGER: return set_integer(command, option, text);
    case OPTION_LIST: return append_to_list(command, option, text);
    }
    return false;
}

/* Reads the value of an option: the rest of its own word, or the next word. */
static bool read_value(word_cursor *cursor, const option_spec *option, const char *attached) {
    if (option->kind == OPTION_FLAG) {
        if (!attached) return set_value(cursor->command, option, NULL);
        app_print_message(cursor->command->name, "--%s takes no value, but \"%s\" was given",
                          option->name, attached);
        return false;
    }
    if (attached) return set_value(cursor->command, option, attached);
    if (cursor->next < cursor->count)
        return set_value(cursor->command, option, cursor->words[cursor->next++]);
    app_print_message(cursor->command->name, "--%s needs a value: --%s %s", option->name,
                      option->name, option->argument);
    return false;
}

static bool refuse_long(const command_spec *command, const char *name) {
    const char *names[SUGGESTION_MAX];
    size_t count = 0;
    names[count++] = "help";
    for (size_t i = 0; i < command->option_count && count < SUGGESTION_MAX; i++)
        names[count++] = command->options[i].name;
    const char *const nearest = text_find_nearest(name, names, count);
    if (nearest)
        app_print_message(command->name, "unknown option --%s; did you mean --%s?", name, nearest);
    else
        app_print_message(command->name, "unknown option --%s; `tulle %s --help` lists the options",
                          name, command->name);
    return false;
}

static bool read_long(word_cursor *cursor, char *word) {
    char *const equals = strchr(word, '=');
    if (equals) *equals = '\0';
    const command_spec *const command = cursor->command;
    for (size_t i = 0; i < command->option_count; i++) {
        if (strcmp(command->options[i].name, word) == 0)
            return read_value(cursor, &command->options[i], equals ? equals + 1 : NULL);
    }
    return refuse_long(command, word);
}

static bool read_short(word_cursor *cursor, const char *word) {
    const command_spec *const command = cursor->command;
    for (size_t i = 0; i < command->option_count; i++) {
        if (command->options[i].letter && command->options[i].letter == word[0])
            return read_value(cursor, &command->options[i], word[1] ? word + 1 : NULL);
    }
    app_print_message(command->name, "unknown option -%s; `tulle %s --help` lists the options",
                      word, command->name);
    return false;
}

static bool check_operand_count(const command_spec *command, size_t count, const char *last) {
    if (count < command->operand_minimum) {
        app_print_message(command->name, "%s is missing; usage: tulle %s %s", command->operands,
                          command->name, command->operands);
        return false;
    }
    if (count > command->operand_maximum) {
        app_print_message(command->name, "\"%s\" is one too many; usage: tulle %s %s", last,
                          command->name, command->operands);
        return false;
    }
    return true;
}

static bool is_help(const char *word) {
    return strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0;
}

options_outcome options_parse(const command_spec *command, int argc, char **argv,
                              size_t *operand_count) {
    word_cursor cursor = {.command = command, .words = argv, .next = 1, .count = argc};
    bool options_ended = false;
    *operand_count = 0;
    while (cursor.next < cursor.count) {
        char *const word = argv[cursor.next++];
        if (options_ended || word[0] != '-' || word[1] == '\0') {
            argv[(*operand_count)++] = word;
        } else if (strcmp(word, "--") == 0) {
            options_ended = true;
        } else if (is_help(word)) {
            options_print_help(command);
            return OPTIONS_HELP;
        } else if (!(word[1] == '-' ? read_long(&cursor, word + 2)
                                    : read_short(&cursor, word + 1))) {
            return OPTIONS_REFUSED;
        }
    }
    const char *const last = *operand_count ? argv[*operand_count - 1] : "";
    return check_operand_count(command, *operand_count, last) ? OPTIONS_READ : OPTIONS_REFUSED;
}

int options_exit(options_outcome outcome) {
    return outcome == OPTIONS_REFUSED ? APP_EXIT_BAD_INPUT : app_finish_output("help");
}

static void print_option(const option_spec *option) {
    int width = option->letter ? printf("  -%c, ", option->letter) : printf("      ");
    width += printf("--%s%s%s", option->name, option->argument ? " " : "",
                    option->argument ? option->argument : "");
    if (width >= HELP_COLUMN) {
        putchar('\n');
        width = 0;
    }
    printf("%*s", HELP_COLUMN - width, "");
    for (const char *line = option->help;;) {
        int const length = (int)strcspn(line, "\n");
        printf("%.*s\n", length, line);
        if (!line[length]) break;
        line += length + 1;
        printf("%*s", HELP_COLUMN, "");
    }
}

void options_print_help(const command_spec *command) {
    printf("usage: tulle %s %s%s\n\n%s\n", command->name, command->operands,
           command->option_count ? " [options]" : "", command->summary);
    fputs("\noptions:\n", stdout);
    for (size_t i = 0; i < command->option_count; i++) print_option(&command->options[i]);
    printf("  -h, --help%*sprint this text\n", HELP_COLUMN - 12, "");
}
