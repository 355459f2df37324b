/* base/timer.h - a monotonic clock. */
#ifndef TULLE_BASE_TIMER_H
#define TULLE_BASE_TIMER_H

/* [s] since some fixed moment. */
double timer_now(void);

#endif
