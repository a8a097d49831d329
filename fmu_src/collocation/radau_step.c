#include "collocation/radau_step.h"

#include <float.h>
#include <math.h>

#include "collocation/radau_system.h"
#include "collocation/step_energy.h"
#include "elementary/elementary.h"
#include "numerics/lu.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- error ---- */

/* omega_0 less the value at 0 of the polynomial through the speeds at the nodes, rad/s. */
static double speed_defect(const RadauSystem *s) {
    const Radau *r = s->method;
    double sum = 0.0; /* the weights at 0 add up to 1, so omega_0 itself cancels */
    for (int j = 0; j < r->stages; j++) sum += r->at_start[j] * (s->omega[j] - s->start->omega);
    return sum;
}

/* x^(1/2 + s/(s + 1)) for s = 3, 5, 7 stages, by roots: pow() would take a tenth of the time of a short step. */
static double error_at_end(double x, int stages) {
    if (stages == 5) return x * elementary_cbrt(x);
    const double quarter = sqrt(sqrt(x));
    return stages == 3 ? x * quarter : x * quarter * sqrt(quarter);
}

/* The largest distance and speed in the step, the largest stiffness at a node; and the largest exponent with which a
 * deviation of the speed falls in the step. */
typedef struct {
    double distance, speed, stiffness, damping;
} StepSize;

static StepSize step_size(const RadauSystem *s, const RadauStep *step) {
    StepSize size = {.speed = fabs(s->start->omega)};
    for (int i = 0; i < s->method->stages; i++) {
        size.distance = max_of(size.distance, fabs(s->dtheta[i]));
        size.speed = max_of(size.speed, fabs(step->node[i].omega));
        size.stiffness = max_of(size.stiffness, radau_system_stiffness(s, &step->node[i].rhs));
        size.damping = max_of(size.damping, -s->h * step->node[i].rhs.by_omega);
    }
    return size;
}

/* Factor on the damped defect of a step of the stiffness z: the error at its end of a solution that varies slowly
 * against 1/z. A step that is not stiff gains the digits of its order 2s - 1. A stiff step does not: its end follows
 * the derivative of its polynomial there (order reduction: E. Hairer, G. Wanner, Solving Ordinary Differential
 * Equations II, section IV.15). Fitted to y' = g' - z (y - g), within a third for 3, 5 and 7 stages and every z. */
static double stiff_share(double z, int stages) {
    const double share = z / (z + RADAU_STIFF_PER_STAGE * stages);
    double product = stages;
    for (int n = 0; n < stages; n++) product *= share;
    return product;
}

/* The error of the speed at the end of a stiff step, relative to the speed: where damping rules the speed, and where
 * the angle follows the torque, so that the speed is the derivative of the angle's polynomial. Without inertia the
 * speed errs by the slope d omega/d theta times the error of the angle. */
static double stiff_error(const RadauSystem *s, const StepSize *size, double defect, double rounding) {
    const int stages = s->method->stages;
    const double h = s->h, z = size->stiffness, w = size->damping, per_speed = 1.0 / (size->speed + DBL_MIN);
    if (s->slip->regime != REGIME_INERTIAL) {
        const double angle = stiff_share(z, stages) * h * defect / (1.0 + z);
        return max_of(angle - rounding, 0.0) * z / h * per_speed;
    }
    const double by_damping = stiff_share(w, stages) * h * defect / (1.0 + w);
    const double by_angle = stiff_share(z / (1.0 + w), stages) * fabs(speed_defect(s));
    return max_of(by_damping, by_angle) * per_speed;
}

/* Is a defect no more than the rounding of the forces? A shorter step does not lessen such a defect. It counts where a
 * motion has just begun, from rest, and its speed is still as small as the effect of the rounding. */
static bool is_rounding(const RightHandSide *start, double defect) {
    return defect <= RADAU_FORCE_ROUNDING * max_of(start->size, fabs(start->value));
}

/* The error inside the step from the defect at the start, relative to speed and distance. A stiff step damps the
 * defect; its angle follows the speed at the nodes, so the defect of the speed counts too. At the end of the
 * step the method has order 2s - 1, inside order s + 1. error_at_end() takes half of that gain: then the errors of the
 * study of integrators stay below RADAU_ERROR_SAFETY times the tolerance; with the whole gain they do not. */
static double error_of_defect(const RadauSystem *s, const RadauStep *step, double defect) {
    const Radau *r = s->method;
    const StepSize size = step_size(s, step);
    const double h = s->h, stiff = size.stiffness;
    const double damped = h * defect / (1.0 + stiff);
    const double rounding = ANGLE_ROUNDING * fabs(s->start->theta);
    double by_speed = 0.0, by_angle = damped * r->defect_once;
    if (s->slip->regime == REGIME_INERTIAL) {
        by_speed = size.speed > 0.0 ? damped * r->defect_once / size.speed : 0.0;
        by_angle = h * (damped * r->defect_twice + fabs(speed_defect(s)) * r->defect_once * stiff / (1.0 + stiff));
    }
    const double inside = max_of(by_speed, max_of(by_angle - rounding, 0.0) / (size.distance + DBL_MIN));
    const double gained = (inside < 1.0 ? error_at_end(inside, r->stages) : inside) * RADAU_ERROR_SAFETY;
    const double at_end = stiff > 1.0 ? stiff_error(s, &size, defect, rounding) : 0.0;
    return max_of(gained, at_end) / s->slip->params->tolerance;
}

/* Where the defect is rounding, the defect of the speed remains, which a stiff step shows. */
static double estimate_error(const RadauSystem *s, const RadauStep *step) {
    const double defect = fabs(s->start->rhs.value - radau_dot(s->method->at_start, s->y, s->method->stages));
    const double error = error_of_defect(s, step, defect);
    return error > 1.0 && is_rounding(&s->start->rhs, defect) ? error_of_defect(s, step, 0.0) : error;
}

/* ---- energy ---- */

static Booking booking_of(const SlipMode *slip, const RadauStep *step) {
    const Radau *r = step->method;
    Booking sum = {.work_in = 0.0};
    for (int j = 0; j < r->stages; j++) {
        const double weight = step->h * r->weight[j];
        const Booking power = balance_power(slip, &step->node[j]);
        sum.work_in += weight * power.work_in;
        sum.work_ext += weight * power.work_ext;
        sum.heat_cam[0] += weight * power.heat_cam[0];
        sum.heat_cam[1] += weight * power.heat_cam[1];
        sum.heat_damper += weight * power.heat_damper;
        sum.heat_shaft += weight * power.heat_shaft;
        sum.wear[0] += weight * power.wear[0];
        sum.wear[1] += weight * power.wear[1];
    }
    return sum;
}

static double kinetic_energy(const SlipMode *slip, const Balance *b) {
    if (slip->regime != REGIME_INERTIAL) return 0.0;
    return kinetic_energy_of(&slip->params->inertia, b->dz_dtheta, b->dpsi_dtheta[0], b->omega);
}

static EnergyEnds energy_ends_of(const SlipMode *slip, const RadauStep *step) {
    const Balance *start = &step->start, *end = radau_step_end(step);
    return (EnergyEnds){
        .z = {start->z, end->z},
        .kinetic = {kinetic_energy(slip, start), kinetic_energy(slip, end)},
        .spring_force = start->force - start->F_ext,
        .tau = end->tau,
        .angle_noise = step->angle_noise,
    };
}

/* ---- the step ---- */

/* Error: the speeds at the nodes must add up to the distance. The integrals of work and heat miss the same amount. */
static bool follow_edge(RadauSystem *s, RadauStep *step) {
    const Radau *r = s->method;
    if (!radau_system_follow_edge(s, step->node, &step->angle_noise)) return false;
    for (int j = 0; j < r->stages; j++) {
        s->y[j] = step->node[j].omega;
        step->node_dtheta[j] = step->node[j].theta - s->start->theta;
    }
    step->dtheta = step->node_dtheta[r->stages - 1];
    step->domega = 0.0;
    const double missed = fabs(step->dtheta - s->h * radau_dot(r->weight, s->y, r->stages));
    const double rounding = ANGLE_ROUNDING * (fabs(s->start->theta) + fabs(step->dtheta)) + step->angle_noise;
    step->error = max_of(missed - rounding, 0.0) / (fabs(step->dtheta) + DBL_MIN) / s->slip->params->tolerance;
    return true;
}

static bool integrate(RadauSystem *s, RadauStep *step) {
    const Radau *r = s->method;
    step->angle_noise = 0.0;
    if (!radau_system_solve(s, step->node)) return false;
    radau_system_place_nodes(s);
    for (int i = 0; i < r->stages; i++) step->node_dtheta[i] = s->dtheta[i];
    step->dtheta = step->node_dtheta[r->stages - 1];
    step->domega = s->slip->regime == REGIME_INERTIAL ? s->h * radau_dot(r->weight, s->y, r->stages) : 0.0;
    step->error = estimate_error(s, step);
    return true;
}

bool radau_step_solve(const SlipMode *slip, const Balance *start, double h, int stages, RadauStep *step) {
    RadauSystem s = radau_system_of(slip, start, h, stages);
    step->method = s.method;
    step->h = h;
    step->start = *start;
    if (!(slip->regime == REGIME_RATE_INDEPENDENT ? follow_edge(&s, step) : integrate(&s, step))) return false;
    step->booking = booking_of(slip, step);
    const EnergyEnds ends = energy_ends_of(slip, step);
    const EnergyBalance energy = step_energy_balance(slip, &step->booking, &ends);
    step->energy_gained = energy.gained;
    step->energy_error = energy.error;
    return true;
}

/* ---- peaks ---- */

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

/* The largest |value| in the step; below `known` the larger one of both ends will do. Where the polynomial has its peak
 * inside, a step that ends at the peak is solved: the end of a step is more exact than the polynomial inside. */
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

/* ---- variation ---- */

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

/* False if the equations have no solution. */
COLD static bool differentiate(const SlipMode *slip, const RadauStep *step, VariedStep *d) {
    d->system = (RadauSystem){.slip = slip, .method = step->method, .h = step->h};
    d->lu.n = step->method->stages;
    for (int i = 0; i < d->lu.n; i++) {
        d->rhs[i] = step->node[i].rhs;
        balance_response(slip, &step->node[i], &d->by[i]);
        leave_out_peaks(slip->params, &d->by[i]);
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

/* A speed that quadratic damping alone rules is a root of the torque: its variation has a pole at rest. */
static bool is_root_of_torque(const SlipMode *slip) {
    return slip->regime == REGIME_VISCOUS && slip->c == 0.0 && slip->params->shaft.damping == 0.0;
}

COLD bool radau_step_vary(const SlipMode *slip, const RadauStep *step, Variation *v) {
    VariedStep varied;
    if (is_root_of_torque(slip) || !differentiate(slip, step, &varied)) return false;
    for (int known = v->first; known < v->end; known++) vary_by(&varied, known, v);
    return true;
}
