#include "outputs/ode.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "elementary/elementary.h"
#include "forward/configuration.h"
#include "forward/decide.h"
#include "forward/stick.h"
#include "numerics/tolerances.h"

bool ode_is_possible(const Mechanism *m, Fault *fault) {
    if (has_inertia(&m->params)) return true;
    snprintf(fault->text, sizeof fault->text,
             "model exchange needs inertia, without it the speed is no state: allowed is inertia.shaft, "
             "inertia.follower_mass or inertia.follower > 0 (co-simulation needs none)");
    return false;
}

void ode_set_states(Mechanism *m, const double x[ODE_STATES]) {
    const Transmission *transmission = &m->model.transmission;
    const TransmissionPiece *first = &transmission->piece[0], *last = &transmission->piece[transmission->count - 1];
    const double lower = m->params.stop.lower - SOLVER_OVERSHOOT * (first->upper - first->lower);
    const double upper = m->params.stop.upper + SOLVER_OVERSHOOT * (last->upper - last->lower);
    m->state.theta = sum_of(min_of(max_of(x[0], lower), upper));
    m->state.omega = sum_of(x[1]);
    update_configuration(m);
}

void ode_get_states(const Mechanism *m, double x[ODE_STATES]) {
    x[0] = m->state.theta.hi;
    x[1] = m->state.omega.hi;
}

bool ode_rates(const Mechanism *m, double rate[ODE_STATES], Fault *fault) {
    rate[0] = m->state.omega.hi;
    rate[1] = 0.0;
    const Decision now = decision_of(m);
    if (!is_slip(now.mode)) return true;
    const SlipMode slip = slip_mode_from_here(m, now.slip_index);
    const Balance balance = balance_from_here(m, &slip);
    if (balance.rhs.possible && isfinite(balance.alpha)) {
        rate[1] = balance.alpha;
        return true;
    }
    snprintf(fault->text, sizeof fault->text,
             "theta = %s, omega = %s, tau = %s: friction jams the motion; allowed is a geometry in which the "
             "inertia felt is positive",
             shortest_decimal(m->state.theta.hi).text, shortest_decimal(m->state.omega.hi).text,
             shortest_decimal(m->inputs.tau[0]).text);
    return false;
}

/* At rest: the torque from tau to an edge of the band, N.m, in the direction `sign`. pressed: tau is beyond
 * this edge already, and a stop holds cam 2. */
static double way_to_edge(const Mechanism *m, double factor, double sign, bool pressed) {
    if (isinf(factor)) return 1.0;
    const double late = LATE_TIES * stick_tie(m) * stick_torque_size(m, factor);
    const double slip = sign * (stick_edge(factor, stick_axial_load(m)) - m->inputs.tau[0]);
    return pressed ? slip - late : slip + late;
}

static void indicate_rest(const Mechanism *m, double indicator[ODE_INDICATORS]) {
    const BandFactors f = stick_edges(m, stick_axial_load(m));
    indicator[INDICATOR_LOAD] = way_to_edge(m, f.load, 1.0, m->state.mode == MODE_UPPER_STOP);
    indicator[INDICATOR_RELEASE] = way_to_edge(m, f.release, -1.0, m->state.mode == MODE_LOWER_STOP);
}

static void indicate_slip(const Mechanism *m, int index, double indicator[ODE_INDICATORS]) {
    const double theta = m->state.theta.hi;
    const int direction = slip_direction(index);
    indicator[INDICATOR_VELOCITY] = direction * m->state.omega.hi + LATE_SPEED;
    if (direction > 0) indicator[INDICATOR_UPPER] = m->params.stop.upper - theta;
    if (direction < 0) indicator[INDICATOR_LOWER] = theta - m->params.stop.lower;
    if (!has_friction(&m->params)) return;
    const SlipMode slip = slip_mode_from_here(m, index);
    const Balance balance = balance_from_here(m, &slip);
    double size[2];
    balance_contact_sizes(&slip, &balance, size);
    for (int i = 0; i < 2; i++) {
        const double late = LATE_LOADS * size[i] + DBL_MIN; /* without any load the flank does not matter */
        indicator[INDICATOR_FLANK_1 + i] = slip.flank[i] * balance.x[i] + late;
    }
}

void ode_indicators(const Mechanism *m, double indicator[ODE_INDICATORS]) {
    for (int i = 0; i < ODE_INDICATORS; i++) indicator[i] = 1.0;
    const Decision now = decision_of(m);
    if (is_slip(now.mode)) {
        indicate_slip(m, now.slip_index, indicator);
    } else {
        indicate_rest(m, indicator);
    }
    for (int i = 0; i < ODE_INDICATORS; i++) /* the sign is what counts */
        if (isinf(indicator[i])) indicator[i] = copysign(DBL_MAX, indicator[i]);
}
