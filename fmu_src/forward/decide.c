#include "forward/decide.h"

#include <string.h>

#include "forward/configuration.h"
#include "forward/stick.h"
#include "numerics/sign.h"

/* ---- does a pair of flanks carry the motion? ---- */

bool begins_with_jump(const Candidate *c, int direction) {
    return c->regime == REGIME_RATE_INDEPENDENT && (!(c->stiffness > 0.0) || direction * c->net > c->rounding);
}

/* From rest alpha (without inertia omega) points along the slip, to rounding. Rate-independent: the torque is beyond
 * the edge of the band, or on it while the edge moves along the slip. */
static bool points_along(const Candidate *c, int direction) {
    if (c->regime != REGIME_RATE_INDEPENDENT) return direction * c->motion >= -c->rounding;
    return begins_with_jump(c, direction) || (direction * c->net >= -c->rounding && direction * c->motion >= 0.0);
}

/* Each reaction presses on its flank, to rounding. Without friction both flanks are one: `x` and `size` are zero. */
static bool bears_on(const Candidate *c, const int flank[2]) {
    return flank[0] * c->x[0] >= -REACTION_ZERO_SHARE * c->size[0] &&
           flank[1] * c->x[1] >= -REACTION_ZERO_SHARE * c->size[1];
}

/* Does this slip carry the motion? `possible`: D/Delta > 0. Without inertia each decision is one from rest. */
static bool carries(const Mechanism *m, int index) {
    const int direction = slip_direction(index);
    int flank[2];
    slip_flanks(index, flank);
    const Candidate c = candidate_of(m, index);
    const bool starts = c.regime != REGIME_INERTIAL || m->state.omega.hi == 0.0;
    return c.possible && bears_on(&c, flank) && !(starts && !points_along(&c, direction));
}

/* ---- the rule ---- */

/* The sign of the axial load when motion in `direction` begins or goes on; where there is none now, of the load that
 * F_ext makes next, or else of the spring's, which has the sign of the movement. */
static int load_sign(const Mechanism *m, int direction) {
    const double v = has_inertia(&m->params) ? m->configuration.geometry.dz_dtheta * m->state.omega.hi : 0.0;
    const double force = stick_axial_load(m) + damper_force(&m->params.damper, direction, v);
    if (stick_force_counts(m, force)) return sign_of(force);
    for (int k = 1; k <= INPUT_ORDER; k++)
        if (m->inputs.F_ext[k] != 0.0) return sign_of(m->inputs.F_ext[k]);
    return direction;
}

static Mode slip_mode(int direction) {
    return direction > 0 ? MODE_LOADING : MODE_RELEASING;
}

/* The slip on pair k of the rule, see flank_pair(). */
static int slip_of_rule(int direction, int k, int sign) {
    int flank[2];
    flank_pair(k, sign, flank);
    return slip_index(direction, flank);
}

/* The slip `first`, -1: none, then that on the pair that supports the axial load, with contact 2 on its other flank,
 * with contact 1 on its other flank, on the opposite pair; not those that a reaction's zero has ended at this place. */
static Decision slip_or_wedge(const Mechanism *m, int direction, int first) {
    const int sign = load_sign(m, direction);
    unsigned tried = m->ended_slips;
    for (int k = first < 0 ? 0 : -1; k < FLANK_PAIR_COUNT; k++) {
        const int index = k < 0 ? first : slip_of_rule(direction, k, sign);
        if (tried >> index & 1u) continue;
        if (carries(m, index)) return (Decision){slip_mode(direction), index};
        tried |= 1u << index;
    }
    return (Decision){MODE_WEDGED, -1};
}

/* The first slip whose reactions x_i = axial_i A press on its flanks under a load A of this sign, or else `otherwise`.
 * */
static int slip_under(const Mechanism *m, int direction, int sign, int otherwise) {
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, sign, flank);
        const Candidate c = candidate_of(m, slip_index(direction, flank));
        const bool agrees = flank[0] * sign * c.axial[0] >= 0.0 && flank[1] * sign * c.axial[1] >= 0.0;
        if (c.possible && agrees) return slip_index(direction, flank);
    }
    return otherwise;
}

/* The slip that follows the present one: the flank turns whose reaction has just passed zero; where the axial load has
 * passed zero, and with it both, the pair that carries the load of the other sign. */
static int next_slip(const Mechanism *m, int direction) {
    int flank[2];
    for (int i = 0; i < 2; i++) flank[i] = m->crossed[i] ? -m->state.flank[i] : m->state.flank[i];
    const int turned = slip_index(direction, flank);
    if (!m->crossed[0] || !m->crossed[1]) return turned;
    const Candidate present = candidate_of(m, present_slip_index(m));
    const int i = present.axial[0] != 0.0 ? 0 : 1;
    const int coming_load = flank[i] * sign_of(present.axial[i]);
    return slip_under(m, direction, coming_load, turned);
}

/* Slip goes on with its pair, or the next one. From any other mode the pair that supports the axial load comes first.
 * */
static Decision slip_on(const Mechanism *m, int direction) {
    const bool goes_on = m->state.mode == slip_mode(direction);
    return slip_or_wedge(m, direction, goes_on ? next_slip(m, direction) : -1);
}

int slip_after_impact(const Mechanism *m, int direction) {
    return slip_or_wedge(m, direction, -1).slip_index;
}

/* ---- the decision ---- */

/* Inside the band: stick, or wedged. Beyond: a stop, slip, or wedged where no pair carries. */
static Decision decide_at_rest(const Mechanism *m) {
    const int direction = stick_direction_beyond_band(m);
    if (direction == 0) return (Decision){stick_mode(m), -1};
    if (angle_to_stop(m, direction) <= 0.0) return (Decision){direction > 0 ? MODE_UPPER_STOP : MODE_LOWER_STOP, -1};
    return slip_on(m, direction);
}

static Decision decide(const Mechanism *m) {
    const bool moves = has_inertia(&m->params) && m->state.omega.hi != 0.0;
    return moves ? slip_on(m, sign_of(m->state.omega.hi)) : decide_at_rest(m);
}

/* In model exchange modes change at events alone. */
static bool is_decided(const Mechanism *m) {
    return m->continuous ||
           (m->cache.is_decided && memcmp(&m->cache.decided, &m->inputs, sizeof m->cache.decided) == 0);
}

Decision decision_of(const Mechanism *m) {
    if (!is_decided(m)) return decide(m);
    return (Decision){m->state.mode, is_slip(m->state.mode) ? present_slip_index(m) : -1};
}

/* ---- entering a mode ---- */

static void enter(Mechanism *m, Decision decision) {
    State *state = &m->state;
    if (state->mode != decision.mode) {
        state->events++;
        state->mode = decision.mode;
        m->cache.rest.valid = false;
    }
    if (is_slip(decision.mode)) slip_flanks(decision.slip_index, state->flank);
    else if (!has_inertia(&m->params)) state->omega = sum_of(0.0); /* with inertia a jam takes the speed */
    m->cache.decided = m->inputs;
    m->cache.is_decided = true;
}

void enter_decided_mode(Mechanism *m) {
    const Decision decision = decide(m);
    m->crossed[0] = m->crossed[1] = false;
    enter(m, decision);
}
