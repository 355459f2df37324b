/* app/cli/interrupt.h - ends long work cleanly when the user asks for it. */
#ifndef TULLE_APP_CLI_INTERRUPT_H
#define TULLE_APP_CLI_INTERRUPT_H

#include <stdbool.h>

/* From this call on SIGINT and SIGTERM only set a flag. The work looks at the flag between its
 * parts; another signal ends the process. Closed pipes and file-size limits become errors of the
 * writes. */
void interrupt_catch(void);
/* Whether a signal has come since. */
bool interrupt_is_pending(void);

#endif
