#include "forward/rest.h"

#include "forward/stick.h"

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
    rest_propose_for(m, stick_rest_time(m, left), segment);
}
