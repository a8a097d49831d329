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
