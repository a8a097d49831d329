#include "collocation/lobatto_step.h"

#include <math.h>
#include <stddef.h>

#include "collocation/breakpoint.h"
#include "collocation/lobatto_peaks.h"
#include "collocation/lobatto_system.h"
#include "collocation/step_energy.h"
#include "elementary/elementary.h"
#include "model/elements.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- friction ---- */

/* Does the sliding speed of contact i stay on its piece of the friction table? */
static bool stays_on_piece(const LobattoSystem *s, int i) {
    LobattoValues v;
    for (int k = 0; k < LOBATTO_HALVES; k++) v.half[k] = s->speed.half[k] * s->pair[k].sliding[i];
    const LobattoRange range = lobatto_range(&v);
    return range.low >= s->lowest[i] && range.high <= s->highest[i];
}

/* N, the nominal loads of contact i at the nodes, with the sign of F. */
static LobattoValues signed_loads(const LobattoSystem *s, int i) {
    const double per_sliding = slip_load_per_sliding(s->slip, i);
    LobattoValues load;
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        const NodePair *n = &s->pair[k];
        load.half[k] = per_sliding * ((n->force + n->damper) * vector2_abs(n->sliding[i]));
    }
    return load;
}

/* Does the nominal load of contact i stay between two loads of its table, or pass one no farther than a step may? */
static bool stays_on_patch(const LobattoSystem *s, int i) {
    const FrictionTable *table = s->slip->law[i].table;
    const LobattoValues load = signed_loads(s, i);
    const LobattoRange signed_range = lobatto_range(&load);
    if (signed_range.low * signed_range.high < 0.0) return false;
    const double from = fabs(load.at[0]), ends[2] = {fabs(signed_range.low), fabs(signed_range.high)};
    const LobattoRange range = {min_of(ends[0], ends[1]), max_of(ends[0], ends[1])};
    const KnotCell cell =
        friction_table_cell(table->load, table->loads, curve_interval(table->load, 1, table->loads + 1, from));
    const bool up = range.high - from > from - range.low;
    const KnotSteps step = knot_steps(&cell, &cell, s->slip->law[i].fall.overshoot, (Vector2){from, from}, up);
    const double ahead = up ? range.high - from : from - range.low, back = up ? from - range.low : range.high - from;
    return ahead <= step.longest[0] && back <= step.back[0];
}

/* Where friction varies: does it change little enough over the step to be seen by the nodes? */
static bool resolves_friction(const LobattoSystem *s) {
    const LobattoRange range = lobatto_range(&s->speed);
    for (int i = 0; i < 2; i++) {
        if (s->law[i]->has_table) {
            if (!stays_on_piece(s, i) || (s->patch[i] != NULL && !stays_on_patch(s, i))) return false;
            continue;
        }
        const FrictionFall *fall = &s->slip->law[i].fall;
        if (fall->low != 0.0) {
            const LobattoValues load = signed_loads(s, i);
            const LobattoRange loads = lobatto_range(&load);
            if (friction_load_share(fall, loads.low, loads.high) < 1.0) return false;
        }
        const double sliding = s->pair[0].sliding[i][0], v[2] = {range.low * sliding, range.high * sliding};
        const double low = v[0] < v[1] ? v[0] : v[1], high = v[0] < v[1] ? v[1] : v[0];
        if (!friction_is_resolved(fall, s->speed.at[0] * sliding, low, high)) return false;
    }
    return true;
}

/* ---- contacts and ledger ---- */

/* The contacts at the nodes, and work and heat over the step. */
typedef struct {
    LobattoValues x[2];        /* N/m, R_i/hypot(r_i, a_i) */
    LobattoValues reaction[2]; /* N, R_i, total */
    Booking booking;
} NodeLoads;

/* Adds the work, the heat and the contact loads of node pair k. A node's share of the integrals over theta and z is the
 * node's weight times h omega and h v. */
static void add_node_loads(const LobattoSystem *s, int k, NodeLoads *out) {
    const SlipMode *slip = s->slip;
    const NodePair *n = &s->pair[k];
    const Vector2 omega = s->speed.half[k], v = n->dz_dtheta * omega;
    const Vector2 dtheta = s->h * LOBATTO.weight.half[k] * omega;
    const Vector2 dz = s->h * LOBATTO.weight.half[k] * v;
    const NodeForces forces = lobatto_node_forces(s, k);
    Booking *b = &out->booking;
    b->work_in += lobatto_sum(s->tau.half[k] * dtheta);
    b->work_ext += lobatto_sum(s->F_ext.half[k] * dz);
    b->heat_damper += lobatto_sum(n->damper * dz);
    b->heat_shaft += slip->params->shaft.damping * lobatto_sum(omega * dtheta);
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius;
        const Vector2 length2 = r * r + n->slope[i] * n->slope[i];
        const Vector2 x = lobatto_node_contact(n, &forces, i);
        out->x[i].half[k] = x;
        out->reaction[i].half[k] = x * (Vector2){sqrt(length2[0]), sqrt(length2[1])};
        const Vector2 sliding = x * length2 * n->dpsi_dtheta[i] * dtheta; /* times the sign of x_i */
        b->heat_cam[i] += slip->friction_varies ? lobatto_sum(n->friction[i] * sliding)
                                                : slip->signed_friction[i] * lobatto_sum(sliding);
        if (has_wear(slip->params))
            b->wear[i] += wear_per_sliding(slip->params, i) * slip->direction * slip->flank[i] * lobatto_sum(sliding);
    }
}

static inline double kinetic_energy(const LobattoSystem *s, int node) {
    const NodePair *n = &s->pair[node / 2];
    if (!lobatto_system_is_inertial(s)) return 0.0;
    const int k = node % 2;
    return kinetic_energy_of(&s->slip->params->inertia, n->dz_dtheta[k], n->dpsi_dtheta[0][k], s->speed.at[node]);
}

static bool keeps_energy(const LobattoSystem *s, const Booking *b, double *gained) {
    const NodePair *first = &s->pair[0], *last = &s->pair[LOBATTO_HALVES - 1];
    const EnergyEnds ends = {
        .z = {first->z[0], last->z[1] + last->dz_dtheta[1] * s->end_shift},
        .kinetic = {kinetic_energy(s, 0), kinetic_energy(s, LOBATTO_END)},
        .spring_force = first->force[0] - s->F_ext.at[0],
        .tau = s->tau.at[LOBATTO_END],
    };
    const EnergyBalance energy = step_energy_balance(s->slip, b, &ends);
    *gained = energy.gained;
    return energy.error <= 1.0;
}

/* True if each contact bears on its flank by more than rounding at the start, and stays on it throughout. */
static bool stays_on_flanks(const LobattoSystem *s, const NodeLoads *loads) {
    const SlipMode *slip = s->slip;
    const NodePair *n = &s->pair[0];
    const double load = balance_load_size(slip->params, n->force[0], n->damper[0], n->dz_dtheta[0] * s->y.at[0]);
    for (int i = 0; i < 2; i++) {
        const LobattoValues *x = &loads->x[i];
        if (!balance_is_firm(slip, i, x->at[0], n->factors.rn[1 - i][0] / n->factors.delta[0], load)) return false;
        if (!lobatto_keeps_sign(x, slip->flank[i])) return false;
    }
    return true;
}

/* Without inertia: does the spring's load stay on the flanks of the contacts? Else the torque can come back into the
 * stick band while the mechanism moves. */
static bool stays_on_spring_flanks(const LobattoSystem *s) {
    if (s->slip->regime != REGIME_VISCOUS) return true;
    bool stays = true;
    for (int k = 0; k < LOBATTO_HALVES; k++)
        for (int i = 0; i < 2; i++) stays &= s->slip->flank[0] * s->pair[k].force[i] > 0.0;
    return stays;
}

/* ---- peaks ---- */

/* True if |v| is largest at an end of the step, or does not exceed what is known. */
static bool peaks_at_end(const LobattoValues *v, double known) {
    const LobattoRange r = lobatto_range(v);
    if (lobatto_largest(r) + BEYOND_NODES * (r.high - r.low) <= known) return true;
    const LobattoValues c = lobatto_combine(LOBATTO.bernstein, v);
    const double a = c.at[1] - c.at[0], b = c.at[2] - c.at[1], d = c.at[3] - c.at[2];
    return (a >= 0.0 && b >= 0.0 && d >= 0.0) || (a <= 0.0 && b <= 0.0 && d <= 0.0);
}

static inline double larger_end(const LobattoValues *v) {
    return max_of(fabs(v->at[0]), fabs(v->at[LOBATTO_END]));
}

static void find_peaks(const LobattoSystem *s, const NodeLoads *loads, const Peaks *known, LobattoStep *out) {
    const double contacts = s->slip->params->contacts;
    const bool monotone = lobatto_system_is_inertial(s) && lobatto_keeps_sign(&s->y, s->y.at[0] > 0.0 ? 1 : -1);
    out->peaks_inside = !monotone && !peaks_at_end(&s->speed, known->omega);
    out->peak = (Peaks){.torque = larger_end(&s->tau), .omega = larger_end(&s->speed)};
    for (int i = 0; i < 2; i++) {
        const LobattoValues *reaction = &loads->reaction[i];
        out->peaks_inside = out->peaks_inside || !peaks_at_end(reaction, known->reaction[i] * contacts);
        out->peak.reaction[i] = larger_end(reaction) / contacts;
    }
    if (out->peaks_inside && s->slip->friction_varies)
        out->peaks_inside = !lobatto_peaks_inside(s, loads->reaction, &out->peak);
}

/* ---- the step ---- */

/* True if the step is accurate enough and if no event lies in it. The answer does not depend on whether a ledger is
 * kept. */
static bool is_accepted(LobattoSystem *s, const LobattoStart *from, LobattoStep *out) {
    const SlipMode *slip = s->slip;
    const bool moves =
        lobatto_keeps_sign(&s->speed, slip->direction) && slip->direction * s->dtheta.at[LOBATTO_END] < from->to_stop;
    out->accurate = lobatto_is_accurate(s, 1.0) && (!slip->friction_varies || resolves_friction(s));
    if (!moves || !out->accurate) return false;
    NodeLoads loads;
    loads.booking = (Booking){.work_in = 0.0};
    for (int k = 0; k < LOBATTO_HALVES; k++) add_node_loads(s, k, &loads);
    if (has_friction(slip->params) && !(stays_on_flanks(s, &loads) && stays_on_spring_flanks(s))) return false;
    if (!keeps_energy(s, &loads.booking, &out->energy_gained)) return false;
    out->booking = loads.booking;
    if (slip->params->ledger) find_peaks(s, &loads, from->known, out);
    return true;
}

/* alpha, or without inertia omega, at the start, but for the square root of quadratic damping, and for the terms of
 * z'', gamma'' and I unless `bend` is given: a first guess. */
static inline double guess_rhs(const SlipMode *slip, const LobattoStart *from, const double friction[2],
                               const GrooveBend *bend) {
    const Params *p = slip->params;
    const Geometry *g = from->geometry;
    ContactFactors f;
    for (int i = 0; i < 2; i++) {
        contact_factors_set(&f, i, g->radius[i], friction[i], g->slope[i]);
    }
    contact_factors_multiply(&f);
    double damping = f.delta * p->shaft.damping;
    if (slip->c + slip->q > 0.0) damping += f.p * g->dz_dtheta * (slip->c + slip->q * fabs(g->dz_dtheta * from->omega));
    const double net =
        f.delta * slip->inputs->tau[0] - f.p * (spring_force(&p->spring, from->z) + slip->inputs->F_ext[0]);
    if (slip->regime != REGIME_INERTIAL) return net / damping;
    double mass = f.delta * p->inertia.shaft;
    if (slip->follower_has_inertia) mass += f.p * p->inertia.follower_mass * g->dz_dtheta;
    if (bend == NULL) return (net - damping * from->omega) / mass;
    const InertiaParams *in = &p->inertia;
    const double swirl = f.p * in->follower_mass * bend->d2z_dtheta2 + f.q * in->follower * bend->d2gamma_dtheta2;
    mass += f.q * in->follower * g->dpsi_dtheta[0];
    return (net - (damping + swirl * from->omega) * from->omega) / mass;
}

/* Solves a step of s->h seconds. If such a step ends beyond the limit of the breakpoint, solves the step to the
 * breakpoint instead. */
static bool solve_to_breakpoint(LobattoSystem *s, double rhs) {
    const SlipMode *slip = s->slip;
    const Breakpoint breakpoint = breakpoint_ahead(slip, s->theta);
    const double limit = breakpoint_limit(&breakpoint);
    EndAngle end = {.distance = breakpoint_aim(&breakpoint), .slack = 0.25 * breakpoint.overshoot};
    lobatto_system_guess(s, rhs);
    do { /* at most two turns: the second one aims at the breakpoint */
        if (slip->direction * s->dtheta.at[LOBATTO_END] > limit) {
            const double alpha = lobatto_system_is_inertial(s) ? slip->direction * rhs : 0.0;
            end.given = true;
            s->end_speed.given = false;
            s->h = ballistic_time(slip->direction * s->omega, alpha, end.distance);
            lobatto_system_guess(s, rhs);
        }
        if (!lobatto_system_solve(s, &end)) return false;
    } while (!end.given && slip->direction * s->dtheta.at[LOBATTO_END] > limit);
    return true;
}

/* Friction at the start, where it varies. */
typedef struct {
    double sliding[2], load2[2]; /* m, v_i per omega; see lobatto_friction() */
    double value[2], kinetic[2]; /* f_i, f_i without an excess that falls */
    bool falls;                  /* at a contact */
} StartFriction;

/* m, of the contacts with a table */
static inline Vector2 tabled_sliding(const LobattoSystem *s, const StartFriction *friction) {
    return (Vector2){friction->sliding[s->slip->law[0].tabled], friction->sliding[s->slip->law[1].tabled]};
}

/* Takes the pieces and patches of the friction tables. */
NOINLINE static void start_on_tables(LobattoSystem *s, double omega, StartFriction *out) {
    const FrictionConstants *law = s->slip->law;
    const Vector2 v = tabled_sliding(s, out) * omega;
    for (int i = 0; i < 2; i++) {
        const FrictionTable *table = law[i].table;
        s->piece[i] = friction_table_piece(table, v[i]);
        s->patch[i] = NULL;
        if (!s->law[i]->has_table) continue;
        if (table->loads > 1)
            s->patch[i] = friction_table_patch(table, s->piece[i], friction_table_span(table, sqrt(out->load2[i])));
        const Vector2 speed = {v[i], v[i]}, load2 = {out->load2[i], out->load2[i]};
        out->value[i] = out->kinetic[i] = lobatto_friction(s, i, speed, load2).value[0];
    }
}

/* f_i of a law at the start: with the excess that falls, and without. */
static void start_on_law(const LobattoSystem *s, int i, double v, StartFriction *out) {
    const FrictionNearby *law = s->law[i];
    const double power = s->has_loads ? s->load[i].power[0] : 1.0;
    const double faint = LOBATTO_FALL_FAINT * sqrt(s->slip->params->tolerance);
    const double kinetic = law->kinetic[0] * power + law->viscous[0] * v;
    out->value[i] = out->kinetic[i] = kinetic;
    if (v * law->minus_by_v[0] < -LOBATTO_FALL_OVER) return;
    out->value[i] = friction_by_law(law, &s->load[i], (Vector2){v, v}, s->load[i].load2).value[0];
    const bool shows = law->is_gauss || fabs(out->value[i] - kinetic) > faint * fabs(kinetic);
    const bool falls = shows && v < s->slip->law[i].fall.end;
    if (!falls) out->kinetic[i] = out->value[i];
    out->falls = out->falls || falls;
}

/* The nominal loads of both contacts at the start, see lobatto_friction(), and their powers, in one vector. */
static void find_start_loads(LobattoSystem *s, const LobattoStart *from, double load2[2]) {
    const SlipMode *slip = s->slip;
    const double v = from->geometry->dz_dtheta * from->omega;
    const double force =
        spring_force(&slip->params->spring, from->z) + slip->inputs->F_ext[0] + slip_damper_force(slip, v);
    const double force2 = force * force;
    for (int i = 0; i < 2; i++) {
        const double sliding = cam_sliding(from->geometry, i);
        load2[i] = force2 * sliding * sliding * s->law[i]->per_load2[0];
    }
    const Vector2 both = {load2[0], load2[1]}, none = {0.0, 0.0};
    const Vector2 half_exponent = {s->law[0]->half_exponent[0], s->law[1]->half_exponent[0]};
    const Vector2 power = friction_load_power(half_exponent, both);
    const Vector2 per = 1.0 / (both + NOMINAL_LOAD_LOW * NOMINAL_LOAD_LOW);
    for (int i = 0; i < 2; i++) s->load[i] = (FrictionLoadStart){none + both[i], none + per[i], none + power[i]};
}

static StartFriction start_friction(LobattoSystem *s, const LobattoStart *from) {
    StartFriction out = {.falls = false};
    for (int i = 0; i < 2; i++) out.sliding[i] = s->slip->direction * cam_sliding(from->geometry, i);
    if (s->has_loads) find_start_loads(s, from, out.load2);
    for (int i = 0; i < 2; i++)
        if (!s->law[i]->has_table) start_on_law(s, i, from->omega * out.sliding[i], &out);
    if (s->has_tables) start_on_tables(s, from->omega, &out);
    return out;
}

/* Where mu falls: the share of the step that four nodes resolve; 0: a share too small for such steps. With u = v/v_s
 * and x its change in the step, the cubic term of exp(-u) is x^3/6 exp(-u), that of exp(-u^2) at most |8 u^3 - 12 u|
 * times as large. The error grows with the fourth power of the share, see lobatto_is_accurate(). */
static double share_in_fall(const LobattoSystem *s, const LobattoStart *from, const StartFriction *friction,
                            const GrooveBend *bend, double rhs) {
    const SlipMode *slip = s->slip;
    const double excess = fabs(rhs - guess_rhs(slip, from, friction->kinetic, bend));
    const double root = sqrt(slip->params->tolerance), allowed = root * sqrt(root);
    double most = 0.0;
    for (int i = 0; i < 2; i++) {
        if (friction->value[i] == friction->kinetic[i]) continue;
        const double per_angle = fabs(friction->sliding[i] * s->law[i]->minus_by_v[0]);
        const double u = fabs(from->omega) * per_angle, x = fabs(rhs) * s->h * per_angle;
        const double steepness =
            s->law[i]->is_gauss ? max_of(fabs(8.0 * u * u * u - 12.0 * u), LOBATTO_FALL_LEAST) : 1.0;
        most = max_of(most, steepness * x * x * x / 6.0);
    }
    const double error = s->h * LOBATTO.missed * LOBATTO.missed_once * excess * most / fabs(from->omega);
    const double parts = ceil(sqrt(sqrt(error / allowed)));
    return parts <= 1.0 ? 1.0 : parts <= (double)LOBATTO_FALL_PARTS ? 1.0 / parts : 0.0;
}

/* A motion that slows down: the share of the step up to which the nodes see the fall ahead. */
static double share_to_fall(const LobattoSystem *s, const StartFriction *friction, double omega, double rhs) {
    double share = 1.0;
    for (int i = 0; i < 2; i++) {
        const FrictionFall *fall = &s->slip->law[i].fall;
        const double sliding = friction->sliding[i], v = sliding * omega;
        if (!fall->table) share = min_of(share, friction_share(fall, v, v + sliding * rhs * s->h));
    }
    return share < 1.0 ? STEP_SAFETY * share : 1.0;
}

/* The speeds that the step may reach on its pieces of the friction tables. */
ALWAYS_INLINE static inline KnotSteps reach_on_pieces(LobattoSystem *s, Vector2 v, bool up) {
    const double overshoot = s->slip->law[0].fall.overshoot; /* the same of both */
    const KnotSteps step = knot_steps(&s->piece[0]->cell, &s->piece[1]->cell, overshoot, v, up);
    s->lowest = v - (up ? step.back : step.longest);
    s->highest = v + (up ? step.longest : step.back);
    return step;
}

/* The patches of a piece lie one after the other. */
static void take_next_piece(LobattoSystem *s, int i, bool up) {
    const ptrdiff_t next = up ? 1 : -1;
    s->piece[i] += next;
    if (s->patch[i] != NULL) s->patch[i] += next * ((ptrdiff_t)s->slip->law[i].table->loads - 1);
}

/* Takes the next piece where a step before has reached the sample ahead. Shortens the step to end at the sample of the
 * first contact to get there. */
NOINLINE static void aim_at_samples(LobattoSystem *s, Vector2 v, Vector2 per_time, bool up, KnotSteps step) {
    const double longest = s->h;
    while (knot_is_reached(&step, 0) || knot_is_reached(&step, 1)) { /* at most one turn per sample */
        for (int i = 0; i < 2; i++)
            if (knot_is_reached(&step, i)) take_next_piece(s, i, up);
        step = reach_on_pieces(s, v, up);
    }
    for (int i = 0; i < 2; i++) {
        const double change = per_time[i] * s->h, aim = knot_aim(&step, i);
        if (v[i] + change >= s->lowest[i] && v[i] + change <= s->highest[i]) continue;
        s->h *= min_of(aim / fabs(change), 1.0);
        const double slack = FRICTION_AIM_SHARE * (step.longest[i] - aim);
        s->end_speed = (EndSpeed){true, s->slip->law[i].tabled, v[i], v[i] + copysign(aim, change), slack, longest};
    }
}

/* Friction tables: does the step stay on its pieces under constant acceleration? If not, the step is shortened. */
NOINLINE static void approach_samples(LobattoSystem *s, const StartFriction *friction, double omega, double rhs) {
    const Vector2 sliding = tabled_sliding(s, friction), v = sliding * omega, per_time = sliding * rhs;
    const bool up = rhs > 0.0;
    const KnotSteps step = up ? reach_on_pieces(s, v, true) : reach_on_pieces(s, v, false);
    const Vector2 margin = vector2_min(knot_margins(&step), step.longest - vector2_abs(per_time * s->h));
    if (!(margin[0] >= 0.0 && margin[1] >= 0.0)) aim_at_samples(s, v, per_time, up, step);
}

static GrooveBend start_bend(const SlipMode *slip, const LobattoStart *from) {
    GrooveBend bend = {0.0, 0.0};
    if (!slip->follower_has_inertia || slip->transmission->straight) return bend;
    const TransmissionPoint p = piece_point(slip->piece, from->theta, TRANSMISSION_FIRST_DERIVATIVES);
    const double *psi = from->geometry->dpsi_dtheta, *a = from->geometry->slope, *b = p.dslope_dtheta;
    bend.d2z_dtheta2 = b[0] * psi[0] * psi[0] + b[1] * psi[1] * psi[1];
    bend.d2gamma_dtheta2 = (b[1] * psi[1] - b[0] * psi[0]) / (a[0] + a[1]);
    return bend;
}

/* Where friction depends on the load alone: guess_rhs(). */
static double begin_loaded(LobattoSystem *s, const LobattoStart *from) {
    double load2[2], friction[2];
    find_start_loads(s, from, load2);
    for (int i = 0; i < 2; i++) friction[i] = s->law[i]->kinetic[0] * s->load[i].power[0];
    return guess_rhs(s->slip, from, friction, NULL);
}

/* Where friction depends on the speed: guess_rhs(). Shortens the step where mu falls. */
NOINLINE static double begin_varying(LobattoSystem *s, const LobattoStart *from) {
    StartFriction friction = start_friction(s, from);
    const GrooveBend bend = start_bend(s->slip, from);
    s->omega = from->omega;
    const double rhs = guess_rhs(s->slip, from, friction.value, &bend);
    if (friction.falls) s->h *= share_in_fall(s, from, &friction, &bend, rhs);
    if (s->slip->direction * rhs < 0.0) s->h *= share_to_fall(s, &friction, from->omega, rhs);
    if (s->has_tables) approach_samples(s, &friction, from->omega, rhs);
    return rhs;
}

/* Solves the step to a breakpoint or the end of s->h seconds. */
static bool solve_longest(LobattoSystem *s, double rhs, const LobattoStart *from, double longest, LobattoStep *out) {
    for (int n = 0;; n++) { /* at most LOBATTO_HALVINGS + 1 turns */
        out->accurate = false;
        if (solve_to_breakpoint(s, rhs) && s->h > 0.0 && s->h <= longest && is_accepted(s, from, out)) return true;
        /* Where friction varies, a part of the step may be accurate where the whole is not. */
        if (n == LOBATTO_HALVINGS || !s->slip->friction_varies || out->accurate) return false;
        s->h = longest = 0.5 * min_of(s->h, longest);
        s->end_speed.given = false;
    }
}

bool lobatto_step_along(const SlipMode *slip, const LobattoStart *from, double left, LobattoStep *out) {
    LobattoSystem s;
    lobatto_system_begin(&s, slip);
    s.h = left;
    const double rhs = s.by_speed    ? begin_varying(&s, from)
                       : s.has_loads ? begin_loaded(&s, from)
                                     : guess_rhs(slip, from, slip->signed_friction, NULL);
    s.theta = from->theta;
    s.omega = slip->regime == REGIME_INERTIAL ? from->omega : rhs;
    if (!(s.h > 0.0) || !solve_longest(&s, rhs, from, left, out)) return false;
    const Vector2 domega = LOBATTO.weight.half[0] * s.y.half[0] + LOBATTO.weight.half[1] * s.y.half[1];
    out->h = s.h;
    out->dtheta = s.dtheta.at[LOBATTO_END];
    out->domega = s.h * lobatto_sum(domega);
    out->omega = lobatto_system_is_inertial(&s) ? s.speed.at[LOBATTO_END] : lobatto_system_speed_at_end(&s);
    return booking_is_in_range(&out->booking, out->dtheta + out->omega); /* else a Radau step is tried */
}
