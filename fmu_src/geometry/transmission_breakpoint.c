#include "geometry/transmission_breakpoint.h"

#include <stdlib.h>

#include "numerics/tolerances.h"
#include "platform/attributes.h"

typedef TransmissionBreakpoint Breakpoint;

/* The stops, and what counts as the same theta. */
typedef struct {
    double lower, upper, slack; /* rad */
} StopRange;

/* Where the pin meets the knots of cam i's table, from stop to stop. Returns the number of breakpoints written. */
static size_t collect_knots(const Groove groove[2], int i, const StopRange *range, Breakpoint *out) {
    const Table *table = &groove[i].table;
    const Groove *other = &groove[1 - i];
    size_t count = 0;
    for (size_t j = 0; j <= table->count && table->count > 0; j++) {
        const double psi = j < table->count ? table->piece[j].psi : groove[i].last;
        const double z = groove_at(&groove[i], psi).z, theta = psi + groove_angle(other, z);
        const bool within = theta >= range->lower - range->slack && theta <= range->upper + range->slack;
        if (within) out[count++] = (Breakpoint){theta, true};
    }
    return count;
}

static int by_theta(const void *a, const void *b) {
    const double x = ((const Breakpoint *)a)->theta, y = ((const Breakpoint *)b)->theta;
    return (x > y) - (x < y);
}

/* Makes one breakpoint of those that differ by rounding only. The stops, at the front and at the end, keep their place.
 * Returns the number that remains. */
static size_t merge(Breakpoint *breakpoint, size_t count, double slack) {
    size_t kept = 1;
    for (size_t j = 1; j < count; j++) {
        Breakpoint *latest = &breakpoint[kept - 1];
        const bool is_end = j + 1 == count;
        if (breakpoint[j].theta - latest->theta > slack) {
            breakpoint[kept++] = breakpoint[j];
        } else if (is_end && kept > 1) {
            *latest = (Breakpoint){breakpoint[j].theta, latest->knot || breakpoint[j].knot};
        } else {
            latest->knot = latest->knot || breakpoint[j].knot;
        }
    }
    return kept;
}

Breakpoint *transmission_breakpoints(const Groove groove[2], double lower, double upper, size_t *count) {
    const StopRange range = {lower, upper, BREAKPOINT_MERGING * (upper - lower)};
    const size_t knots = groove[0].table.count + groove[1].table.count + 2;
    Breakpoint *breakpoint = malloc((knots + 2) * sizeof *breakpoint);
    if (!breakpoint) return NULL;
    size_t n = 1 + collect_knots(groove, 0, &range, breakpoint + 1);
    n += collect_knots(groove, 1, &range, breakpoint + n);
    qsort(breakpoint + 1, n - 1, sizeof *breakpoint, by_theta);
    breakpoint[0] = (Breakpoint){lower, false};
    breakpoint[n++] = (Breakpoint){upper, false};
    *count = merge(breakpoint, n, range.slack);
    return breakpoint;
}
