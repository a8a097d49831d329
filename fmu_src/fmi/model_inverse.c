#include <math.h>
#include <stdlib.h>

#include "fmi/variables.h"
#include "sensitivity/inverse_derivatives.h"

static GivenInput given_by(unsigned derivatives_given) {
    if (derivatives_given >> VR_THETA & 1u) return GIVEN_THETA;
    if (derivatives_given >> VR_OMEGA & 1u) return GIVEN_OMEGA;
    return derivatives_given >> VR_ALPHA & 1u ? GIVEN_ALPHA : GIVEN_ENDS;
}

bool model_advance(FmuModel *m, double h, unsigned derivatives_given, Watcher *watcher, Fault *fault) {
    const Mode before = m->state.mode;
    if (!inverse_advance(m, h, given_by(derivatives_given), fault)) return false;
    if (watcher != NULL && m->state.mode != before) (void)watcher->changed(watcher, 0.0);
    return true;
}

void model_clear_input_derivatives(InverseInputs *inputs) {
    *inputs = (InverseInputs){
        .theta = {inputs->theta[0]},
        .omega = {inputs->omega[0]},
        .alpha = {inputs->alpha[0]},
        .F_ext = {inputs->F_ext[0]},
    };
}

bool model_outputs(const FmuModel *m, unsigned groups, InverseOutputs *outputs, Fault *fault) {
    if ((groups & GROUP_MOTION) && !inverse_motion_outputs(m, &outputs->motion, fault)) return false;
    if ((groups & GROUP_LOADS) && !inverse_load_outputs(m, &outputs->loads, fault)) return false;
    if ((groups & GROUP_CONTACT) && !inverse_torque_outputs(m, &outputs->contact, fault)) return false;
    if (groups & GROUP_ENERGY) inverse_energy_outputs(m, &outputs->energy);
    if (groups & GROUP_AUDIT) inverse_audit_outputs(m, &outputs->audit);
    return true;
}

double model_output_derivative(const FmuModel *m, unsigned reference, int order) {
    InverseDerivatives derivatives;
    inverse_derivatives(m, &derivatives);
    switch (reference) {
        case VR_TAU: return derivatives.tau[order - 1];
        case VR_Z: return derivatives.z[order - 1];
        default: return derivatives.z[order];
    }
}

int model_known(unsigned reference) {
    switch (reference) {
        case VR_THETA: return KNOWN_THETA;
        case VR_OMEGA: return KNOWN_OMEGA;
        case VR_ALPHA: return KNOWN_ALPHA;
        case VR_F_EXT: return KNOWN_F_EXT;
        default: return tunable_known(reference);
    }
}

int model_unknown(unsigned reference) {
    switch (reference) {
        case VR_TAU: return 0;
        case VR_Z: return 1;
        case VR_V: return 2;
        default: return -1;
    }
}

bool model_partials(const FmuModel *m, unsigned reference, Partials *out, Fault *fault) {
    if (reference == VR_TAU) return inverse_torque_partials(m, out, fault);
    return inverse_axial_partials(m, reference == VR_Z ? 0 : 1, out, fault);
}

/* ---- model exchange: no continuous states, and one event indicator ---- */

bool model_begin_model_exchange(FmuModel *m, Fault *fault) {
    (void)fault; /* always possible */
    m->continuous = true;
    return true;
}

void model_set_states(FmuModel *m, const double x[]) {
    (void)m, (void)x;
}

void model_get_states(const FmuModel *m, double x[]) {
    (void)m, (void)x;
}

bool model_state_derivatives(const FmuModel *m, double derivative[], Fault *fault) {
    (void)m, (void)derivative, (void)fault;
    return true;
}

void model_indicators(const FmuModel *m, double indicator[]) {
    indicator[0] = inverse_indicator(m);
}

unsigned model_state_reference(int state) {
    (void)state; /* there is no continuous state, so nobody calls this function */
    return REFERENCE_END;
}

void model_update_discrete_states(FmuModel *m) {
    if (m->continuous) inverse_settle(m); /* in co-simulation the step does so */
}

bool model_complete_integrator_step(FmuModel *m, double h, Fault *fault) {
    return h <= 0.0 || inverse_advance(m, h, GIVEN_ENDS, fault);
}

/* A new member does not compile before its padding is dealt with here. */
_Static_assert(sizeof(InverseState) ==
                   4 * sizeof(double) + 2 * sizeof(int64_t) + sizeof(Mode) + sizeof(int32_t) + sizeof(Ledger),
               "padding in InverseState");

bool model_state_is_possible(const InverseState *state) {
    return (int)state->mode >= MODE_STICK && (int)state->mode <= MODE_WEDGED && abs(state->direction) == 1 &&
           isfinite(state->theta) && isfinite(state->omega) && isfinite(state->cam) && isfinite(state->F_ext_at_start);
}
