/* The work of one call of the FMI interface, and its limit. All searches of a call count their evaluations of the motion
 * in one counter, so that the call ends after a bounded number of operations, whatever parameters, inputs and step are.
 * Each search also has a bound of its own; the counter bounds searches inside searches. */
#ifndef DUALCAM_WORK_H
#define DUALCAM_WORK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Evaluations at most: about two seconds, 0.1 to 0.2 us each. What the decision and the proposal of a segment count for, and a
 * balance where friction depends on the load, which iterates. */
enum { MAX_WORK = 10000000, WORK_OF_SEGMENT = 20, WORK_OF_LOADED_BALANCE = 5 };

typedef struct {
    int64_t done, most; /* evaluations */
} Work;

/* `work` may be NULL: then the caller makes a fixed number of evaluations, which nobody counts. */
static inline void work_add(Work *work, int evaluations) {
    if (work != NULL) work->done += evaluations;
}

/* A search ends, as if it had found nothing, once the work is spent. The step is then refused (forward/step.c,
 * inverse/inverse.c), so that nothing depends on what the search returned. */
static inline bool work_is_spent(const Work *work) {
    return work != NULL && work->done >= work->most;
}

#endif
