/* The transmission: both grooves as functions of theta alone.
 *
 * z = g1(gamma) = g2(phi), gamma + phi = theta (docs/mechanism.md, section 2). The equations of motion need
 *     a_1(theta) = g1'(gamma(theta))    a_2(theta) = g2'(theta - gamma(theta))    z(theta) = g1(gamma)
 * and derivatives of a_i by theta. The transmission holds them as piecewise polynomials. The pieces end at the knots
 * of tables, where third derivatives jump, and wherever TRANSMISSION_DEGREE does not suffice for 13 digits. A value
 * then costs a few multiplications, and no root is sought while the mechanism moves.
 *
 * The room geometry/ holds the shape of the mechanism: the groove laws g_i(psi) and tables of samples (groove.h), the
 * pin in both grooves (pin_position.h), the transmission, and the kinematics at one theta (cam.h). May include:
 * platform, elementary, numerics, model. */
#ifndef DUALCAM_TRANSMISSION_H
#define DUALCAM_TRANSMISSION_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "elementary/vector2.h"
#include "geometry/groove.h"
#include "model/fault.h"
#include "model/params.h"
#include "numerics/chebyshev.h"

enum { TRANSMISSION_DEGREE = CHEBYSHEV_DEGREE };
_Static_assert(TRANSMISSION_DEGREE % 2 == 0, "piece_at pairs an even part with an odd one that is one shorter");

/* bytes: the alignment at which a Vector2 is loaded by one instruction; malloc of 32-bit systems guarantees 8. */
enum { PIECE_ALIGNMENT = sizeof(void *) == 8 ? 16 : 8 };

/* Coefficients by powers of x = (theta - middle) scale, lowest first. x runs through [-1, 1]; only for two helices
 * x = theta (middle 0, scale 1), which makes every value exact. */
typedef struct {
    double lower, upper;                                                /* rad */
    double middle, scale;                                               /* rad, 1/rad */
    _Alignas(PIECE_ALIGNMENT) double slope[TRANSMISSION_DEGREE + 1][2]; /* [k][i] of cam i: both are read together */
    double z[TRANSMISSION_DEGREE + 1];
    bool knot_lower, knot_upper; /* a knot of a table lies at that end: a third derivative jumps there */
} TransmissionPiece;

/* The transmission at one theta. The polynomial of a slope that is 0 may round below 0. */
typedef struct {
    double slope[2];           /* m/rad, a_i */
    double dslope_dtheta[2];   /* m/rad^2, da_i/dtheta */
    double d2slope_dtheta2[2]; /* m/rad^3, d^2 a_i/dtheta^2 */
    double z;                  /* m */
} TransmissionPoint;

typedef struct {
    Groove groove[2];
    CamParams cam[2];         /* the parameters that the transmission was built from */
    double lower, upper;      /* rad */
    size_t count;             /* of pieces */
    TransmissionPiece *piece; /* owned, in order of theta */
    bool straight;            /* both grooves are helices: one piece with exact constants */
    double slope_size;        /* m/rad, largest |a_i|: the polynomials round by some eps of this value; 0 if straight */
    double steepest[2];       /* m/rad, largest |a_i| of each cam; 0 for a helix, whose slope is exact */
    double z_size;            /* m, largest |z|, likewise */
} Transmission;

/* Was the transmission built for these grooves and stops? Friction does not matter. False for a zeroed Transmission. */
bool transmission_is_of(const Transmission *transmission, const Params *params);

/* Safe on a zeroed Transmission, and twice. */
void transmission_free(Transmission *transmission);

/* The piece that holds theta; at a breakpoint the piece ahead in `direction` (0: either). A theta within
 * BREAKPOINT_MERGING of the piece's width counts as at the breakpoint. Beyond the stops: the first or last piece. */
const TransmissionPiece *transmission_piece(const Transmission *transmission, double theta, int direction);

/* gamma and z to rounding, from the groove laws, not from the polynomials. */
double transmission_gamma(const Transmission *transmission, double theta);
double transmission_z(const Transmission *transmission, double theta);

typedef Vector2 Both; /* the name of Vector2 in lobatto_step.c */

/* Coefficients k of both slopes. */
static inline Vector2 slopes_of(const TransmissionPiece *piece, int k) {
    Vector2 slopes;
    memcpy(&slopes, piece->slope[k], sizeof slopes);
    return slopes;
}

/* Coefficients k - 1 and k of z. */
static inline Vector2 heights_of(const TransmissionPiece *piece, int k) {
    return (Vector2){piece->z[k - 1], piece->z[k]};
}

/* The derivatives of the slopes to compute. */
typedef enum { TRANSMISSION_SLOPES, TRANSMISSION_FIRST_DERIVATIVES, TRANSMISSION_SECOND_DERIVATIVES } TransmissionDepth;

/* Values of the piece's polynomials; also slightly outside the piece, by their continuation. Derivatives beyond `depth`
 * are left 0.
 *
 * p(x) = E(y) + x O(y) with y = x^2. Horner's rule runs for the even and the odd part, each with its first derivative
 * (e1, o1) and half its second derivative (e2, o2) by y. A chain is half as long as that of Horner's rule in x, and all
 * chains are independent, so the processor runs them side by side. */
static inline TransmissionPoint piece_point(const TransmissionPiece *piece, double theta, TransmissionDepth depth) {
    const bool with_first = depth >= TRANSMISSION_FIRST_DERIVATIVES,
               with_second = depth >= TRANSMISSION_SECOND_DERIVATIVES;
    const double x = (theta - piece->middle) * piece->scale, y = x * x;
    const Vector2 none = {0.0, 0.0};
    Vector2 e = slopes_of(piece, TRANSMISSION_DEGREE), e1 = none, e2 = none;
    Vector2 o = slopes_of(piece, TRANSMISSION_DEGREE - 1), o1 = none, o2 = none;
    Vector2 z = heights_of(piece, TRANSMISSION_DEGREE); /* odd and even part */
    for (int k = TRANSMISSION_DEGREE - 2; k >= 2; k -= 2) {
        if (with_second) e2 = e2 * y + e1;
        if (with_first) e1 = e1 * y + e;
        e = e * y + slopes_of(piece, k);
        z = z * y + heights_of(piece, k);
        if (with_second) o2 = o2 * y + o1;
        if (with_first) o1 = o1 * y + o;
        o = o * y + slopes_of(piece, k - 1);
    }
    if (with_second) e2 = e2 * y + e1;
    if (with_first) e1 = e1 * y + e;
    e = e * y + slopes_of(piece, 0);
    const Vector2 value = e + x * o;
    const Vector2 first = with_first ? (o + 2.0 * (x * e1 + y * o1)) * piece->scale : none;
    const Vector2 half_second = with_second ? e1 + 4.0 * y * e2 + x * (3.0 * o1 + 4.0 * y * o2) : none;
    const double square = 2.0 * piece->scale * piece->scale;
    return (TransmissionPoint){
        .slope = {value[0], value[1]},
        .dslope_dtheta = {first[0], first[1]},
        .d2slope_dtheta2 = {square * half_second[0], square * half_second[1]},
        .z = z[1] * y + piece->z[0] + x * z[0],
    };
}

/* piece_point() with first derivatives, not inlined. */
TransmissionPoint piece_at(const TransmissionPiece *piece, double theta);

#endif
