/* base/timer.h - clocks. */
#ifndef TULLE_BASE_TIMER_H
#define TULLE_BASE_TIMER_H

/* [s] since some fixed moment. */
double timer_now(void);

/* [s] of processor time that all threads of the process took together. Waits a moment: a thread
 * that runs is counted to its last sleep, or a few milliseconds late, and helpers look for work
 * before they sleep. */
double timer_processor_now(void);

#endif
