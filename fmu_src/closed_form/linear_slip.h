/* The motion in one slip mode in closed form: helical grooves, linear spring, linear damper, inputs linear in time.
 *
 * The room closed_form/ holds slip of two helices under linear forces, where the motion is known exactly at any time,
 * and the events that end such a motion. May include: elementary, numerics, model, contact (which brings geometry).
 *
 * With both grooves helical, z' and gamma' are constant, and so is every coefficient below. With A the axial load
 * and T the torque that cam 2 passes to the follower (docs/mechanism.md, sections 3 and 6),
 *     A = F_s(z) + F_ext + c v + m dv/dt           T = tau - b omega - J alpha = rho A + rho kappa_1 I d2gamma/dt2
 * the equation of motion is
 *     M alpha + B omega = tau - rho (F_s(z) + F_ext) =: N(theta, t)
 *     M = J + rho m z' + rho kappa_1 I gamma'    B = b + rho c z'    dN/dtheta = -K = -rho k z'
 * The regime follows from the coefficients that are zero. M > 0: inertial. M = 0 and B not 0: viscous, omega = N/B.
 * Both zero: rate-independent, N = 0, theta follows the edge of the stick band. oscillator.h gives the motion at
 * any time. */
#ifndef DUALCAM_LINEAR_SLIP_H
#define DUALCAM_LINEAR_SLIP_H

#include <stdbool.h>

#include "closed_form/oscillator.h"
#include "contact/contact.h"
#include "model/elements.h"
#include "model/ledger.h"
#include "model/mode.h"
#include "model/params.h"

/* A slip mode and its constant coefficients. */
typedef struct {
    bool possible; /* D/Delta > 0: M, or without inertia B, is positive; without both Delta > 0 */
    int direction; /* sigma: +1 loading, -1 releasing */
    int flank[2];  /* e_i */
    Regime regime;
    Transfer transfer;
    double mass, damping, stiffness; /* kg.m^2, N.m.s/rad, N.m/rad: M, B, K */
    Oscillator oscillator;
    /* x_i = transfer.axial (F_s + F_ext) + speed omega + acceleration alpha, see contact.h */
    double speed[2], acceleration[2];
    double reaction[2]; /* N per unit of x_i: reaction at one pin end */
    double heat[2];     /* m^2: the heat flow at contact i is heat x_i omega, >= 0 */
    double damper;      /* N.s/m, c in this direction */
} LinearSlipMode;

/* The start of a segment of slip. The rates of the inputs hold over the whole segment. */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2 */
    double alpha_drive;         /* rad/s^3, d alpha/dt + 2a alpha = U - w2 omega */
    double drive;               /* rad/s^3, U: rate of tau - rho F_ext over M; 0 without inertia */
    double tau, tau_rate;       /* N.m, N.m/s */
    double F_ext, F_ext_rate;   /* N, N/s */
    double force;               /* N, F_s + F_ext */
    double offset;              /* rad, rate-independent only: back to the edge of the stick band, a rounding */
} SlipStart;

/* The motion at time t after the start: increments since the start, and values at t. */
typedef struct {
    double t;                  /* s */
    double dtheta, domega;     /* rad, rad/s */
    double omega, alpha, jerk; /* rad/s, rad/s^2, rad/s^3 at t */
    bool settled;              /* omega has its own rounding, not that of omega at the start */
} LinearMotion;

/* x_i of a contact and its first and second time derivatives. */
typedef struct {
    double value, rate, second;
} ContactLoad;

/* x_i and its first time derivative, of both contacts. */
typedef struct {
    double value[2], rate[2];
} ContactLoadPair;

/* The coefficients at this geometry; direction: +1 loading, -1 releasing. */
void linear_slip_build(LinearSlipMode *linear, const Params *params, const Geometry *g, int direction,
                       const int flank[2]);

/* `omega` is the speed of the state, rad/s. Without inertia the balance of forces gives the speed instead. */
SlipStart linear_slip_start(const LinearSlipMode *linear, const Params *params, const Geometry *g, double theta,
                            double omega, const Inputs *inputs);

/* N = tau - rho (F_s + F_ext), N.m: torque beyond the torque that holds the load. */
double linear_slip_net_torque(const LinearSlipMode *linear, const SlipStart *start);

LinearMotion linear_slip_motion_at_start(const LinearSlipMode *linear, const SlipStart *start);

/* The motion at the time of the kernel. */
void linear_slip_motion(const LinearSlipMode *linear, const SlipStart *start, const Kernel *kernel,
                        LinearMotion *motion);

/* x_i and dx_i/dt under the axial force F_s + F_ext, N, and its rate, N/s, at the speed, alpha and jerk of `motion`. */
ContactLoadPair linear_slip_contacts(const LinearSlipMode *linear, double force, double force_rate,
                                     const LinearMotion *motion);

/* x_i and its first and second time derivatives at `motion`. */
ContactLoad linear_slip_contact(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                                const SlipStart *start, const LinearMotion *motion, int i);

/* The sum of the magnitudes of the terms of x_i at the start. The rounding error is some eps of it. */
double linear_slip_contact_size(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                                const SlipStart *start, int i);

/* Work and heat over the segment that `kernel` and `motion` describe, J, and with has_wear() the wear. Computes
 * kernel->square if needed. */
void linear_slip_book(const LinearSlipMode *linear, const Params *params, const Geometry *g, const SlipStart *start,
                      const LinearMotion *motion, Kernel *kernel, Booking *booking);

/* Work and heat of the rate-independent jump by dtheta, rad, along the edge of the stick band, J. The torque taken is
 * that of the edge, rho F. */
Booking linear_slip_jump_booking(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                                 const SlipStart *start, double dtheta);

#endif
