/* app/cli/interrupt.c - see interrupt.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/interrupt.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>

/* Any thread may look. */
static atomic_int interrupt_count;

static void note_interrupt(int signal_number) {
    (void)signal_number;
    interrupt_count = 1;
}

void interrupt_catch(void) {
    struct sigaction action = {.sa_handler = note_interrupt};
    sigemptyset(&action.sa_mask);
    action.sa_flags = (int)SA_RESETHAND | SA_RESTART; /* the second one has its usual effect */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

bool interrupt_is_pending(void) { return interrupt_count != 0; }
