/* The clock of all timed loops, and the attribute of the functions that Python calls. The including file defines
 * _POSIX_C_SOURCE before any header. */
#ifndef CLOCK_H
#define CLOCK_H

#include <time.h>

#define EXPORT __attribute__((visibility("default")))

static inline double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#endif
