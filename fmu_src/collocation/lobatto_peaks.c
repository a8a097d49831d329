#include "collocation/lobatto_peaks.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

typedef enum { PEAK_REACTION_1, PEAK_REACTION_2, PEAK_SPEED } PeakQuantity;

/* |value| at the end of a step over the share x of the step: the end of a step is more exact than the cubic inside. NAN
 * where there is no such step. */
static double value_after(const LobattoSystem *s, PeakQuantity quantity, double x) {
    LobattoSystem part = *s;
    const EndAngle anywhere = {.given = false};
    part.h *= x;
    part.end_speed.given = false;
    lobatto_system_guess(&part, s->y.at[0]);
    if (!lobatto_system_solve(&part, &anywhere)) return NAN;
    if (quantity == PEAK_SPEED) return fabs(part.speed.at[LOBATTO_END]);
    const int i = (int)quantity, last = LOBATTO_HALVES - 1;
    const NodeForces forces = lobatto_node_forces(&part, last);
    const double r = s->slip->params->cam[i].radius, a = part.pair[last].slope[i][1];
    return fabs(lobatto_node_contact(&part.pair[last], &forces, i)[1]) * sqrt(r * r + a * a);
}

/* The turning points of the cubic with these Bernstein coefficients: the zeros of a (1 - x)^2 + 2 b x (1 - x) +
 * c x^2. */
static void turning_points(const double at[LOBATTO_NODES], double x[2]) {
    const double a = at[1] - at[0], b = at[2] - at[1], c = at[3] - at[2], square = a - 2.0 * b + c, half = b - a;
    const double q = -(half + copysign(sqrt(max_of(half * half - square * a, 0.0)), half));
    x[0] = q / square;
    x[1] = a / q;
}

/* Raises *peak, the larger |value| of both ends, to that of a turning point inside, in units of 1/unit. The cubic
 * through the values gives the place x; the error of the cubic there, e, moves x by some e over its
 * second derivative. */
static bool raise(const LobattoSystem *s, PeakQuantity quantity, const LobattoValues *v, double unit, double *peak) {
    const LobattoValues c = lobatto_combine(LOBATTO.bernstein, v);
    double x[2];
    turning_points(c.at, x);
    for (int k = 0; k < 2; k++) {
        if (!(x[k] > 0.0 && x[k] < 1.0)) continue;
        const double y = 1.0 - x[k], first = y * c.at[1] + x[k] * c.at[2];
        const double low = y * (y * c.at[0] + x[k] * c.at[1]) + x[k] * first;
        const double high = y * first + x[k] * (y * c.at[2] + x[k] * c.at[3]);
        const double size = fabs(y * low + x[k] * high);
        if (!(size > *peak * unit)) continue;
        const double found = value_after(s, quantity, x[k]), error = found - size;
        const double bend =
            6.0 * fabs(y * (c.at[0] - 2.0 * c.at[1] + c.at[2]) + x[k] * (c.at[1] - 2.0 * c.at[2] + c.at[3]));
        if (!(LOBATTO_PEAK_SHARE * error * error <= s->slip->params->tolerance * size * bend)) return false;
        *peak = max_of(*peak, found / unit);
    }
    return true;
}

bool lobatto_peaks_inside(const LobattoSystem *s, const LobattoValues reaction[2], Peaks *peaks) {
    const double contacts = s->slip->params->contacts;
    return raise(s, PEAK_REACTION_1, &reaction[0], contacts, &peaks->reaction[0]) &&
           raise(s, PEAK_REACTION_2, &reaction[1], contacts, &peaks->reaction[1]) &&
           raise(s, PEAK_SPEED, &s->speed, 1.0, &peaks->omega);
}
