/* The fundamental solution of alpha'' + 2a alpha' + w2 alpha = 0 and its repeated integrals.
 *
 * Inside one mode of a helical scene the angle obeys M theta'' + B theta' + K theta = u0 + u1 t, so
 * alpha = theta'' obeys the homogeneous equation with 2a = B/M and w2 = K/M (without inertia: with
 * 2a = K/B and w2 = 0). Let s be its solution with s(0) = 0, s'(0) = 1, and p1, p2, p3 the first to
 * third integral of s from 0. Everything else follows as increments from the start values omega0, alpha0
 * and the drive U (= u1/M), over a time in which the damping changes little:
 *     omega - omega0 = alpha0 s + (U - w2 omega0) p1
 *     theta - theta0 = omega0 (s + 2a p1) + alpha0 p1 + U p2
 *     integral of (theta - theta0) = omega0 (p1 + 2a p2) + alpha0 p2 + U p3
 * Over a time in which damping, rather than a vibration, settles the motion, terms in omega0 and alpha0 would nearly
 * cancel. Then the speed that is left, b0 = omega0 + alpha0/(2a), replaces omega0; the caller knows it better than as a sum
 * (inertial: b0 = N/B). With lead = 1/(2a):
 *     omega = b0 (1 - w2 p1) - lead s' alpha0 + U p1
 *     theta - theta0 = b0 (s + 2a p1) - lead s alpha0 + U p2
 *     integral of (theta - theta0) = b0 (p1 + 2a p2) - lead p1 alpha0 + U p3
 * a may be negative and w2 of either sign (a locked contact drives itself), but not a < 0 with
 * w2 > a^2: a growing oscillation has no cause here. */
#ifndef DUALCAM_OSCILLATOR_H
#define DUALCAM_OSCILLATOR_H

#include <stdbool.h>

typedef struct {
    double decay2;      /* 1/s, 2a */
    double stiffness;   /* 1/s^2, w2 */
    double separation;  /* 1/s^2, a^2 - w2: > 0 overdamped, < 0 underdamped */
    double frequency;   /* rad/s, sqrt(|separation|) */
    double half_period; /* s, pi/frequency if underdamped, else infinity */
    double rate;        /* 1/s, the largest of the motion */
    double horizon;     /* s, to be used for no longer: a growing solution reaches exp(MAX_GROWTH) */
} Oscillator;

typedef struct {
    double t;          /* s; NAN: empty */
    double s, ds;      /* s, 1: s and its derivative */
    double p1, p2, p3; /* s^2, s^3, s^4 */
    double lead;       /* s, 1/(2a) if |2a| t > 1 and (2a)^2 >= w2, else 0: which of the two forms above to use */
    /* integral of omega^2 as a quadratic form in (b0, alpha0, U); see oscillator_square */
    double square[6];
    bool squared;
} Kernel;

Oscillator oscillator_of(double decay2, double stiffness);

/* s, ds, p1, p2, p3 and lead at t >= 0. */
void oscillator_kernel(const Oscillator *osc, double t, Kernel *kernel);

/* Fills kernel->square: integral of omega^2 over [0, t]
 *     = q0 b0^2 + 2 q1 b0 alpha0 + 2 q2 b0 U + q3 alpha0^2 + 2 q4 alpha0 U + q5 U^2,  b0 = omega0 + lead alpha0 */
void oscillator_square(const Oscillator *osc, Kernel *kernel);

/* First t > 0 at which the homogeneous solution with y(0) = y0, y'(0) = dy0 vanishes, or infinity. */
double oscillator_zero(const Oscillator *osc, double y0, double dy0);

/* First t > 0 at which y, of a rate that is homogeneous, would vanish without damping; from y, y' and y'' at 0. NAN or
 * below 0 if it does not. */
double oscillator_offset_zero(const Oscillator *osc, double y0, double dy0, double ddy0);

#endif
