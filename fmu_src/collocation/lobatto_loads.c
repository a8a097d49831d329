#include "collocation/lobatto_loads.h"

#include <float.h>
#include <math.h>

#include "model/elements.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- the start ---- */

/* mu at the contacts whose tables have loads. Takes the patches. */
NOINLINE static void take_patches(LobattoSystem *s, const Geometry *g, const double x[2], FrictionStart *out) {
    const FrictionConstants *law = s->slip->law;
    const FrictionPatch *patch[2] = {NULL, NULL};
    const FrictionPiece *piece[2] = {NULL, NULL};
    double v[2], q[2], R[2];
    for (int i = 0; i < 2; i++) {
        const int of = law[i].loaded ? i : 1 - i;
        const FrictionTable *table = law[of].loaded;
        R[i] = fabs(x[of]) * cam_length(g, of);
        q[i] = R[i] * s->law[of]->per_load[0];
        s->span[of] = friction_table_span(table, q[i] * table->load[1]);
        s->patch[of] = patch[i] = friction_table_patch(table, s->piece[of], s->span[of]);
        piece[i] = s->piece[of];
        v[i] = s->omega * s->slip->direction * cam_sliding(g, of);
    }
    friction_start(patch, piece, v, q, out);
    s->share_to_load = INFINITY;
    for (int i = 0; i < 2; i++) {
        const Vector2 none = {0.0, 0.0};
        const bool is_far_from_level = q[i] * (1.0 - OF_TWO_LOG_NEAR) > LEVEL_LOG_FROM * (1.0 + OF_TWO_LOG_NEAR);
        s->near[i] = (FrictionNear){none + (is_far_from_level ? R[i] : 0.0), none + out->b[i], none + out->log_mu[i],
                                    none + out->mu.value[i], s->law[i]->per_load};
    }
}

/* Is a load, `ratio` times that of `start`, beyond those of its patch? With ln r <= r - 1 and ln r >= (r - 1)/r, rather
 * yes than no. */
static inline bool leaves_patches(const LobattoSystem *s, const FrictionStart *start, const double ratio[2]) {
    bool leaves = false;
    for (int i = 0; i < 2; i++) {
        const double change = start->per[i] * (ratio[i] - 1.0);
        leaves |= s->law[i]->has_patches && (change > start->above[i] || change < start->below[i] * ratio[i]);
    }
    return leaves;
}

/* mu at another load over mu, to second order in the change: with L = ln mu, R mu' = mu L' and
 * R^2 mu'' = mu (L'^2 - L' + L''). */
static inline double follow_load(const VectorLoadedFriction *mu, int i, double change) {
    const double p = mu->power[i];
    return 1.0 + change * (p + 0.5 * change * (p * p - p + mu->bend[i]));
}

/* Both contacts in one vector. */
NOINLINE void lobatto_loads_guess(LobattoSystem *s, const Geometry *g, const GrooveBend *bend, double z,
                                  double value[2], double kinetic[2]) {
    const SlipMode *slip = s->slip;
    const Params *p = slip->params;
    const InertiaParams *in = &p->inertia;
    const double v = g->dz_dtheta * s->omega, omega2 = s->omega * s->omega, a[2] = {g->slope[0], g->slope[1]};
    const double axial = spring_force(&p->spring, z) + slip->inputs->F_ext[0] + slip_damper_force(slip, v) +
                         in->follower_mass * bend->d2z_dtheta2 * omega2;
    const double net = slip->inputs->tau[0] - p->shaft.damping * s->omega;
    const double axial_mass = in->follower_mass * g->dz_dtheta, turning_mass = in->follower * g->dpsi_dtheta[0];
    double dry[2], viscous[2], more[2] = {0.0, 0.0}, power[2] = {1.0, 1.0}, x[2] = {0.0, 0.0}, torque[2];
    for (int i = 0; i < 2; i++) {
        viscous[i] = s->law[i]->viscous[0] * slip->direction * s->omega * cam_sliding(g, i);
        dry[i] = value[i] - viscous[i];
    }
    const Vector2 exponent = {s->law[0]->load_exponent[0], s->law[1]->load_exponent[0]};
    const bool has_tables = lobatto_has_patches(s), has_powers = exponent[0] != 0.0 || exponent[1] != 0.0;
    const int guesses = has_powers ? LOBATTO_LOAD_GUESSES : LOBATTO_TABLE_GUESSES;
    FrictionStart tables;
    double before[2] = {1.0, 1.0}, ratio[2] = {1.0, 1.0};
    s->load_square[0] = s->load_square[1] = (Vector2){0.0, 0.0};
    for (int n = 0;; n++) { /* at most LOBATTO_LOAD_GUESSES + 1 turns */
        ContactFactors f;
        double load = axial;
        for (int i = 0; i < 2; i++) {
            const double r = g->radius[i];
            contact_factors_set(&f, i, r, dry[i] * power[i] + viscous[i] + more[i], a[i]);
            load -= a[i] * more[i] * x[i];
            torque[i] = r * r * more[i] * x[i];
        }
        contact_factors_multiply(&f);
        double moment = torque[1] - torque[0] + in->follower * bend->d2gamma_dtheta2 * omega2;
        if (slip->follower_has_inertia) {
            const double alpha = (f.delta * (net + torque[1]) - f.p * load - f.q * moment) /
                                 (f.delta * in->shaft + f.p * axial_mass + f.q * turning_mass);
            load += axial_mass * alpha;
            moment += turning_mass * alpha;
        }
        x[0] = (f.rn[1] * load - f.d[1] * moment) / f.delta;
        x[1] = (f.rn[0] * load + f.d[0] * moment) / f.delta;
        if (n >= guesses) {
            for (int i = 0; i < 2; i++) ratio[i] = x[i] / before[i];
            if (n == LOBATTO_LOAD_GUESSES || !leaves_patches(s, &tables, ratio)) break;
        }
        if (has_powers) {
            const Vector2 q = {fabs(x[0]) * cam_length(g, 0) * s->law[0]->per_load[0],
                               fabs(x[1]) * cam_length(g, 1) * s->law[1]->per_load[0]};
            const VectorLoadPower at = friction_load_power(exponent, q);
            for (int i = 0; i < 2; i++) {
                power[i] = at.value[i];
                more[i] = dry[i] * at.by_log_load[i];
            }
        }
        if (!has_tables) continue;
        take_patches(s, g, x, &tables);
        for (int i = 0; i < 2; i++) {
            if (!slip->law[i].loaded) continue;
            const double friction = s->law[i]->sign[0] * tables.mu.value[i];
            power[i] = friction / dry[i];
            more[i] = friction * tables.mu.power[i];
            before[i] = x[i];
        }
    }
    for (int i = 0; i < 2; i++) {
        if (has_tables && slip->law[i].loaded) power[i] *= follow_load(&tables.mu, i, ratio[i] - 1.0);
        kinetic[i] = (kinetic[i] - viscous[i]) * power[i] + viscous[i];
        value[i] = dry[i] * power[i] + viscous[i];
        for (int k = 0; k < LOBATTO_HALVES; k++) s->pair[k].x[i] = (Vector2){x[i], x[i]};
    }
}

/* ---- the first iterate ---- */

/* x_i on the parabola through the start, the middle and the end. df_i/domega of a table on the line through the middle
 * and the end: at the start the slope has no effect on the step. */
void lobatto_loads_place(LobattoSystem *s, const NodePair *n) {
    for (int i = 0; i < 2; i++) {
        const Parabola x = parabola_through(s->pair[0].x[i][0], n->x[i]);
        const double end = n->dfriction_domega[i][1], rise = 2.0 * (end - n->dfriction_domega[i][0]);
        for (int k = 0; k < LOBATTO_HALVES; k++) {
            const Vector2 node = LOBATTO.node.half[k];
            s->pair[k].x[i] = parabola_at(&x, node);
            if (s->law[i]->has_patches) s->pair[k].dfriction_domega[i] = end + rise * (node - 1.0);
        }
        s->load_square[i] = (Vector2){0.0, 0.0};
    }
    s->keeps_slopes = true;
}

/* ---- a sweep ---- */

double lobatto_loads_error(LobattoSystem *s) {
    const Vector2 largest = vector2_max((Vector2){s->load_square[0][0], s->load_square[1][0]},
                                        (Vector2){s->load_square[0][1], s->load_square[1][1]});
    s->load_square[0] = s->load_square[1] = (Vector2){0.0, 0.0};
    return LOBATTO_LOAD_SHARE * max_of(largest[0], largest[1] * sqrt(largest[1]));
}

/* N, R_i of all contacts, from the x_i of the sweep before. */
static inline Vector2 total_reaction(const LobattoSystem *s, const NodePair *n, int i) {
    const Vector2 square = n->x[i] * n->x[i] * (s->law[i]->radius2 + n->slope[i] * n->slope[i]);
    return (Vector2){sqrt(square[0]), sqrt(square[1])};
}

static inline void linearise_power(const LobattoSystem *s, int i, NodePair *n) {
    const Vector2 exponent = s->law[i]->load_exponent, none = {0.0, 0.0};
    n->is_bent[i] = false;
    if (exponent[0] == 0.0) {
        n->rest[i] = n->bend[i] = none;
        return;
    }
    const VectorLoadPower power = friction_load_power(exponent, total_reaction(s, n, i) * s->law[i]->per_load);
    const Vector2 viscous = s->law[i]->viscous * n->sliding[i]; /* the part of df_i/domega that has no R */
    const Vector2 dry = n->friction[i] - viscous * n->omega, more = dry * power.by_log_load;
    n->friction[i] = dry * power.value + viscous * n->omega + more;
    n->dfriction_domega[i] = (n->dfriction_domega[i] - viscous) * power.value + viscous;
    n->rest[i] = more * n->x[i];
    n->is_bent[i] = power.is_power;
    n->bend[i] = power.is_power ? -(0.5 + 0.5 * exponent) * n->rest[i] : none;
}

/* Without a power of the load F is a line. */
NOINLINE static void linearise_beside_table(const LobattoSystem *s, int i, NodePair *n) {
    linearise_power(s, i, n);
    n->is_bent[i] |= s->law[i]->load_exponent[0] == 0.0;
}

/* With f = e^L, L over ln R of slope p and second derivative w: f' = f (1 + p) and x F'' = f (p + p^2 + w). The sweeps
 * after the first keep df_i/domega: it serves to predict the change by the next one. */
NOINLINE static void linearise_tables(const LobattoSystem *s, NodePair *n) {
    for (int i = 0; i < 2; i++) {
        if (!s->law[i]->has_patches) {
            linearise_beside_table(s, i, n);
            continue;
        }
        const VectorLoadedFriction mu = friction_on_patch(
            s->patch[i], s->piece[i], &s->near[i], n->omega * n->sliding[i], total_reaction(s, n, i), !s->keeps_slopes);
        const Vector2 value = s->law[i]->sign * mu.value, more = value * mu.power, force = value * n->x[i];
        n->friction[i] = value + more;
        if (!s->keeps_slopes) n->dfriction_domega[i] = s->law[i]->sign * mu.by_speed * n->sliding[i];
        n->rest[i] = more * n->x[i];
        n->is_bent[i] = true;
        n->bend[i] = -0.5 * (n->rest[i] * (1.0 + mu.power) + force * mu.bend);
    }
}

NOINLINE void lobatto_loads_linearise(LobattoSystem *s, NodePair *n) {
    if (lobatto_has_patches(s)) {
        linearise_tables(s, n);
        return;
    }
    for (int i = 0; i < 2; i++) linearise_power(s, i, n);
}

/* The change of net torque, N.m m^3, by changes of the friction forces f_i x_i, N/m: as minus rests of that size. */
static inline Vector2 torque_by_friction(const LobattoSystem *s, const NodePair *n, const Vector2 force[2]) {
    const VectorContactFactors *f = &n->factors;
    const Vector2 torque[2] = {s->law[0]->radius2 * force[0], s->law[1]->radius2 * force[1]};
    return f->delta * torque[1] + f->p * (n->slope[0] * force[0] + n->slope[1] * force[1]) -
           f->q * (torque[1] - torque[0]);
}

Vector2 lobatto_loads_find(LobattoSystem *s, Vector2 omega, Vector2 alpha, const LoadShift *shift, NodePair *n) {
    const SlipMode *slip = s->slip;
    const InertiaParams *in = &slip->params->inertia;
    const VectorContactFactors *f = &n->factors;
    const Vector2 inverse = 1.0 / f->delta, inertia = 1.0 / n->mass;
    Vector2 axial = n->force + n->damper + shift->axial, moment = shift->moment;
    if (slip->follower_has_inertia) {
        axial += in->follower_mass * (n->dz_dtheta * alpha + n->d2z_dtheta2 * omega * omega);
        moment += in->follower * (n->dpsi_dtheta[0] * alpha + n->d2gamma_dtheta2 * omega * omega);
    }
    const Vector2 x[2] = {(f->rn[1] * axial - f->d[1] * moment) * inverse,
                          (f->rn[0] * axial + f->d[0] * moment) * inverse};
    Vector2 by_speed[2], bent[2];
    for (int i = 0; i < 2; i++) {
        const Vector2 change = x[i] - n->x[i];
        Vector2 square = change * change / (n->x[i] * n->x[i] + DBL_MIN);
        square = (Vector2){square[0] < 0.1 ? square[0] : 0.1, square[1] < 0.1 ? square[1] : 0.1};
        Vector2 *largest = &s->load_square[n->is_bent[i]];
        *largest = vector2_max(square, *largest);
        bent[i] = n->bend[i] * square;
        n->rest[i] += bent[i];
        n->x[i] = x[i];
        by_speed[i] = x[i] * n->dfriction_domega[i];
    }
    n->friction_damping = torque_by_friction(s, n, by_speed) * inertia;
    return alpha + torque_by_friction(s, n, bent) * inertia;
}
