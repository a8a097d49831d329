#include "forward/decide.h"

#include <math.h>

#include "forward/configuration.h"
#include "forward/stick.h"
#include "numerics/sign.h"
#include "platform/attributes.h"

/* ---- does a slip mode agree with itself? ---- */

COMPACT_BEGIN
/* From rest the net torque must point in the direction of the slip, or be zero; a rate has decided then: the torque grows
 * beyond the edge of the stick band. */
static bool starts(const Candidate *candidate, int direction) {
    const double rounding = candidate->tie * candidate->net_size;
    return direction * candidate->net >= (candidate->recedes ? rounding : -rounding);
}

bool begins_with_jump(const Candidate *candidate, int direction) {
    return candidate->regime == REGIME_RATE_INDEPENDENT &&
           direction * candidate->net > candidate->tie * candidate->net_size;
}

/* Is x_i on the flank that the slip mode assumes, or about to be there? Where x_i is zero, its first time derivative
 * decides; where this is zero, the second; where rounding hides that too, the axial load that follows. A contact that
 * stays without load suits either flank. */
static bool flank_agrees(const Candidate *candidate, int direction, int flank, int i) {
    const ContactLoad *c = &candidate->contact[i], *size = &candidate->size[i];
    if (fabs(c->value) > REACTION_ZERO_SHARE * size->value) return flank * c->value > 0.0;
    if (begins_with_jump(candidate, direction)) /* in a jump only the spring's force changes, in proportion to theta */
        return flank * direction * candidate->axial[i] >= 0.0;
    if (fabs(c->rate) > REACTION_ZERO_SHARE * size->rate) return flank * c->rate > 0.0;
    if (fabs(c->second) > REACTION_ZERO_SHARE * size->second) return flank * c->second > 0.0;
    return flank * candidate->ahead[i] >= 0.0;
}

/* Rate-independent slip that does not begin with a jump follows the moving edge of the band, in its own direction. */
static bool follows_edge(const Candidate *candidate, int direction) {
    if (candidate->regime != REGIME_RATE_INDEPENDENT || !(candidate->stiffness > 0.0)) return true;
    return begins_with_jump(candidate, direction) || direction * candidate->omega > 0.0;
}

static bool agrees(const Mechanism *m, int index, const Candidate *candidate, bool at_rest) {
    const int direction = slip_direction(index);
    int flank[2];
    slip_flanks(index, flank);
    if (!candidate->possible) return false;
    if (at_rest && !starts(candidate, direction)) return false;
    if (!follows_edge(candidate, direction)) return false;
    if (!has_friction(&m->params)) return true;
    return flank_agrees(candidate, direction, flank[0], 0) && flank_agrees(candidate, direction, flank[1], 1);
}

/* The sign with which F_ext leaves its value; 0: F_ext is constant. */
static int load_trend(const Mechanism *m) {
    for (int k = 1; k <= INPUT_ORDER; k++)
        if (m->inputs.F_ext[k] != 0.0) return sign_of(m->inputs.F_ext[k]);
    return 0;
}

/* Sign of the axial load when motion in `direction` begins or continues. */
static int load_sign(const Mechanism *m, int direction) {
    const double v = has_inertia(&m->params) ? m->configuration.geometry.dz_dtheta * m->state.omega.hi : 0.0;
    const double force = stick_axial_load(m) + damper_force(&m->params.damper, direction, v);
    if (stick_force_counts(m, force)) return sign_of(force);
    const int trend = load_trend(m);
    if (trend != 0) return trend;
    return m->params.spring.stiffness != 0.0 ? direction : 1;
}

/* Just before a change of flanks a reaction still has the sign of its flank, but counts as zero and falls. The location
 * of this event lies ahead. True if both reactions exceed their rounding. */
static bool is_before_change(int index, const Candidate *candidate) {
    int flank[2];
    slip_flanks(index, flank);
    if (!candidate->possible || !follows_edge(candidate, slip_direction(index))) return false;
    bool before = true;
    for (int i = 0; i < 2; i++)
        before &= flank[i] * candidate->contact[i].value > REACTION_ZERO_SHARE * candidate->rounding[i];
    return before;
}

/* Both reactions can vanish at the same instant, as where one axial load makes both. Just before, the one can count as
 * zero while the other is still on its flank. The location of the event of this other one lies ahead. True if this other
 * one falls to zero within the time in which the first one counts as zero. */
static bool vanish_together(int index, const Candidate *candidate) {
    int flank[2];
    slip_flanks(index, flank);
    if (!candidate->possible || !follows_edge(candidate, slip_direction(index))) return false;
    for (int i = 0; i < 2; i++) {
        const ContactLoad *zero = &candidate->contact[i], *other = &candidate->contact[1 - i];
        const double rounding = REACTION_ZERO_SHARE * candidate->size[i].value, fall = -flank[1 - i] * other->rate;
        const double left = flank[1 - i] * other->value;
        if (!(fabs(zero->value) <= rounding && left > REACTION_ZERO_SHARE * candidate->size[1 - i].value)) continue;
        if (left * fabs(zero->rate) <= VANISH_TOGETHER * rounding * fall) return true;
    }
    return false;
}

/* Toward a dwell the load of a locked contact falls to zero and stays zero, while the other contact bears a load: the rate,
 * which no later load confirms, does not jam the contacts. True if one reaction is rounding and stays so, and the other one
 * agrees with its flank. */
static bool is_unloaded(int index, const Candidate *candidate) {
    int flank[2];
    slip_flanks(index, flank);
    if (!candidate->possible || candidate->unseen[0] == candidate->unseen[1]) return false;
    const int loaded = candidate->unseen[0] ? 1 : 0;
    return flank_agrees(candidate, slip_direction(index), flank[loaded], loaded);
}

/* Do the reactions leave the range of numbers? Then no comparison with them means anything. */
static bool overflows(const Candidate *candidate) {
    bool finite = isfinite(candidate->net);
    for (int i = 0; i < 2; i++) {
        const ContactLoad *c = &candidate->contact[i];
        finite &= isfinite(c->value) && isfinite(c->rate) && isfinite(c->second);
    }
    return candidate->possible && !finite;
}

/* What the search for a slip mode starts from. */
typedef enum {
    FROM_REST,
    FROM_MOTION, /* the mechanism moves, and its flanks are not known */
    FROM_FLANKS, /* the mechanism moves on flanks that do not agree any more */
} SearchStart;

/* Does the pair k of flanks, which agrees, come before those that follow? A stable pair does (candidate.h) whose reactions are
 * its only ones. So does, with inertia and under Coulomb friction, the pair of the flanks that support the axial load: with
 * the reference values of the kinetostatic model (docs/mechanism.md, section 6). */
static bool comes_first(const Mechanism *m, const Candidate *candidate, int k) {
    const bool supports = k == 0 && candidate->regime == REGIME_INERTIAL && !m->model.friction_is_loaded;
    return supports || (candidate->stable && candidate->single);
}

/* The index of the slip mode whose flanks agree, or -1. Of several the first one that comes_first(). Without inertia each
 * pair has a speed of its own; where friction varies with the speed the slowest comes first: a mechanism with hardly any
 * inertia, accelerated from rest by the torque that is left, reaches it first (A. N. Tikhonov's theorem on systems with a
 * small parameter). Where none agrees, from a motion one that is just before a change of flanks or without loads, or one
 * that leaves the range of numbers: the step is then refused in this mode. `searches`: 0 or SLIP_SEARCHES. *built receives the
 * coefficients of the last candidate that had none in the model; mostly this is the slip mode that is found. */
static int find_slip_mode(const Mechanism *m, int direction, SearchStart from, int searches, LinearSlipMode *built) {
    const int sign = load_sign(m, direction);
    int first = -1, before = -1, overflowing = -1, slowest = -1;
    double least = INFINITY;
    const bool slowest_first = !has_inertia(&m->params) && any_friction_varies(&m->params);
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, sign, flank);
        const int index = slip_index(direction, flank) + searches;
        const Candidate candidate = candidate_building(m, index, built);
        if (from == FROM_MOTION && before < 0 && vanish_together(index, &candidate)) before = index;
        const bool unloaded = from != FROM_REST && is_unloaded(index, &candidate);
        if (unloaded && (before < 0 || (from == FROM_FLANKS && index == present_slip_index(m)))) before = index;
        if (overflows(&candidate)) overflowing = index;
        if (!agrees(m, index, &candidate, from == FROM_REST)) continue;
        if (!slowest_first && comes_first(m, &candidate, k)) return index;
        if (candidate.stable && fabs(candidate.omega) < least) {
            slowest = index;
            least = SLOWER * fabs(candidate.omega);
        }
        if (first < 0) first = index;
    }
    if (slowest >= 0) return slowest;
    if (first >= 0) return first;
    return before >= 0 ? before : overflowing;
}
COMPACT_END

/* ---- the decision ---- */

static Mode slip_mode(int direction) {
    return direction > 0 ? MODE_LOADING : MODE_RELEASING;
}

COMPACT_BEGIN
/* Where the load of a contact passes zero, both of its flanks give the same loads and the same acceleration: the motion
 * goes on without a jump if the contact changes its flank and the other contact does not. A contact without load suits
 * either flank, and takes the one that the axial load presses. The index of this slip mode, or -1 where a load that is
 * not zero disagrees with its flank. */
static int slip_across_zero(const Mechanism *m, int present, const Candidate *candidate) {
    const int direction = slip_direction(present);
    int flank[2];
    slip_flanks(present, flank);
    if (!candidate->possible) return -1;
    for (int i = 0; i < 2; i++) {
        const bool agreed = flank_agrees(candidate, direction, flank[i], i);
        if (fabs(candidate->contact[i].value) > REACTION_ZERO_SHARE * candidate->size[i].value) {
            if (!agreed) return -1;
        } else if (!agreed) {
            flank[i] = -flank[i];
        } else if (flank_agrees(candidate, direction, -flank[i], i)) {
            flank[i] = load_sign(m, direction);
        }
    }
    return slip_index(direction, flank);
}

/* Under friction that depends on the load, is each reaction still on its flank, if by no more than rounding, and has the location
 * of events seen none pass zero? A load that fades away never does, though its rate tells the other flank. */
COMPACT static bool has_passed_no_zero(const Mechanism *m, int present, const Candidate *candidate) {
    int flank[2];
    slip_flanks(present, flank);
    bool on_flanks = m->model.friction_is_loaded && candidate->possible;
    for (int i = 0; i < 2; i++) on_flanks &= flank[i] * candidate->contact[i].value >= 0.0 && m->crossed[i] == 0;
    return on_flanks;
}

/* The other flank of a contact without load can have another answer of the balance, with a load. */
COMPACT static bool jumps(const Candidate *candidate, const Candidate *next) {
    bool same = true;
    for (int i = 0; i < 2; i++) {
        const double change = fabs(next->contact[i].value - candidate->contact[i].value);
        same &= change <= LOCATION_LOST_SHARE * candidate->size[i].value;
    }
    return !same;
}

/* Without inertia and damping, where no pair of flanks agrees: F_0 is zero and F_ext lifts F_0 in the direction in which the
 * torque is beyond the band. A contact locks where F_0 has the other sign, so that the motion follows F_0 = 0 (jump.c).
 * The index of the flanks of the coming load, or -1. */
static int unloaded_slip(const Mechanism *m, int direction) {
    const int flank[2] = {direction, direction}, index = slip_index(direction, flank);
    if (!stick_is_unloaded(m) || load_trend(m) != direction) return -1;
    return slip_mode_from_here(m, index).regime == REGIME_RATE_INDEPENDENT ? index : -1;
}
COMPACT_END

/* Does the motion go on along the pair `index`? */
static bool keeps(const Mechanism *m, int index, const Candidate *candidate) {
    return candidate->regime == REGIME_VISCOUS && candidate->stable && slip_direction(index) * candidate->omega > 0.0 &&
           agrees(m, index, candidate, true);
}

/* Without inertia several pairs of flanks can balance the torque, each at its own speed: where friction grows with the speed
 * while the axial load passes zero, or where a contact locks. The motion goes on along its pair as long as this pair
 * agrees, and then along the pair with the same speed. The index of this pair, or -1. */
static int kept_flanks(const Mechanism *m, int direction, LinearSlipMode *built) {
    if (m->state.mode != slip_mode(direction) || has_inertia(&m->params)) return -1;
    const int present = present_slip_index(m);
    const Candidate candidate = candidate_building(m, present, built);
    if (keeps(m, present, &candidate)) return present;
    const int across = candidate.regime == REGIME_VISCOUS ? slip_across_zero(m, present, &candidate) : -1;
    if (across < 0) return -1;
    const Candidate next = candidate_building(m, across, built);
    return keeps(m, across, &next) ? across : -1;
}

/* Rigid contacts stop a motion only where no pair of flanks has an answer. Where friction depends on the load and no pair
 * agrees at the answer of Newton's method, the answers are searched: of the present pair first. */
COMPACT static int find_searched(const Mechanism *m, int direction, SearchStart from, LinearSlipMode *built) {
    const int present = slip_index(direction, m->state.flank) + SLIP_SEARCHES;
    if (from == FROM_FLANKS) {
        const Candidate candidate = candidate_building(m, present, built);
        if (agrees(m, present, &candidate, false)) return present;
    }
    return find_slip_mode(m, direction, from, SLIP_SEARCHES, built);
}

static Decision decide_at_rest(const Mechanism *m, LinearSlipMode *built) {
    const int direction = stick_direction_beyond_band(m);
    if (direction == 0) return (Decision){.mode = stick_mode(m), .slip_index = -1};
    if (direction > 0 && m->state.theta.hi >= m->params.stop.upper)
        return (Decision){.mode = MODE_UPPER_STOP, .slip_index = -1};
    if (direction < 0 && m->state.theta.hi <= m->params.stop.lower)
        return (Decision){.mode = MODE_LOWER_STOP, .slip_index = -1};
    /* The loads of a slip that begins later do not tell the flanks now. */
    if (!stick_excess_grows(m, direction)) return (Decision){.mode = MODE_STICK, .slip_index = -1};
    const int kept = kept_flanks(m, direction, built);
    int index = kept >= 0 ? kept : find_slip_mode(m, direction, FROM_REST, 0, built);
    if (index < 0) index = unloaded_slip(m, direction);
    /* No slip mode agrees, and the torque is on the edge: rounding decides whether it is inside or beyond. */
    if (index < 0 && stick_is_on_edge(m, direction)) return (Decision){.mode = MODE_STICK, .slip_index = -1};
    /* Newton's method can end at another answer than that of the motion which begins. */
    if (index < 0 && m->model.friction_is_loaded && has_inertia(&m->params))
        index = find_searched(m, direction, FROM_REST, built);
    return (Decision){.mode = index < 0 ? MODE_WEDGED : slip_mode(direction), .slip_index = index};
}

/* Contacts without any load have pressed no flank: of several pairs that agree the present one is not the one that goes on. */
static bool is_without_loads(const Mechanism *m, const Candidate *candidate) {
    return has_friction(&m->params) && candidate->contact[0].value == 0.0 && candidate->contact[1].value == 0.0;
}

/* Have torque and axial force gone on from those at the end of the latest step? */
COMPACT static bool inputs_go_on(const Mechanism *m) {
    const Step *step = &m->state.step;
    if (m->moves_on) return true;
    if (!(step->h > 0.0) || step->retuned) return false;
    const InputValues before = input_values_at(&step->inputs, step->h), now = input_values_at(&m->inputs, 0.0);
    return fabs(now.tau - before.tau) <= INPUT_JUMP * (fabs(now.tau) + fabs(before.tau)) &&
           fabs(now.F_ext - before.F_ext) <= INPUT_JUMP * stick_axial_size(m);
}

/* Does a reaction press off its flank by far more than rounding, or is there none? No motion takes it there: Newton's method
 * has lost the reactions (loaded_contacts.h). */
static bool has_lost_reactions(int index, const Candidate *candidate) {
    int flank[2];
    slip_flanks(index, flank);
    bool lost = !candidate->possible;
    for (int i = 0; i < 2; i++)
        lost |= flank[i] * candidate->contact[i].value < -LOCATION_LOST_SHARE * candidate->size[i].value;
    return lost;
}

/* The present slip mode where a motion goes on, under friction that depends on the load, at the reactions that Newton's method
 * has lost; else -1. After a jump of the inputs the reactions may be others. */
COMPACT static int goes_on_at_lost_reactions(const Mechanism *m, int present, const Candidate *candidate,
                                             LinearSlipMode *built) {
    if (!m->model.friction_is_loaded || present >= SLIP_SEARCHES) return -1;
    if (!has_lost_reactions(present, candidate) || !inputs_go_on(m)) return -1;
    const Candidate searched = candidate_building(m, present + SLIP_SEARCHES, built);
    return agrees(m, present, &searched, false) ? present + SLIP_SEARCHES : -1;
}

/* While the mechanism slips, the flanks stay the same as long as they agree with their reactions. Where several pairs
 * agree, the one that continues the motion comes first. */
COMPACT static Decision decide_moving(const Mechanism *m, LinearSlipMode *built) {
    const int direction = sign_of(m->state.omega.hi);
    const Mode mode = slip_mode(direction);
    const bool stays = m->state.mode == mode;
    const bool searches = stays && m->state.searches && inputs_go_on(m);
    const int present = slip_index(direction, m->state.flank) + (searches ? SLIP_SEARCHES : 0);
    const Candidate candidate = candidate_building(m, present, built);
    const bool agreed = agrees(m, present, &candidate, false);
    if (stays && ((agreed && !is_without_loads(m, &candidate)) || is_before_change(present, &candidate)))
        return (Decision){.mode = mode, .slip_index = present};
    const int lost = stays && !agreed ? goes_on_at_lost_reactions(m, present, &candidate, built) : -1;
    if (lost >= 0) return (Decision){.mode = mode, .slip_index = lost};
    const int across = stays && !agreed ? slip_across_zero(m, present, &candidate) : -1;
    if (across >= 0) {
        const Candidate next = candidate_building(m, across, built);
        if (has_passed_no_zero(m, present, &candidate) && jumps(&candidate, &next))
            return (Decision){.mode = mode, .slip_index = present};
        if (next.stable && agrees(m, across, &next, false)) return (Decision){.mode = mode, .slip_index = across};
    }
    const SearchStart from = stays ? FROM_FLANKS : FROM_MOTION;
    int index = find_slip_mode(m, direction, from, 0, built);
    if (index < 0 && stays && (vanish_together(present, &candidate) || has_passed_no_zero(m, present, &candidate)))
        index = present;
    if (index < 0 && m->model.friction_is_loaded) index = find_searched(m, direction, from, built);
    return (Decision){.mode = index < 0 ? MODE_WEDGED : mode, .slip_index = index};
}

static Decision decide(const Mechanism *m, LinearSlipMode *built) {
    return has_inertia(&m->params) && m->state.omega.hi != 0.0 ? decide_moving(m, built) : decide_at_rest(m, built);
}

/* Without inertia, contacts that lock at rest can carry a motion: with friction that varies with the speed, and with friction
 * that grows with the load where dampers carry a part of the load. The decision looks at rest first. But hardly any inertia
 * would keep the present motion (A. N. Tikhonov's theorem). Does the present motion go on where the contacts lock at rest? */
COMPACT static bool rest_and_motion_balance(const Mechanism *m) {
    const int direction = direction_of(m->state.mode);
    LinearSlipMode unused;
    return (any_friction_varies(&m->params) || m->model.friction_is_loaded) &&
           kept_flanks(m, direction, &unused) >= 0 && angle_to_stop(m, direction) > 0.0 && stick_locks(m, direction);
}

/* Without inertia a damper lets the motion toward an edge of the stick band fade away. A step may end at a speed so small
 * that the torque counts as on the edge. The motion goes on until the next step decides. */
COMPACT static bool fades_away(const Mechanism *m, const Decision *decision) {
    const int direction = direction_of(m->state.mode);
    if (decision->mode != MODE_STICK || !(direction * m->state.omega.hi > 0.0)) return false;
    return slip_mode_from_here(m, present_slip_index(m)).regime == REGIME_VISCOUS && stick_is_on_edge(m, direction);
}

/* With an inertia a jam takes the speed. A motion that has a speed at the end of a step has not jammed, even if no pair of flanks
 * carries the reactions from now on. */
COMPACT static bool jams_next(const Mechanism *m, const Decision *decision) {
    return decision->mode == MODE_WEDGED && is_slip(m->state.mode) && has_inertia(&m->params) &&
           m->state.omega.hi != 0.0 && inputs_go_on(m);
}

Decision decision_of(const Mechanism *m) {
    LinearSlipMode storage;
    const Mode mode = m->state.mode;
    const Decision present = {.mode = mode, .slip_index = is_slip(mode) ? present_slip_index(m) : -1};
    if (m->continuous) return present;
    const Decision decision = decide(m, &storage);
    if (is_slip(decision.mode)) return decision;
    const bool goes_on = fades_away(m, &decision) || jams_next(m, &decision) || rest_and_motion_balance(m);
    return goes_on ? present : decision;
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

int slip_mode_of_moving(Mechanism *m, int direction) {
    LinearSlipMode built;
    built.direction = 0;
    const int index = find_slip_mode(m, direction, FROM_MOTION, 0, &built);
    keep_linear_slip(m, &built);
    return index;
}

/* Takes a slip mode that agrees and has a motion. */
static bool take_slip(Mechanism *m, int index) {
    const bool at_rest = !has_inertia(&m->params) || m->state.omega.hi == 0.0;
    if (is_quotient_of_zeros(m, index)) return false;
    const Candidate candidate = candidate_of(m, index);
    if (!candidate.stable || !agrees(m, index, &candidate, at_rest)) return false;
    take_slip_flanks(&m->state, index);
    return true;
}

/* Takes the first pair of flanks other than the present one. */
static bool take_other_flanks(Mechanism *m, int searches) {
    const int present = present_pair_index(m), direction = slip_direction(present), sign = load_sign(m, direction);
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int flank[2];
        flank_pair(k, sign, flank);
        const int index = slip_index(direction, flank);
        if (index != present && take_slip(m, index + searches)) return true;
    }
    return false;
}

bool leave_lost_flanks(Mechanism *m) {
    const bool may_search = m->model.friction_is_loaded && !m->state.searches;
    const int searched = present_pair_index(m) + SLIP_SEARCHES;
    if (may_search && search_goes_on(m, searched) && take_slip(m, searched)) return true;
    if (take_other_flanks(m, 0)) return true;
    if (may_search && take_slip(m, searched)) return true;
    return m->model.friction_is_loaded && take_other_flanks(m, SLIP_SEARCHES);
}

void let_go(Mechanism *m, int direction) {
    for (int sign = 1; sign >= -1; sign -= 2) {
        const int flank[2] = {sign, sign}, index = slip_index(direction, flank);
        if (flank[0] == m->state.flank[0] && flank[1] == m->state.flank[1]) continue; /* the pair that has let go */
        const Candidate candidate = candidate_of(m, index);
        if (!agrees(m, index, &candidate, false)) continue;
        take_slip_flanks(&m->state, index);
        return;
    }
}

static void enter(Mechanism *m, Decision decision) {
    State *state = &m->state;
    if (state->mode != decision.mode) {
        state->events++;
        state->mode = decision.mode;
        m->cache.rest.valid = false;
    }
    if (is_slip(decision.mode)) take_slip_flanks(state, decision.slip_index);
    else if (!has_inertia(&m->params)) state->omega = sum_of(0.0); /* with inertia a jam takes the speed */
}

bool enter_decided_mode(Mechanism *m) {
    LinearSlipMode built;
    built.direction = 0;
    const Decision decision = decide(m, &built);
    keep_linear_slip(m, &built);
    if (!is_slip(decision.mode) && rest_and_motion_balance(m)) return false;
    enter(m, decision);
    return true;
}
