#include <math.h>
#include <stdlib.h>

#include "fmi/variables.h"
#include "forward/configuration.h"
#include "forward/step.h"
#include "outputs/outputs.h"
#include "sensitivity/sensitivity.h"
#include "sensitivity/step_sensitivity.h"

bool model_advance(FmuModel *m, double h, unsigned derivatives_given, Watcher *watcher, Fault *fault) {
    (void)derivatives_given; /* derivatives that are not given are zero */
    return mechanism_advance(m, h, watcher, fault);
}

void model_clear_input_derivatives(Inputs *inputs) {
    for (int order = 1; order <= INPUT_ORDER; order++) {
        inputs->tau[order] = 0.0;
        inputs->F_ext[order] = 0.0;
    }
}

bool model_outputs(const FmuModel *m, unsigned groups, Outputs *outputs, Fault *fault) {
    (void)fault; /* the outputs exist in every state */
    if (groups & GROUP_MOTION) mechanism_motion(m, &outputs->motion);
    if (groups & (GROUP_LOADS | GROUP_CONTACT)) mechanism_loads(m, &outputs->loads);
    if (groups & GROUP_ENERGY) mechanism_energy(m, &outputs->energy);
    if (groups & GROUP_AUDIT) mechanism_audit(m, &outputs->audit);
    if (groups & GROUP_STEP) step_sensitivity(m, false, &outputs->step);
    if (groups & GROUP_STEP_PARAMETERS) step_sensitivity(m, true, &outputs->step);
    return true;
}

double model_output_derivative(const FmuModel *m, unsigned reference, int order) {
    MotionDerivatives derivatives;
    motion_derivatives(m, &derivatives);
    switch (reference) {
        case VR_THETA: return derivatives.theta[order - 1];
        case VR_OMEGA: return derivatives.theta[order];
        case VR_Z: return derivatives.z[order - 1];
        default: return derivatives.z[order];
    }
}

int model_known(unsigned reference) {
    switch (reference) {
        case VR_THETA: return KNOWN_THETA;
        case VR_OMEGA: return KNOWN_OMEGA;
        case VR_TAU: return KNOWN_TAU;
        case VR_F_EXT: return KNOWN_F_EXT;
        default: return tunable_known(reference);
    }
}

int model_unknown(unsigned reference) {
    switch (reference) {
        case VR_THETA: return 0;
        case VR_OMEGA: return 1;
        case VR_ALPHA: return 2;
        case VR_Z: return 3;
        case VR_V: return 4;
        default: return -1;
    }
}

/* Angle and speed are states: each depends on itself alone. */
bool model_partials(const FmuModel *m, unsigned reference, Partials *out, Fault *fault) {
    switch (reference) {
        case VR_THETA: *out = (Partials){.by = {[KNOWN_THETA] = 1.0}}; return true;
        case VR_OMEGA: *out = (Partials){.by = {[KNOWN_OMEGA] = 1.0}}; return true;
        case VR_Z: mechanism_axial_partials(m, 0, out); return true;
        case VR_V: mechanism_axial_partials(m, 1, out); return true;
        default: return mechanism_alpha_partials(m, out, fault);
    }
}

/* ---- model exchange ---- */

bool model_begin_model_exchange(FmuModel *m, Fault *fault) {
    if (!ode_is_possible(m, fault)) return false;
    m->continuous = true;
    return true;
}

void model_set_states(FmuModel *m, const double x[]) {
    ode_set_states(m, x);
}

void model_get_states(const FmuModel *m, double x[]) {
    ode_get_states(m, x);
}

bool model_state_derivatives(const FmuModel *m, double derivative[], Fault *fault) {
    return ode_rates(m, derivative, fault);
}

void model_indicators(const FmuModel *m, double indicator[]) {
    ode_indicators(m, indicator);
}

unsigned model_state_reference(int state) {
    return state == 0 ? VR_THETA : VR_OMEGA;
}

void model_update_discrete_states(FmuModel *m) {
    mechanism_settle(m);
}

bool model_complete_integrator_step(FmuModel *m, double h, Fault *fault) {
    (void)m, (void)h, (void)fault; /* the states hold everything already */
    return true;
}

static bool is_mode(Mode mode) {
    return (int)mode >= MODE_STICK && (int)mode <= MODE_WEDGED;
}

static bool are_flanks(const int flank[2]) {
    return abs(flank[0]) <= 1 && abs(flank[1]) <= 1;
}

/* The latest step is computed again for its derivatives; without a step its mode is 0. */
bool model_state_is_possible(const State *state) {
    const Step *step = &state->step;
    return is_mode(state->mode) && are_flanks(state->flank) && (is_mode(step->mode) || step->mode == 0) &&
           are_flanks(step->flank) && isfinite(state->theta.hi) && isfinite(state->omega.hi) &&
           isfinite(step->theta.hi) && isfinite(step->omega.hi) && isfinite(state->F_ext_at_start) && step->h >= 0.0 &&
           isfinite(step->h);
}

/* Equal states have equal bytes: no padding. */
_Static_assert(sizeof(Step) == 2 * sizeof(Sum) + sizeof(Inputs) + 2 * sizeof(double) + sizeof(Mode) + 3 * sizeof(int),
               "padding in Step");
_Static_assert(offsetof(State, ledger) ==
                   2 * sizeof(Sum) + 2 * sizeof(double) + sizeof(int64_t) + sizeof(Mode) + 3 * sizeof(int),
               "padding in State");
_Static_assert(sizeof(Tunables) == 16 * sizeof(double) + sizeof(SpringParams) + sizeof(DamperParams),
               "padding in Tunables");
_Static_assert(sizeof(State) == offsetof(State, ledger) + sizeof(Ledger) + sizeof(Step) + sizeof(Tunables),
               "padding in State");
