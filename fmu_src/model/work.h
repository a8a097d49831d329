/* The work of one call of the FMI interface, and its limit. All searches of a call count their evaluations of the
 * motion in one counter, so that the call ends after a bounded number of operations, whatever parameters, inputs and
 * step are. Each search also has a bound of its own; the counter bounds searches inside searches. */
#ifndef DUALCAM_WORK_H
#define DUALCAM_WORK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Evaluations at most: about two seconds, 0.1 to 0.2 us each. What the decision and the proposal of a segment count
 * for. */
enum { MAX_WORK = 10000000, WORK_OF_SEGMENT = 20 };

/* A step that needs more segments is refused. The limit bounds a step to about two seconds: a segment takes 15 us where
 * friction varies. Bounces with a restitution near 1, vibrations of a
 * tiny inertia, and long steps through stiff motion reach the limit. */
enum { MAX_SEGMENTS_PER_STEP = 100000 };

/* Stall guard: STALL_GUARD_SEGMENTS segments must advance time by the share STALL_GUARD_PROGRESS of the step, else the
 * step is refused. Segments as short as the rounding of time would otherwise keep a step busy for minutes. */
enum { STALL_GUARD_SEGMENTS = 2000 };
static const double STALL_GUARD_PROGRESS = 1e-9;

typedef struct {
    int64_t done, most; /* evaluations */
} Work;

/* The work of a call. `limit`: evaluations at most, which a test sets; 0: MAX_WORK. */
static inline Work work_of_call(int64_t limit) {
    return (Work){.most = limit > 0 ? limit : MAX_WORK};
}

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
