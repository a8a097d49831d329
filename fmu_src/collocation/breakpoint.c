#include "collocation/breakpoint.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

double ballistic_time(double speed, double alpha, double distance) {
    const double root = speed * speed + 2.0 * alpha * distance;
    if (!(root > 0.0)) return INFINITY;
    const double sum = speed + sqrt(root);
    return sum > 0.0 ? 2.0 * distance / sum : INFINITY;
}

/* rad, of the transmission's piece beyond the breakpoint; infinite if there is none */
static double next_width(const SlipMode *slip) {
    const TransmissionPiece *piece = slip->piece, *first = slip->transmission->piece,
                            *last = first + slip->transmission->count - 1;
    if (piece == (slip->direction > 0 ? last : first)) return INFINITY;
    const TransmissionPiece *next = piece + slip->direction;
    return next->upper - next->lower;
}

/* Share of the narrower piece's width. At a table knot a third derivative jumps. Along the edge of the stick band the
 * edge may have its fold there. */
static double overshoot_share(const SlipMode *slip, bool is_knot) {
    if (!is_knot) return BREAKPOINT_OVERSHOOT;
    if (slip->regime == REGIME_RATE_INDEPENDENT) return BREAKPOINT_EDGE_OVERSHOOT;
    return BREAKPOINT_KNOT_OVERSHOOT * sqrt(slip->params->tolerance);
}

Breakpoint breakpoint_ahead(const SlipMode *slip, double theta) {
    if (slip->transmission->straight) return (Breakpoint){INFINITY, 0.0};
    const TransmissionPiece *piece = slip->piece;
    const bool up = slip->direction > 0;
    const double share = overshoot_share(slip, up ? piece->knot_upper : piece->knot_lower);
    return (Breakpoint){
        .distance = max_of(slip->direction * ((up ? piece->upper : piece->lower) - theta), 0.0),
        .overshoot = share * min_of(piece->upper - piece->lower, next_width(slip)),
    };
}

double breakpoint_time(const SlipMode *slip, const Balance *start, const Breakpoint *breakpoint) {
    return ballistic_time(slip->direction * start->omega, slip->direction * start->alpha, breakpoint_aim(breakpoint));
}
