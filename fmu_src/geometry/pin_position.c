#include "geometry/pin_position.h"

#include <float.h>
#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

GammaRange pin_gamma_range(const Groove groove[2], double theta) {
    return (GammaRange){
        .lower = max_of(groove[0].first, theta - groove[1].last),
        .upper = min_of(groove[0].last, theta - groove[1].first),
    };
}

/* g1(gamma) - g2(theta - gamma), which increases with gamma. */
static double gap(const Groove groove[2], double theta, double gamma) {
    return groove_at(&groove[0], gamma).z - groove_at(&groove[1], theta - gamma).z;
}

bool pin_is_reachable(const Groove groove[2], double theta) {
    const GammaRange in = pin_gamma_range(groove, theta);
    return in.lower <= in.upper && gap(groove, theta, in.lower) <= 0.0 && gap(groove, theta, in.upper) >= 0.0;
}

/* Newton's method inside a bracket. Bisection takes over where a slope that nearly vanishes sends Newton's method out
 * of the bracket or lets it converge slowly. The iteration ends when the step or the gap is rounding. */
double pin_gamma(const Groove groove[2], double theta, double guess) {
    GammaRange in = pin_gamma_range(groove, theta);
    double gamma = guess >= in.lower && guess <= in.upper ? guess : 0.5 * (in.lower + in.upper);
    double last_step = INFINITY;
    for (int i = 0; i < ROOT_MAX_ITERATIONS; i++) {
        const double phi = theta - gamma;
        const GroovePoint p1 = groove_at(&groove[0], gamma), p2 = groove_at(&groove[1], phi);
        const double f = p1.z - p2.z, slope = p1.slope + p2.slope;
        if (f < 0.0) in.lower = gamma;
        else in.upper = gamma;
        double next = gamma - f / slope;
        const bool inside = next >= in.lower && next <= in.upper;
        if (fabs(f) <= ROOT_WIDTH * fabs(p1.z)) return inside ? next : gamma;
        if (!inside || fabs(next - gamma) > 0.5 * last_step) next = 0.5 * (in.lower + in.upper);
        last_step = fabs(next - gamma);
        gamma = next;
        if (last_step <= ROOT_WIDTH * max_of(fabs(gamma), fabs(phi))) return gamma;
    }
    return gamma;
}

double pin_height(GroovePoint first, GroovePoint second) {
    return first.slope <= second.slope ? first.z : second.z;
}

/* Error of the slope of one groove at `point`, m/rad. groove_slope() takes a steep ellipse's slope from its height, by
 * d slope/dz = g''/g'; else the slope comes from the angle, whose error is `angle` times eps. */
static double slope_rounding(const Groove *groove, GroovePoint point, double angle) {
    const double by_angle = fabs(point.dslope_dpsi) * angle;
    const double by_height = fabs(point.dslope_dpsi / point.slope * groove->height);
    const bool steep = groove->profile == PROFILE_ELLIPSE && by_height < by_angle;
    return DBL_EPSILON * (steep ? by_height : by_angle);
}

PinPosition pin_position(const Groove groove[2], double theta, double guess) {
    const double gamma = pin_gamma(groove, theta, guess), psi[2] = {gamma, theta - gamma};
    const GroovePoint point[2] = {groove_at(&groove[0], psi[0]), groove_at(&groove[1], psi[1])};
    PinPosition position = {.gamma = gamma, .z = pin_height(point[0], point[1])};
    /* the angles round, and so do the heights that determine them */
    const double angle = max_of(fabs(psi[0]), fabs(psi[1])) + fabs(position.z) / (point[0].slope + point[1].slope);
    for (int i = 0; i < 2; i++) {
        position.slope[i] = groove_slope(&groove[i], psi[i], position.z);
        position.rounding[i] = slope_rounding(&groove[i], point[i], angle);
    }
    return position;
}

bool pin_is_undetermined(const Groove groove[2], const PinPosition *position) {
    return position->slope[0] <= LEVEL_SLOPE * groove[0].radius && position->slope[1] <= LEVEL_SLOPE * groove[1].radius;
}
