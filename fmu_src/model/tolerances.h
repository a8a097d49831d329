/* Every tolerance and every limit of the core, each with its reason, by the room that uses it.
 *
 * A tolerance is a share of the size named beside it. Where a test fails once the tolerance is ten times larger, the
 * test is named. Limits bound the work of one call. */
#ifndef DUALCAM_TOLERANCES_H
#define DUALCAM_TOLERANCES_H

#include <float.h>

/* ---- numerics ---- */

/* ---- geometry ---- */

/* ---- contact ---- */

/* ---- closed_form ---- */

/* Share of the sum of |terms| of x_i, or of dx_i/dt, below which the sum is zero: a few roundings. The flank of a zero
 * reaction follows from the first derivative that is not zero. */
#define NO_REACTION 1e-13

/* Share of its value at the start below which a derivative at the end of a segment has died away, so that its sign is
 * rounding. */
static const double LINEAR_DECAYED = 1e-12;

/* Share of the rate at the start of an interval below which the rate has died away, so that its sign is rounding. */
static const double LINEAR_DECAYED_RATE = 1e-13;

/* Share of the torques whose sum is M alpha below which M alpha is rounding: 45 times the unit roundoff. */
static const double LINEAR_TORQUE_ROUNDING = 1e-14;

/* Share of the start's omega and alpha that counts in the rounding of x_i at the end. Times NO_REACTION: a few unit
 * roundoffs of the start. */
static const double LINEAR_START_SHARE = 0.01;

/* Newton step times the largest rate of the motion, below which the second derivative is constant over the step. */
static const double LINEAR_NEWTON_SHORT = 0.1;

/* Limit of the root finder's iterations. Every other iteration halves the bracket at least, so about 120 reach two
 * neighbouring numbers. */
enum { LINEAR_ROOT_ITERATIONS = 200 };

/* ---- collocation ---- */

/* ---- forward ---- */

/* ---- inverse ---- */

/* ---- sensitivity ---- */

/* ---- fmi ---- */

#endif
