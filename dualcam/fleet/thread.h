/* Threads and a condition to sleep on, of the operating system. */
#ifndef DUALCAM_THREAD_H
#define DUALCAM_THREAD_H

#include <stdbool.h>

typedef struct Thread Thread;

/* Runs body(argument) in a new thread. NULL: the system has no further thread. */
Thread *thread_start(void (*body)(void *), void *argument);
/* Waits until the thread has ended, and frees it. */
void thread_join(Thread *thread);

typedef struct Monitor Monitor; /* one lock with one condition */

Monitor *monitor_new(void);
void monitor_free(Monitor *monitor);
void monitor_lock(Monitor *monitor);
void monitor_unlock(Monitor *monitor);
/* Unlocks, sleeps until monitor_wake or without a reason, and locks again. */
void monitor_sleep(Monitor *monitor);
/* Wakes all that sleep. */
void monitor_wake(Monitor *monitor);

/* Tells the processor that the caller waits in a loop. */
void thread_pause(void);
/* Lets another thread have the processor. */
void thread_yield(void);
/* s, from some point in time on; never goes back. */
double thread_clock(void);
/* The number of the process. A forked child has another one than its parent, and none of the parent's threads. */
unsigned long thread_process(void);

#endif
