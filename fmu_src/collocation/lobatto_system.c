#include "collocation/lobatto_system.h"

#include "elementary/elementary.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- the kinematics at two nodes ---- */

typedef struct {
    Vector2 slope[2], dslope_dtheta[2], z;
} PointPair;

static inline PointPair point_pair(const TransmissionPiece *piece, Vector2 theta, TransmissionDepth depth) {
    const TransmissionPoint a = piece_point(piece, theta[0], depth), b = piece_point(piece, theta[1], depth);
    PointPair points = {.z = {a.z, b.z}};
    for (int i = 0; i < 2; i++) {
        points.slope[i] = (Vector2){a.slope[i], b.slope[i]};
        points.dslope_dtheta[i] = (Vector2){a.dslope_dtheta[i], b.dslope_dtheta[i]};
    }
    return points;
}

NOINLINE static void find_curved_points(const SlipMode *slip, Vector2 theta, PointPair *out) {
    *out = slip->follower_has_inertia ? point_pair(slip->piece, theta, TRANSMISSION_FIRST_DERIVATIVES)
                                      : point_pair(slip->piece, theta, TRANSMISSION_SLOPES);
}

static inline PointPair points_at(const SlipMode *slip, Vector2 theta) {
    const TransmissionPiece *piece = slip->piece;
    PointPair points;
    if (slip->transmission->straight) {
        const Vector2 none = {0.0, 0.0};
        points = (PointPair){.slope = {none + piece->slope[0][0], none + piece->slope[0][1]}};
        points.z = piece->z[0] + theta * piece->z[1];
    } else {
        find_curved_points(slip, theta, &points);
    }
    return points;
}

/* The kinematics of docs/mechanism.md, section 2. */
static inline void find_kinematics(const SlipMode *slip, Vector2 theta, NodePair *n) {
    const PointPair points = points_at(slip, theta);
    const Vector2 none = {0.0, 0.0}; /* a negative slope is rounding of the polynomial of a level groove */
    for (int i = 0; i < 2; i++) n->slope[i] = vector2_max(points.slope[i], none);
    const Vector2 inverse = 1.0 / (n->slope[0] + n->slope[1]);
    n->z = points.z;
    n->dpsi_dtheta[0] = n->slope[1] * inverse;
    n->dpsi_dtheta[1] = n->slope[0] * inverse;
    n->dz_dtheta = n->slope[0] * n->dpsi_dtheta[0];
    if (!slip->follower_has_inertia) return;
    n->d2gamma_dtheta2 =
        (points.dslope_dtheta[1] * n->dpsi_dtheta[1] - points.dslope_dtheta[0] * n->dpsi_dtheta[0]) * inverse;
    n->d2z_dtheta2 = points.dslope_dtheta[0] * n->dpsi_dtheta[0] * n->dpsi_dtheta[0] +
                     points.dslope_dtheta[1] * n->dpsi_dtheta[1] * n->dpsi_dtheta[1];
}

/* ---- the balance at two nodes, see balance.h ---- */

static inline void set_law(LobattoSystem *s) {
    const SlipMode *slip = s->slip;
    s->end_speed.given = false;
    for (int i = 0; i < 2; i++) s->law[i] = &slip->law[i].near[friction_sign_index(slip->direction * slip->flank[i])];
    s->has_tables = s->law[0]->has_table || s->law[1]->has_table;
    s->by_speed = any_friction_depends_on_speed(slip->params);
    s->has_loads = any_friction_depends_on_load(slip->params);
}

void lobatto_system_begin(LobattoSystem *s, const SlipMode *slip) {
    s->slip = slip;
    s->has_damper = slip->c + slip->q > 0.0;
    s->is_resisted = slip->follower_has_inertia || s->has_damper || slip->params->shaft.damping > 0.0;
    s->by_speed = s->has_loads = false;
    if (slip->friction_varies) set_law(s);
}

/* D. Without a damper the branch saves the wait for z' and a product with zero, which would cost as much as the other
 * forces of a sweep. */
static inline Vector2 damper_at(const LobattoSystem *s, Vector2 dz_dtheta, Vector2 omega) {
    const SlipMode *slip = s->slip;
    const Vector2 none = {0.0, 0.0}, v = dz_dtheta * omega;
    return s->has_damper ? v * (slip->c + slip->q * slip->direction * v) : none;
}

VectorFriction lobatto_friction(const LobattoSystem *s, int i, Vector2 v, Vector2 load2) {
    const FrictionNearby *law = s->law[i];
    if (!law->has_table) return friction_by_law(law, &s->load[i], v, load2);
    if (s->patch[i] != NULL) return friction_on_patch(law->sign, s->patch[i], s->piece[i], v, load2);
    return friction_on_piece(law->sign, s->piece[i], v);
}

NOINLINE static void find_friction_by_tables(const LobattoSystem *s, const Vector2 load2[2], NodePair *n) {
    for (int i = 0; i < 2; i++) {
        const VectorFriction f = lobatto_friction(s, i, n->omega * n->sliding[i], load2[i]);
        n->friction[i] = f.value;
        n->dfriction_domega[i] = f.by_speed * n->sliding[i];
    }
}

/* m: v_i per omega. */
static inline Vector2 sliding_at(const LobattoSystem *s, const NodePair *n, int i) {
    const Vector2 length2 = s->law[i]->radius2 + n->slope[i] * n->slope[i];
    return s->slip->direction * n->dpsi_dtheta[i] * (Vector2){sqrt(length2[0]), sqrt(length2[1])};
}

/* N^2, the square of F at the speeds of two nodes. */
static inline Vector2 force2_at(const LobattoSystem *s, Vector2 omega, const NodePair *n) {
    const Vector2 force = n->force + damper_at(s, n->dz_dtheta, omega);
    return force * force;
}

/* Where friction depends on the load alone: f_i at two nodes. */
NOINLINE static void find_loaded_friction(const LobattoSystem *s, Vector2 omega, NodePair *n) {
    const Vector2 force2 = force2_at(s, omega, n);
    for (int i = 0; i < 2; i++) {
        const FrictionNearby *law = s->law[i];
        const Vector2 sliding = n->sliding[i] = sliding_at(s, n, i);
        n->friction[i] = law->kinetic;
        if (law->half_exponent[0] != 0.0)
            n->friction[i] *= friction_load_power_near(law, &s->load[i], force2 * (sliding * sliding) * law->per_load2);
    }
}

/* Where friction depends on the speed: f_i at the speeds of two nodes, under their force F. */
ALWAYS_INLINE static inline void find_friction(const LobattoSystem *s, Vector2 omega, NodePair *n) {
    const Vector2 none = {0.0, 0.0}, force2 = s->has_loads ? force2_at(s, omega, n) : none;
    Vector2 load2[2];
    n->omega = omega;
    for (int i = 0; i < 2; i++) {
        const Vector2 sliding = n->sliding[i] = sliding_at(s, n, i);
        load2[i] = force2 * (sliding * sliding) * s->law[i]->per_load2;
        if (s->has_tables) continue;
        const VectorFriction f = friction_by_law(s->law[i], &s->load[i], omega * sliding, load2[i]);
        n->friction[i] = f.value;
        n->dfriction_domega[i] = f.by_speed * sliding;
    }
    if (s->has_tables) find_friction_by_tables(s, load2, n);
}

static inline void set_varying_factors(const LobattoSystem *s, int i, NodePair *n) {
    vector_contact_factors_set_varying(&n->factors, i, s->law[i]->radius, s->law[i]->radius2, n->friction[i],
                                       n->slope[i]);
}

/* Where friction varies: the friction at the speeds of the solution, to first order. The last sweep has changed the
 * speeds by more than the next one would; reactions and heat follow friction. */
static void follow_speeds(LobattoSystem *s) {
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        NodePair *n = &s->pair[k];
        for (int i = 0; i < 2; i++) {
            n->friction[i] += n->dfriction_domega[i] * (s->speed.half[k] - n->omega);
            set_varying_factors(s, i, n);
        }
        vector_contact_factors_multiply(&n->factors);
    }
}

/* rad/s: the largest difference between the speeds and those at which the balances were taken last. */
static inline double speeds_moved(const LobattoSystem *s) {
    LobattoValues change;
    for (int k = 0; k < LOBATTO_HALVES; k++) change.half[k] = s->speed.half[k] - s->pair[k].omega;
    return lobatto_largest(lobatto_range(&change));
}

/* All that depends on theta, F_ext and, where friction varies, on the speed. */
ALWAYS_INLINE static inline void find_factors(const LobattoSystem *s, Vector2 theta, Vector2 F_ext, Vector2 omega,
                                              bool varies, NodePair *n) {
    const SlipMode *slip = s->slip;
    const SpringParams *spring = &slip->params->spring;
    find_kinematics(slip, theta, n);
    const Vector2 rate = spring->stiffness + n->z * (spring->stiffness2 + n->z * spring->stiffness3);
    n->force = spring->preload + n->z * rate + F_ext;
    if (varies) find_friction(s, omega, n);
    else if (s->has_loads) find_loaded_friction(s, omega, n);
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius;
        if (varies || s->has_loads) set_varying_factors(s, i, n);
        else vector_contact_factors_set(&n->factors, i, r, slip->signed_friction[i], n->slope[i]);
    }
    vector_contact_factors_multiply(&n->factors);
}

/* 1/s: minus the derivative of alpha by the speed through the friction coefficients. */
static inline Vector2 friction_damping(const LobattoSystem *s, Vector2 torque, Vector2 omega, Vector2 alpha,
                                       const NodePair *n) {
    const SlipMode *slip = s->slip;
    const InertiaParams *in = &slip->params->inertia;
    const VectorContactFactors *f = &n->factors;
    const Vector2 rn[2] = {s->law[0]->radius2 * n->dfriction_domega[0], s->law[1]->radius2 * n->dfriction_domega[1]};
    const Vector2 d[2] = {-n->slope[0] * n->dfriction_domega[0], -n->slope[1] * n->dfriction_domega[1]};
    const Vector2 q = d[0] * f->rn[1] + f->d[0] * rn[1], delta = q + rn[0] * f->d[1] + f->rn[0] * d[1];
    const Vector2 p = rn[0] * f->rn[1] + f->rn[0] * rn[1];
    Vector2 change = delta * (torque - in->shaft * alpha) - p * (n->force + n->damper);
    if (slip->follower_has_inertia) {
        const Vector2 m = p * in->follower_mass, I = q * in->follower;
        change -= (m * n->d2z_dtheta2 + I * n->d2gamma_dtheta2) * omega * omega +
                  (m * n->dz_dtheta + I * n->dpsi_dtheta[0]) * alpha;
    }
    return -change / n->mass;
}

/* alpha */
static inline Vector2 inertial_rhs(const LobattoSystem *s, Vector2 tau, Vector2 omega, bool varies, bool first,
                                   NodePair *n) {
    const SlipMode *slip = s->slip;
    const InertiaParams *in = &slip->params->inertia;
    const VectorContactFactors *f = &n->factors;
    const double b = slip->params->shaft.damping;
    n->damper = damper_at(s, n->dz_dtheta, omega);
    Vector2 net = f->delta * (tau - b * omega) - f->p * (n->force + n->damper), swirl = {0.0, 0.0};
    n->mass = in->shaft * f->delta;
    if (slip->follower_has_inertia) {
        const Vector2 m = f->p * in->follower_mass, I = f->q * in->follower;
        n->mass += m * n->dz_dtheta + I * n->dpsi_dtheta[0];
        swirl = (m * n->d2z_dtheta2 + I * n->d2gamma_dtheta2) * omega;
        net -= swirl * omega;
    }
    if (s->is_resisted) {
        const Vector2 resistance = slip->c + 2.0 * slip->q * slip->direction * (n->dz_dtheta * omega); /* dD/dv */
        n->damping_rate = (b * f->delta + f->p * n->dz_dtheta * resistance + 2.0 * swirl) / n->mass;
    }
    const Vector2 alpha = net / n->mass;
    if (varies) {
        if (first) n->friction_damping = friction_damping(s, tau - b * omega, omega, alpha, n);
        n->damping_rate = s->is_resisted ? n->damping_rate + n->friction_damping : n->friction_damping;
    }
    return alpha;
}

/* omega from B omega + C omega |omega| = N, see balance.c. */
static inline Vector2 viscous_rhs(const LobattoSystem *s, Vector2 tau, NodePair *n) {
    const SlipMode *slip = s->slip;
    const VectorContactFactors *f = &n->factors;
    const Vector2 lever = f->p * n->dz_dtheta, net = f->delta * tau - f->p * n->force;
    n->mass = slip->params->shaft.damping * f->delta + slip->c * lever;
    Vector2 sum = 2.0 * n->mass;
    if (slip->q > 0.0) {
        const Vector2 square = n->mass * n->mass + (4.0 * slip->q * slip->direction) * lever * n->dz_dtheta * net;
        sum = n->mass + (Vector2){sqrt(square[0]), sqrt(square[1])};
    }
    const Vector2 omega = 2.0 * net / sum;
    n->damper = damper_at(s, n->dz_dtheta, omega);
    return omega;
}

/* With inertia: the balance at pair k of nodes. */
ALWAYS_INLINE static inline void evaluate_inertial(LobattoSystem *s, int k, bool varies, bool first) {
    NodePair *n = &s->pair[k];
    find_factors(s, s->theta + s->dtheta.half[k], s->F_ext.half[k], s->speed.half[k], varies, n);
    s->y.half[k] = inertial_rhs(s, s->tau.half[k], s->speed.half[k], varies, first, n);
}

NOINLINE static void evaluate_varying(LobattoSystem *s, int k, bool first) {
    evaluate_inertial(s, k, true, first);
}

/* The balances at the nodes. Friction varies with inertia only. */
ALWAYS_INLINE static inline void evaluate(LobattoSystem *s, bool varies, bool first) {
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        NodePair *n = &s->pair[k];
        if (varies) evaluate_varying(s, k, first);
        else if (lobatto_system_is_inertial(s)) evaluate_inertial(s, k, false, first);
        else {
            find_factors(s, s->theta + s->dtheta.half[k], s->F_ext.half[k], s->speed.half[k], false, n);
            s->y.half[k] = s->speed.half[k] = viscous_rhs(s, s->tau.half[k], n);
        }
    }
}

double lobatto_system_speed_at_end(LobattoSystem *s) {
    const int last = LOBATTO_HALVES - 1;
    NodePair pair;
    find_factors(s, s->theta + s->dtheta.half[last], s->F_ext.half[last], s->speed.half[last], false, &pair);
    return viscous_rhs(s, s->tau.half[last], &pair)[1];
}

/* True if at every node the slip mode is possible, if without inertia the motion is stable and the flanks support it,
 * and where friction varies if Delta keeps its sign. */
static inline bool is_possible(const LobattoSystem *s, bool varies) {
    bool possible = true;
    for (int k = 0; k < LOBATTO_NODES; k++) {
        const NodePair *n = &s->pair[k / 2];
        const double mass = n->mass[k % 2], delta = n->factors.delta[k % 2];
        if (varies) possible &= delta * s->pair[0].factors.delta[0] > 0.0;
        possible &= varies || lobatto_system_is_inertial(s) ? mass * delta > 0.0
                                                            : delta > 0.0 && mass >= 0.0 && n->factors.p[k % 2] > 0.0;
    }
    return possible;
}

/* ---- iteration ---- */

void lobatto_system_guess(LobattoSystem *s, double rhs) {
    const double alpha = lobatto_system_is_inertial(s) ? rhs : 0.0;
    s->y = lobatto_constant(rhs);
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        const Vector2 t = s->h * LOBATTO.node.half[k];
        s->speed.half[k] = s->omega + alpha * t;
        s->dtheta.half[k] = t * (s->omega + 0.5 * alpha * t);
    }
}

ALWAYS_INLINE static inline void place_nodes(LobattoSystem *s, bool varies) {
    const double h = s->h;
    const LobattoValues once = lobatto_combine(LOBATTO.once, &s->y);
    if (!varies && !lobatto_system_is_inertial(s)) {
        for (int k = 0; k < LOBATTO_HALVES; k++) s->dtheta.half[k] = h * once.half[k];
        return;
    }
    const LobattoValues twice = lobatto_combine(LOBATTO.twice, &s->y);
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        s->dtheta.half[k] = h * (LOBATTO.node.half[k] * s->omega + h * twice.half[k]);
        s->speed.half[k] = s->omega + h * once.half[k];
    }
}

/* Estimate of the change of y by the next sweep. `change` is the change by the latest sweep. y is taken to grow with
 * theta at its mean rate over the step; the known dependence on the speed is taken off. */
static inline LobattoValues predict_change(const LobattoSystem *s, const LobattoValues *change, bool varies) {
    const double h = s->h, per_angle = 1.0 / s->dtheta.at[LOBATTO_END];
    double growth = (s->y.at[LOBATTO_END] - s->y.at[0]) * per_angle;
    LobattoValues next = lobatto_combine(LOBATTO.once, change);
    if (!varies && !lobatto_system_is_inertial(s)) {
        for (int k = 0; k < LOBATTO_HALVES; k++) next.half[k] *= growth * h;
        return next;
    }
    const bool resisted = s->is_resisted || varies;
    if (resisted)
        growth += s->pair[LOBATTO_HALVES - 1].damping_rate[1] * (s->speed.at[LOBATTO_END] - s->omega) * per_angle;
    const LobattoValues twice = lobatto_combine(LOBATTO.twice, change);
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        const Vector2 by_angle = growth * h * h * twice.half[k];
        next.half[k] = resisted ? by_angle - s->pair[k].damping_rate * (h * next.half[k]) : by_angle;
    }
    return next;
}

static inline void find_inputs(LobattoSystem *s) {
    const Inputs *in = s->slip->inputs;
    s->tau = lobatto_constant(in->tau[0]);
    s->F_ext = lobatto_constant(in->F_ext[0]);
    for (int k = 1; k < LOBATTO_NODES && !s->slip->inputs_are_constant; k++) {
        const double t = s->h * LOBATTO.node.at[k];
        s->tau.at[k] = input_value(in->tau, t);
        s->F_ext.at[k] = input_value(in->F_ext, t);
    }
}

/* Corrects h so that the step ends at the angle; returns by how much the step missed the angle, rad. */
static inline double aim_at_end(LobattoSystem *s, const EndAngle *end) {
    const int direction = s->slip->direction;
    const double missed = end->distance - direction * s->dtheta.at[LOBATTO_END];
    s->h += direction * missed / s->speed.at[LOBATTO_END];
    place_nodes(s, false);
    return missed;
}

/* Corrects h so that the sliding speed of a contact ends at the sample; false if the speed missed the sample before.
 * The groove's part of the acceleration is taken to be constant over the step. */
static bool aim_at_sample(LobattoSystem *s) {
    const EndSpeed *end = &s->end_speed;
    const double omega = s->speed.at[LOBATTO_END], sliding = s->pair[LOBATTO_HALVES - 1].sliding[end->contact][1];
    const double v = omega * sliding, missed = end->speed - v;
    if (fabs(missed) <= end->slack || s->h >= end->longest) return true;
    const double bend = s->h * s->y.at[LOBATTO_END] - (omega - s->omega); /* of the speed, over the step */
    s->h = min_of(s->h * (1.0 + missed / (v - end->start + sliding * bend)), end->longest);
    place_nodes(s, false);
    return false;
}

/* One evaluation at the nodes; returns the change of y. */
ALWAYS_INLINE static inline LobattoValues sweep(LobattoSystem *s, bool varies, bool first) {
    LobattoValues change = s->y;
    evaluate(s, varies, first);
    for (int k = 0; k < LOBATTO_HALVES; k++) change.half[k] = s->y.half[k] - change.half[k];
    return change;
}

/* Were the forces found near enough to the angle at which the step ends? Where alpha hardly depends on the speed, the
 * last prediction is small long before. */
static inline bool is_placed(const LobattoSystem *s) {
    const double theta = s->theta + s->dtheta.at[LOBATTO_END];
    return fabs(s->end_shift) <= LOBATTO_SHIFT_SHARE * s->slip->params->tolerance * fabs(theta);
}

/* ---- the first iterate where friction varies ---- */

static inline Vector2 inputs_in_middle_and_at_end(const LobattoSystem *s, const double input[]) {
    return (Vector2){input_value(input, 0.5 * s->h), input_value(input, s->h)};
}

static void place_on_parabola(LobattoSystem *s, const Parabola *p) {
    const double h = s->h;
    for (int k = 0; k < LOBATTO_HALVES; k++) {
        const Vector2 node = LOBATTO.node.half[k];
        s->y.half[k] = parabola_at(p, node);
        s->speed.half[k] = s->omega + h * parabola_once(p, node);
        s->dtheta.half[k] = h * (node * s->omega + h * parabola_twice(p, node));
    }
}

/* Half a sweep: one pair of nodes, the middle and the end of the step under constant acceleration. The parabola through
 * alpha there, with the change by the next sweep, and at the start is a first iterate at the nodes whose error is of
 * third order. alpha at the start is that of the first guess. */
NOINLINE static Parabola guess_parabola(LobattoSystem *s) {
    const double h = s->h, rhs = s->y.at[0];
    const Vector2 c = {0.5, 1.0}, t = h * c;
    NodePair *n = &s->pair[1];
    s->speed.half[1] = s->omega + rhs * t;
    s->dtheta.half[1] = t * (s->omega + 0.5 * rhs * t);
    if (!s->slip->inputs_are_constant) {
        s->tau.half[1] = inputs_in_middle_and_at_end(s, s->slip->inputs->tau);
        s->F_ext.half[1] = inputs_in_middle_and_at_end(s, s->slip->inputs->F_ext);
    }
    evaluate_varying(s, 1, true);
    Vector2 alpha = s->y.half[1];
    const double turned = s->dtheta.half[1][1], gained = s->speed.half[1][1] - s->omega;
    const double growth = (alpha[1] - rhs + n->damping_rate[1] * gained) / turned;
    Parabola change = parabola_through(0.0, alpha - rhs);
    for (int k = 0; k < 2; k++) {
        const Vector2 next =
            h * (h * growth * parabola_twice(&change, c) - n->damping_rate * parabola_once(&change, c));
        change = parabola_through(0.0, next);
        alpha += next;
    }
    const Parabola p = parabola_through(rhs, alpha);
    place_on_parabola(s, &p);
    return p;
}

/* The first iterate of a step that is to end at an angle or a sliding speed, if one is given. */
ALWAYS_INLINE static inline void guess_step(LobattoSystem *s, const EndAngle *end) {
    const double h = s->h;
    Parabola p = guess_parabola(s);
    if (end->given) aim_at_end(s, end);
    if (s->end_speed.given) aim_at_sample(s);
    const double longer = s->h / h;
    if (longer == 1.0) return;
    p.linear *= longer;
    p.square *= longer * longer;
    place_on_parabola(s, &p);
}

/* ---- the sweeps ---- */

/* `varies` is a constant of the compiler: friction that does not vary costs nothing. Friction that varies makes alpha
 * depend on the speed more than all else does. Then the last prediction is part of the solution: its own error is a
 * tenth of it or less. The first sweep may be the last one, for guess_parabola() precedes it; a step that it shows to
 * be far from accurate needs no other. */
ALWAYS_INLINE static inline bool solve_with(LobattoSystem *s, const EndAngle *end, bool varies) {
    const SlipMode *slip = s->slip;
    const double per_y = varies || lobatto_system_is_inertial(s) ? s->h : 1.0;
    const double share = ITERATION_SHARE * slip->params->tolerance, speed = fabs(s->omega);
    double before = INFINITY, missed = 0.0;
    if (varies) {
        if (slip->inputs_are_constant) find_inputs(s);
        guess_step(s, end);
    }
    const bool length_changes = end->given || (varies && s->end_speed.given);
    const bool inputs_change = length_changes && !slip->inputs_are_constant;
    for (int n = 0; n < LOBATTO_SWEEPS; n++) {
        const double end_before = s->dtheta.at[LOBATTO_END];
        if ((n == 0 && !(varies && slip->inputs_are_constant)) || inputs_change) find_inputs(s);
        const LobattoValues change = sweep(s, varies, n == 0);
        const double size = lobatto_largest(lobatto_range(&change));
        const LobattoValues next = predict_change(s, &change, varies);
        /* Where the motion slows down, friction needs the lower speed to the same share. */
        const double end_speed = fabs(s->speed.at[LOBATTO_END]);
        const double slowed = varies && end_speed < speed ? end_speed : speed;
        const double allowed = varies ? LOBATTO_LAST_SHARE / ITERATION_SHARE * share : share;
        bool converged = (varies || n > 0) && lobatto_largest(lobatto_range(&next)) <= allowed * slowed / per_y;
        for (int k = 0; k < LOBATTO_HALVES && (varies || !converged); k++) s->y.half[k] += next.half[k];
        place_nodes(s, varies);
        if (end->given) missed = aim_at_end(s, end);
        const bool at_sample = !varies || !s->end_speed.given || aim_at_sample(s);
        s->end_shift = s->dtheta.at[LOBATTO_END] - end_before;
        const bool at_end = !end->given || fabs(missed) <= min_of(end->slack, LOBATTO_AIM_SHARE * end->distance);
        if (converged && at_end && at_sample && (!varies || is_placed(s))) {
            if (varies && speeds_moved(s) > share * slowed) follow_speeds(s);
            return is_possible(s, varies);
        }
        if (varies && n == 0 && !lobatto_is_accurate(s, LOBATTO_FAR_OFF)) return false;
        if (n > 0 && !(size <= LOBATTO_CONTRACTION * before)) {
            const double rounding = CORRECTION_ROUNDING * lobatto_largest(lobatto_range(&s->y));
            return at_end && size <= rounding && is_possible(s, varies);
        }
        before = size;
    }
    return false;
}

NOINLINE static bool solve_varying(LobattoSystem *s, const EndAngle *end) {
    return solve_with(s, end, true);
}

bool lobatto_system_solve(LobattoSystem *s, const EndAngle *end) {
    return s->by_speed ? solve_varying(s, end) : solve_with(s, end, false);
}
