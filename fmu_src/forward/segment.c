#include "forward/segment.h"

#include "forward/stick.h"
#include "numerics/bernstein.h"

void segment_raise_input_peaks(const Mechanism *m, double t, Segment *segment) {
    if (inputs_within(&m->inputs, 1)) return;
    Peaks *peak = &segment->peak;
    const Bernstein tau = bernstein_of_taylor(m->inputs.tau, t), F_ext = bernstein_of_taylor(m->inputs.F_ext, t);
    peak_raise(&peak->torque, bernstein_value(&tau, bernstein_peak(&tau)));
    if (is_slip(m->state.mode)) return;
    Bernstein load = F_ext;
    for (int i = 0; i <= load.degree; i++) load.c[i] += spring_force(&m->params.spring, m->configuration.z);
    const double F_0 = bernstein_value(&load, bernstein_peak(&load));
    for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], stick_sharing(m, i) * F_0);
}
