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

/* Torque and load at rest are known to a few roundings, in curved grooves to the digits of the transmission. A
 * difference below this share of their size counts as zero: a tie is rest. */
static const double STICK_TIE_STRAIGHT = 8.0 * DBL_EPSILON;
static const double STICK_TIE_CURVED = 2e-12;

/* The rounding of the transmission's polynomials is of the largest z and of the largest slope between the stops. These
 * shares of them count among the terms of F_0 and of a torque. */
static const double STICK_HEIGHT_SHARE = 0.1;
static const double STICK_SLOPE_SHARE = 0.01;

/* What is left of a rate of torque and the rate of the band's edge that cancel: below this share of both it is zero.
 * Helices with linear forces know both rates exactly. */
static const double STICK_RATE_CANCELLED = 1e-12;

/* Torque and edge move together, where their rates differ by less than this share. */
static const double STICK_EDGE_MOVES_ALONG = 1e-9;

/* The modes other than stick end this many ties short of the band's edge: a tie at the edge is stick. */
static const double STICK_MARGIN_TIES = 4.0;

/* A collocation step ends on a change of flanks to its own rounding: this many times the rounding of one balance. */
static const double CANDIDATE_COARSE = 10.0;

/* Where neither a reaction nor its rate tells the flank, the reaction of a little later does: after this share of the
 * motion's time scale, and at most as many seconds. */
static const double CANDIDATE_LOOK_AHEAD = 1e-3;

/* A fold is where the edge of the band stops rising. Nearer to the fold than this share of a piece's width, the rounding
 * of the torques is all that moves theta. The energies that a jump from there leaves out are of its third power. */
static const double FOLD_SHARE = 3e-6;

/* A bounce whose excursion is below this share of the largest angle is lost in the rounding of theta. */
static const double BOUNCE_INVISIBLE = 16.0 * DBL_EPSILON;

/* A velocity ratio dz/dtheta below this share of the steepest slope is near enough to a dwell to run away. */
static const double NEAR_DWELL = 1e-3;

/* A solver that integrates for model exchange finds an end stop to this share of the largest angle. */
static const double AT_STOP = 1e-13;

/* Model exchange: an indicator crosses zero this much late, beyond the tie tolerance, so that a reported crossing
 * changes the mode. Stops are not late: to fall on beyond them would make the smallest bounces go on for ever. */
static const double LATE_SPEED = 1e-10; /* rad/s */
static const double LATE_TIES = 4.0;    /* ties of torque */
static const double LATE_LOADS = 1e-11; /* of the terms of a reaction; the tie of the reactions is less */

/* Model exchange: a solver may look this far beyond the stops, a share of the last piece's width. The polynomials of the
 * transmission still hold there. */
static const double SOLVER_OVERSHOOT = 0.05;

/* Play operator: the first sample of a piece is this share of its width away; each is up to twice as far from the last
 * as that from its own, up to 1/PLAY_SAMPLES of the width. Between two samples the edge crosses the torque at most once. */
static const double PLAY_FIRST_SAMPLE = 1e-6;
enum { PLAY_SAMPLES = 32 };

/* Play operator: two rules of order 13 that agree to the tolerance are more exact than their difference. */
static const double PLAY_SHARE_OF_TOLERANCE = 0.1;

/* Play operator: a sampled reaction below this share of the largest reaction so far is not looked at closely. */
static const double PLAY_NEAR_PEAK = 0.99;

/* Play operator: golden section finds a peak to 4e-9 of the interval, and its value to rounding. */
enum { PLAY_GOLDEN_STEPS = 40 };

/* Play operator: bounds of the work of one jump. */
enum { PLAY_MAX_DEPTH = 30, PLAY_MAX_HALVINGS = 5000, PLAY_MAX_BISECTIONS = 200 };

/* A step with more segments than this is refused: that bounds the time of a step to some tenths of a second. Only
 * bounces of a restitution near 1, or vibrations of a tiny inertia, come so often in one step. */
enum { MAX_SEGMENTS_PER_STEP = 200000 };

/* Stall guard: STALL_GUARD_SEGMENTS segments must advance time by the share STALL_GUARD_PROGRESS of the step, else the
 * step is refused. Speeds that are nothing but rounding would otherwise keep a step busy for minutes. */
enum { STALL_GUARD_SEGMENTS = 2000 };
static const double STALL_GUARD_PROGRESS = 1e-9;

/* Moving contacts can jam and let go again at once. Without inertia of the shaft a locked contact can do so for ever, in
 * ever shorter time: rigid bodies under Coulomb friction then have no motion at all (P. Painleve, 1895). */
enum { MAX_JAMS_PER_STEP = 1000 };

/* ---- inverse ---- */

/* ---- sensitivity ---- */

/* ---- fmi ---- */

#endif
