/* The collocation equations of a Lobatto IIIA step in one slip mode, and their solution by functional iteration.
 *
 * With alpha_i = alpha(theta_i, omega_i, t_i) at the four nodes, of which the first is the start:
 *     omega_i = omega_0 + h sum once_ij alpha_j    theta_i = theta_0 + c_i h omega_0 + h^2 sum twice_ij alpha_j
 * or, without inertia, with omega_i = omega(theta_i, t_i):
 *     theta_i = theta_0 + h sum once_ij omega_j
 * The right-hand sides are those of balance.h. A sweep evaluates them at all nodes, two nodes per vector register, and
 * needs values only, no derivatives. */
#ifndef DUALCAM_LOBATTO_SYSTEM_H
#define DUALCAM_LOBATTO_SYSTEM_H

#include <float.h>
#include <math.h>

#include "collocation/lobatto_nodes.h"
#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* An angle at which the step must end, likewise. */
typedef struct {
    bool given;
    double distance, slack; /* rad, from the start on; the step may miss the distance by the slack */
} EndAngle;

static inline bool lobatto_system_is_inertial(const LobattoSystem *system) {
    return system->slip->regime == REGIME_INERTIAL;
}

/* Sets what all sweeps have in common: slip mode, forces that are there, friction law. */
void lobatto_system_begin(LobattoSystem *system, const SlipMode *slip);

/* A first iterate under constant acceleration. `rhs`: alpha, or without inertia omega, at the start. */
void lobatto_system_guess(LobattoSystem *system, double rhs);

/* Sweeps from the first iterate until the equations hold to a share of the tolerance. False if the iteration converges
 * too slowly, or if the slip mode is not possible at a node. */
bool lobatto_system_solve(LobattoSystem *system, const EndAngle *end);

/* Times the sign of contact i: its friction at two sliding speeds, m/s; load2: the square of the nominal loads over N_ref, or
 * over 1 N where there is a table. */
VectorFriction lobatto_friction(const LobattoSystem *system, int i, Vector2 v, Vector2 load2);

/* Without inertia: omega by the balance at the end of the step, rad/s. */
double lobatto_system_speed_at_end(LobattoSystem *system);

/* ---- the error of a step ---- */

/* The coefficient of c^3 of the cubic through the values. Where it happens to be small, the decay of the lower
 * coefficients stands for it. */
static inline double lobatto_cubic_term(const LobattoValues *y) {
    const LobattoValues c = lobatto_combine(LOBATTO.bernstein, y);
    const double *b = c.at;
    const double linear = 3.0 * fabs(b[1] - b[0]), square = 3.0 * fabs(b[0] - 2.0 * b[1] + b[2]);
    return max_of(fabs(b[3] - b[0] + 3.0 * (b[1] - b[2])),
                  LOBATTO_DECAY * square * square / (linear + square + DBL_MIN));
}

/* The parabola through the last three nodes misses the value at the start by the cubic term times LOBATTO.missed. In
 * between, its integrals are those of prod(1 - c/c_i) times that. The cubic itself misses far less. x is the error of
 * the parabola relative to speed and distance. The limit x^(11/8) <= tolerance is set so that of 5000 random steps that
 * just pass, all are within the tolerance, and 99 of 100 within half of it. `margin`: factor on tolerance^8. */
static inline bool lobatto_is_accurate(const LobattoSystem *s, double margin) {
    const double tolerance = s->slip->params->tolerance;
    const double missed = s->h * LOBATTO.missed * lobatto_cubic_term(&s->y);
    const double distance = fabs(s->dtheta.at[LOBATTO_END]), rounding = ANGLE_ROUNDING * fabs(s->theta);
    double by_speed = 0.0, by_angle = missed * LOBATTO.missed_once;
    if (lobatto_system_is_inertial(s)) {
        by_speed = missed * LOBATTO.missed_once / lobatto_largest(lobatto_range(&s->speed));
        by_angle = missed * LOBATTO.missed_twice * s->h;
    }
    const double x = max_of(by_speed, max_of(by_angle - rounding, 0.0) / (distance + DBL_MIN));
    const double x2 = x * x, x8 = (x2 * x2) * (x2 * x2), t2 = tolerance * tolerance;
    return x < 1.0 && x8 * x2 * x <= margin * (t2 * t2) * (t2 * t2);
}

#endif
