/* The pair of grooves along theta: the mechanism's geometry as a function of theta alone.
 *
 * z = g1(gamma) = g2(phi), gamma + phi = theta (mechanism page, section 2). What motion needs is
 *     a_1(theta) = g1'(gamma(theta))    a_2(theta) = g2'(theta - gamma(theta))    z(theta) = g1(gamma)
 * and derivatives of a_i by theta. They are precomputed as piecewise polynomials: pieces end at table
 * knots, where third derivatives jump, and wherever TRANSMISSION_DEGREE does not suffice for 13 digits.
 * So a value costs a few multiplications, and no root is sought while the mechanism moves. */
#ifndef DUALCAM_TRANSMISSION_H
#define DUALCAM_TRANSMISSION_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "geometry/groove.h"
#include "model/fault.h"
#include "model/params.h"

enum { TRANSMISSION_DEGREE = 12 };
_Static_assert(TRANSMISSION_DEGREE % 2 == 0, "piece_at pairs an even part with an odd one that is one shorter");

/* Where a vector may be loaded at once; a 32-bit malloc knows of no larger alignment. */
enum { PIECE_ALIGNMENT = sizeof(void *) == 8 ? 16 : 8 };

/* Monomials in x = (theta - middle) scale, lowest first. x runs through [-1, 1]; only two helices have
 * x = theta (middle 0, scale 1), which makes every value exact. */
typedef struct {
    double lower, upper;                                                /* rad */
    double middle, scale;                                               /* rad, 1/rad */
    _Alignas(PIECE_ALIGNMENT) double slope[TRANSMISSION_DEGREE + 1][2]; /* [k][i] of cam i: both are wanted at once */
    double z[TRANSMISSION_DEGREE + 1];
    bool knot_lower, knot_upper; /* a table knot (a third derivative jumps), not just another polynomial */
} TransmissionPiece;

/* The geometry at one theta. Polynomials being what they are, a slope that should be 0 may be negative by
 * rounding. */
typedef struct {
    double slope[2];           /* m/rad, a_i */
    double dslope_dtheta[2];   /* m/rad^2, da_i/dtheta */
    double d2slope_dtheta2[2]; /* m/rad^3, d^2 a_i/dtheta^2 */
    double z;                  /* m */
} TransmissionPoint;

typedef struct {
    Groove groove[2];
    CamParams cam[2];         /* that it was built from */
    double lower, upper;      /* rad */
    size_t count;             /* of pieces */
    TransmissionPiece *piece; /* owned, in order of theta */
    bool straight;            /* both grooves are helices: one piece with exact constants */
    double slope_size;        /* m/rad, largest |a_i|: what the rounding of the polynomials is of; 0 if straight */
    double z_size;            /* m, largest |z|, likewise */
} Transmission;

/* Precomputes the course between the stops. A table's relative path starts from the directory `resources`. On failure
 * returns false with the reason in `fault`; `course` then owns nothing. */
bool transmission_build(Transmission *transmission, const Params *params, const char *resources, Fault *fault);

/* Is this the course of these grooves and stops? Friction is no matter of it. False for a zeroed Transmission. */
bool transmission_is_of(const Transmission *transmission, const Params *params);

/* Safe on a zeroed Transmission, and twice. */
void transmission_free(Transmission *transmission);

/* The piece that holds theta; at a border the one ahead in `direction` (0: either). Within 1e-9 of the
 * piece's width of a border counts as at the border. Outside the course: the first or last piece. */
const TransmissionPiece *transmission_piece(const Transmission *transmission, double theta, int direction);

/* gamma and z to rounding, from the groove laws (not from the polynomials); they depend on theta alone. */
double transmission_gamma(const Transmission *transmission, double theta);
double transmission_z(const Transmission *transmission, double theta);

/* The same of both cams, computed by one instruction. */
typedef double Both __attribute__((vector_size(2 * sizeof(double))));

static inline Both slopes_of(const TransmissionPiece *piece, int k) {
    Both both;
    memcpy(&both, piece->slope[k], sizeof both);
    return both;
}

/* Coefficients k - 1 and k of z. */
static inline Both heights_of(const TransmissionPiece *piece, int k) {
    return (Both){piece->z[k - 1], piece->z[k]};
}

/* How many derivatives of the slopes are wanted. */
typedef enum { TRANSMISSION_SLOPES, TRANSMISSION_FIRST_DERIVATIVES, TRANSMISSION_SECOND_DERIVATIVES } TransmissionDepth;

/* Values of the piece's polynomials; also slightly outside the piece (analytic continuation).
 *
 * p(x) = E(y) + x O(y) with y = x^2: Horner's rule for the even and the odd part, each with its first
 * derivative (e1, o1) and half its second by y (e2, o2), is half as long a chain as Horner's rule in x and
 * takes fewer operations. All chains are independent, so the processor runs them side by side. What is
 * deeper than wanted is left 0. */
static inline TransmissionPoint piece_point(const TransmissionPiece *piece, double theta, TransmissionDepth depth) {
    const bool with_first = depth >= TRANSMISSION_FIRST_DERIVATIVES,
               with_second = depth >= TRANSMISSION_SECOND_DERIVATIVES;
    const double x = (theta - piece->middle) * piece->scale, y = x * x;
    const Both none = {0.0, 0.0};
    Both e = slopes_of(piece, TRANSMISSION_DEGREE), e1 = none, e2 = none;
    Both o = slopes_of(piece, TRANSMISSION_DEGREE - 1), o1 = none, o2 = none;
    Both z = heights_of(piece, TRANSMISSION_DEGREE); /* odd and even part */
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
    const Both value = e + x * o;
    const Both first = with_first ? (o + 2.0 * (x * e1 + y * o1)) * piece->scale : none;
    const Both half_second = with_second ? e1 + 4.0 * y * e2 + x * (3.0 * o1 + 4.0 * y * o2) : none;
    const double square = 2.0 * piece->scale * piece->scale;
    return (TransmissionPoint){
        .slope = {value[0], value[1]},
        .dslope_dtheta = {first[0], first[1]},
        .d2slope_dtheta2 = {square * half_second[0], square * half_second[1]},
        .z = z[1] * y + piece->z[0] + x * z[0],
    };
}

static inline TransmissionPoint piece_at(const TransmissionPiece *piece, double theta) {
    return piece_point(piece, theta, TRANSMISSION_SECOND_DERIVATIVES);
}

#endif
