/* Coulomb friction at the two contacts of the pin.
 *
 * In each groove the pin bears on one of two flanks. With x_i = R_i / hypot(r_i, a_i), R_i the total
 * normal reaction (+ on the flank that carries F > 0) and e_i = sign(x_i), moving in direction
 * sigma, the contact passes torque and axial force
 *     tau_i = r_i n_i x_i    A_i = d_i x_i    n_i = a_i + sigma e_i mu_i r_i    d_i = r_i - sigma e_i mu_i a_i
 * (mechanism page, section 3: "forms that stay finite at lambda -> 0"). Axial balance A_1 + A_2 = A
 * and moment balance tau_2 - tau_1 = W, with W = I gamma_ddot, give, with Delta = r2 d1 n2 + r1 d2 n1,
 *     x_1 = (r2 n2 A - d2 W)/Delta    x_2 = (r1 n1 A + d1 W)/Delta    T = tau_2 = r2 n2 x_2
 * No trigonometric call, and only Delta = 0 is singular. */
#ifndef DUALCAM_CONTACT_H
#define DUALCAM_CONTACT_H

#include <stdbool.h>

#include "geometry/cam.h"

/* Linear map from axial load A and twist W to torque and reactions, for one direction and one pair
 * of flanks. */
typedef struct {
    bool regular;      /* Delta != 0 */
    double rho;        /* m, T per A */
    double rho_kappa1; /* T per W */
    double axial[2];   /* 1/m, x_i per A */
    double moment[2];  /* 1/m^2, x_i per W */
} Transfer;

/* Edges of the stick band per axial load F_0 > 0: T_load = load F_0, T_release = release F_0.
 * load = +inf: jammed; release = -inf: wedged. For F_0 < 0 the two change places (same products). */
typedef struct {
    double load, release; /* m */
} BandFactors;

/* x_i of a contact and its first and second time derivatives, or their sizes. */
typedef struct {
    double value, rate, curvature;
} ContactLoad;

/* x_i and its first time derivative, of both contacts. */
typedef struct {
    double value[2], rate[2];
} ContactLoadPair;

/* ---- flanks and slip modes ---- */

enum { FLANK_PAIR_COUNT = 4, SLIP_MODE_COUNT = 2 * FLANK_PAIR_COUNT /* directions x pairs of flanks */ };

/* The pairs of flanks in the order in which a search tries them: (s,s), (s,-s), (-s,s), (-s,-s) with s = `sign`, the
 * sign of the axial load. The supporting flanks come first. */
static inline void flank_pair(int k, int sign, int flank[2]) {
    flank[0] = k < 2 ? sign : -sign;
    flank[1] = k % 2 == 0 ? sign : -sign;
}

/* Index of a slip mode in a table of SLIP_MODE_COUNT. */
static inline int slip_index(int direction, const int flank[2]) {
    return (direction > 0 ? 0 : 4) + (flank[0] > 0 ? 0 : 2) + (flank[1] > 0 ? 0 : 1);
}

/* direction: +1 loading, -1 releasing; flank[i] = e_i: +1 or -1. */
Transfer contact_transfer(const Geometry *g, int direction, const int flank[2]);

BandFactors contact_band(const Geometry *g);

/* The pair of flanks and the transfer by which motion in `direction` along the band's edge carries F_0 > 0; false
 * where no torque moves it that way. */
bool contact_edge(const Geometry *g, int direction, int flank[2], Transfer *transfer);

#endif
