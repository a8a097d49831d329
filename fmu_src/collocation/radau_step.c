#include "collocation/radau_step.h"

#include <float.h>
#include <math.h>

#include "platform/attributes.h"

enum { MAX_ITERATIONS = 12 };

/* The iteration ends when the last correction is this share of what the tolerance allows. */
static const double NEWTON_SHARE = 0.05;

/* A step may look this share of a piece's width beyond its ends: the polynomials still hold 11 digits there. */
static const double LOOK_BEYOND = 0.05;

/* Rounding of the forces may be so many times that of what they add up to. */
static const double STALLED = 100.0;

/* Steps whose h |by_omega| + h^2 |by_theta| is below: the derivatives hardly change, and their own terms are small. */
static const double FROZEN = 0.05;

/* Above: a first guess must not follow the tangent. */
static const double STIFF = 0.3;

/* ---- small dense systems ---- */

typedef struct {
    int n;
    double a[RADAU_MAX][RADAU_MAX];
    int pivot[RADAU_MAX];
} Factors;

/* Gaussian elimination with row exchange; false if singular. */
static bool factorize(Factors *f) {
    for (int k = 0; k < f->n; k++) {
        int p = k;
        for (int i = k + 1; i < f->n; i++)
            if (fabs(f->a[i][k]) > fabs(f->a[p][k])) p = i;
        f->pivot[k] = p;
        if (!(fabs(f->a[p][k]) > 0.0)) return false;
        for (int j = 0; p != k && j < f->n; j++) {
            const double swap = f->a[k][j];
            f->a[k][j] = f->a[p][j];
            f->a[p][j] = swap;
        }
        const double inverse = 1.0 / f->a[k][k];
        for (int i = k + 1; i < f->n; i++) {
            const double l = f->a[i][k] *= inverse;
            for (int j = k + 1; j < f->n; j++) f->a[i][j] -= l * f->a[k][j];
        }
    }
    return true;
}

static void solve(const Factors *f, double x[RADAU_MAX]) {
    for (int k = 0; k < f->n; k++) {
        const double swap = x[f->pivot[k]];
        x[f->pivot[k]] = x[k];
        x[k] = swap;
    }
    for (int i = 1; i < f->n; i++)
        for (int j = 0; j < i; j++) x[i] -= f->a[i][j] * x[j];
    for (int i = f->n - 1; i >= 0; i--) {
        for (int j = i + 1; j < f->n; j++) x[i] -= f->a[i][j] * x[j];
        x[i] /= f->a[i][i];
    }
}

/* ---- the collocation equations ---- */

typedef struct {
    const SlipMode *slip;
    const Balance *start;
    const Radau *method;
    double h;
    double lowest, highest;                     /* rad, where the piece's polynomials may be used */
    double y[RADAU_MAX];                        /* alpha_j, or omega_j without inertia */
    double turned[RADAU_MAX], omega[RADAU_MAX]; /* rad, rad/s: what follows from y at the nodes, see place_nodes() */
} System;

static double dot(const double a[RADAU_MAX], const double b[RADAU_MAX], int n) {
    double sum = 0.0;
    for (int j = 0; j < n; j++) sum += a[j] * b[j];
    return sum;
}

/* Columns times y, as far as `width`: a constant where this is inlined, so that the loops have a fixed length. */
static inline void combine_to(int width, const double columns[RADAU_MAX][RADAU_WIDTH], const double y[RADAU_MAX], int n,
                              double out[RADAU_WIDTH]) {
    for (int i = 0; i < width; i++) out[i] = 0.0;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < width; i++) out[i] += columns[j][i] * y[j];
}

/* Integrals of y up to the n nodes, if the columns are the method's. Three stages need half the width. */
static inline void combine(const double columns[RADAU_MAX][RADAU_WIDTH], const double y[RADAU_MAX], int n,
                           double out[RADAU_WIDTH]) {
    if (n <= RADAU_WIDTH / 2) {
        combine_to(RADAU_WIDTH / 2, columns, y, n, out);
    } else {
        combine_to(RADAU_WIDTH, columns, y, n, out);
    }
}

/* theta_i - theta_0 and omega_i from y. */
static void place_nodes(System *s) {
    const Radau *r = s->method;
    const int n = r->stages;
    const double h = s->h, omega = s->start->omega;
    double once[RADAU_WIDTH], twice[RADAU_WIDTH];
    combine(r->once, s->y, n, once);
    if (s->slip->regime != REGIME_INERTIAL) {
        for (int i = 0; i < n; i++) s->turned[i] = h * once[i];
        for (int i = 0; i < n; i++) s->omega[i] = s->y[i];
        return;
    }
    combine(r->twice, s->y, n, twice);
    for (int i = 0; i < n; i++) s->turned[i] = h * (r->node[i] * omega + h * twice[i]);
    for (int i = 0; i < n; i++) s->omega[i] = omega + h * once[i];
}

static bool is_inside(const System *s, double theta) {
    return theta >= s->lowest && theta <= s->highest;
}

/* d theta_i/d y_j and d omega_i/d y_j, weighed with the derivatives of the pace at node i: how a change of y_j changes
 * the pace there. The Newton matrix is 1 less that. */
static double response(const System *s, const RightHandSide *rhs, int i, int j) {
    const Radau *r = s->method;
    const double h = s->h;
    if (s->slip->regime != REGIME_INERTIAL) return rhs->by_theta * h * r->once[j][i];
    return rhs->by_theta * h * h * r->twice[j][i] + rhs->by_omega * h * r->once[j][i];
}

static void fill_row(const System *s, const RightHandSide *rhs, int i, double row[RADAU_MAX]) {
    for (int j = 0; j < s->method->stages; j++) row[j] = -response(s, rhs, i, j);
    row[i] += 1.0;
}

/* Columns of the response, with the derivatives at the start. */
static void build_series(const System *s, double response[RADAU_MAX][RADAU_WIDTH]) {
    const Radau *r = s->method;
    const RightHandSide *p = &s->start->rhs;
    const bool inertial = s->slip->regime == REGIME_INERTIAL;
    const double h = s->h, u = inertial ? p->by_theta * h * h : 0.0, w = (inertial ? p->by_omega : p->by_theta) * h;
    for (int j = 0; j < r->stages; j++)
        for (int i = 0; i < RADAU_WIDTH; i++) response[j][i] = u * r->twice[j][i] + w * r->once[j][i];
}

/* x = (1 - M)^-1 d by x = d + M (d + M (d + M d)): M is small. */
static void solve_by_series(const double M[RADAU_MAX][RADAU_WIDTH], int n, double d[RADAU_MAX]) {
    double x[RADAU_WIDTH] = {0.0}, more[RADAU_WIDTH];
    for (int i = 0; i < n; i++) x[i] = d[i];
    for (int term = 0; term < 3; term++) {
        combine(M, x, n, more);
        for (int i = 0; i < n; i++) x[i] = d[i] + more[i];
    }
    for (int i = 0; i < n; i++) d[i] = x[i];
}

/* Newton's method: the derivatives at the start serve throughout a short step, where a series does for a
 * factorization; else those at the nodes. */
typedef struct {
    bool slow;
    double series[RADAU_MAX][RADAU_WIDTH];
    Factors factors;
} Newton;

/* Paces at the nodes of the present guess; with `balances` everything else there too. */
static bool evaluate(System *s, RightHandSide rhs[RADAU_MAX], Balance *balances) {
    bool possible = true;
    place_nodes(s);
    for (int i = 0; i < s->method->stages; i++) {
        const double theta = s->start->theta + s->turned[i], omega = s->omega[i], t = s->method->node[i] * s->h;
        possible = possible && is_inside(s, theta);
        if (balances != NULL) {
            balance_at(s->slip, theta, omega, t, &balances[i]);
            rhs[i] = balances[i].rhs;
        } else {
            rhs[i] = balance_rhs(s->slip, theta, omega, t);
        }
        possible = possible && rhs[i].possible && isfinite(rhs[i].value);
    }
    return possible;
}

/* One correction of y; returns its largest part, or NAN. `fresh`: with new derivatives. */
static double correct(System *s, const RightHandSide rhs[RADAU_MAX], Newton *newton, bool fresh) {
    const int n = s->method->stages;
    Factors *f = &newton->factors;
    if (fresh) {
        f->n = n;
        for (int i = 0; i < n; i++) fill_row(s, &rhs[i], i, f->a[i]);
        if (!factorize(f)) return NAN;
    }
    double d[RADAU_MAX], largest = 0.0;
    for (int i = 0; i < n; i++) d[i] = rhs[i].value - s->y[i];
    if (newton->slow) solve_by_series(newton->series, n, d);
    else solve(f, d);
    for (int i = 0; i < n; i++) {
        s->y[i] += d[i];
        largest = fmax(largest, fabs(d[i]));
    }
    return isfinite(largest) ? largest : NAN;
}

/* How stiff the step is, by the derivatives at one instant. */
static double stiffness_of(const System *s, const RightHandSide *p) {
    const double h = s->h;
    return s->slip->regime == REGIME_INERTIAL ? h * fabs(p->by_omega) + h * h * fabs(p->by_theta)
                                              : h * fabs(p->by_theta);
}

/* How much more the pace grows over the step than at its rate at the start: from one balance at the step's end, where
 * a constant growth would lead. */
static double dslope_of(const System *s, double rate) {
    const Balance *b = s->start;
    const double h = s->h, grown = b->rhs.value + rate * h;
    const bool inertial = s->slip->regime == REGIME_INERTIAL;
    const double mean = b->rhs.value + 0.5 * rate * h, third = b->rhs.value + rate * h / 3.0;
    const double turned = inertial ? h * (b->omega + 0.5 * h * third) : h * mean;
    const double theta = b->theta + turned, omega = inertial ? b->omega + h * mean : 0.0;
    if (!is_inside(s, theta)) return 0.0;
    const RightHandSide end = balance_rhs(s->slip, theta, omega, h);
    return end.possible && isfinite(end.value) ? end.value - grown : 0.0;
}

/* First guess: the pace grows as at the start, in longer steps as a parabola through the end. Where that is stiff, the
 * equations linearised at the start are solved: y_i = pace + by_theta (theta_i - theta_0) + by_omega (omega_i - omega_0)
 * + by_time t_i. */
static bool guess(System *s, Newton *newton) {
    const Balance *b = s->start;
    const RightHandSide *p = &b->rhs;
    const int n = s->method->stages;
    const double *node = s->method->node;
    const bool inertial = s->slip->regime == REGIME_INERTIAL;
    const double stiffness = stiffness_of(s, p);
    newton->slow = stiffness < FROZEN;
    if (newton->slow) build_series(s, newton->series);
    if (stiffness < STIFF) {
        const double rate = p->by_time + p->by_theta * b->omega + p->by_omega * b->alpha;
        const double dslope_dtheta = n > RADAU_MIN ? dslope_of(s, rate) : 0.0;
        for (int j = 0; j < n; j++) s->y[j] = p->value + node[j] * (rate * s->h + dslope_dtheta * node[j]);
        return true;
    }
    Factors *f = &newton->factors;
    f->n = n;
    for (int i = 0; i < n; i++) fill_row(s, p, i, f->a[i]);
    if (!factorize(f)) return false;
    const double drift = p->by_time + (inertial ? p->by_theta * b->omega : 0.0);
    for (int j = 0; j < n; j++) s->y[j] = p->value + drift * node[j] * s->h;
    solve(f, s->y);
    return true;
}

/* Corrections of y that count as small, at the latest evaluation. */
typedef struct {
    double rounding; /* of y: no correction gets smaller */
    double wanted;   /* by the tolerance */
} Allowed;

static Allowed allowed_correction(const System *s) {
    const int n = s->method->stages;
    double speed = fabs(s->start->omega), y = fabs(s->start->rhs.value);
    for (int i = 0; i < n; i++) {
        speed = fmax(speed, fabs(s->omega[i]));
        y = fmax(y, fabs(s->y[i]));
    }
    const double per_y = s->slip->regime == REGIME_INERTIAL ? speed / s->h : speed;
    return (Allowed){
        .rounding = 8.0 * DBL_EPSILON * fmax(y, s->start->rhs.size),
        .wanted = NEWTON_SHARE * s->slip->params->tolerance * per_y,
    };
}

/* Corrects until a correction is small enough, with new derivatives until only a correction of a correction is left. An
 * iteration that gets no further has met the rounding of the forces. */
static bool iterate(System *s, RadauStep *radau) {
    Newton newton;
    RightHandSide rhs[RADAU_MAX];
    if (!guess(s, &newton)) return false;
    double last = INFINITY;
    for (int n = 0; n < MAX_ITERATIONS; n++) {
        if (!evaluate(s, rhs, n > 0 ? radau->node : NULL)) return false;
        const Allowed allowed = allowed_correction(s);
        const double small = allowed.rounding + (s->slip->to_rounding ? 0.0 : allowed.wanted);
        const bool fresh = !newton.slow && !(last <= 1e6 * small);
        const double size = correct(s, rhs, &newton, fresh);
        if (isnan(size)) return false;
        if (size <= small && n > 0) return true;
        if (n > 3 && size > 0.5 * last) return size <= STALLED * allowed.rounding + allowed.wanted;
        last = size;
    }
    return false;
}

/* ---- the error ---- */

/* omega_0 less the value at 0 of the polynomial through the speeds at the nodes, rad/s. */
static double speed_defect(const System *s) {
    const Radau *r = s->method;
    double sum = 0.0; /* the weights at 0 add up to 1, so omega_0 itself drops out */
    for (int j = 0; j < r->stages; j++) sum += r->at_start[j] * (s->omega[j] - s->start->omega);
    return sum;
}

/* x^(1/2 + s/(s + 1)) for s = 3, 5, 7 stages, by roots: a power would be a tenth of a short step. */
static double gained(double x, int stages) {
    if (stages == 5) return x * cbrt(x);
    const double quarter = sqrt(sqrt(x));
    return stages == 3 ? x * quarter : x * quarter * sqrt(quarter);
}

/* The polynomial misses the derivative at the start by d0, so between the nodes it misses it by about
 * d0 prod(1 - c/c_i), a defect; its integrals are the errors inside the step, damped where the step is stiff. There the
 * angle follows the speed at the nodes, whose own defect then counts. At the end of the step the method is of order
 * 2s - 1, not s + 1; the power takes half of that gain (benchmarks/integrators.py: the errors are then below
 * SAFETY times the tolerance, with all of it they are not). */
static void estimate(const System *s, RadauStep *radau) {
    static const double SAFETY = 10.0;
    const Radau *r = s->method;
    const RightHandSide *p = &s->start->rhs;
    const bool inertial = s->slip->regime == REGIME_INERTIAL;
    const double h = s->h;
    const double defect = fabs(p->value - dot(r->at_start, s->y, r->stages));
    double slip = 0.0, speed = fabs(s->start->omega), stiff = 0.0;
    for (int i = 0; i < r->stages; i++) {
        slip = fmax(slip, fabs(s->turned[i]));
        speed = fmax(speed, fabs(radau->node[i].omega));
        stiff = fmax(stiff, stiffness_of(s, &radau->node[i].rhs));
    }
    const double damped = h * defect / (1.0 + stiff);
    const double noise = 64.0 * DBL_EPSILON * fabs(s->start->theta);
    double by_speed = 0.0, by_angle = damped * r->defect_once;
    if (inertial) {
        by_speed = speed > 0.0 ? damped * r->defect_once / speed : 0.0;
        by_angle = h * (damped * r->defect_twice + fabs(speed_defect(s)) * r->defect_once * stiff / (1.0 + stiff));
    }
    const double inside = fmax(by_speed, fmax(by_angle - noise, 0.0) / (slip + DBL_MIN));
    radau->error = (inside < 1.0 ? gained(inside, r->stages) : inside) * SAFETY / s->slip->params->tolerance;
    radau->stiffness = stiff;
}

/* ---- quasi-static ---- */

/* The angle from `theta` on, in the way's direction, at which the edge of the band is the torque at time t: Newton's
 * method inside a bracket, since an edge that begins level sends the first steps far off. NAN if the edge stops rising
 * before it gets there. */
static double angle_on_edge(const System *s, double theta, double t) {
    enum { ITERATIONS = 100 };
    const int sign = s->slip->direction;
    double from = theta, to = sign > 0 ? s->highest : s->lowest;
    double last = INFINITY;
    for (int n = 0; n < ITERATIONS; n++) {
        const RightHandSide rhs = balance_rhs(s->slip, theta, 0.0, t);
        if (!rhs.possible) return NAN;
        const double short_of = sign * rhs.net; /* torque left, in the direction of the motion */
        if (short_of > 0.0 && !(rhs.by_theta > 0.0)) return NAN;
        if (short_of > 0.0) {
            from = theta;
        } else {
            to = theta;
        }
        double step = rhs.net / rhs.by_theta, next = theta + step;
        if (rhs.by_theta > 0.0 &&
            (fabs(step) <= 2.0 * DBL_EPSILON * fabs(theta) || (n > 4 && fabs(step) >= fabs(last))))
            return next;
        const bool inside = rhs.by_theta > 0.0 && sign * (next - from) >= 0.0 && sign * (to - next) >= 0.0;
        if (!inside && n == 0 && short_of <= 0.0) return next; /* rounding has it past the edge already */
        last = inside ? step : INFINITY;
        if (!inside) next = isfinite(to) ? 0.5 * (from + to) : theta + 0.5 * step;
        if (next == theta) return theta;
        theta = next;
    }
    return NAN;
}

/* theta_i on the edge of the band at t_i, each from the one before. */
static bool follow_edge(const System *s, RadauStep *radau) {
    double theta = s->start->theta;
    for (int i = 0; i < s->method->stages; i++) {
        const double t = s->method->node[i] * s->h;
        theta = angle_on_edge(s, theta, t);
        if (isnan(theta) || !is_inside(s, theta)) return false;
        balance_at(s->slip, theta, 0.0, t, &radau->node[i]);
        if (!(radau->node[i].rhs.by_theta > 0.0)) return false;
    }
    return true;
}

/* How far the rounding of the torques moves theta along an edge that is nearly level, rad. */
static double edge_noise(const System *s, const RadauStep *radau) {
    double noise = 0.0;
    for (int i = 0; i < s->method->stages; i++) {
        const Balance *b = &radau->node[i];
        const double rho = b->force != 0.0 ? b->tau / b->force : 0.0;
        const double torque = fabs(b->tau) + fabs(rho) * (fabs(b->force - b->F_ext) + fabs(b->F_ext));
        noise = fmax(noise, 8.0 * DBL_EPSILON * torque / b->rhs.by_theta);
    }
    return noise;
}

static bool solve_quasistatic(System *s, RadauStep *radau) {
    const Radau *r = s->method;
    if (!follow_edge(s, radau)) return false;
    for (int j = 0; j < r->stages; j++) {
        s->y[j] = radau->node[j].omega;
        radau->turned[j] = radau->node[j].theta - s->start->theta;
    }
    radau->dtheta = radau->node[r->stages - 1].theta - s->start->theta;
    radau->domega = 0.0;
    radau->stiffness = 0.0;
    /* the speeds must add up to the way: what the ledger's integrals will miss */
    const double missed = fabs(radau->dtheta - s->h * dot(r->weight, s->y, r->stages));
    radau->noise = edge_noise(s, radau);
    const double noise = 64.0 * DBL_EPSILON * (fabs(s->start->theta) + fabs(radau->dtheta)) + radau->noise;
    radau->error = fmax(missed - noise, 0.0) / (fabs(radau->dtheta) + DBL_MIN) / s->slip->params->tolerance;
    return true;
}

/* ---- energy ---- */

static Booking booking_of(const SlipMode *slip, const RadauStep *radau) {
    const Radau *r = radau->method;
    Booking sum = {.work_in = 0.0};
    for (int j = 0; j < r->stages; j++) {
        const double weight = radau->h * r->weight[j];
        const Booking power = balance_power(slip, &radau->node[j]);
        sum.work_in += weight * power.work_in;
        sum.work_ext += weight * power.work_ext;
        sum.heat_cam[0] += weight * power.heat_cam[0];
        sum.heat_cam[1] += weight * power.heat_cam[1];
        sum.heat_damper += weight * power.heat_damper;
        sum.heat_shaft += weight * power.heat_shaft;
    }
    return sum;
}

static double kinetic_energy(const SlipMode *slip, const Balance *b) {
    if (slip->regime != REGIME_INERTIAL) return 0.0;
    return kinetic_energy_of(&slip->params->inertia, b->dz_dtheta, b->dpsi_dtheta[0], b->omega);
}

/* Many steps may take energy back and forth: each may miss this share of what the tolerance allows. */
static const double ENERGY_SHARE = 0.1;

double radau_step_energy_error(const SlipMode *slip, const Booking *b, const EnergyEnds *e) {
    const Params *p = slip->params;
    const double spring[2] = {spring_energy(&p->spring, e->z[0]), spring_energy(&p->spring, e->z[1])};
    const double stored = (spring[1] - spring[0]) + (e->kinetic[1] - e->kinetic[0]);
    const double heat = b->heat_cam[0] + b->heat_cam[1] + b->heat_damper + b->heat_shaft;
    const double missed = fabs(b->work_in - b->work_ext - heat - stored);
    const double passed = fabs(b->work_in) + fabs(b->work_ext) + fabs(b->heat_cam[0]) + fabs(b->heat_cam[1]) +
                          b->heat_damper + b->heat_shaft + fabs(spring[1] - spring[0]);
    const double z = fabs(slip->piece->z[0]) + fabs(slip->piece->z[1]); /* what the polynomial's rounding is of */
    const double at_rest = fabs(spring[0]) + fabs(spring[1]) + fabs(e->spring_force) * z;
    const double rounding =
        32.0 * DBL_EPSILON * (passed + at_rest + e->kinetic[0] + e->kinetic[1]) + e->angle_noise * fabs(e->tau);
    return fmax(missed - rounding, 0.0) / (ENERGY_SHARE * p->tolerance * (passed + e->kinetic[1]) + DBL_MIN);
}

static void check_energy(const System *s, RadauStep *radau) {
    const SlipMode *slip = s->slip;
    const Balance *start = s->start, *end = &radau->node[s->method->stages - 1];
    const EnergyEnds ends = {
        .z = {start->z, end->z},
        .kinetic = {kinetic_energy(slip, start), kinetic_energy(slip, end)},
        .spring_force = start->force - start->F_ext,
        .tau = end->tau,
        .angle_noise = radau->noise,
    };
    radau->energy_error = radau_step_energy_error(slip, &radau->booking, &ends);
}

/* ---- the step ---- */

bool radau_step_solve(const SlipMode *slip, const Balance *start, double h, int stages, RadauStep *radau) {
    System s = {.slip = slip, .start = start, .method = radau_of(stages), .h = h};
    const double beyond =
        slip->transmission->straight ? INFINITY : LOOK_BEYOND * (slip->piece->upper - slip->piece->lower);
    s.lowest = slip->piece->lower - beyond;
    s.highest = slip->piece->upper + beyond;
    radau->method = s.method;
    radau->h = h;
    radau->start = *start;
    if (slip->regime == REGIME_RATE_INDEPENDENT) {
        if (!solve_quasistatic(&s, radau)) return false;
        radau->booking = booking_of(slip, radau);
        check_energy(&s, radau);
        return true;
    }
    radau->noise = 0.0;
    if (!iterate(&s, radau)) return false;
    const int last = s.method->stages - 1;
    place_nodes(&s);
    for (int i = 0; i <= last; i++) radau->turned[i] = s.turned[i];
    radau->dtheta = radau->turned[last];
    radau->domega = slip->regime == REGIME_INERTIAL ? h * dot(s.method->weight, s.y, s.method->stages) : 0.0;
    estimate(&s, radau);
    radau->booking = booking_of(slip, radau);
    check_energy(&s, radau);
    return true;
}

/* The collocation equations, differentiated: with y_j the change of alpha (or omega) at node j,
 *     y_i = by_theta_i dtheta_i + by_omega_i domega_i + mobility_i torque
 * where dtheta_i and domega_i follow from y as theta_i and omega_i do. A pole at the end is left out: a root of time,
 * see vary_in_parts(). */
COLD static bool vary(const SlipMode *slip, const RadauStep *radau, double torque, Variation *v) {
    const Radau *r = radau->method;
    const System s = {.slip = slip, .method = r, .h = radau->h};
    const int n = r->stages;
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double omega = inertial ? v->omega : 0.0;
    Factors f = {.n = n};
    static const double POLE = 1e3; /* times as large as at the node before */
    double y[RADAU_MAX], twice = 0.0, before = INFINITY;
    for (int i = 0; i < n; i++) {
        RightHandSide p = radau->node[i].rhs;
        double mobility = balance_mobility(slip, &radau->node[i]);
        if (!(fabs(mobility) <= POLE * before)) mobility = p.by_theta = 0.0;
        before = fabs(mobility);
        fill_row(&s, &p, i, f.a[i]);
        y[i] = p.by_theta * (v->theta + r->node[i] * s.h * omega) + p.by_omega * omega + mobility * torque;
    }
    if (!factorize(&f)) return false;
    solve(&f, y);
    const double once = s.h * dot(r->weight, y, n);
    for (int j = 0; j < n; j++) twice += s.h * s.h * r->twice[j][n - 1] * y[j];
    v->theta += inertial ? s.h * omega + twice : once;
    v->omega = inertial ? omega + once : y[n - 1];
    return true;
}

/* Where a variation has got to. */
typedef struct {
    Inputs inputs;
    Balance at;
    Variation v;
} Front;

/* Moves on by t seconds in one leap. */
COLD static bool move_front(const SlipMode *slip, double t, double torque, Front *front) {
    RadauStep radau;
    SlipMode here = *slip;
    here.inputs = &front->inputs;
    here.to_rounding = true;
    if (!radau_step_solve(&here, &front->at, t, RADAU_MAX, &radau) || !vary(&here, &radau, torque, &front->v))
        return false;
    inputs_advance(&front->inputs, t);
    balance_at(&here, front->at.theta + radau.dtheta, 0.0, 0.0, &front->at);
    return true;
}

/* A leap is as long as the motion allows, which without inertia may be too long for a variation: one that dies out
 * while the motion is steady, or where quadratic damping alone makes speed a root of time. So it is gone through again
 * in leaps that agree with two of half their length, or that are short against the times from start and end, where
 * only rounding can be what differs. Next to start and end it is the root: the errors are of the root of the length, so
 * that one leap and two halves together tell them (Richardson's extrapolation). */
COLD static bool vary_in_parts(const SlipMode *slip, const RadauStep *radau, double torque, Variation *v) {
    enum { TRIALS = 300 };
    static const double ALLOWED = 1e-9, SHORT = 0.25, SHORTEST = 1e-4, ROOT = 3.414213562373095; /* 1/(1 - sqrt(1/2)) */
    Front front = {*slip->inputs, radau->start, *v};
    const double h = radau->h;
    double left = h, step = h, scale = fabs(v->theta);
    for (int n = 0; n < TRIALS && left > 0.0 && step > 0.1 * SHORTEST * h; n++) {
        Front once = front, twice = front;
        step = fmin(step, left);
        const bool is_shortest = step <= SHORTEST * h, is_short = is_shortest || step <= SHORT * fmin(h - left, left);
        bool found = true;
        for (int k = 0; found && k < 3; k++)
            found = move_front(slip, k == 0 ? step : 0.5 * step, torque, k == 0 ? &once : &twice);
        found = found && isfinite(once.v.theta + twice.v.theta);
        if (found) scale = fmax(scale, fabs(twice.v.theta));
        if (found && (is_short || fabs(once.v.theta - twice.v.theta) <= ALLOWED * scale)) {
            front = twice;
            if (is_shortest) front.v.theta = once.v.theta + ROOT * (twice.v.theta - once.v.theta);
            left -= step;
            step *= 4.0;
        } else {
            step *= 0.25;
        }
    }
    *v = front.v;
    return true;
}

COLD bool radau_step_vary(const SlipMode *slip, const RadauStep *radau, double torque, Variation *v) {
    return slip->regime == REGIME_INERTIAL ? vary(slip, radau, torque, v) : vary_in_parts(slip, radau, torque, v);
}

double radau_step_time_scale(const SlipMode *slip, const Balance *b) {
    const RightHandSide *p = &b->rhs;
    double rate = fabs(p->by_omega);
    rate += slip->regime == REGIME_INERTIAL ? sqrt(fabs(p->by_theta)) : fabs(p->by_theta);
    if (slip->regime == REGIME_RATE_INDEPENDENT) rate = 0.0;
    return 1.0 / fmax(rate, DBL_MIN);
}
