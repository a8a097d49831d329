#include "collocation/radau_variation.h"

#include <math.h>

#include "collocation/radau_system.h"
#include "elementary/elementary.h"
#include "numerics/lu.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* The collocation equations, differentiated: the change y_j of alpha (or omega) at node j obeys
 *     y_i = by_theta_i dtheta_i + by_omega_i domega_i + by_known_i
 * where dtheta_i and domega_i follow from y as theta_i and omega_i do. */
typedef struct {
    RadauSystem system;
    RightHandSide rhs[RADAU_MAX];
    Partials by[RADAU_MAX]; /* of alpha (or omega) */
    Lu lu;
} VariedStep;

/* Where a law has no fall of friction, peak = 1, no step resolves the speeds of the fall: the peak has no part. */
static void leave_out_peaks(const Params *p, Partials *by) {
    for (int i = 0; i < 2; i++)
        if (p->cam[i].law.peak == 1.0) by->by[KNOWN_PEAK_1 + i] = 0.0;
}

/* False if the equations have no solution. A pole at the end is left out. Such a pole belongs to an angle that is a
 * root of time, see vary_in_parts(). */
COLD static bool differentiate(const SlipMode *slip, const RadauStep *step, VariedStep *d) {
    d->system = (RadauSystem){.slip = slip, .method = step->method, .h = step->h};
    d->lu.n = step->method->stages;
    double before = INFINITY;
    for (int i = 0; i < d->lu.n; i++) {
        d->rhs[i] = step->node[i].rhs;
        balance_response(slip, &step->node[i], &d->by[i]);
        leave_out_peaks(slip->params, &d->by[i]);
        if (!(fabs(d->by[i].by[KNOWN_TAU]) <= VARIATION_POLE * before)) {
            d->by[i] = (Partials){.by = {0.0}};
            d->rhs[i].by_theta = 0.0;
        }
        before = fabs(d->by[i].by[KNOWN_TAU]);
        radau_system_newton_row(&d->system, &d->rhs[i], i, d->lu.a[i]);
    }
    return lu_factorize(&d->lu);
}

/* A change of the state has no part in by_known. */
COLD static void vary_by(const VariedStep *d, int known, Variation *v) {
    const Radau *r = d->system.method;
    const int n = r->stages;
    const bool inertial = d->system.slip->regime == REGIME_INERTIAL;
    const double h = d->system.h, theta = v->theta[known], omega = inertial ? v->omega[known] : 0.0;
    double y[RADAU_MAX], twice = 0.0;
    for (int i = 0; i < n; i++) {
        const double forced = known < KNOWN_TAU ? 0.0 : d->by[i].by[known];
        y[i] = d->rhs[i].by_theta * (theta + r->node[i] * h * omega) + d->rhs[i].by_omega * omega + forced;
    }
    lu_solve(&d->lu, y);
    const double once = h * radau_dot(r->weight, y, n);
    for (int j = 0; j < n; j++) twice += h * h * r->twice[j][n - 1] * y[j];
    v->theta[known] += inertial ? h * omega + twice : once;
    v->omega[known] = inertial ? omega + once : y[n - 1];
}

COLD static bool vary(const SlipMode *slip, const RadauStep *step, Variation *v) {
    VariedStep varied;
    if (!differentiate(slip, step, &varied)) return false;
    for (int known = v->first; known < v->end; known++) vary_by(&varied, known, v);
    return true;
}

/* How far the variation has been carried through a step. */
typedef struct {
    Inputs inputs;
    Balance at;
    Variation v;
} VariationFront;

/* Carries the variation on by t seconds in one step. */
COLD static bool carry(const SlipMode *slip, double t, VariationFront *front) {
    RadauStep step;
    SlipMode here = *slip;
    here.inputs = &front->inputs;
    here.to_rounding = true;
    if (!radau_step_solve(&here, &front->at, t, RADAU_MAX, &step) || !vary(&here, &step, &front->v)) return false;
    inputs_advance(&front->inputs, t);
    balance_at(&here, front->at.theta + step.dtheta, 0.0, 0.0, &front->at);
    return true;
}

/* The same part in one step, and in two steps of half its length. */
typedef struct {
    VariationFront once, twice;
} PartTwice;

static bool is_finite(const Variation *v) {
    double sum = 0.0;
    for (int known = v->first; known < v->end; known++) sum += v->theta[known];
    return isfinite(sum);
}

COLD static bool carry_twice(const SlipMode *slip, double t, PartTwice *part) {
    bool found = true;
    for (int k = 0; found && k < 3; k++) found = carry(slip, k == 0 ? t : 0.5 * t, k == 0 ? &part->once : &part->twice);
    return found && is_finite(&part->once.v) && is_finite(&part->twice.v);
}

/* Raises the largest variation so far, `scale`, of each known. Do one step and two half steps agree? */
COLD static bool agree(const PartTwice *part, double scale[KNOWN_COUNT]) {
    bool good = true;
    for (int known = part->once.v.first; known < part->once.v.end; known++) {
        const double once = part->once.v.theta[known], twice = part->twice.v.theta[known];
        scale[known] = max_of(scale[known], fabs(twice));
        good = good && fabs(once - twice) <= VARIATION_TOLERANCE * scale[known];
    }
    return good;
}

static const double ROOT = 3.414213562373095; /* 1/(1 - sqrt(1/2)) */

COLD static void extrapolate(const PartTwice *part, Variation *v) {
    for (int known = v->first; known < v->end; known++) {
        const double once = part->once.v.theta[known];
        v->theta[known] = once + ROOT * (part->twice.v.theta[known] - once);
    }
}

/* Without inertia a step that is good for the motion may be too long for its variation: a variation that dies out
 * while the motion is steady, or, where quadratic damping alone acts, a speed that is a root of time. So the step is
 * gone through again in parts. A part is accepted if one step and two half steps agree. It is accepted too if it is
 * short against the times from the start and to the end of the step: only rounding can differ there. The shortest
 * parts lie next to the start and the end, where the error is proportional to the root of the length: one step and two
 * half steps together then give the limit (Richardson's extrapolation). */
COLD static bool vary_in_parts(const SlipMode *slip, const RadauStep *step, Variation *v) {
    VariationFront front = {.at = step->start, .v = *v};
    front.inputs = *slip->inputs;
    const double h = step->h;
    double left = h, t = h, scale[KNOWN_COUNT];
    for (int known = 0; known < KNOWN_COUNT; known++) scale[known] = fabs(v->theta[known]);
    for (int n = 0; n < VARIATION_TRIALS && left > 0.0 && t > 0.1 * VARIATION_SHORTEST * h; n++) {
        if (work_is_spent(slip->work)) return false;
        PartTwice part = {front, front};
        t = min_of(t, left);
        const bool is_shortest = t <= VARIATION_SHORTEST * h;
        const bool is_short = is_shortest || t <= VARIATION_SHORT * min_of(h - left, left);
        if (carry_twice(slip, t, &part) && (agree(&part, scale) || is_short)) {
            front = part.twice;
            if (is_shortest) extrapolate(&part, &front.v);
            left -= t;
            t *= 4.0;
        } else {
            t *= 0.25;
        }
    }
    *v = front.v;
    return true;
}

COLD bool radau_step_vary(const SlipMode *slip, const RadauStep *step, Variation *v) {
    return slip->regime == REGIME_INERTIAL ? vary(slip, step, v) : vary_in_parts(slip, step, v);
}
