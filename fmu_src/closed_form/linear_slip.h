/* Motion inside one mode: one direction of slip, one pair of flanks.
 *
 * For two helical grooves, a linear spring and a linear damper, every coefficient below is constant,
 * so the motion is known in closed form at any time (oscillator.h). With A the axial load,
 *     A = F_s(z) + F_ext + c v + m dv/dt           T = tau - b omega - J alpha = rho A + rho kappa_1 I gamma''
 * the equation of motion is, with z' and gamma' constant,
 *     M alpha + B omega = tau - rho (F_s(z) + F_ext) =: N(theta, t)
 *     M = J + rho m z' + rho kappa_1 I gamma'    B = b + rho c z'    dN/dtheta = -K = -rho k z'
 * Three regimes, by what is zero: M > 0 inertial; M = 0, B > 0 viscous (omega = N/B); both zero:
 * quasi-static (N = 0, theta follows the edge of the stick band). */
#ifndef DUALCAM_LINEAR_SLIP_H
#define DUALCAM_LINEAR_SLIP_H

#include <stdbool.h>

#include "closed_form/oscillator.h"
#include "contact/contact.h"
#include "geometry/cam.h"
#include "model/elements.h"
#include "model/ledger.h"
#include "model/params.h"
#include "model/regime.h"

/* One way to slip and its constant coefficients. */
typedef struct {
    bool possible; /* false: singular, or the inertia felt is not positive (friction then jams it) */
    int direction; /* sigma: +1 loading, -1 releasing */
    int flank[2];  /* e_i */
    Regime regime;
    Transfer transfer;
    double mass, damping, stiffness; /* kg.m^2, N.m.s/rad, N.m/rad: M, B, K */
    Oscillator oscillator;
    /* x_i = axial (F_s + F_ext) + speed omega + acceleration alpha, see contact.h */
    double speed[2], acceleration[2];
    double reaction[2]; /* N per unit of x_i: reaction of one contact */
    double heat[2];     /* heat flow at contact i = heat x_i omega, >= 0 */
    double damper;      /* N.s/m, c in this direction */
} LinearSlipMode;

/* Start of a stretch of motion. Rates are those of the inputs over the stretch (inputs are linear). */
typedef struct {
    double theta, omega, alpha; /* rad, rad/s, rad/s^2 */
    double curvature;           /* rad/s^3, d alpha/dt + 2a alpha = U - w2 omega */
    double drive;               /* rad/s^3, U: rate of the load over M (0 without inertia) */
    double tau, tau_rate;       /* N.m, N.m/s */
    double F_ext, F_ext_rate;   /* N, N/s */
    double force;               /* N, F_s + F_ext */
    double offset;              /* rad, quasi-static only: way back to the edge of the band, a rounding */
} SlipStart;

/* Increments over, and values at the end of, the time t since the launch. */
typedef struct {
    double t;
    double dtheta, domega;     /* rad, rad/s */
    double omega, alpha, jerk; /* rad/s, rad/s^2, rad/s^3 at t */
    bool settled;              /* omega is exact to its own rounding, not to that of the start's */
} LinearMotion;

void linear_slip_build(LinearSlipMode *linear, const Params *params, const Geometry *g, int direction,
                       const int flank[2]);

/* omega is the state's speed; without inertia the launch finds its own. */
SlipStart linear_slip_start(const LinearSlipMode *linear, const Params *params, const Geometry *g, double theta,
                            double omega, const Inputs *inputs);

/* Torque left to move it: N = tau - rho (F_s + F_ext), N.m. */
double linear_slip_net_torque(const LinearSlipMode *linear, const SlipStart *start);

LinearMotion linear_slip_motion_at_start(const LinearSlipMode *linear,
                                         const SlipStart *start); /* the arc of length 0 */
void linear_slip_motion(const LinearSlipMode *linear, const SlipStart *start, const Kernel *kernel,
                        LinearMotion *motion);

/* With F_s + F_ext and its rate, at the speed, alpha and jerk of the arc's end. */
ContactLoadPair linear_slip_contacts(const LinearSlipMode *linear, double force, double force_rate,
                                     const LinearMotion *motion);

ContactLoad linear_slip_contact(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                                const SlipStart *start, const LinearMotion *motion, int i);

/* The sizes of what adds up to x_i and its derivatives at the launch: their rounding errors are a few eps of
 * these. */
ContactLoad linear_slip_contact_size(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                                     const SlipStart *start, int i);

/* Work and heat over the arc that `kernel` describes. */
Booking linear_slip_booking(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                            const SlipStart *start, const LinearMotion *motion, Kernel *kernel);

/* The quasi-static jump by dtheta along the edge of the stick band: the torque taken is rho F. */
Booking linear_slip_jump_booking(const LinearSlipMode *linear, const Params *params, const Geometry *g,
                                 const SlipStart *start, double dtheta);

#endif
