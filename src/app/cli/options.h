/* app/cli/options.h - command-line options of a subcommand, described by a table that also prints
 * its
 * --help. Accepts --name VALUE, --name=VALUE, -x VALUE, -xVALUE; `--` ends the options; options and
 * operands may be mixed. */
#ifndef TULLE_APP_CLI_OPTIONS_H
#define TULLE_APP_CLI_OPTIONS_H

#include <stddef.h>

enum { OPTION_LIST_MAX = 256 };

/* Values of an option that may be given several times. */
typedef struct option_list {
    const char *items[OPTION_LIST_MAX];
    size_t count;
} option_list;

typedef enum option_kind {
    OPTION_FLAG,    /* value: int *, becomes 1 */
    OPTION_TEXT,    /* value: const char ** */
    OPTION_CHOICE,  /* value: const char **, one of `choices` */
    OPTION_INTEGER, /* value: long *, minimum .. maximum */
    OPTION_LIST     /* value: option_list *, may be repeated */
} option_kind;

typedef struct option_spec {
    const char *name; /* long name without dashes */
    char letter;      /* short name, 0: none */
    option_kind kind;
    void *value;          /* untouched unless the option is given */
    const char *argument; /* the value's name in the help, "N"; null for a flag */
    const char *help;
    long minimum, maximum;      /* OPTION_INTEGER */
    const char *const *choices; /* OPTION_CHOICE, ends with null */
} option_spec;

#define FLAG_OPTION(name, letter, value, help)                                                     \
    { name, letter, OPTION_FLAG, value, NULL, help, 0, 0, NULL }
#define TEXT_OPTION(name, letter, value, argument, help)                                           \
    { name, letter, OPTION_TEXT, value, argument, help, 0, 0, NULL }
#define LIST_OPTION(name, letter, value, argument, help)                                           \
    { name, letter, OPTION_LIST, value, argument, help, 0, 0, NULL }
#define CHOICE_OPTION(name, letter, value, argument, choices, help)                                \
    { name, letter, OPTION_CHOICE, value, argument, help, 0, 0, choices }
#define INTEGER_OPTION(name, letter, value, argument, minimum, maximum, help)                      \
    { name, letter, OPTION_INTEGER, value, argument, help, minimum, maximum, NULL }

typedef struct command_spec {
    const char *name;     /* "run" */
    const char *operands; /* "SCENE.yaml" */
    const char *summary;  /* what it does, lines of at most 90 characters */
    const option_spec *options;
    size_t option_count;
    size_t operand_minimum, operand_maximum;
} command_spec;
#define COMMAND(name, operands, options, least, most, summary)                                     \
    { name, operands, summary, options, sizeof options / sizeof options[0], least, most }

typedef enum options_outcome {
    OPTIONS_READ,   /* go on */
    OPTIONS_HELP,   /* the help is printed to standard output; exit with APP_EXIT_FINE */
    OPTIONS_REFUSED /* the reason is printed to standard error; exit with APP_EXIT_BAD_INPUT */
} options_outcome;

/* Reads argv[1] .. argv[argc - 1] into the values of the table. Moves the operands to argv[0] ..
 * argv[*operand_count - 1]. */
options_outcome options_parse(const command_spec *command, int argc, char **argv,
                              size_t *operand_count);

/* Exit code for an outcome other than OPTIONS_READ. */
int options_exit(options_outcome outcome);

/* Prints usage, summary and the table of options to standard output. */
void options_print_help(const command_spec *command);

#endif
