/* The fundamental solution of alpha'' + 2a alpha' + w2 alpha = 0 and its repeated integrals.
 *
 * In one slip mode with helical grooves the angle obeys M theta'' + B theta' + K theta = u0 + u1 t. So alpha = theta''
 * obeys the homogeneous equation with 2a = B/M and w2 = K/M; without inertia with 2a = K/B and w2 = 0. Let s be the
 * solution with s(0) = 0 and s'(0) = 1. Let p1, p2, p3 be the first, second and third integral of s from 0. With the
 * values at the start omega0 and alpha0 and the drive U = u1/M the motion follows as
 *     omega - omega0 = alpha0 s + (U - w2 omega0) p1
 *     theta - theta0 = omega0 (s + 2a p1) + alpha0 p1 + U p2
 *     integral of (theta - theta0) = omega0 (p1 + 2a p2) + alpha0 p2 + U p3
 * These increments are exact to rounding over a time in which the damping changes little. Over a time in which damping
 * settles the motion, the terms in omega0 and alpha0 nearly cancel. Then the settled speed b0 = omega0 + alpha0/(2a)
 * replaces omega0. The caller knows b0 without the cancellation (with inertia b0 = N/B). With lead = 1/(2a):
 *     omega = b0 (1 - w2 p1) - lead s' alpha0 + U p1
 *     theta - theta0 = b0 (s + 2a p1) - lead s alpha0 + U p2
 *     integral of (theta - theta0) = b0 (p1 + 2a p2) - lead p1 alpha0 + U p3
 * a may be negative and w2 may have either sign: a locked contact drives itself. Excluded is a < 0 together with
 * w2 > a^2: nothing in the mechanism causes a growing oscillation. */
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
    double horizon;     /* s, limit of t: a growing solution then reaches exp(OSCILLATOR_MAX_GROWTH) */
} Oscillator;

typedef struct {
    double t;          /* s; NAN: the kernel is empty */
    double s, ds;      /* s, 1: s and its derivative */
    double p1, p2, p3; /* s^2, s^3, s^4 */
    double
        lead; /* s, 1/(2a) if damping settles the motion, |2a| t > 1 and (2a)^2 >= w2: the second form above; else 0 */
    /* integral of omega^2 as a quadratic form in (b0, alpha0, U), see oscillator_square() */
    double square[6];
    bool has_square;
} Kernel;

/* decay2: 2a, 1/s; stiffness: w2, 1/s^2. */
Oscillator oscillator_of(double decay2, double stiffness);

/* Fills s, ds, p1, p2, p3 and lead at t >= 0. */
void oscillator_kernel(const Oscillator *osc, double t, Kernel *kernel);

/* Fills kernel->square: integral of omega^2 over [0, t]
 *     = q0 b0^2 + 2 q1 b0 alpha0 + 2 q2 b0 U + q3 alpha0^2 + 2 q4 alpha0 U + q5 U^2,  b0 = omega0 + lead alpha0 */
void oscillator_square(const Oscillator *osc, Kernel *kernel);

/* First t > 0 at which the homogeneous solution with y(0) = y0, y'(0) = dy0 vanishes, or infinity. */
double oscillator_zero(const Oscillator *osc, double y0, double dy0);

/* First t > 0 at which y would vanish without damping, where y' obeys the homogeneous equation; from y, y' and y''
 * at 0. NAN or a negative number if y does not vanish. */
double oscillator_offset_zero(const Oscillator *osc, double y0, double dy0, double ddy0);

#endif
