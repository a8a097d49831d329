#include "collocation/radau_system.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/lu.h"
#include "numerics/tolerances.h"

_Static_assert((int)RADAU_MAX == (int)LU_MAX, "a row of the Newton matrix is a row of Lu");

RadauSystem radau_system_of(const SlipMode *slip, const Balance *start, double h, int stages) {
    const TransmissionPiece *piece = slip->piece;
    const double beyond = slip->transmission->straight ? INFINITY : RADAU_BEYOND_PIECE * (piece->upper - piece->lower);
    return (RadauSystem){
        .slip = slip,
        .start = start,
        .method = radau_of(stages),
        .h = h,
        .lowest = piece->lower - beyond,
        .highest = piece->upper + beyond,
    };
}

static bool is_inertial(const RadauSystem *s) {
    return s->slip->regime == REGIME_INERTIAL;
}

void radau_system_place_nodes(RadauSystem *s) {
    const Radau *r = s->method;
    const int n = r->stages;
    const double h = s->h, omega = s->start->omega;
    double once[RADAU_WIDTH], twice[RADAU_WIDTH];
    radau_combine(r->once, s->y, n, once);
    if (!is_inertial(s)) {
        for (int i = 0; i < n; i++) s->dtheta[i] = h * once[i];
        for (int i = 0; i < n; i++) s->omega[i] = s->y[i];
        return;
    }
    radau_combine(r->twice, s->y, n, twice);
    for (int i = 0; i < n; i++) s->dtheta[i] = h * (r->node[i] * omega + h * twice[i]);
    for (int i = 0; i < n; i++) s->omega[i] = omega + h * once[i];
}

double radau_system_stiffness(const RadauSystem *s, const RightHandSide *p) {
    const double h = s->h;
    return is_inertial(s) ? h * fabs(p->by_omega) + h * h * fabs(p->by_theta) : h * fabs(p->by_theta);
}

/* The derivative of the right-hand side at node i by y_j. */
static double response(const RadauSystem *s, const RightHandSide *rhs, int i, int j) {
    const Radau *r = s->method;
    const double h = s->h;
    if (!is_inertial(s)) return rhs->by_theta * h * r->once[j][i];
    return rhs->by_theta * h * h * r->twice[j][i] + rhs->by_omega * h * r->once[j][i];
}

void radau_system_newton_row(const RadauSystem *s, const RightHandSide *rhs, int i, double row[RADAU_MAX]) {
    for (int j = 0; j < s->method->stages; j++) row[j] = -response(s, rhs, i, j);
    row[i] += 1.0;
}

/* ---- linear solution ---- */

/* Solves (1 - M) d = r, where M holds the responses. In a short step M is small and the derivatives hardly change: M
 * with the derivatives at the start serves throughout, and a series replaces the factorization. Else M holds the
 * derivatives at the nodes. */
typedef struct {
    bool by_series;
    double response[RADAU_MAX][RADAU_WIDTH]; /* [j][i], at the start */
    Lu lu;
} NewtonMatrix;

/* The responses with the derivatives at the start. */
static void fill_series(const RadauSystem *s, NewtonMatrix *newton) {
    const Radau *r = s->method;
    const RightHandSide *p = &s->start->rhs;
    const bool inertial = is_inertial(s);
    const double h = s->h, u = inertial ? p->by_theta * h * h : 0.0, w = (inertial ? p->by_omega : p->by_theta) * h;
    for (int j = 0; j < r->stages; j++)
        for (int i = 0; i < RADAU_WIDTH; i++) newton->response[j][i] = u * r->twice[j][i] + w * r->once[j][i];
}

/* x = (1 - M)^-1 d by x = d + M (d + M (d + M d)): M is small. */
static void solve_by_series(const NewtonMatrix *newton, int n, double d[RADAU_MAX]) {
    double x[RADAU_WIDTH] = {0.0}, more[RADAU_WIDTH];
    for (int i = 0; i < n; i++) x[i] = d[i];
    for (int term = 0; term < 3; term++) {
        radau_combine(newton->response, x, n, more);
        for (int i = 0; i < n; i++) x[i] = d[i] + more[i];
    }
    for (int i = 0; i < n; i++) d[i] = x[i];
}

/* ---- first guess ---- */

/* How much more the right-hand side grows over the step than at its rate at the start. It is evaluated at the end of
 * the step, where a constant growth would lead. */
static double excess_growth(const RadauSystem *s, double rate) {
    const Balance *b = s->start;
    const double h = s->h, grown = b->rhs.value + rate * h;
    const double mean = b->rhs.value + 0.5 * rate * h, third = b->rhs.value + rate * h / 3.0;
    const double dtheta = is_inertial(s) ? h * (b->omega + 0.5 * h * third) : h * mean;
    const double theta = b->theta + dtheta, omega = is_inertial(s) ? b->omega + h * mean : 0.0;
    if (!radau_system_is_inside(s, theta)) return 0.0;
    const RightHandSide end = balance_rhs(s->slip, theta, omega, h);
    return end.possible && isfinite(end.value) ? end.value - grown : 0.0;
}

/* The right-hand side grows as at the start; in steps of more than three stages as a parabola through the end. */
static void guess_by_growth(RadauSystem *s) {
    const Balance *b = s->start;
    const RightHandSide *p = &b->rhs;
    const int n = s->method->stages;
    const double *node = s->method->node;
    const double rate = p->by_time + p->by_theta * b->omega + p->by_omega * b->alpha;
    const double excess = n > RADAU_MIN ? excess_growth(s, rate) : 0.0;
    for (int j = 0; j < n; j++) s->y[j] = p->value + node[j] * (rate * s->h + excess * node[j]);
}

/* A stiff step: solves the equations linearised at the start,
 *     y_i = value + by_theta (theta_i - theta_0) + by_omega (omega_i - omega_0) + by_time t_i. */
static bool guess_by_linearisation(RadauSystem *s, Lu *lu) {
    const Balance *b = s->start;
    const RightHandSide *p = &b->rhs;
    const int n = s->method->stages;
    lu->n = n;
    for (int i = 0; i < n; i++) radau_system_newton_row(s, p, i, lu->a[i]);
    if (!lu_factorize(lu)) return false;
    const double drift = p->by_time + (is_inertial(s) ? p->by_theta * b->omega : 0.0);
    for (int j = 0; j < n; j++) s->y[j] = p->value + drift * s->method->node[j] * s->h;
    lu_solve(lu, s->y);
    return true;
}

static bool guess(RadauSystem *s, NewtonMatrix *newton) {
    const double stiffness = radau_system_stiffness(s, &s->start->rhs);
    newton->by_series = stiffness < RADAU_SERIES_STIFFNESS;
    if (newton->by_series) fill_series(s, newton);
    if (!(stiffness < RADAU_TANGENT_STIFFNESS)) return guess_by_linearisation(s, &newton->lu);
    guess_by_growth(s);
    return true;
}

/* ---- Newton's method ---- */

/* Right-hand sides at the nodes of the present iterate; with `balances` the whole balances too. False if a node has
 * left the range in which the slip mode is possible: mostly the last node, so that the nodes are visited backwards. */
static bool evaluate(RadauSystem *s, RightHandSide rhs[RADAU_MAX], Balance *balances) {
    radau_system_place_nodes(s);
    for (int i = s->method->stages - 1; i >= 0; i--) {
        const double theta = s->start->theta + s->dtheta[i], omega = s->omega[i], t = s->method->node[i] * s->h;
        if (!radau_system_is_inside(s, theta)) return false;
        if (balances != NULL) {
            balance_at(s->slip, theta, omega, t, &balances[i]);
            rhs[i] = balances[i].rhs;
        } else {
            rhs[i] = balance_rhs(s->slip, theta, omega, t);
        }
        if (!rhs[i].possible || !isfinite(rhs[i].value)) return false;
    }
    return true;
}

/* Corrects y once. `fresh`: with the derivatives at the present nodes. Fills *largest with the largest correction.
 * False if the matrix is singular or a correction is not a number. */
static bool correct(RadauSystem *s, const RightHandSide rhs[RADAU_MAX], NewtonMatrix *newton, bool fresh,
                    double *largest) {
    const int n = s->method->stages;
    Lu *lu = &newton->lu;
    if (fresh) {
        lu->n = n;
        for (int i = 0; i < n; i++) radau_system_newton_row(s, &rhs[i], i, lu->a[i]);
        if (!lu_factorize(lu)) return false;
    }
    double d[RADAU_MAX];
    for (int i = 0; i < n; i++) d[i] = rhs[i].value - s->y[i];
    if (newton->by_series) solve_by_series(newton, n, d);
    else lu_solve(lu, d);
    *largest = 0.0;
    for (int i = 0; i < n; i++) {
        s->y[i] += d[i];
        *largest = max_of(*largest, fabs(d[i]));
    }
    return isfinite(*largest);
}

/* Corrections of y that count as small at the present iterate. */
typedef struct {
    double rounding; /* of y: no correction gets smaller */
    double wanted;   /* by the tolerance */
} SmallCorrection;

/* The Newton matrix of a stiff step divides the rounding of the right-hand sides by the stiffness, and leaves that of
 * the speeds over h. */
static double rounding_of(const RadauSystem *s, double y, double speed) {
    const RightHandSide *rhs = &s->start->rhs;
    const double stiffness = radau_system_stiffness(s, rhs);
    if (!is_inertial(s) || stiffness <= 1.0) return CORRECTION_ROUNDING * max_of(y, rhs->size);
    return CORRECTION_ROUNDING * max_of(max_of(y, speed / s->h), rhs->size / stiffness);
}

static SmallCorrection small_correction(const RadauSystem *s) {
    const int n = s->method->stages;
    double speed = fabs(s->start->omega), slowest = INFINITY, y = fabs(s->start->rhs.value);
    for (int i = 0; i < n; i++) {
        speed = max_of(speed, fabs(s->omega[i]));
        slowest = min_of(slowest, fabs(s->omega[i]));
        y = max_of(y, fabs(s->y[i]));
    }
    const double rounding = rounding_of(s, y, speed);
    if (s->slip->friction_varies) speed = slowest; /* friction at a node needs the node's speed to the same share */
    const double per_y = is_inertial(s) ? speed / s->h : speed;
    return (SmallCorrection){
        .rounding = rounding,
        .wanted = ITERATION_SHARE * s->slip->params->tolerance * per_y,
    };
}

/* Newton's method with new derivatives until only a correction of a correction is left. An iteration whose corrections
 * no longer shrink has reached the rounding of the forces. */
bool radau_system_solve(RadauSystem *s, Balance node[RADAU_MAX]) {
    NewtonMatrix newton;
    RightHandSide rhs[RADAU_MAX];
    if (!guess(s, &newton)) return false;
    double last = INFINITY, size;
    for (int n = 0; n < RADAU_NEWTON_ITERATIONS; n++) {
        slip_count(s->slip, s->method->stages);
        if (!evaluate(s, rhs, n > 0 ? node : NULL)) return false;
        const SmallCorrection allowed = small_correction(s);
        const double small = allowed.rounding + (s->slip->to_rounding ? 0.0 : allowed.wanted);
        const bool fresh = !newton.by_series && !(last <= RADAU_CHORD_BELOW * small);
        if (!correct(s, rhs, &newton, fresh, &size)) return false;
        if (size <= small && n > 0) return true;
        if (n > 3 && size > 0.5 * last) return size <= RADAU_STALLED * allowed.rounding + allowed.wanted;
        last = size;
    }
    return false;
}

/* ---- the edge of the stick band ---- */

/* Bracket invariant: the edge is below the torque at `from`, and not below the torque at `to`, which may be infinite.
 * `from` is the start of the search until the edge has been found below the torque. */
typedef struct {
    double from, to; /* rad */
    double last;     /* rad, latest Newton step; infinite after a bisection */
} EdgeBracket;

typedef enum { EDGE_FOUND, EDGE_SEARCHING, EDGE_LOST } EdgeProgress;

/* One iteration from *theta: a Newton step, or the middle of the bracket if the Newton step leaves it. EDGE_FOUND:
 * *theta is the solution. EDGE_LOST: the edge does not rise to the torque. */
static EdgeProgress improve_angle(const RadauSystem *s, double t, int n, EdgeBracket *bracket, double *theta) {
    const int sign = s->slip->direction;
    const RightHandSide rhs = balance_rhs(s->slip, *theta, 0.0, t);
    const double torque_left = sign * rhs.net; /* in the direction of the motion */
    const bool rises = rhs.by_theta > 0.0;
    if (!rhs.possible || (torque_left > 0.0 && !rises)) return EDGE_LOST;
    if (torque_left > 0.0) {
        bracket->from = *theta;
    } else {
        bracket->to = *theta;
    }
    const double step = rhs.net / rhs.by_theta;
    double next = *theta + step;
    const bool exact = fabs(step) <= ROOT_WIDTH * fabs(*theta) || (n > 4 && fabs(step) >= fabs(bracket->last));
    const bool inside = rises && sign * (next - bracket->from) >= 0.0 && sign * (bracket->to - next) >= 0.0;
    const bool starts_past_edge = !inside && n == 0 && torque_left <= 0.0; /* by rounding */
    if ((rises && exact) || starts_past_edge) {
        *theta = next;
        return EDGE_FOUND;
    }
    bracket->last = inside ? step : INFINITY;
    if (!inside) next = isfinite(bracket->to) ? 0.5 * (bracket->from + bracket->to) : *theta + 0.5 * step;
    if (next == *theta) return EDGE_FOUND;
    *theta = next;
    return EDGE_SEARCHING;
}

/* Moves *theta, in the direction of the slip, to where the edge of the band is the torque at time t. Newton's method
 * inside a bracket: an edge that begins level sends the first Newton steps far off. */
static bool find_angle_on_edge(const RadauSystem *s, double t, double *theta) {
    EdgeBracket bracket = {
        .from = *theta,
        .to = s->slip->direction > 0 ? s->highest : s->lowest,
        .last = INFINITY,
    };
    for (int n = 0; n < BRACKET_ITERATIONS; n++) {
        slip_count(s->slip, 1);
        const EdgeProgress progress = improve_angle(s, t, n, &bracket, theta);
        if (progress != EDGE_SEARCHING) return progress == EDGE_FOUND;
    }
    return false;
}

bool radau_system_follow_edge(const RadauSystem *s, Balance node[RADAU_MAX], double *noise) {
    double theta = s->start->theta;
    *noise = 0.0;
    for (int i = 0; i < s->method->stages; i++) {
        const double t = s->method->node[i] * s->h;
        Balance *b = &node[i];
        if (!find_angle_on_edge(s, t, &theta) || !radau_system_is_inside(s, theta)) return false;
        balance_at(s->slip, theta, 0.0, t, b);
        if (!(b->rhs.by_theta > 0.0)) return false;
        const double rho = b->force != 0.0 ? b->tau / b->force : 0.0;
        const double torque = fabs(b->tau) + fabs(rho) * (fabs(b->force - b->F_ext) + fabs(b->F_ext));
        *noise = max_of(*noise, STICK_TIE_STRAIGHT * torque / b->rhs.by_theta);
    }
    return true;
}
