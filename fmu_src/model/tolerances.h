/* Every tolerance and every limit of the core, each with its reason, by the room that uses it. Those of the numerical
 * methods stand in numerics/numerics.h, which numerics may include.
 *
 * A tolerance is a share of the size named beside it. Where a test fails once the tolerance is ten times larger, the
 * test is named. Limits bound the work of one call. */
#ifndef DUALCAM_TOLERANCES_H
#define DUALCAM_TOLERANCES_H

#include <float.h>

/* ---- numerics: numerics/numerics.h ---- */

/* ---- geometry ---- */

/* Samples of a table, and bytes of its file. Fewer than four samples do not determine slopes and curvatures; the upper
 * limits bound memory and time. */
enum { SAMPLES_MIN = 4, SAMPLES_MAX = 100000, SAMPLES_MAX_BYTES = 16 * 1024 * 1024 };

/* Newton's method for the angle of a table ends at this share of a piece's width: half a rounding of 1. Ten
 * times larger: tests/test_groove.py fails, in the test of a transmission with a dwell. */
static const double TABLE_ROUNDING = 1e-16;

/* Newton steps or bisections at most; bisection alone needs 53. */
enum { TABLE_MAX_ITERATIONS = 100 };

/* S = sin(lead angle) of an elliptical groove may come this close to 1, where tan(lead angle) is 7e4 b/a: beyond, the
 * groove counts as vertical. Ten times larger: tests/test_groove.py fails, in the test of the ends of an ellipse. */
static const double ELLIPSE_VERTICAL = 1e-10;

/* Newton's method for gamma ends where its step, or the gap between both grooves, is this share of the angle or of z.
 * Ten times larger: tests/test_groove.py fails, in the test of a transmission. */
static const double PIN_ROUNDING = 2.0 * DBL_EPSILON;

/* Newton steps or bisections at most: bisection of all doubles takes 64 or, for those near zero, some more. */
enum { PIN_MAX_ITERATIONS = 200 };

/* A groove with tan(lead angle) below this value counts as level. */
static const double LEVEL_SLOPE = 1e-9;

/* rad, times 1 + |stop|: a groove may end this much before a stop, for the rounding of an end that is meant to be the
 * stop. */
static const double GROOVE_END_SLACK = 1e-12;

/* Share of the range between the stops within which two breakpoints are one, and below which pieces are not halved;
 * and share of a piece's width within which theta is at its breakpoint. */
static const double BREAKPOINT_MERGING = 1e-9;

/* Error of the polynomials of a transmission, as a share of the largest slope or height. Ten times larger:
 * tests/test_groove.py fails, in the test of the derivatives of a transmission. */
static const double TRANSMISSION_ERROR = 1e-13;

/* The polynomials may err by this many times the estimated rounding of the slopes, in addition. Ten times larger:
 * tests/test_groove.py fails, in the test of a transmission with a dwell. */
static const double TRANSMISSION_ROUNDING_FACTOR = 16.0;

/* Last two Chebyshev coefficients at most, in multiples of the allowed error: a necessary condition that saves the
 * comparison between nodes. */
static const double CHEBYSHEV_TAIL_FACTOR = 100.0;

/* Pieces of a transmission at most, besides those that end at a knot of a table. */
enum { TRANSMISSION_MAX_PIECES = 20000 };

/* ---- contact ---- */

/* Samples per piece of the transmission in the search for jammed contacts. A piece is one smooth polynomial; the pieces
 * of a table, JAM_MANY_PIECES or more, are short. */
enum { JAM_SAMPLES = 64, JAM_SAMPLES_OF_MANY = 8, JAM_MANY_PIECES = 64 };

/* Share of the terms that add up to a reaction below which the reaction is zero and suits either flank: rounding. */
static const double REACTION_ROUNDING = 16.0 * DBL_EPSILON;

/* Share of balance_load_size() by which a reaction must exceed zero so that a step may skip the search for a change of
 * flank. */
static const double FLANK_CLEARANCE = 1e-9;

/* The share of the transmission's sizes that counts as a term of z and of the slopes. Sums count as zero below 1e-13 of
 * their terms; the polynomials round by some eps of the transmission's sizes, 1e-2 of 1e-13. */
static const double TRANSMISSION_TERM_SHARE = 0.01;

/* ---- closed_form ---- */

/* ---- collocation ---- */

/* ---- forward ---- */

/* ---- inverse ---- */

/* ---- sensitivity ---- */

/* ---- fmi ---- */

#endif
