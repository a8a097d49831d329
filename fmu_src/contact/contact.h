/* Coulomb friction at the two contacts of the pin.
 *
 * The contact room holds the forces at the pin: friction, flanks, the stick band, the balance of forces and its
 * derivatives. It may include platform, elementary, numerics, model and geometry.
 *
 * In each groove the pin bears on one of two flanks. With x_i = R_i/hypot(r_i, a_i), R_i the total normal reaction
 * (positive on the flank that carries F > 0) and the flank sign e_i = sign(x_i), contact_factors.h gives the torques
 * and the axial forces of the contacts. Axial balance A_1 + A_2 = A and moment balance tau_2 - tau_1 = W, W = I
 * gamma_ddot, give x_1, x_2 and the torque T of cam 2, linear in A and W. No trigonometric function is needed, and only
 * Delta = 0 is singular (docs/mechanism.md, section 3).
 *
 * Three words for contacts that block:
 *   locked  one contact: its lead angle does not exceed its friction angle (n_i <= 0 when releasing), so that the axial
 *           load cannot turn the cam back. With one contact locked, releasing needs tau < 0.
 *   jammed  the pair, when loading: Delta <= 0, so that T_load is infinite. Such parameters are refused (domain.h).
 *   wedged  the pair, in one direction: no pair of flanks agrees with its own reactions, so that no torque moves the
 *           mechanism this way, and it rests. */
#ifndef DUALCAM_CONTACT_H
#define DUALCAM_CONTACT_H

#include <stdbool.h>

#include "geometry/cam.h"

/* The linear map from axial load A and moment W to torque and reactions, for one direction and one pair of flanks. */
typedef struct {
    bool regular;      /* Delta != 0 */
    double delta;      /* m^3 */
    double rho;        /* m, T per A */
    double rho_rate;   /* m, dT/dA: rho, unless friction depends on the load */
    double rho_kappa1; /* T per W */
    double axial[2];   /* 1/m, x_i per A */
    double moment[2];  /* 1/m^2, x_i per W */
} Transfer;

/* Edges of an interval of torque at rest, per axial load F_0: the upper edge is load F_0, the lower edge release F_0.
 * load = +inf: jammed; release = -inf: wedged. */
typedef struct {
    double load, release;           /* m */
    double load_rate, release_rate; /* m, dT/dF_0: the same, unless friction depends on the load */
} BandFactors;

/* ---- flanks and slip modes ---- */

enum { FLANK_PAIR_COUNT = 4, SLIP_MODE_COUNT = 2 * FLANK_PAIR_COUNT /* directions x pairs of flanks */ };

/* Pair k of flanks in the order of the rule (docs/mechanism.md, section 3): (s,s), (s,-s), (-s,s), (-s,-s) with s =
 * `sign`, the sign of the axial load. The supporting flanks come first. */
static inline void flank_pair(int k, int sign, int flank[2]) {
    flank[0] = k < 2 ? sign : -sign;
    flank[1] = k % 2 == 0 ? sign : -sign;
}

/* Index of a slip mode in a table of SLIP_MODE_COUNT. */
static inline int slip_index(int direction, const int flank[2]) {
    return (direction > 0 ? 0 : 4) + (flank[0] > 0 ? 0 : 2) + (flank[1] > 0 ? 0 : 1);
}

/* direction: +1 loading, -1 releasing; flank[i] = e_i: +1 or -1. rho_rate is that under the load of cam_set_load(). */
Transfer contact_transfer(const Geometry *g, int direction, const int flank[2]);

/* The stick band for F_0 > 0. For F_0 < 0 the same two products are the edges of the other direction. */
BandFactors contact_band(const Geometry *g);

/* The pair of flanks and the transfer with which motion in `direction` along the band's edge carries F_0 > 0; false
 * where no torque moves the mechanism in this direction. */
bool contact_edge(const Geometry *g, int direction, int flank[2], Transfer *transfer);

#endif
