/* The coefficients of a slip mode where friction depends on the load. They belong to the loads, and their derivatives
 * follow from the implicit function theorem (loaded_contacts.h): A and W change with theta, omega and alpha, the
 * reactions with A and W, the friction coefficients with the reactions. */
#ifndef DUALCAM_LOADED_SLIP_H
#define DUALCAM_LOADED_SLIP_H

#include "contact/residual.h"

/* Sets the friction of the coefficients at theta: with inertia together with alpha and without the factors, without
 * inertia under F_0 and the damper's force at the speed omega, and the factors with their derivatives. */
void loaded_slip_set(const SlipMode *slip, double omega, double z, const InputValues *in, SlipCoefficients *k);

/* With inertia: alpha follows from the balance with the tangent factors. While the inertia stays above zero, Delta and
 * the tangent Delta can pass zero with finite reactions (docs/mechanism.md, section 9, "Motion"). */
typedef struct {
    double alpha_by[2]; /* 1/s^2 and 1/s: by theta and by omega */
    double inertia;     /* kg.m^5: J Delta + m z' P + I gamma' Q with the tangent factors */
} LoadedMotionResponse;

/* The coefficients are those of loaded_slip_set(). */
LoadedMotionResponse loaded_slip_motion(const SlipMode *slip, const SlipCoefficients *k, double z, double omega);

/* A motion, and the forces that act on the follower. */
typedef struct {
    double z, omega, alpha;      /* m, rad/s, rad/s^2 */
    double force, damper, F_ext; /* N: F_0, D and the part F_ext of F_0 */
    bool has_torque;             /* T is known */
    double torque;               /* N.m: T */
} LoadedMotion;

/* The same under these loads. */
void loaded_slip_set_under(const SlipMode *slip, const LoadedMotion *motion, SlipCoefficients *k);

/* A change of theta, omega, A, W and, for another reason, of f_i. */
typedef struct {
    double theta, omega, axial, moment, friction[2];
} LoadStep;

/* The changes of x_i and f_i. */
LoadResponse loaded_slip_response(const SlipMode *slip, double omega, const SlipCoefficients *k, const LoadStep *step);

/* The change of the factors through f_i. */
ContactFactors loaded_slip_change(const SlipMode *slip, double omega, const SlipCoefficients *k, const LoadStep *step);

/* Minus the derivatives of the residual of balance_partials() by A, which is P if friction does not depend on the load,
 * and by alpha. */
double loaded_slip_lever(const SlipMode *slip, const SlipCoefficients *k, const MotionTerms *terms);
double loaded_slip_inertia(const SlipMode *slip, const SlipCoefficients *k, const MotionTerms *terms);

#endif
