#include "closed_form/linear_segment.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* A quantity has at most one zero in the segment. True if the quantity has none after the start. A quantity that
 * starts at zero has had its zero. Where the quantity has all but died away, its sign at the end is rounding. */
static inline bool keeps_sign(double start, double end) {
    return end * start > LINEAR_DECAYED * start * start || start == 0.0;
}

/* True if a homogeneous quantity has at most one zero in the segment. */
static bool is_short(const LinearSegment *s, const SegmentEnds *ends) {
    return ends->motion.t < s->linear->oscillator.half_period;
}

static double contact_curvature(const LinearSegment *s, const LinearMotion *motion, int i) {
    return linear_slip_contact(s->linear, s->params, s->geometry, &s->start, motion, i).second;
}

/* True if dx_i/dt has at most one zero in a short segment: dx_i/dt is homogeneous (constant inputs) or monotone (its
 * derivative keeps its sign). */
static bool contact_rate_has_one_zero(const LinearSegment *s, const SegmentEnds *ends, int i) {
    if (has_constant_inputs(&s->start)) return true;
    const LinearMotion start = linear_slip_motion_at_start(s->linear, &s->start);
    return keeps_sign(contact_curvature(s, &start, i), contact_curvature(s, &ends->motion, i));
}

static bool alpha_keeps_sign(const LinearSegment *s, const SegmentEnds *ends) {
    return keeps_sign(s->start.alpha, ends->motion.alpha);
}

static inline bool contact_rate_keeps_sign(const SegmentEnds *ends, int i) {
    return keeps_sign(ends->start.rate[i], ends->end.rate[i]);
}

bool linear_segment_speed_is_monotone(const LinearSegment *s, const SegmentEnds *ends) {
    return is_short(s, ends) && alpha_keeps_sign(s, ends);
}

bool linear_segment_contact_is_monotone(const LinearSegment *s, const SegmentEnds *ends, int i) {
    return is_short(s, ends) && contact_rate_keeps_sign(ends, i) && contact_rate_has_one_zero(s, ends, i);
}

void linear_segment_ends(const LinearSegment *s, const Kernel *kernel, SegmentEnds *ends) {
    const SlipStart *l = &s->start;
    const LinearMotion start = linear_slip_motion_at_start(s->linear, l), *motion = &ends->motion;
    linear_slip_motion(s->linear, l, kernel, &ends->motion);
    ends->monotone = linear_segment_speed_is_monotone(s, ends);
    if (!s->flanks && !s->params->ledger) return;
    const double spring = s->params->spring.stiffness * s->geometry->dz_dtheta, rate = l->F_ext_rate;
    const double force = l->force + spring * motion->dtheta + rate * motion->t;
    ends->start = linear_slip_contacts(s->linear, l->force, spring * l->omega + rate, &start);
    ends->end = linear_slip_contacts(s->linear, force, spring * motion->omega + rate, motion);
    ends->monotone =
        ends->monotone && contact_rate_keeps_sign(ends, 0) && contact_rate_keeps_sign(ends, 1) &&
        (has_constant_inputs(l) || (contact_rate_has_one_zero(s, ends, 0) && contact_rate_has_one_zero(s, ends, 1)));
}

/* ---- quiet test ---- */

bool linear_segment_is_steady(const LinearSegment *s, const SegmentEnds *ends) {
    const SlipStart *l = &s->start;
    if (s->linear->regime != REGIME_INERTIAL) return false;
    const double spring = fabs(s->params->spring.preload) +
                          fabs(s->params->spring.stiffness * s->geometry->dz_dtheta * l->theta) + fabs(l->F_ext);
    const double torque = fabs(l->tau) + fabs(s->linear->transfer.rho) * spring + fabs(s->linear->damping * l->omega);
    return max_of(fabs(l->alpha), fabs(ends->motion.alpha)) * s->linear->mass <= LINEAR_TORQUE_ROUNDING * torque;
}

static inline bool ends_on_flank(const LinearSegment *s, const SegmentEnds *ends, int i) {
    const double sign = s->linear->flank[i];
    return sign * ends->start.value[i] >= 0.0 && sign * ends->end.value[i] >= 0.0;
}

/* dx_i/dt has at most one zero. If x_i moves away from zero at the start, x_i is nearest to zero at an end. If x_i
 * moves towards zero at the start, the same holds unless dx_i/dt changes its sign. */
bool linear_segment_keeps_flank(const LinearSegment *s, const SegmentEnds *ends, int i) {
    if (!is_short(s, ends) || !ends_on_flank(s, ends, i) || !contact_rate_has_one_zero(s, ends, i)) return false;
    return s->linear->flank[i] * ends->start.rate[i] >= 0.0 || contact_rate_keeps_sign(ends, i);
}

bool linear_segment_keeps_speed(const LinearSegment *s, const SegmentEnds *ends) {
    const double sign = s->linear->direction;
    if (!(sign * ends->motion.omega > 0.0) || !is_short(s, ends)) return false;
    return sign * s->start.alpha >= 0.0 || alpha_keeps_sign(s, ends) || linear_segment_is_steady(s, ends);
}

bool linear_segment_has_band_edge(const LinearSegment *s, int i) {
    return s->flanks && s->linear->regime == REGIME_VISCOUS && s->edge[i] != s->linear->transfer.rho;
}

/* Does no edge of the band end the motion? While F_0 keeps its sign, this is so if the edge for that sign is where the
 * speed is zero. F_0 is monotone, as theta is, if F_ext is constant. */
static bool keeps_beyond_band(const LinearSegment *s, const SegmentEnds *ends) {
    if (!s->flanks || s->linear->regime != REGIME_VISCOUS) return true;
    const double force = s->start.force, spring = s->params->spring.stiffness * s->geometry->dz_dtheta;
    return s->start.F_ext_rate == 0.0 && force * (force + spring * ends->motion.dtheta) > 0.0 &&
           !linear_segment_has_band_edge(s, s->linear->direction * force > 0.0 ? 0 : 1);
}

bool linear_segment_is_quiet(const LinearSegment *s, const SegmentEnds *ends) {
    const LinearMotion *motion = &ends->motion;
    const double sign = s->linear->direction;
    if (!(sign * motion->dtheta < s->to_stop && sign * motion->omega > 0.0)) return false;
    if (!(motion->t <= s->linear->oscillator.horizon) || !keeps_beyond_band(s, ends)) return false;
    if (s->flanks && !(ends_on_flank(s, ends, 0) && ends_on_flank(s, ends, 1))) return false;
    if (ends->monotone) return true;
    return linear_segment_keeps_speed(s, ends) &&
           (!s->flanks || (linear_segment_keeps_flank(s, ends, 0) && linear_segment_keeps_flank(s, ends, 1)));
}
