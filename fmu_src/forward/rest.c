#include "forward/rest.h"

#include <math.h>

#include "elementary/elementary.h"
#include "forward/candidate.h"
#include "forward/decide.h"
#include "forward/stick.h"
#include "numerics/bernstein.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- wedged beyond a finite edge of the stick band ---- */

/* What must be positive: the acceleration in the direction of the torque, and the reactions on their flanks. */
enum { CONDITIONS = 3, TIMES_MAX = CONDITIONS * INPUT_ORDER };

/* Each condition is by_tau tau + by_load F_0. The factors are scaled so that the terms of both add up to 1 at present.
 */
typedef struct {
    double by_tau[CONDITIONS], by_load[CONDITIONS];
} Conditions;

bool wedge_holds(const Mechanism *m) {
    return m->state.mode == MODE_WEDGED && has_inertia(&m->params) && stick_direction_beyond_band(m) != 0;
}

COMPACT_BEGIN
/* The conditions of one slip mode at rest. False if friction jams this mode, or depends on the load: its conditions are no
 * polynomials of tau and F_0. */
static bool conditions_of(const Mechanism *m, int index, Conditions *c) {
    const SlipMode slip = slip_mode_from_here(m, index);
    if (slip.friction_is_loaded) return false;
    const InertiaParams *in = &m->params.inertia;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(&slip, m->state.theta.hi, 0.0, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const double inertia = slip_inertia(&slip, k).value, delta = f->delta.value;
    if (!(inertia * delta > 0.0)) return false;
    const double mz = in->follower_mass * k->dz_dtheta.value, I = in->follower * k->dpsi_dtheta[0].value;
    const double alpha[2] = {delta / inertia, -f->p.value / inertia}; /* per torque and per load */
    c->by_tau[0] = slip.direction * alpha[0];
    c->by_load[0] = slip.direction * alpha[1];
    for (int i = 0; i < 2; i++) {
        const double rn = f->rn[1 - i].value, d = i == 0 ? -f->d[1].value : f->d[0].value;
        const double sign = slip.flank[i] / delta, by_alpha = rn * mz + d * I;
        c->by_tau[1 + i] = sign * by_alpha * alpha[0];
        c->by_load[1 + i] = sign * (rn + by_alpha * alpha[1]);
    }
    const double tau = fabs(m->inputs.tau[0]), load = stick_axial_size(m);
    for (int i = 0; i < CONDITIONS; i++) {
        const double size = fabs(c->by_tau[i]) * tau + fabs(c->by_load[i]) * load;
        c->by_tau[i] /= size;
        c->by_load[i] /= size;
    }
    return true;
}

/* Condition i as a polynomial of the time: its derivatives, less what counts as rounding. */
static void condition_along(const Mechanism *m, const Conditions *c, int i, double u[INPUT_ORDER + 1]) {
    u[0] = c->by_tau[i] * m->inputs.tau[0] + c->by_load[i] * stick_axial_load(m) - LATE_LOADS;
    for (int k = 1; k <= INPUT_ORDER; k++) u[k] = c->by_tau[i] * m->inputs.tau[k] + c->by_load[i] * m->inputs.F_ext[k];
}

static double least_at(double u[CONDITIONS][INPUT_ORDER + 1], double t) {
    return min_of(input_value(u[0], t), min_of(input_value(u[1], t), input_value(u[2], t)));
}

/* The first time in (0, left] after which all conditions are met; infinity if there is none. Where the axial load passes
 * zero, both reactions change their sign at once, to rounding. */
static double time_of(double u[CONDITIONS][INPUT_ORDER + 1], double left) {
    double first = INFINITY;
    for (int i = 0; i < CONDITIONS; i++) {
        const Bernstein p = bernstein_of_taylor(u[i], left);
        double x[BERNSTEIN_MAX];
        const int count = bernstein_crossings(&p, x);
        for (int k = 0; k < count; k++) {
            const double t = x[k] * left, rate = input_rate(u[i], t);
            double others = INFINITY;
            for (int j = 0; j < CONDITIONS; j++)
                if (j != i) others = min_of(others, input_value(u[j], t));
            if (rate > 0.0 && others >= -0.5 * LATE_LOADS) first = min_of(first, t);
        }
    }
    return first;
}

/* The time, s, at most `left`, until a pair of flanks agrees. */
static double wedge_time(const Mechanism *m, double left) {
    const int direction = stick_direction_beyond_band(m);
    double first = left;
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, 1, flank);
        Conditions c;
        if (!conditions_of(m, slip_index(direction, flank), &c)) continue;
        double u[CONDITIONS][INPUT_ORDER + 1];
        for (int i = 0; i < CONDITIONS; i++) condition_along(m, &c, i, u[i]);
        first = min_of(first, time_of(u, left));
    }
    return first;
}

/* Wedged contacts under friction that depends on the load, t seconds from now. Contacts with the same number wedge for the
 * same reason: beyond a finite edge, or inside an infinite one. */
typedef struct {
    bool lets_go; /* a pair of flanks agrees */
    int reason;
} WedgeSample;

/* Leaves the inputs of that time in `m`. */
static WedgeSample wedge_sample(Mechanism *m, const Inputs *now, double t) {
    work_add(m->work, WORK_OF_SEGMENT);
    m->inputs = *now;
    inputs_advance(&m->inputs, t);
    const BandFactors band = stick_band(m);
    const int reason = stick_direction_beyond_band(m) + 4 * (isinf(band.load) != 0) + 8 * (isinf(band.release) != 0);
    return (WedgeSample){is_slip(decision_of(m).mode), reason};
}

/* An interval at whose start, and before, the contacts hold. */
typedef struct {
    double before, after;
    WedgeSample at_before, at_after;
} WedgeInterval;

/* Halves the interval toward the first instant at which the contacts let go or wedge for another reason, to the share
 * `width` of the time. A short time in which they let go lies at such an instant. */
static void narrow_wedge(Mechanism *m, const Inputs *now, double width, WedgeInterval *in) {
    for (int n = 0; n < BISECTIONS_MAX && in->after - in->before > width * in->after; n++) {
        const double middle = 0.5 * (in->before + in->after);
        if (middle == in->before || middle == in->after) return;
        const WedgeSample sample = wedge_sample(m, now, middle);
        if (sample.lets_go || (!in->at_after.lets_go && sample.reason != in->at_before.reason)) {
            in->after = middle;
            in->at_after = sample;
        } else {
            in->before = middle;
            in->at_before = sample;
        }
    }
}

/* The same where friction depends on the load: by samples of the decision, and bisection. With or without inertia, and
 * also inside the band: an infinite edge can become finite, beyond the torque, while F_ext varies. */
COLD static double loaded_wedge_time(Mechanism *m, double left) {
    const Inputs now = m->inputs;
    WedgeInterval in = {.before = 0.0, .at_before = wedge_sample(m, &now, 0.0)};
    double time = left;
    for (int k = 1; k <= LOADED_REST_SAMPLES; k++) {
        const double t = left * k / (int)LOADED_REST_SAMPLES;
        const WedgeSample sample = wedge_sample(m, &now, t);
        in.after = t;
        in.at_after = sample;
        if (!sample.lets_go && sample.reason != in.at_before.reason) narrow_wedge(m, &now, LOADED_REST_CHANGE, &in);
        if (in.at_after.lets_go) {
            narrow_wedge(m, &now, LOCATION_ROUNDING, &in);
            time = in.after;
            break;
        }
        in.before = t;
        in.at_before = sample;
    }
    m->inputs = now;
    return time;
}

/* The time, s, at most `left`, until the contacts let go or wedge for another reason. Friction that does not depend on the
 * load has conditions that are polynomials of the time. They know no rounding but that of the present loads: where the
 * loads grow, a reaction that hinders a pair of flanks can become rounding, and the decision takes this pair. */
static double wedged_time(Mechanism *m, double left) {
    if (!m->model.friction_is_loaded) {
        const double time = wedge_holds(m) ? wedge_time(m, left) : left;
        if (time < left || !wedge_holds(m)) return time;
        const Inputs now = m->inputs;
        const bool lets_go = wedge_sample(m, &now, left).lets_go;
        m->inputs = now;
        if (!lets_go) return left;
    }
    return loaded_wedge_time(m, left);
}

double wedge_agreement(const Mechanism *m) {
    const int direction = stick_direction_beyond_band(m);
    double largest = -1.0;
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, 1, flank);
        Conditions c;
        if (!conditions_of(m, slip_index(direction, flank), &c)) continue;
        double u[CONDITIONS][INPUT_ORDER + 1];
        for (int i = 0; i < CONDITIONS; i++) condition_along(m, &c, i, u[i]);
        largest = max_of(largest, least_at(u, 0.0));
    }
    return largest;
}
COMPACT_END

/* ---- segments ---- */

bool rest_goes_on(Mechanism *m) {
    const RestInterval *rest = &m->cache.rest;
    const double tau = m->inputs.tau[0];
    if (!rest->valid || !(tau >= rest->lower && tau <= rest->upper)) return false;
    if (m->inputs.F_ext[0] != rest->F_ext) return false;
    if (m->params.ledger) peak_raise(&m->state.ledger.peak.torque, tau);
    return true;
}

/* Raises the peaks to the torque and the reactions at rest, t seconds after the start of the segment. */
static void raise_peaks(const Mechanism *m, double t, Segment *segment) {
    const double spring = spring_force(&m->params.spring, m->configuration.z);
    const double F_0 = spring + input_value(m->inputs.F_ext, t);
    peak_raise(&segment->peak.torque, input_value(m->inputs.tau, t));
    for (int i = 0; i < 2; i++) peak_raise(&segment->peak.reaction[i], F_0 * stick_sharing(m, i));
}

void rest_propose_for(const Mechanism *m, double t, Segment *segment) {
    segment_begin(m, SEGMENT_REST, segment);
    segment->duration = t;
    segment->varies = !inputs_constant(&m->inputs);
    if (!m->params.ledger) return;
    raise_peaks(m, 0.0, segment);
    if (!segment->varies) return;
    segment_raise_input_peaks(m, t, segment);
    raise_peaks(m, t, segment);
}

void rest_propose(Mechanism *m, double left, Segment *segment) {
    if (inputs_constant(&m->inputs)) {
        m->cache.rest = stick_rest_interval(m); /* the next step at rest costs one comparison */
        rest_propose_for(m, left, segment);
        return;
    }
    const double time = stick_rest_time(m, left);
    rest_propose_for(m, m->state.mode == MODE_WEDGED ? wedged_time(m, time) : time, segment);
}
