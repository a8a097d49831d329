#include "forward/decide.h"

#include <math.h>
#include <string.h>

#include "forward/configuration.h"
#include "forward/stick.h"
#include "numerics/sign.h"

/* ---- does a pair of flanks carry the motion? ---- */

bool begins_with_jump(const Candidate *c, int direction) {
    return c->regime == REGIME_RATE_INDEPENDENT && (!(c->stiffness > 0.0) || direction * c->net > c->rounding);
}

/* From rest the motion points along the slip, to rounding. Along a moving edge of the band only in its direction. */
static bool points_along(const Candidate *c, int direction) {
    if (c->regime != REGIME_RATE_INDEPENDENT) return direction * c->motion >= -c->rounding;
    return begins_with_jump(c, direction) || (direction * c->net >= -c->rounding && direction * c->motion >= -c->still);
}

static bool bears_on(const Candidate *c, const int flank[2]) {
    return flank[0] * c->x[0] >= -REACTION_ZERO_SHARE * c->size[0] &&
           flank[1] * c->x[1] >= -REACTION_ZERO_SHARE * c->size[1];
}

/* Does the pair of flanks carry the motion in `direction`? */
static bool carries(const Mechanism *m, int direction, const int flank[2], LinearSlipMode *built) {
    const Candidate c = candidate_building(m, slip_index(direction, flank), built);
    const bool starts = c.regime != REGIME_INERTIAL || m->state.omega.hi == 0.0;
    return c.possible && bears_on(&c, flank) && !(starts && !points_along(&c, direction));
}

/* ---- the rule ---- */

/* The sign of the axial load when motion in `direction` begins or goes on; where there is none now, of the load that F_ext or
 * the spring makes next. */
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

/* The pair `first`, then the pair that supports the axial load, its neighbours, the opposite pair. */
static Decision slip_or_wedge(const Mechanism *m, int direction, const int first[2], LinearSlipMode *built) {
    const bool is_left = m->left_slips >> slip_index(direction, first) & 1u;
    if (!is_left && carries(m, direction, first, built))
        return (Decision){slip_mode(direction), slip_index(direction, first)};
    const int sign = load_sign(m, direction);
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, sign, flank);
        if ((flank[0] == first[0] && flank[1] == first[1]) || (m->left_slips >> slip_index(direction, flank) & 1u))
            continue;
        if (carries(m, direction, flank, built)) return (Decision){slip_mode(direction), slip_index(direction, flank)};
    }
    return (Decision){MODE_WEDGED, -1};
}

/* The first pair that carries an axial load of this sign: x_i = axial_i A. Where a contact locks, the other one bears on its other
 * flank. Leaves *flank where there is none. */
static void find_pair_for(const Mechanism *m, int direction, int sign, LinearSlipMode *built, int flank[2]) {
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int pair[2];
        flank_pair(k, sign, pair);
        const Candidate c = candidate_building(m, slip_index(direction, pair), built);
        if (!c.possible || pair[0] * sign * c.axial[0] < 0.0 || pair[1] * sign * c.axial[1] < 0.0) continue;
        for (int i = 0; i < 2; i++) flank[i] = pair[i];
        return;
    }
}

/* The pair that follows the present one: the flank turns whose reaction has just passed zero; where the axial load has passed
 * zero, and with it both, the pair that carries the load of the other sign. */
static void find_next_pair(const Mechanism *m, int direction, LinearSlipMode *built, int flank[2]) {
    for (int i = 0; i < 2; i++) flank[i] = m->crossed[i] ? -m->state.flank[i] : m->state.flank[i];
    if (!m->crossed[0] || !m->crossed[1]) return;
    const Candidate present = candidate_building(m, slip_index(direction, m->state.flank), built);
    const int i = present.axial[0] != 0.0 ? 0 : 1;
    find_pair_for(m, direction, -m->state.flank[i] * sign_of(present.axial[i]), built, flank);
}

/* Where the mechanism has not slipped in this direction before, the pair that supports the axial load comes first. */
static Decision slip_on(const Mechanism *m, int direction, LinearSlipMode *built) {
    int flank[2];
    if (m->state.mode == slip_mode(direction)) find_next_pair(m, direction, built, flank);
    else flank_pair(0, load_sign(m, direction), flank);
    return slip_or_wedge(m, direction, flank, built);
}

/* ---- the decision ---- */

static Decision decide_at_rest(const Mechanism *m, LinearSlipMode *built) {
    const int direction = stick_direction_beyond_band(m);
    if (direction == 0) return (Decision){stick_mode(m), -1};
    if (angle_to_stop(m, direction) <= 0.0) return (Decision){direction > 0 ? MODE_UPPER_STOP : MODE_LOWER_STOP, -1};
    return slip_on(m, direction, built);
}

static Decision decide(const Mechanism *m, LinearSlipMode *built) {
    const bool moves = has_inertia(&m->params) && m->state.omega.hi != 0.0;
    return moves ? slip_on(m, sign_of(m->state.omega.hi), built) : decide_at_rest(m, built);
}

static bool is_decided(const Mechanism *m) {
    return m->continuous ||
           (m->cache.is_decided && memcmp(&m->cache.decided, &m->inputs, sizeof m->cache.decided) == 0);
}

Decision decision_of(const Mechanism *m) {
    LinearSlipMode storage;
    if (!is_decided(m)) return decide(m, &storage);
    return (Decision){m->state.mode, is_slip(m->state.mode) ? present_slip_index(m) : -1};
}

/* ---- entering a mode ---- */

/* Keeps coefficients of the closed form in the model; direction 0: there are none. */
static void keep_linear_slip(Mechanism *m, const LinearSlipMode *built) {
    if (built->direction == 0) return;
    const int index = slip_index(built->direction, built->flank);
    m->model.linear_slip[index] = *built;
    m->model.linear_slips |= 1u << index;
}

void build_linear_slip(Mechanism *m, int index) {
    LinearSlipMode built;
    keep_linear_slip(m, linear_slip_of(m, index, &built));
}

int slip_after_impact(Mechanism *m, int direction) {
    LinearSlipMode built;
    int flank[2];
    built.direction = 0;
    flank_pair(0, load_sign(m, direction), flank);
    const Decision decision = slip_or_wedge(m, direction, flank, &built);
    keep_linear_slip(m, &built);
    return decision.slip_index;
}

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
    LinearSlipMode built;
    built.direction = 0;
    const Decision decision = decide(m, &built);
    keep_linear_slip(m, &built);
    m->crossed[0] = m->crossed[1] = false;
    enter(m, decision);
}
