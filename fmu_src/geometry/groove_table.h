/* The curve through the samples of a groove.
 *
 * Quintic Hermite pieces, so g is twice continuously differentiable. At each knot slope d_j and second
 * derivative c_j are those of the polynomial of degree 4 through the 5 nearest knots (j-2..j+2,
 * shifted inward at the ends; with exactly 4 points degree 3 through all). Then, for monotony, with
 * Delta_j = (z_{j+1}-z_j)/(psi_{j+1}-psi_j) and h_j the width of piece j:
 *   (1) d_j = max(d_j, 0); if a piece adjacent to knot j has Delta = 0 then d_j = c_j = 0.
 *   (2) clamp c_j into [-4 d_j/h_right, +4 d_j/h_left] (only the existing side at the ends).
 *   (3) for each piece s = 2 d0 + c0 h/4 + 2 d1 - c1 h/4; f = min(1, 5 Delta/s) (f = 1 if s <= 0).
 *   (4) multiply d_j and c_j by the smallest f of the adjacent pieces.
 * Then the Bernstein coefficients of the derivative, d0, d0 + c0 h/4, 5 Delta - s, d1 - c1 h/4 and d1, are all >= 0:
 * monotone samples give a monotone curve. z is measured from the curve's value at psi = 0. */
#ifndef DUALCAM_GROOVE_TABLE_H
#define DUALCAM_GROOVE_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "geometry/groove_csv.h"

/* A groove law at one angle: g, g', g'' in m, m/rad, m/rad^2. */
typedef struct {
    double z, slope, dslope_dpsi;
} GroovePoint;

/* The curve from one sample to the next; 64 bytes. */
typedef struct {
    double psi;      /* rad, where it starts */
    double width;    /* rad */
    double z;        /* m, where it starts */
    double slope[5]; /* m/rad, Bernstein coefficients of the derivative: none is negative */
} TablePiece;

typedef struct {
    TablePiece *piece; /* owned */
    size_t count;      /* of pieces */
} Table;

/* Builds the curve through samples that samples_read() has accepted. Returns false, with an empty table, if memory is
 * short or if the samples are so close that a coefficient overflows. */
bool table_build(Table *table, const Samples *samples);

/* Safe on a zeroed Table, and twice. */
void table_free(Table *table);

/* The curve at psi within the samples' range. */
GroovePoint table_at(const Table *table, double psi);

/* An angle where the height of the curve is z or nearest to z. */
double table_angle(const Table *table, double z);

#endif
