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

/* ---- collocation ---- */

/* ---- forward ---- */

/* ---- inverse ---- */

/* A coefficient of the imposed polynomial at the end of the step is zero if it is below this share of what adds up to
 * it: a speed that is zero at the end makes no reversal just before the end. */
static const double MOTION_END_ROUNDING = 8.0 * DBL_EPSILON;

/* An imposed angle may lie beyond a stop by this share of the range between the stops: masters add up their angles.
 * From 7e-7 on test_refuses_to_go_beyond_the_stops of test_inverse.py fails; ten times the value passes. */
static const double IMPOSED_STOP_ROUNDING = 1e-9;

/* rad/s: the event indicator changes its sign this late, so that rest, omega = 0, is no event. */
static const double INVERSE_INDICATOR_DELAY = 1e-10;

/* The elastic shaft's torque and the edge of the stick band are known to a few roundings. Shares of the sum of the
 * magnitudes that their difference adds up. The tests pass with ten times these values. */
static const double BAND_EDGE_ROUNDING = 16.0 * DBL_EPSILON; /* a smaller excess does not move cam 2 */
static const double BAND_EDGE_TIE = 64.0 * DBL_EPSILON;      /* a smaller difference: the torque is on the edge */

/* The holding angle may fall between two samples if its slope halfway is below this share of the largest slope. A
 * larger share costs more searches for the smallest slope, and finds no fewer reversals. */
static const double SMALL_EDGE_SLOPE = 0.1;

/* Sampling with an elastic shaft. More samples find narrower places where cam 2 rests or snaps, and cost more. */
enum {
    ELASTIC_SEARCH_INTERVALS = 64, /* of the search for a rest position, from stop to stop; at least */
    ELASTIC_REST_SAMPLES = 4,      /* per interval of the search */
    ELASTIC_SNAP_SAMPLES = 8,      /* per part of a path of cam 2, in search of a snap */
    ELASTIC_PATH_PARTS = 100,      /* of a path of cam 2 in one interval, at most */
    ELASTIC_FORCE_INTERVALS = 64,  /* of constant F_ext, in which a polynomial F_ext is followed */
    BAND_EDGE_GOLDEN_STEPS = 50    /* of the search for the smallest slope: the interval shrinks by 3.6e-11 */
};

/* ---- sensitivity ---- */

/* ---- fmi ---- */

/* Relative tolerance of integration: where the master gives none, and the range that others are brought into. Below the
 * range rounding is larger; above the range the results mean nothing. */
static const double TOLERANCE_DEFAULT = 1e-9;
static const double TOLERANCE_MIN = 1e-12;
static const double TOLERANCE_MAX = 1e-2;

/* A master adds up its time on its own: the time of a step may differ from the FMU's by this share. */
static const double TIME_ROUNDING = 1e-12;

/* Share of the largest input value: differences of sampled inputs below this share are rounding, as those of a constant
 * or of a ramp are. */
static const double SAMPLED_INPUT_ROUNDING = 8.0 * DBL_EPSILON;

#endif
