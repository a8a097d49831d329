#include "closed_form/linear_indicator.h"

#include <math.h>

#include "numerics/tolerances.h"

static IndicatorSample sample_speed(const LinearIndicator *indicator, const LinearMotion *motion) {
    const Oscillator *osc = &indicator->segment->linear->oscillator;
    return (IndicatorSample){
        .t = motion->t,
        .value = indicator->sign * motion->omega,
        .rate = indicator->sign * motion->alpha,
        .second = indicator->sign * motion->jerk,
        .third = indicator->sign * (-osc->decay2 * motion->jerk - osc->stiffness * motion->alpha),
    };
}

/* The rounding of x_i at the end of the motion: that of its terms there, and the part of the terms at the start that
 * is left in omega and alpha. */
static double contact_rounding(const LinearSegment *s, const LinearMotion *motion, int i) {
    const SlipStart *l = &s->start;
    const double spring = fabs(s->params->spring.stiffness * s->geometry->dz_dtheta);
    const double force = fabs(s->params->spring.preload) + spring * (fabs(l->theta) + fabs(motion->dtheta)) +
                         fabs(l->F_ext) + fabs(l->F_ext_rate) * motion->t;
    return REACTION_ZERO_SHARE *
           (fabs(s->linear->transfer.axial[i]) * force +
            fabs(s->linear->speed[i]) * (fabs(motion->omega) + LINEAR_START_SHARE * fabs(l->omega)) +
            fabs(s->linear->acceleration[i]) * (fabs(motion->alpha) + LINEAR_START_SHARE * fabs(l->alpha)));
}

static IndicatorSample sample_contact(const LinearIndicator *indicator, const LinearMotion *motion, int i) {
    const LinearSegment *s = indicator->segment;
    const Oscillator *osc = &s->linear->oscillator;
    const ContactLoad c = linear_slip_contact(s->linear, s->params, s->geometry, &s->start, motion, i);
    const double snap = -osc->decay2 * motion->jerk - osc->stiffness * motion->alpha; /* d jerk/dt */
    const double crackle = -osc->decay2 * snap - osc->stiffness * motion->jerk;       /* d snap/dt */
    const double spring = s->linear->transfer.axial[i] * s->params->spring.stiffness * s->geometry->dz_dtheta;
    return (IndicatorSample){
        .t = motion->t,
        .value = indicator->sign * c.value,
        .rate = indicator->sign * c.rate,
        .second = indicator->sign * c.second,
        .third = indicator->sign *
                 (spring * motion->jerk + s->linear->speed[i] * snap + s->linear->acceleration[i] * crackle),
        .rounding = contact_rounding(s, motion, i),
    };
}

static IndicatorSample sample_band_edge(const LinearIndicator *indicator, const LinearMotion *motion, double edge) {
    const LinearSegment *s = indicator->segment;
    const SlipStart *l = &s->start;
    const double spring = edge * s->params->spring.stiffness * s->geometry->dz_dtheta;
    const double rate = l->tau_rate - edge * l->F_ext_rate;
    return (IndicatorSample){
        .t = motion->t,
        .value = indicator->sign * (l->tau - edge * l->force - spring * motion->dtheta + rate * motion->t),
        .rate = indicator->sign * (rate - spring * motion->omega),
        .second = indicator->sign * -spring * motion->alpha,
        .third = indicator->sign * -spring * motion->jerk,
    };
}

static IndicatorSample sample_to_stop(const LinearIndicator *indicator, const LinearMotion *motion) {
    return (IndicatorSample){
        .t = motion->t,
        .value = indicator->segment->to_stop - indicator->sign * motion->dtheta,
        .rate = -indicator->sign * motion->omega,
        .second = -indicator->sign * motion->alpha,
        .third = -indicator->sign * motion->jerk,
    };
}

static IndicatorSample sample(const LinearIndicator *indicator, const LinearMotion *motion) {
    switch (indicator->quantity) {
        case QUANTITY_SPEED: return sample_speed(indicator, motion);
        case QUANTITY_EDGE_1:
        case QUANTITY_EDGE_2:
            return sample_band_edge(indicator, motion, indicator->segment->edge[indicator->quantity - QUANTITY_EDGE_1]);
        case QUANTITY_TO_STOP: return sample_to_stop(indicator, motion);
        case QUANTITY_CONTACT_1: return sample_contact(indicator, motion, 0);
        default: return sample_contact(indicator, motion, 1);
    }
}

IndicatorSample linear_indicator_at_start(const LinearIndicator *indicator) {
    const LinearMotion motion = linear_slip_motion_at_start(indicator->segment->linear, &indicator->segment->start);
    return sample(indicator, &motion);
}

IndicatorSample linear_indicator_at(const LinearIndicator *indicator, double t) {
    const LinearSlipMode *linear = indicator->segment->linear;
    work_add(indicator->segment->work, 1);
    oscillator_kernel(&linear->oscillator, t, indicator->kernel);
    LinearMotion motion;
    linear_slip_motion(linear, &indicator->segment->start, indicator->kernel, &motion);
    return sample(indicator, &motion);
}
