#include "contact/loaded_contacts.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#include "elementary/elementary.h"
#include "numerics/root.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

static double sign_on(const LoadedPin *pin, int i) {
    return pin->direction * pin->flank[i];
}

double loaded_pin_reaction(const LoadedPin *pin, int i) {
    const double r = pin->params->cam[i].radius;
    return sqrt(r * r + pin->slope[i] * pin->slope[i]) / pin->params->contacts;
}

/* ---- Newton's method ---- */

/* mu_i at the present x_i, the tangent factors, and the part of the friction force that the tangent leaves at x_i = 0:
 * f_i x_i = f'_i x_i - rest_i. */
COMPACT static void linearise(const LoadedPin *pin, const double reaction[2], LoadedContacts *c, double rest[2]) {
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &pin->params->cam[i];
        const double R = fabs(c->x[i]) * reaction[i], sign = sign_on(pin, i);
        c->mu[i] = friction_under(cam, pin->speed[i], R);
        c->friction[i] = sign * c->mu[i].value;
        const double more = sign * R * c->mu[i].by_load;
        rest[i] = more * c->x[i];
        contact_factors_set(&c->tangent, i, cam->radius, c->friction[i] + more, pin->slope[i]);
    }
    contact_factors_multiply(&c->tangent);
}

/* x_i of the linear balance with the tangent factors. */
static void solve_linear(const ContactFactors *f, double axial, double moment, double x[2]) {
    const double inverse = 1.0 / f->delta;
    x[0] = (f->rn[1] * axial - f->d[1] * moment) * inverse;
    x[1] = (f->rn[0] * axial + f->d[0] * moment) * inverse;
}

/* One iteration; returns the change of x_i, relative to the larger x_i, or 0 where no contact carries anything: there
 * the change is rounding, however often the iteration goes on. */
COMPACT static double improve(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha,
                              const double rest[2], double share, LoadedContacts *c) {
    const CamParams *cam = pin->params->cam;
    const ContactFactors *f = &c->tangent;
    const double torque[2] = {cam[0].radius * cam[0].radius * rest[0], cam[1].radius * cam[1].radius * rest[1]};
    double axial = loads->axial - (pin->slope[0] * rest[0] + pin->slope[1] * rest[1]);
    double moment = loads->moment + (torque[1] - torque[0]);
    if (by_alpha != NULL) {
        const double net = f->delta * (loads->torque + torque[1]) - f->p * axial - f->q * moment;
        c->alpha = net / (f->delta * by_alpha->torque + f->p * by_alpha->axial + f->q * by_alpha->moment);
        axial += by_alpha->axial * c->alpha;
        moment += by_alpha->moment * c->alpha;
    }
    double x[2], change = 0.0, carried = 0.0;
    solve_linear(f, axial, moment, x);
    for (int i = 0; i < 2; i++) {
        change = max_of(change, fabs(x[i] - c->x[i]));
        carried = max_of(carried, cam[i].radius * max_of(fabs(x[i]), fabs(c->x[i])));
        c->x[i] += share * (x[i] - c->x[i]);
    }
    if (carried <= LOADED_ZERO * loads->size) return 0.0;
    return change / max_of(max_of(fabs(x[0]), fabs(x[1])), max_of(fabs(c->x[0]), fabs(c->x[1])));
}

/* Has the balance one answer? See the head of loaded_contacts.h. */
COMPACT static bool is_single(const LoadedPin *pin, const LoadedContacts *c) {
    ContactFactors f;
    bool single = true;
    for (int i = 0; i < 2; i++) {
        const double r = pin->params->cam[i].radius;
        contact_factors_set(&f, i, r, c->friction[i], pin->slope[i]);
        const bool passes = f.rn[i] > -LOADED_NO_TORQUE * r * pin->slope[i];
        single &= !(c->tangent.rn[i] <= 0.0 && passes && c->mu[i].by_load != 0.0);
    }
    contact_factors_multiply(&f);
    const bool grows = c->tangent.rn[0] > 0.0 && c->tangent.rn[1] > 0.0 && c->tangent.delta > 0.0;
    return single && (grows || f.delta * c->tangent.delta > 0.0);
}

/* Improves x_i from those in *c. An iteration whose changes shrink too slowly is damped: with the share s of the change
 * made, the next change can be no smaller than 1 - s of the latest (P. Deuflhard, Newton Methods for Nonlinear Problems,
 * 2004, section 3.3). */
COMPACT static void iterate(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha,
                            LoadedContacts *c) {
    const double reaction[2] = {loaded_pin_reaction(pin, 0), loaded_pin_reaction(pin, 1)};
    double rest[2], before = INFINITY, share = 1.0;
    c->possible = false;
    for (int n = 0; n < LOADED_ITERATIONS; n++) {
        work_add(pin->work, 1);
        linearise(pin, reaction, c, rest);
        const double change = improve(pin, loads, by_alpha, rest, share, c);
        const bool stalls = change <= LOADED_STALLED && change > 0.5 * before; /* at rounding */
        if (stalls || !(change > LOADED_LAST_CHANGE)) {
            for (int i = 0; i < 2; i++)
                if (fabs(c->x[i]) * pin->params->cam[i].radius <= LOADED_ZERO * loads->size) c->x[i] = 0.0;
            linearise(pin, reaction, c, rest);
            c->single = is_single(pin, c);
            c->possible = isfinite(c->x[0] + c->x[1] + c->alpha) && (by_alpha != NULL || c->single);
            return;
        }
        const bool slow = change > (1.0 - LOADED_SHARE_GAINED * share) * before;
        share = slow ? max_of(0.5 * share, LOADED_LEAST_SHARE) : min_of(2.0 * share, 1.0);
        before = change;
    }
}

/* The balance as if no friction acted. */
COMPACT static void begin(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha, LoadedContacts *c) {
    const double none[2] = {0.0, 0.0};
    c->alpha = 0.0;
    for (int i = 0; i < 2; i++) contact_factors_set(&c->tangent, i, pin->params->cam[i].radius, 0.0, pin->slope[i]);
    contact_factors_multiply(&c->tangent);
    c->x[0] = c->x[1] = 0.0;
    improve(pin, loads, by_alpha, none, 1.0, c);
}

/* ---- where Newton's method does not find the answer ---- */

/* Samples of a reaction on its flank, N/m, each LOADED_SEARCH_FACTOR times the one before, for a change of the sign of
 * `missed`. */
typedef struct {
    ScalarFunction *missed;
    const void *context;
    double at, missed_at;
    int left; /* samples */
} Samples;

/* The first sample is a LOADED_SEARCH_RANGE-th of `size`, N/m, on the flank. No sample is taken of a size that is zero or
 * not finite. */
COMPACT static Samples samples_on_flank(ScalarFunction *missed, const void *context, int flank, double size,
                                        int samples) {
    const double at = flank * size / LOADED_SEARCH_RANGE;
    const bool can = size > 0.0 && isfinite(size);
    return (Samples){missed, context, at, can ? missed(context, at) : 0.0, can ? samples : 0};
}

/* Goes on to the next change of sign. */
COMPACT static bool next_root(Samples *s, double *root) {
    while (s->left > 0) { /* at most LOADED_FAR_SAMPLES turns */
        s->left--;
        const double before = s->at, missed_before = s->missed_at;
        s->at = LOADED_SEARCH_FACTOR * before;
        s->missed_at = s->missed(s->context, s->at);
        if ((s->missed_at > 0.0) == (missed_before > 0.0)) continue;
        *root = root_between(s->missed, s->context, before, missed_before, s->at, s->missed_at);
        return true;
    }
    return false;
}

typedef struct {
    const LoadedPin *pin;
    const LoadTerms *loads, *by_alpha;
    int sampled; /* the contact whose reaction is known: 0 or 1; with `by_alpha` 1, which the shaft's torque loads */
} Elimination;

/* What follows from one reaction: alpha, the other reaction, and by how much its friction force f x misses the law. */
typedef struct {
    double alpha, other, missed;
} Eliminated;

/* q_i = f_i x_i, N/m, by the law. */
COMPACT static double friction_force(const LoadedPin *pin, int i, double x) {
    const double R = fabs(x) * loaded_pin_reaction(pin, i);
    return sign_on(pin, i) * friction_under(&pin->params->cam[i], pin->speed[i], R).value * x;
}

/* Contact i passes on r_i (a_i x_i + r_i q_i) as torque and r_i x_i - a_i q_i as axial force, with q_i = f_i x_i. So one
 * reaction gives both for its contact, the balances give both for the other contact, and these two forces are linear in the
 * x and q of this other one. */
COMPACT static Eliminated eliminate(const Elimination *e, double x) {
    const LoadedPin *pin = e->pin;
    const int i = e->sampled, j = 1 - i;
    const double r = pin->params->cam[i].radius, a = pin->slope[i];
    const double other_r = pin->params->cam[j].radius, other_a = pin->slope[j];
    work_add(pin->work, 1);
    const double q = friction_force(pin, i, x), torque = r * (a * x + r * q);
    LoadTerms loads = *e->loads;
    Eliminated out = {.alpha = 0.0};
    if (e->by_alpha != NULL) {
        out.alpha = (loads.torque - torque) / e->by_alpha->torque;
        loads.axial += e->by_alpha->axial * out.alpha;
        loads.moment += e->by_alpha->moment * out.alpha;
    }
    const double other_torque = i == 1 ? torque - loads.moment : torque + loads.moment;
    const double other_axial = loads.axial - (r * x - a * q), inverse = 1.0 / (other_r * other_r + other_a * other_a);
    out.other = (other_r * other_axial + other_a * other_torque / other_r) * inverse;
    out.missed = (other_torque - other_a * other_axial) * inverse - friction_force(pin, j, out.other);
    return out;
}

static double missed_by(const void *context, double x) {
    return eliminate(context, x).missed;
}

/* Do the reactions press the flanks of the pair? */
static bool is_on_flanks(const LoadedPin *pin, const LoadedContacts *c) {
    return pin->flank[0] * c->x[0] >= 0.0 && pin->flank[1] * c->x[1] >= 0.0;
}

/* How far a balance is an answer: from one that is not possible, or not on the flanks, to one at which the reactions settle
 * between slightly elastic flanks (docs/mechanism.md, section 9, "Motion"). Without `by_alpha` nothing moves. */
typedef enum { ANSWER_NONE, ANSWER_ON_FLANKS, ANSWER_SETTLES } AnswerRank;

COMPACT static double inertia_of(const LoadTerms *by_alpha, const LoadedContacts *c) {
    const ContactFactors *f = &c->tangent;
    return by_alpha->torque * f->delta + by_alpha->axial * f->p + by_alpha->moment * f->q;
}

/* From rest no motion in the direction of the pin accelerates against this direction. */
static bool accelerates_back(const LoadedPin *pin, const LoadedContacts *c) {
    return pin->speed[0] == 0.0 && pin->speed[1] == 0.0 && pin->direction * c->alpha < 0.0;
}

COMPACT static AnswerRank rank_of(const LoadedPin *pin, const LoadTerms *by_alpha, const LoadedContacts *c) {
    if (!c->possible || !is_on_flanks(pin, c)) return ANSWER_NONE;
    if (by_alpha != NULL && accelerates_back(pin, c)) return ANSWER_NONE;
    const double inertia = by_alpha != NULL ? inertia_of(by_alpha, c) : 1.0;
    if (inertia > 0.0) return ANSWER_SETTLES;
    return inertia * c->tangent.delta > 0.0 ? ANSWER_ON_FLANKS : ANSWER_NONE;
}

typedef struct {
    AnswerRank rank;
    LoadedContacts contacts;
} Answer;

/* Improves the reactions of `tried` to a balance, and takes the balance if it is a better answer. Is the answer final? */
COMPACT static bool improve_answer(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha,
                                   LoadedContacts *tried, Answer *best) {
    iterate(pin, loads, by_alpha, tried);
    const AnswerRank rank = rank_of(pin, by_alpha, tried);
    if (rank > best->rank) *best = (Answer){rank, *tried};
    return best->rank == ANSWER_SETTLES;
}

/* Takes samples of the reaction of one contact, from those of `size` N/m. */
COMPACT static void search(const Elimination *e, double size, int samples, Answer *best) {
    const int i = e->sampled;
    Samples found = samples_on_flank(missed_by, e, e->pin->flank[i], size, samples);
    LoadedContacts tried;
    while (next_root(&found, &tried.x[i])) { /* at most `samples` turns */
        const Eliminated rest = eliminate(e, tried.x[i]);
        tried.x[1 - i] = rest.other;
        tried.alpha = rest.alpha;
        if (improve_answer(e->pin, e->loads, e->by_alpha, &tried, best)) return;
    }
}

/* A scalar equation of one contact, p x_i + q f_i x_i = c. */
typedef struct {
    const LoadedPin *pin;
    int contact;
    double p, q, c;
} ContactEquation;

static double missed_of_contact(const void *context, double x) {
    const ContactEquation *e = context;
    work_add(e->pin->work, 1);
    return e->p * x + e->q * friction_force(e->pin, e->contact, x) - e->c;
}

COMPACT static Samples samples_of(const ContactEquation *e) {
    const double size = fabs(e->c) / (fabs(e->p) + fabs(e->q));
    return samples_on_flank(missed_of_contact, e, e->pin->flank[e->contact], size, LOADED_SEARCH_SAMPLES);
}

/* r_i n_i x_i = torque */
COMPACT static ContactEquation torque_equation(const LoadedPin *pin, int i, double torque) {
    const double r = pin->params->cam[i].radius;
    return (ContactEquation){pin, i, r * pin->slope[i], r * r, torque};
}

/* Without inertia of the shaft the torque tau - b omega alone makes x_2. The other two equations, without alpha, make x_1. */
COMPACT static void search_without_shaft(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha,
                                         Answer *best) {
    const double r1 = pin->params->cam[0].radius, a1 = pin->slope[0], m = by_alpha->axial, I = by_alpha->moment;
    const double torque1 = loads->torque - loads->moment; /* at alpha = 0 */
    const ContactEquation of_second = torque_equation(pin, 1, loads->torque);
    Samples second = samples_of(&of_second);
    double x[2];
    while (next_root(&second, &x[1])) { /* at most LOADED_SEARCH_SAMPLES turns */
        const double axial2 = pin->params->cam[1].radius * x[1] - pin->slope[1] * friction_force(pin, 1, x[1]);
        const double axial1 = loads->axial - axial2; /* at alpha = 0 */
        const ContactEquation of_first = {pin, 0, r1 * (m * a1 + I), m * r1 * r1 - I * a1, m * torque1 + I * axial1};
        Samples first = samples_of(&of_first);
        while (next_root(&first, &x[0])) { /* at most LOADED_SEARCH_SAMPLES turns */
            const double q1 = friction_force(pin, 0, x[0]);
            const double alpha =
                I > 0.0 ? (torque1 - r1 * (a1 * x[0] + r1 * q1)) / I : (r1 * x[0] - a1 * q1 - axial1) / m;
            LoadedContacts tried = {.alpha = alpha, .x = {x[0], x[1]}};
            if (improve_answer(pin, loads, by_alpha, &tried, best)) return;
        }
    }
}

/* N/m, of the larger reaction of *c, as a size of x_i. */
static double size_of(const LoadedPin *pin, const LoadedContacts *c, int i) {
    const CamParams *cam = pin->params->cam;
    return max_of(fabs(c->x[0]) * cam[0].radius, fabs(c->x[1]) * cam[1].radius) / cam[i].radius;
}

/* The iteration starts as if no friction acted. It can end nowhere, or in a motion at reactions that do not settle. A search
 * then goes on to the smallest better answer on the flanks. A balance off the flanks that settles stays, unless the pin
 * searches: the law holds there for |x_i|, and a reaction that passes zero comes there. */
COMPACT static void solve(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha, LoadedContacts *c) {
    begin(pin, loads, by_alpha, c);
    const double size = size_of(pin, c, 1);
    iterate(pin, loads, by_alpha, c);
    const bool off = c->possible && !is_on_flanks(pin, c);
    if (by_alpha == NULL && c->possible && !(off && pin->searches)) return;
    Answer best = {rank_of(pin, by_alpha, c), *c};
    if (off ? !pin->searches && inertia_of(by_alpha, c) > 0.0 && c->single : best.rank == ANSWER_SETTLES) return;
    const Elimination second = {pin, loads, by_alpha, 1};
    if (by_alpha != NULL && by_alpha->torque == 0.0) search_without_shaft(pin, loads, by_alpha, &best);
    else search(&second, size, LOADED_SEARCH_SAMPLES, &best);
    if (!off || best.rank == ANSWER_SETTLES) *c = best.contacts;
}

/* Under known loads, with the reactions on their flanks. A contact that bears next to nothing hides between two samples of
 * the other reaction. */
COMPACT static void search_on_flanks(const LoadedPin *pin, const LoadTerms *loads, LoadedContacts *c) {
    Answer best = {.rank = ANSWER_NONE};
    begin(pin, loads, NULL, c);
    for (int i = 1; i >= 0 && best.rank == ANSWER_NONE; i--) {
        const Elimination e = {pin, loads, NULL, i};
        search(&e, size_of(pin, c, i), LOADED_FAR_SAMPLES, &best);
    }
    *c = best.contacts;
}

NOINLINE void loaded_contacts_under(const LoadedPin *pin, const LoadTerms *loads, LoadedContacts *out) {
    solve(pin, loads, NULL, out);
}

/* ---- in a known motion ---- */

/* r_i n_i x_i, N.m. */
static double torque_of(const LoadedPin *pin, const LoadedContacts *c, int i) {
    const double r = pin->params->cam[i].radius;
    return r * (pin->slope[i] + r * c->friction[i]) * c->x[i];
}

/* By how much the reactions miss the torques at both contacts and the axial load, as a share of the terms. */
COMPACT static double missed_share(const LoadedPin *pin, const LoadTerms *loads, const double torque[2],
                                   const LoadedContacts *c) {
    double axial = -loads->axial, terms = loads->size, share = 0.0;
    for (int i = 0; i < 2; i++) {
        const double r = pin->params->cam[i].radius, a = pin->slope[i], friction = c->friction[i];
        const double size = r * (a + r * fabs(friction)) * fabs(c->x[i]) + fabs(torque[i]);
        share = max_of(share, fabs(torque_of(pin, c, i) - torque[i]) / (size + DBL_MIN));
        axial += (r - a * friction) * c->x[i];
        terms += (r + a * fabs(friction)) * fabs(c->x[i]);
    }
    return max_of(share, fabs(axial) / (terms + DBL_MIN));
}

COMPACT void loaded_contacts_in_motion(const LoadedPin *pin, const LoadTerms *loads, LoadedContacts *c) {
    solve(pin, loads, NULL, c);
    const ContactFactors *f = &c->tangent;
    if (!(fabs(f->delta) <= LOADED_FAINT_DELTA * (fabs(f->q) + fabs(f->rn[0] * f->d[1])))) return;
    const double torque[2] = {loads->torque - loads->moment, loads->torque};
    const double missed = missed_share(pin, loads, torque, c);
    if (!(missed > pin->params->tolerance)) return;
    const double reaction[2] = {loaded_pin_reaction(pin, 0), loaded_pin_reaction(pin, 1)};
    double unused[2];
    LoadedContacts other = *c;
    for (int i = 0; i < 2; i++) {
        const ContactEquation e = torque_equation(pin, i, torque[i]);
        Samples samples = samples_of(&e);
        if (!next_root(&samples, &other.x[i])) other.x[i] = 0.0;
    }
    linearise(pin, reaction, &other, unused);
    if (missed_share(pin, loads, torque, &other) < missed) *c = other;
}

NOINLINE void loaded_contacts_moving(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha,
                                     LoadedContacts *out) {
    solve(pin, loads, by_alpha, out);
}

/* ---- changes to first order ---- */

/* At constant x_i the changes of f_i and a_i change the forces, which the changes of x_i balance. */
COMPACT LoadTerms loaded_contacts_unbalanced(const LoadedPin *pin, const LoadedContacts *c, const LoadChange *change) {
    LoadTerms left = {.axial = change->axial};
    double torque[2];
    for (int i = 0; i < 2; i++) {
        const double r = pin->params->cam[i].radius;
        left.axial += c->x[i] * (pin->slope[i] * change->friction[i] + c->friction[i] * change->slope[i]);
        torque[i] = c->x[i] * r * (change->slope[i] + r * change->friction[i]);
    }
    left.moment = change->moment - (torque[1] - torque[0]);
    left.torque = -torque[1];
    return left;
}

COMPACT LoadResponse loaded_contacts_response(const LoadedPin *pin, const LoadedContacts *c, const LoadChange *change) {
    const LoadTerms left = loaded_contacts_unbalanced(pin, c, change);
    LoadResponse response;
    solve_linear(&c->tangent, left.axial, left.moment, response.x);
    for (int i = 0; i < 2; i++) {
        const double by_x = sign_on(pin, i) * (c->x[i] < 0.0 ? -1.0 : 1.0) * c->mu[i].by_load;
        response.friction[i] = change->friction[i] + by_x * loaded_pin_reaction(pin, i) * response.x[i];
    }
    return response;
}

double loaded_pin_friction_by_slope(const LoadedPin *pin, const LoadedContacts *c, int i) {
    const double r = pin->params->cam[i].radius, a = pin->slope[i];
    const double R = fabs(c->x[i]) * loaded_pin_reaction(pin, i);
    return sign_on(pin, i) * c->mu[i].by_load * R * a / (r * r + a * a);
}

LoadResponse loaded_contacts_along_groove(const LoadedPin *pin, const LoadedContacts *c, const double dslope[2]) {
    LoadChange change = {.slope = {dslope[0], dslope[1]}};
    for (int i = 0; i < 2; i++) change.friction[i] = loaded_pin_friction_by_slope(pin, c, i) * dslope[i];
    return loaded_contacts_response(pin, c, &change);
}

/* ---- the stick band ---- */

static LoadedPin pin_at_rest(const Params *params, const Geometry *g, int direction, const int flank[2], Work *work) {
    return (LoadedPin){
        .params = params,
        .direction = direction,
        .flank = {flank[0], flank[1]},
        .slope = {g->slope[0], g->slope[1]},
        .work = work,
    };
}

/* Does friction lock both contacts under all of F_0 > 0, or none? On the flanks that support F_0 the contacts share F_0, and
 * from one end of the shares to the other the difference of their torques changes its sign: there is an answer. */
COMPACT static bool lock_alike(const LoadedPin *pin, double F_0) {
    bool locks[2];
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &pin->params->cam[i];
        const double R = F_0 / cam->radius * loaded_pin_reaction(pin, i);
        locks[i] = friction_under(cam, 0.0, R).value * cam->radius > pin->slope[i];
    }
    return locks[0] == locks[1];
}

/* A pair of flanks carries F_0 > 0 if the reactions have the signs of the flanks. The first pass takes Newton's method, and
 * the search for the flanks that support F_0 if these have an answer. The second pass, where no pair carries, takes the
 * search. */
COMPACT static bool loaded_edge(const Params *params, Geometry *g, double F_0, int direction, int flank[2],
                                Transfer *transfer, Work *work) {
    const int candidates = direction > 0 ? 1 : FLANK_PAIR_COUNT - 1;
    const LoadTerms loads = {.axial = F_0};
    for (int k = 0; k < 2 * candidates; k++) {
        flank_pair(k % candidates, 1, flank);
        const LoadedPin pin = pin_at_rest(params, g, direction, flank, work);
        LoadedContacts c = {.possible = false};
        if (k < candidates) loaded_contacts_under(&pin, &loads, &c);
        const bool searches = k >= candidates || (k == 0 && lock_alike(&pin, F_0));
        if (searches && rank_of(&pin, NULL, &c) == ANSWER_NONE) search_on_flanks(&pin, &loads, &c);
        if (rank_of(&pin, NULL, &c) == ANSWER_NONE) continue;
        for (int i = 0; i < 2; i++) g->friction[i] = c.mu[i].value;
        *transfer = contact_transfer(g, direction, flank);
        transfer->rho_rate = c.tangent.p / c.tangent.delta;
        return true;
    }
    return false;
}

bool contact_edge_under(const Params *params, Geometry *g, double F_0, int direction, int flank[2], Transfer *transfer,
                        Work *work) {
    if (!any_friction_depends_on_load(params)) return contact_edge(g, direction, flank, transfer);
    return loaded_edge(params, g, max_of(F_0, LOADED_LEAST_FORCE), direction, flank, transfer, work);
}

COMPACT static BandFactors loaded_band(const Params *params, const Geometry *g, double F_0, Work *work) {
    BandFactors band = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    Geometry edge = *g;
    int flank[2];
    Transfer t;
    if (contact_edge_under(params, &edge, F_0, 1, flank, &t, work)) {
        band.load = t.rho;
        band.load_rate = t.rho_rate;
    }
    if (contact_edge_under(params, &edge, F_0, -1, flank, &t, work)) {
        band.release = t.rho;
        band.release_rate = t.rho_rate;
    }
    return band;
}

BandFactors contact_band_under(const Params *params, const Geometry *g, double F_0, Work *work) {
    return any_friction_depends_on_load(params) ? loaded_band(params, g, F_0, work) : contact_band(g);
}
