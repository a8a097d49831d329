#include "collocation/step_control.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* s, of the motion. */
static double time_scale(const SlipMode *slip, const Balance *b) {
    const RightHandSide *p = &b->rhs;
    double rate = fabs(p->by_omega);
    rate += slip->regime == REGIME_INERTIAL ? sqrt(fabs(p->by_theta)) : fabs(p->by_theta);
    if (slip->regime == REGIME_RATE_INDEPENDENT) rate = 0.0;
    return 1.0 / max_of(rate, DBL_MIN);
}

/* Few stages while the motion is slow against the step. Along the edge of the stick band, which is solved for node by
 * node, stages cost little against short steps. */
static int stages_for(const SlipMode *slip, const Balance *start, double h) {
    if (slip->regime == REGIME_RATE_INDEPENDENT) return RADAU_MAX;
    const double ratio = h / time_scale(slip, start);
    if (ratio < STEP_FOR_3_STAGES) return 3;
    return slip->params->tolerance > STEP_7_STAGES_TOLERANCE || ratio < STEP_FOR_5_STAGES ? 5 : 7;
}

/* x^(1/order), x > 0 */
static double root_of(double x, double order) {
    return elementary_exp(elementary_log(x) / order);
}

/* Where damping rules the motion, stiffness does no harm to long steps. */
double step_control_first_length(const SlipMode *slip, const Balance *start) {
    const RightHandSide *p = &start->rhs;
    const bool vibrates = slip->regime == REGIME_INERTIAL && p->by_omega * p->by_omega < fabs(p->by_theta);
    if (!vibrates) return INFINITY;
    return STEP_FIRST_LENGTH * root_of(slip->params->tolerance, STEP_FIRST_ORDER) / sqrt(fabs(p->by_theta));
}

/* The order of the error estimate in h. */
static double order_of(const RadauStep *step) {
    const double n = step->method->stages;
    return (n + 1.0) * (0.5 + n / (n + 1.0));
}

/* The factor on h that brings the error to 1, less a margin. */
static double length_factor(const RadauStep *step, double order) {
    return STEP_SAFETY / root_of(max_of(max_of(step->error, step->energy_error), STEP_LEAST_ERROR), order);
}

/* The factor on h after a rejected step. Where the step is too long, the error falls more slowly than its order says,
 * except along the edge of the stick band. */
static double rejection_factor(const SlipMode *slip, const RadauStep *step) {
    const double share = slip->regime == REGIME_RATE_INDEPENDENT ? 1.0 : STEP_REJECTED_ORDER;
    return min_of(STEP_LEAST_SHORTENING, max_of(STEP_MOST_SHORTENING, length_factor(step, share * order_of(step))));
}

StepProposal step_control_next(const RadauStep *step) {
    const double factor = min_of(STEP_MOST_GROWTH, max_of(length_factor(step, order_of(step)), 1.0));
    return (StepProposal){step->h * factor, step->method->stages};
}

/* A step much shorter than the proposal needs no more stages than its own length asks for. */
static int first_stages(const SlipMode *slip, const Balance *start, double h, const StepProposal *first) {
    const int stages = stages_for(slip, start, h);
    const bool similar = first->h == INFINITY || h >= STEP_SIMILAR * first->h;
    return similar && stages < first->stages ? first->stages : stages;
}

/* The share of the step over which friction changes little enough to be seen by the nodes, or after which a sliding
 * speed or a nominal load reaches a sample of a table. */
static double resolved_share(const SlipMode *slip, const RadauStep *step) {
    double share = 1.0;
    for (int j = 0; slip->friction_varies && j < step->method->stages; j++) {
        const double part = balance_friction_share(slip, &step->start, &step->node[j]);
        if (part < 1.0) share = min_of(share, part * step->method->node[j]);
    }
    return share;
}

/* The energy balance may miss no more than the last digits of the transmission itself, which no shorter step makes
 * better: a residual that a trial has not halved is accepted. */
bool step_control_solve(const SlipMode *slip, const Balance *start, double longest, const StepProposal *first,
                        RadauStep *step) {
    double h = longest, energy_before = INFINITY;
    const bool has_samples = slip->friction_varies && (slip->law[0].fall.table || slip->law[1].fall.table);
    bool at_sample = false;
    int stages = first_stages(slip, start, h, first);
    for (int n = 0; n < STEP_TRIALS && !work_is_spent(slip->work); n++) {
        if (!radau_step_solve(slip, start, h, stages, step)) {
            h *= STEP_UNSOLVED_SHORTENING;
            continue;
        }
        const double share = resolved_share(slip, step);
        if (share < 1.0) {
            const bool aims = has_samples && n < STEP_SAMPLE_TRIALS; /* a step that does not get there may end before */
            const double most = aims && step->error <= 1.0 ? 1.0 : STEP_LEAST_SHORTENING;
            h *= min_of(max_of(share, STEP_MOST_SHORTENING), most);
            at_sample = has_samples;
            continue;
        }
        const bool stalled = step->energy_error > 0.5 * energy_before;
        step->at_sample = at_sample;
        if (step->error <= 1.0 && (step->energy_error <= 1.0 || stalled)) return true;
        energy_before = step->error <= 1.0 ? step->energy_error : INFINITY;
        if (stages < RADAU_MAX) {
            stages += 2;
        } else {
            h *= rejection_factor(slip, step);
        }
    }
    return false;
}
