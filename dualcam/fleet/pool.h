/* Threads that share the numbers 0 to count - 1 of a job. */
#ifndef DUALCAM_POOL_H
#define DUALCAM_POOL_H

#include <stddef.h>

typedef struct Pool Pool;

/* Does the numbers first to last - 1. `worker`: which thread calls, from 0. */
typedef void PoolJob(void *context, size_t first, size_t last, unsigned worker);

/* The caller and `threads` - 1 threads, `threads` > 0. NULL: no memory, or the system has no further thread. A forked
 * child has a copy of the pool without the threads: there pool_run leaves all numbers to the caller, and pool_free may
 * not be called. */
Pool *pool_new(unsigned threads);
void pool_free(Pool *pool);
/* Returns when all numbers are done. `work_of_one`: how many steps of about 50 ns or more one number is at least; small
 * jobs are the caller's alone. One call at a time. */
void pool_run(Pool *pool, PoolJob *job, void *context, size_t count, size_t work_of_one);

#endif
