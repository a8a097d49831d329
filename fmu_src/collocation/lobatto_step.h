/* One easy step of slip through grooves of any shape, in which nothing happens: the common case, and so the fast one.
 *
 * Lobatto IIIA collocation with four nodes, the first of them the start: with alpha_i = alpha(theta_i, omega_i, t_i)
 *     omega_i = omega_0 + h sum once_ij alpha_j    theta_i = theta_0 + c_i h omega_0 + h^2 sum twice_ij alpha_j
 * or, without inertia, theta_i = theta_0 + h sum once_ij omega_j: order 6 at the end of the step (E. Hairer, G. Wanner,
 * Solving Ordinary Differential Equations II, IV.5). An easy step is not stiff, so that functional iteration solves
 * these equations in two or three sweeps. A sweep needs values only, no derivatives, and takes the four nodes side by
 * side, one in each lane of a vector. The equations of motion are those of balance.h.
 *
 * What is not easy, or where anything might happen, is refused, and left to the leaps of event_location.h. */
#ifndef DUALCAM_LOBATTO_STEP_H
#define DUALCAM_LOBATTO_STEP_H

#include "collocation/event_location.h"
#include "contact/balance.h"

/* Where it starts: what the mechanism knows of the place. */
typedef struct {
    double theta, omega, z;   /* rad, rad/s, m */
    const Geometry *geometry; /* there */
    double room;              /* rad, to the end stop ahead */
    const Peaks *known;       /* the largest values seen so far; reactions per contact */
} LobattoStart;

typedef struct {
    double h;              /* s, how long it takes */
    double dtheta, domega; /* rad, rad/s: increments; domega only if inertial */
    double omega, tau;     /* rad/s, N.m, at the end */
    bool accurate;         /* so few nodes do; set also where it is refused, unless that is so before it is known */
    Booking booking;
    /* Only if the mechanism keeps a ledger: */
    double peak_omega, peak_reaction[2]; /* rad/s, N per contact: the larger of both ends */
    bool peaks_inside;                   /* one of them may be exceeded in between, and what is known too */
} LobattoStep;

/* All of `left` seconds, or the way to the end of the piece, in one step. Not for quasi-static ways. */
bool lobatto_step_along(const SlipMode *slip, const LobattoStart *from, double left, LobattoStep *lobatto);

#endif
