#include "fmi/variables.h"
#include "sensitivity/inverse_derivatives.h"
#include "sensitivity/inverse_sensitivity.h"

bool model_start(Machine *m, Fault *fault) {
    return inverse_start(m, fault);
}

bool model_rebuild(Machine *m, Fault *fault) {
    return inverse_rebuild(m, fault);
}

bool model_retune(Machine *m, const Params *params, Fault *fault) {
    return inverse_retune(m, params, fault);
}

void model_free(Machine *m) {
    inverse_free(m);
}

static GivenInput given_by(unsigned with_rates) {
    if (with_rates >> VR_THETA & 1u) return GIVEN_THETA;
    if (with_rates >> VR_OMEGA & 1u) return GIVEN_OMEGA;
    return with_rates >> VR_ALPHA & 1u ? GIVEN_ALPHA : GIVEN_ENDS;
}

bool model_advance(Machine *m, double h, unsigned with_rates, Fault *fault) {
    return inverse_advance(m, h, given_by(with_rates), fault);
}

bool model_advance_watched(Machine *m, double h, unsigned with_rates, Watcher *watcher, Fault *fault) {
    const Mode before = m->state.mode;
    if (!model_advance(m, h, with_rates, fault)) return false;
    if (m->state.mode != before) (void)watcher->changed(watcher, 0.0);
    return true;
}

void model_forget_rates(InverseInputs *inputs) {
    *inputs = (InverseInputs){
        .theta = {inputs->theta[0]},
        .omega = {inputs->omega[0]},
        .alpha = {inputs->alpha[0]},
        .F_ext = {inputs->F_ext[0]},
    };
}

bool model_outputs(const Machine *m, unsigned groups, InverseOutputs *outputs, Fault *fault) {
    if ((groups & GROUP_MOTION) && !inverse_motion(m, &outputs->motion, fault)) return false;
    if ((groups & GROUP_LOADS) && !inverse_loads(m, &outputs->loads, fault)) return false;
    if ((groups & GROUP_CONTACT) && !inverse_contact(m, &outputs->contact, fault)) return false;
    if (groups & GROUP_ENERGY) inverse_energy(m, &outputs->energy);
    if (groups & GROUP_AUDIT) inverse_audit(m, &outputs->audit);
    return true;
}

double model_output_derivative(const Machine *m, unsigned reference, int order) {
    InverseDerivatives rates;
    inverse_derivatives(m, &rates);
    switch (reference) {
        case VR_TAU: return rates.tau[order - 1];
        case VR_Z: return rates.z[order - 1];
        default: return rates.z[order];
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

int model_row(unsigned reference) {
    switch (reference) {
        case VR_TAU: return 0;
        case VR_Z: return 1;
        case VR_V: return 2;
        default: return -1;
    }
}

bool model_partials(const Machine *m, unsigned reference, Partials *out, Fault *fault) {
    if (reference == VR_TAU) return inverse_torque_partials(m, out, fault);
    return inverse_axial_partials(m, reference == VR_Z ? 0 : 1, out, fault);
}

/* ---- model exchange: no continuous states, and one event indicator ---- */

bool model_begin_exchange(Machine *m, Fault *fault) {
    (void)fault; /* it always can */
    m->continuous = true;
    return true;
}

void model_set_states(Machine *m, const double x[]) {
    (void)m, (void)x;
}

void model_get_states(const Machine *m, double x[]) {
    (void)m, (void)x;
}

bool model_state_rates(const Machine *m, double rate[], Fault *fault) {
    (void)m, (void)rate, (void)fault;
    return true;
}

void model_indicators(const Machine *m, double indicator[]) {
    indicator[0] = inverse_indicator(m);
}

unsigned model_state_reference(int state) {
    (void)state; /* there is none: nobody calls it */
    return VARIABLE_COUNT;
}

bool model_settle(Machine *m, Fault *fault) {
    (void)fault;
    if (m->continuous) inverse_settle(m); /* a step does it itself */
    return true;
}

bool model_accept(Machine *m, double h, Fault *fault) {
    return h <= 0.0 || inverse_advance(m, h, GIVEN_ENDS, fault);
}

/* A new member fails here until its padding is looked at. */
_Static_assert(sizeof(InverseState) ==
                   3 * sizeof(double) + sizeof(int64_t) + sizeof(Mode) + sizeof(int32_t) + sizeof(Ledger),
               "padding in InverseState");

void model_clear_padding(InverseState *state) {
    (void)state; /* there is none */
}
