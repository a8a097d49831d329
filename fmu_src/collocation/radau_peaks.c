#include "collocation/radau_peaks.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

typedef enum { PEAK_SPEED, PEAK_REACTION_1, PEAK_REACTION_2 } PeakQuantity;

/* rad/s, or N in total */
static double value_of(const Balance *b, PeakQuantity quantity) {
    if (quantity == PEAK_SPEED) return b->omega;
    const int i = quantity == PEAK_REACTION_1 ? 0 : 1;
    return b->x[i] * sqrt(b->length2[i]);
}

static RadauValues values_of(const RadauStep *step, PeakQuantity quantity) {
    RadauValues v = {.value = {value_of(&step->start, quantity)}};
    for (int j = 0; j < step->method->stages; j++) v.value[j + 1] = value_of(&step->node[j], quantity);
    radau_find_range(&v, step->method->stages);
    return v;
}

/* |value| at the end of a step over the share x of the step; NAN where there is none. */
static double value_after(const SlipMode *slip, const RadauStep *step, PeakQuantity quantity, double x) {
    RadauStep part;
    if (!radau_step_solve(slip, &step->start, x * step->h, step->method->stages, &part)) return NAN;
    return fabs(value_of(radau_step_end(&part), quantity));
}

/* The largest |value| in the step; below `known` the larger one of both ends will do. Where the polynomial has its peak inside, a step that ends at the peak is solved:
 * the end of a step is more exact than the polynomial inside. */
static double peak_of(const SlipMode *slip, const RadauStep *step, PeakQuantity quantity, double known) {
    const Radau *r = step->method;
    const RadauValues v = values_of(step, quantity);
    const double ends = max_of(fabs(v.value[0]), fabs(v.value[r->stages]));
    if (max_of(fabs(v.low), fabs(v.high)) + BEYOND_NODES * (v.high - v.low) <= known) return ends;
    const Bernstein p = radau_polynomial(r, v.value);
    if (bernstein_is_monotone(&p)) return ends;
    const double x = bernstein_peak(&p);
    const double size = fabs(bernstein_value(&p, x));
    if (!(size > ends) || x <= 0.0 || x >= 1.0) return ends;
    const double found = value_after(slip, step, quantity, x);
    if (!isfinite(found)) return size;
    return max_of(ends, found);
}

/* True if alpha keeps its sign throughout, so that |omega| is largest at an end. */
static bool is_speed_monotone(const RadauStep *step) {
    RadauValues v = {.value = {step->start.alpha}};
    for (int j = 0; j < step->method->stages; j++) v.value[j + 1] = step->node[j].alpha;
    radau_find_range(&v, step->method->stages);
    return max_of(v.low, -v.high) > BEYOND_NODES * (v.high - v.low);
}

void radau_step_raise_peaks(const SlipMode *slip, const RadauStep *step, Peaks *peak) {
    const Balance *start = &step->start, *end = radau_step_end(step);
    const int contacts = slip->params->contacts;
    peak_raise(&peak->omega, is_speed_monotone(step) ? max_of(fabs(start->omega), fabs(end->omega))
                                                     : peak_of(slip, step, PEAK_SPEED, peak->omega));
    peak_raise(&peak->torque, start->tau);
    peak_raise(&peak->torque, end->tau);
    for (int i = 0; i < 2; i++) {
        const PeakQuantity quantity = i == 0 ? PEAK_REACTION_1 : PEAK_REACTION_2;
        peak_raise(&peak->reaction[i], peak_of(slip, step, quantity, peak->reaction[i] * contacts) / contacts);
    }
}
