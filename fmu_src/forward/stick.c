#include "forward/stick.h"

#include <float.h>
#include <math.h>

#include "contact/balance.h"
#include "elementary/elementary.h"
#include "numerics/bernstein.h"
#include "numerics/golden_section.h"
#include "numerics/root.h"
#include "numerics/sign.h"
#include "platform/attributes.h"

double stick_axial_load(const Mechanism *m) {
    return spring_force(&m->params.spring, m->configuration.z) + m->inputs.F_ext[0];
}

/* The size of the terms of F_0 under the external load F_ext; `rounded`: m, see spring_terms(). */
static double terms_of_load(const Mechanism *m, double rounded, double F_ext) {
    const SpringParams *s = &m->params.spring;
    return fabs(s->preload) + spring_terms(s, m->configuration.z, rounded) + fabs(F_ext);
}

/* The size of the terms of F_0, whose rounding is that of the largest z, too. */
static double axial_size(const Mechanism *m, double F_ext) {
    return terms_of_load(m, STICK_HEIGHT_SHARE * m->model.transmission.z_size, F_ext);
}

double stick_axial_size(const Mechanism *m) {
    return axial_size(m, m->inputs.F_ext[0]);
}

bool stick_force_counts(const Mechanism *m, double force) {
    return fabs(force) > stick_tie(m) * stick_axial_size(m);
}

bool stick_is_unloaded(const Mechanism *m) {
    return fabs(stick_axial_load(m)) <= STICK_TIE_CURVED * stick_axial_size(m);
}

/* m/rad, the size of the rounding of an edge factor by that of the slopes. With rho = 1/(kappa_1 + kappa_2) of section
 * 3 of docs/mechanism.md, d rho/d a_i = (1 + f_i^2) (rho/n_i)^2, where rho/n_i is at most about 1, and where groove i
 * is steep at most about (a_j + mu_j r_j)/a_i: the slope of a steep groove hardly matters, and so does its rounding. */
static double slope_size(const Mechanism *m) {
    const Geometry *g = &m->configuration.geometry;
    double size = 0.0;
    for (int i = 0; i < 2; i++) {
        const double other = g->slope[1 - i] + g->friction[1 - i] * g->radius[1 - i];
        const double share = other < g->slope[i] ? other / g->slope[i] : 1.0;
        size = max_of(size, share * share * m->model.transmission.steepest[i]);
    }
    return size;
}

/* m/rad, the terms of an edge factor that do not vanish with the factor, as on a dwell and where a contact begins to
 * lock: its rounding is a share of the largest slope. */
static double slope_terms(const Mechanism *m) {
    return m->model.transmission.straight ? 0.0 : STICK_SLOPE_SHARE * slope_size(m);
}

/* The size of the terms of factor F_0, for a factor of the stick band. The terms of the slopes multiply those of the
 * present F_0 alone, for the rounding of the factor times that of z is of second order. */
static double edge_size(const Mechanism *m, double factor, double F_ext) {
    if (m->model.transmission.straight) return fabs(factor) * axial_size(m, F_ext);
    const double lever = fabs(factor) + m->configuration.geometry.dz_dtheta;
    return lever * axial_size(m, F_ext) + slope_terms(m) * terms_of_load(m, 0.0, F_ext);
}

double stick_torque_size(const Mechanism *m, double factor) {
    return fabs(m->inputs.tau[0]) + edge_size(m, factor, m->inputs.F_ext[0]);
}

static BandFactors band_under(const Mechanism *m, double F_0) {
    Geometry g = m->configuration.geometry;
    cam_set_load(&m->params, F_0, &g);
    return contact_band(&g);
}

BandFactors stick_band(const Mechanism *m) {
    if (m->model.transmission.straight && !m->model.friction_is_loaded) return m->configuration.band;
    return band_under(m, stick_axial_load(m));
}

/* For F_0 < 0 the pins bear on the other flanks: the edges change places. */
static BandFactors edges_of_band(BandFactors band, double side) {
    if (side >= 0.0) return band;
    return (BandFactors){
        .release = band.load, .load = band.release, .release_rate = band.load_rate, .load_rate = band.release_rate};
}

BandFactors stick_edges(const Mechanism *m, double side) {
    return edges_of_band(stick_band(m), side);
}

double stick_edge(double factor, double F_0) {
    return F_0 == 0.0 ? 0.0 : factor * F_0; /* without load there is no friction, also where contacts lock */
}

/* ---- differences that decide by their sign ---- */

/* F_0, or tau less an edge factor F_0, whose sign decides, as a polynomial of the time at rest: u(t) = sum u_k t^k/k!.
 * Below a tie of the size of its terms u is rounding. */
typedef struct {
    double u[INPUT_ORDER + 1];
    bool is_load;
    double factor;
} Difference;

/* The tie of u after t seconds. */
static double tie_at(const Mechanism *m, const Difference *d, double t) {
    const double tau = input_value(m->inputs.tau, t), F_ext = input_value(m->inputs.F_ext, t);
    return stick_tie(m) * (d->is_load ? axial_size(m, F_ext) : fabs(tau) + edge_size(m, d->factor, F_ext));
}

/* The sign of u. Where u is rounding, its first rate decides, if u leaves the rounding in this direction: a torque that
 * touches the edge of the band and turns back is not beyond. 0: u stays rounding for now. */
static int sign_of_difference(const Mechanism *m, const Difference *d) {
    const double tie = tie_at(m, d, 0.0);
    if (fabs(d->u[0]) > tie) return sign_of(d->u[0]);
    const double first = d->u[1] != 0.0 ? d->u[1] : d->u[2] != 0.0 ? d->u[2] : d->u[3];
    return first * taylor_leaving_sign(d->u, tie) > 0.0 ? sign_of(first) : 0;
}

/* F_0 */
static Difference load_of(const Mechanism *m, double F_0) {
    Difference load = {.u = {F_0}, .is_load = true};
    for (int k = 1; k <= INPUT_ORDER; k++) load.u[k] = m->inputs.F_ext[k];
    return load;
}

/* F_0, or, where F_0 is no more than rounding, the sign that F_0 is about to take. */
static double side_of(const Mechanism *m, double F_0) {
    if (stick_force_counts(m, F_0)) return F_0;
    const Difference load = load_of(m, F_0);
    const int coming = sign_of_difference(m, &load);
    return coming != 0 ? coming : F_0;
}

/* The edges per F_0 that tell whether the mechanism rests. Without a load, now and later, each direction has the edge
 * of the load that the spring makes in this direction. */
static BandFactors edges_at_rest(const Mechanism *m, double F_0) {
    const double side = side_of(m, F_0);
    if (side != F_0 || stick_force_counts(m, F_0)) return stick_edges(m, side);
    const BandFactors up = stick_edges(m, 1.0), down = stick_edges(m, -1.0);
    return (BandFactors){
        .load = up.load, .load_rate = up.load_rate, .release = down.release, .release_rate = down.release_rate};
}

/* k-th time derivative of tau - E(F_0) at rest, with `factor` dE/dF_0. Zero if both terms cancel to rounding, or are no
 * more than the rounding of the factor: on a level groove the load passes no torque. Where friction depends on the
 * load, the second derivative of E is left out: it counts only if the first one of F_0 is zero as well. */
static double excess_rate(const Mechanism *m, double factor, int k) {
    const double cancelled = m->model.closed_form ? 0.0 : STICK_RATE_CANCELLED;
    const double tau = m->inputs.tau[k], load = stick_edge(factor, m->inputs.F_ext[k]);
    const double rounding = stick_tie(m) * slope_terms(m) * fabs(m->inputs.F_ext[k]);
    return fabs(tau - load) <= cancelled * (fabs(tau) + fabs(load)) + rounding ? 0.0 : tau - load;
}

/* tau - factor F_0, for a finite factor; `rate`: the derivative of the edge factor F_0 by F_0 */
static Difference excess_of(const Mechanism *m, double factor, double rate, double F_0) {
    Difference excess = {.u = {m->inputs.tau[0] - stick_edge(factor, F_0)}, .factor = factor};
    for (int k = 1; k <= INPUT_ORDER; k++) excess.u[k] = excess_rate(m, rate, k);
    return excess;
}

/* Is tau beyond factor F_0, on the side of `sign`? No torque is beyond an infinite edge. */
static bool is_beyond(const Mechanism *m, double factor, double rate, double F_0, double sign) {
    if (isinf(factor)) return false;
    const Difference excess = excess_of(m, factor, rate, F_0);
    return sign * sign_of_difference(m, &excess) > 0.0;
}

/* ---- decisions ---- */

int stick_direction_beyond_band(const Mechanism *m) {
    const double F_0 = stick_axial_load(m);
    const BandFactors f = edges_at_rest(m, F_0);
    if (is_beyond(m, f.load, f.load_rate, F_0, 1.0)) return 1;
    return is_beyond(m, f.release, f.release_rate, F_0, -1.0) ? -1 : 0;
}

Mode stick_mode(const Mechanism *m) {
    const double F_0 = stick_axial_load(m), frictionless_factor = m->configuration.geometry.dz_dtheta;
    const BandFactors f = edges_at_rest(m, F_0);
    if (isinf(f.release) && is_beyond(m, frictionless_factor, frictionless_factor, F_0, -1.0)) return MODE_WEDGED;
    if (isinf(f.load) && is_beyond(m, frictionless_factor, frictionless_factor, F_0, 1.0)) return MODE_WEDGED;
    return MODE_STICK;
}
/* Is the mechanism wedged above the frictionless torque z' F_0? At that torque, to rounding, the infinite edge
 * decides. */
static bool wedged_above(const Mechanism *m, const BandFactors *band, double F_0) {
    const double frictionless_factor = m->configuration.geometry.dz_dtheta,
                 excess = m->inputs.tau[0] - frictionless_factor * F_0;
    return fabs(excess) <= stick_tie(m) * stick_torque_size(m, frictionless_factor) ? isinf(band->load) : excess > 0.0;
}

/* The factors of the torque interval in which the present mode of rest lasts, with the edges `band`; F_0 is that at the
 * present instant. */
static BandFactors rest_factors(const Mechanism *m, BandFactors band, double F_0, double side) {
    const double frictionless_factor = m->configuration.geometry.dz_dtheta;
    const double release = isfinite(band.release) ? band.release : frictionless_factor;
    const double load = isfinite(band.load) ? band.load : frictionless_factor;
    const double open = side < 0.0 ? -INFINITY : INFINITY;
    const BandFactors above = {.release = load, .load = open}, below = {.release = -open, .load = release};
    switch (m->state.mode) {
        case MODE_LOWER_STOP: return below;
        case MODE_UPPER_STOP: return above;
        case MODE_WEDGED: return wedged_above(m, &band, F_0) ? above : below;
        default: return (BandFactors){.release = release, .load = load};
    }
}

/* The distance from the band's edge, N.m, at which the modes other than stick end: a tie at the edge is stick. */
static double margin(const Mechanism *m, double factor) {
    if (m->state.mode == MODE_STICK) return 0.0;
    return STICK_MARGIN_TIES * stick_tie(m) * fabs(factor) * stick_axial_size(m) + DBL_MIN;
}

RestInterval stick_rest_interval(const Mechanism *m) {
    const double F_0 = stick_axial_load(m);
    const BandFactors f = rest_factors(m, stick_edges(m, F_0), F_0, F_0);
    return (RestInterval){
        .lower = isinf(f.release) ? -INFINITY : stick_edge(f.release, F_0) + margin(m, f.release),
        .upper = isinf(f.load) ? INFINITY : stick_edge(f.load, F_0) - margin(m, f.load),
        .F_ext = m->inputs.F_ext[0],
        .valid = m->state.mode != MODE_WEDGED || stick_direction_beyond_band(m) == 0,
    };
}

/* First time in (0, t_end] at which the polynomial sign * u rises above zero; infinity if the polynomial does not. At
 * time 0 the polynomial is at or below zero, or above zero by rounding. */
NOINLINE static double time_above(const double u[INPUT_ORDER + 1], double sign, double t_end) {
    if (u[2] == 0.0 && u[3] == 0.0) { /* a straight line: the time is exact */
        if (!(sign * u[1] > 0.0)) return INFINITY;
        const double t = max_of(-sign * u[0], 0.0) / (sign * u[1]);
        return t <= t_end ? t : INFINITY;
    }
    double below[INPUT_ORDER + 1];
    for (int k = 0; k <= INPUT_ORDER; k++) below[k] = -sign * u[k];
    below[0] = max_of(below[0], 0.0);
    const Bernstein p = bernstein_of_taylor(below, t_end);
    return t_end * bernstein_descent(&p);
}

/* First time in (0, t_end] at which u rises above zero, on the side of `sign`, and goes on to more than a tie; or
 * infinity. Where u only touches zero, to rounding, u first falls by a tie: then the search goes on. A polynomial of
 * degree 3 rises once more at most. */
static double time_past_zero(const Mechanism *m, const Difference *d, double sign, double t_end) {
    const double first = time_above(d->u, sign, t_end);
    if (!(first < INFINITY)) return INFINITY;
    double u[INPUT_ORDER + 1] = {d->u[0], d->u[1], d->u[2], d->u[3]};
    input_shift(u, first);
    const double tie = tie_at(m, d, first);
    if (sign * taylor_leaving_sign(u, tie) > 0.0) return first;
    const double from_tie[INPUT_ORDER + 1] = {u[0] + sign * tie, u[1], u[2], u[3]};
    const double fall = time_above(from_tie, -sign, t_end - first);
    if (!(fall < INFINITY)) return INFINITY;
    input_shift(u, fall);
    return first + fall + time_above(u, sign, t_end - first - fall);
}

/* First time in (0, t_end] at which tau is beyond factor F_0, on the side of `sign`, by more than `ties` ties; or
 * infinity. */
static double time_beyond(const Mechanism *m, double factor, double F_0, double sign, double ties, double t_end) {
    if (isinf(factor)) return INFINITY;
    Difference excess = excess_of(m, factor, factor, F_0);
    if (ties == 0.0) return time_past_zero(m, &excess, sign, t_end);
    excess.u[0] -= sign * ties * tie_at(m, &excess, 0.0);
    return time_above(excess.u, sign, t_end);
}

/* First time in (0, left] at which F_0 changes its sign. */
static double time_to_mirror(const Mechanism *m, double F_0, double left) {
    Difference load = load_of(m, F_0);
    const double side = side_of(m, F_0);
    if (side * F_0 <= 0.0) load.u[0] = 0.0; /* about to take the sign of `side` */
    if (load.u[0] == 0.0 && inputs_within(&m->inputs, 1)) return INFINITY;
    return time_past_zero(m, &load, side > 0.0 ? -1.0 : 1.0, left);
}

/* Where friction depends on the load and F_ext varies, no edge is a polynomial of time: the excess of the torque over
 * one edge of the rest interval, on the side of `sign`. */
typedef struct {
    const Mechanism *m;
    double spring, F_0, side, sign, ties; /* F_0: at the present instant */
} LoadedRest;

static double loaded_excess(const void *context, double t) {
    const LoadedRest *rest = context;
    const Mechanism *m = rest->m;
    const double tau = input_value(m->inputs.tau, t), F_ext = input_value(m->inputs.F_ext, t);
    const double F_0 = rest->spring + F_ext;
    const BandFactors band = band_under(m, F_0);
    const BandFactors f = rest_factors(m, edges_of_band(band, rest->side), rest->F_0, rest->side);
    const double factor = rest->sign > 0.0 ? f.load : f.release;
    if (isinf(factor)) return -INFINITY;
    const double tie = stick_tie(m) * (fabs(tau) + edge_size(m, factor, F_ext));
    return rest->sign * (tau - stick_edge(factor, F_0)) - rest->ties * tie;
}

/* The zero of the excess between a and b, s, on the side on which the torque has left: where an edge becomes infinite,
 * the excess jumps, and the other side is still rest. An excess of zero at a counts as rest: at F_0 = 0 both the torque
 * and the edge can be zero, while under the smallest load contacts that lock each other hold a torque. */
COLD static double loaded_exit(const LoadedRest *rest, double a, double f_a, double b, double f_b) {
    double t = root_between(loaded_excess, rest, a, min_of(f_a, -DBL_MIN), b, f_b);
    double more = max_of(DBL_EPSILON * b, DBL_TRUE_MIN); /* the product is 0 in steps below 1e-308 s */
    /* At most 53 turns: from a rounding of the time to the whole. */
    for (; t < b && !(loaded_excess(rest, t) > 0.0); more *= 2.0) t += more;
    return min_of(t, b);
}

/* First time in (0, t_end] at which the torque leaves the rest interval on the side of `sign`, or infinity. */
COLD static double loaded_time_beyond(const LoadedRest *rest, double t_end) {
    const FirstPositive exit = golden_section_first_positive(loaded_excess, rest, loaded_excess(rest, 0.0), t_end,
                                                             LOADED_REST_SAMPLES, LOADED_GOLDEN_STEPS);
    if (isinf(exit.x)) return INFINITY;
    return loaded_exit(rest, exit.before, exit.f_before, exit.x, exit.value);
}

/* Time until the torque has left the rest interval by `ties` ties, or F_0 changes its sign. There the band is
 * mirrored, so that the next segment begins. */
static double rest_time(const Mechanism *m, double ties, double left) {
    const double F_0 = stick_axial_load(m);
    const double side = side_of(m, F_0), t_end = min_of(time_to_mirror(m, F_0, left), left);
    if (m->model.friction_is_loaded && !inputs_load_constant(&m->inputs)) {
        LoadedRest rest = {m, spring_force(&m->params.spring, m->configuration.z), F_0, side, 1.0, ties};
        const double load = loaded_time_beyond(&rest, t_end);
        rest.sign = -1.0;
        return min_of(t_end, min_of(load, loaded_time_beyond(&rest, t_end)));
    }
    const BandFactors f = rest_factors(m, stick_edges(m, side), F_0, side);
    const double above = time_beyond(m, f.load, F_0, 1.0, ties, t_end);
    const double below = time_beyond(m, f.release, F_0, -1.0, ties, t_end);
    return min_of(t_end, min_of(above, below));
}

double stick_rest_time(const Mechanism *m, double left) {
    /* Far below the rounding of the step, whose end has other loads; a load that passes zero with the angle would else
     * end rest after rest. */
    const double t = rest_time(m, 0.0, left), least = DBL_EPSILON * DBL_EPSILON * left;
    return t > least ? t : max_of(rest_time(m, STICK_TIES_OF_NO_SLIP, left), least);
}

double stick_sharing(const Mechanism *m, int i) {
    return cam_nominal_load(&m->configuration.geometry, i, 1.0, m->params.contacts);
}

double stick_reaction(const Mechanism *m, int i) {
    return stick_axial_load(m) * stick_sharing(m, i);
}
