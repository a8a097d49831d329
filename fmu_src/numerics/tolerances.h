/* Every tolerance and every limit of the core, each with its reason, by the room that uses it. The file stands in the
 * lowest room that needs it, so that all rooms may include it.
 *
 * A tolerance is a share of the size that its comment names. Where a test fails once the tolerance is ten times
 * larger, the test is named. Limits bound the work of one call. */
#ifndef DUALCAM_TOLERANCES_H
#define DUALCAM_TOLERANCES_H

#include <float.h>

#include "numerics/friction_tolerances.h"

/* ---- numerics ---- */

/* bernstein */

/* Halvings of [0, 1] at most: 2^-48 is 16 roundings of 1, and narrower intervals hold nothing. */
enum { BERNSTEIN_MAX_DEPTH = 48 };

/* Widths, as shares of [0, 1], to which a zero of a polynomial is found, some roundings, and a maximum: the value there
 * errs by the square of this share. */
static const double BERNSTEIN_ZERO_WIDTH = 1e-15, BERNSTEIN_PEAK_WIDTH = 1e-10;

/* A polynomial through its values at the start and at the nodes of a collocation method exceeds the range of these
 * values by less than this share of the range: the Lebesgue constants of the nodes are below 2.2. */
static const double BEYOND_NODES = 0.6;

/* root */

/* Iterations of root finders at most: where the root is one of all doubles, which bisection alone finds in 64 and the
 * methods of the core in at most three times as many; and where it lies in a bracket of known size, which takes 60
 * halvings. */
enum { ROOT_MAX_ITERATIONS = 200, BRACKET_ITERATIONS = 100 };

/* Halvings of any interval of doubles at most: DBL_MAX to 5e-324. */
enum { BISECTIONS_MAX = 2200 };

/* Share of |x| at which a bracket holds no double inside, and a step of an iteration is rounding. Of the angle of the
 * pin ten times larger: tests/test_groove.py fails, in the test of a transmission. */
static const double ROOT_WIDTH = 2.0 * DBL_EPSILON;

/* golden section */

/* Steps in the search for a peak: 0.618^40 = 4e-9 of the interval, and the value errs by the square. */
enum { GOLDEN_STEPS = 40 };

/* quadrature */

/* Halvings of a panel, and panels in all, at most: they bound the work whatever the integrand is. */
enum { QUADRATURE_MAX_DEPTH = 40, QUADRATURE_MAX_PANELS = 20000 };

/* Panels below this share of the interval are not divided where formulas change: rounding may change them often. */
static const double QUADRATURE_NARROW = 1e-6;

/* A panel is integrated to the tolerance times this share of the whole sum of magnitudes at least. */
static const double QUADRATURE_NEGLIGIBLE = 1e-3;

/* Share of a panel's sum of magnitudes that rounding may take. */
static const double QUADRATURE_ROUNDING = 16.0 * DBL_EPSILON;

/* A sample exceeds its neighbours, and is searched for a peak, by more than this share of its value: rounding. */
static const double QUADRATURE_PEAK_ROUNDING = 4.0 * DBL_EPSILON;

/* ---- model ---- */

/* Share of what adds up to it below which a coefficient of an input's polynomial is rounding: a difference of the
 * samples of a ramp, or a speed that is zero at the end of a step, which makes no reversal just before the end. */
static const double INPUT_ROUNDING = 8.0 * DBL_EPSILON;

/* Share s of spring_terms(), at most: where F_s begins with z^2 or z^3, the rounding of z changes F_s at z = 0 in
 * second order. */
static const double SPRING_BENDS = 2e-12;

/* Bytes of a file of numbers. Samples of a friction table: three give the curve a bend; steps end at each.
 * LARGEST_ENERGY: J, of one segment; 2^63 segments add up to a finite number. */
enum { CSV_MAX_BYTES = 16 * 1024 * 1024, FRICTION_SAMPLES_MIN = 3, FRICTION_SAMPLES_MAX = 2000 };
static const double FRICTION_MAX = 10.0, FRICTION_LOAD_POWER = 0.9, LARGEST_ENERGY = 1e288;

/* A step may pass a sample by a share of a piece, times tolerance^(3/8): the error of the jump grows with the cube;
 * share of that before a sample that counts as reached. In a step the speed may change by the share SPAN of a piece,
 * times SLACK beyond an aim: with a whole piece, errors reach 20 tolerances. Share of the way left by which a step
 * misses its aim. */
static const double FRICTION_OVERSHOOT = 0.6, FRICTION_REACHED = 0.25, FRICTION_AIM_SHARE = 0.8;
static const double FRICTION_SPAN = 0.5, FRICTION_SPAN_SLACK = 1.1;

/* ---- geometry ---- */

/* Samples of a groove table. Four determine slopes and curvatures; the upper limit bounds memory and time. */
enum { SAMPLES_MIN = 4, SAMPLES_MAX = 100000 };

/* Newton's method for the angle of a table ends at this share of a piece's width: half a rounding of 1. Ten
 * times larger: tests/test_groove.py fails, in the test of a transmission with a dwell. */
static const double TABLE_ROUNDING = 1e-16;

/* S = sin(lead angle) of an elliptical groove may come this close to 1, where tan(lead angle) is 7e4 b/a: beyond, the
 * groove counts as vertical. Ten times larger: tests/test_groove.py fails, in the test of the ends of an ellipse. */
static const double ELLIPSE_VERTICAL = 1e-10;

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

/* Samples per piece of the transmission in the search for the place that a message names. The pieces of a table,
 * JAM_MANY_PIECES, are short. Halvings of a piece, in all, in the proof that D > 0: where D all but touches zero, the
 * class is self-locking. */
enum { JAM_SAMPLES = 64, JAM_SAMPLES_OF_MANY = 8, JAM_MANY_PIECES = 64, DOMAIN_HALVINGS = 1000 };

/* Share of the terms that add up to a reaction below which the reaction is zero and suits either flank: rounding. */
static const double REACTION_ROUNDING = 16.0 * DBL_EPSILON;

/* Share of balance_load_size() by which a reaction must exceed zero so that no change of flank is searched for. */
static const double FLANK_CLEARANCE = 1e-9;

/* The share of the transmission's sizes that counts as a term of z and of the slopes. Sums count as zero below 1e-13 of
 * their terms; the polynomials round by some eps of the transmission's sizes, 1e-2 of 1e-13. */
static const double TRANSMISSION_TERM_SHARE = 0.01;

/* ---- closed_form ---- */

/* Share of the sum of |terms| of x_i, or of dx_i/dt, below which the sum is zero: a few roundings. The flank of a zero
 * reaction follows from the first derivative that is not zero. */
#define REACTION_ZERO_SHARE 1e-13

/* |2a| t and sqrt|w2| t up to which the oscillator's kernel is summed as a Taylor series. Below the limit the terms
 * shrink at least like 3.3^n/(n+3)!. Above the limit the closed forms lose at most two digits in p3, one in p2,
 * none in s. */
static const double OSCILLATOR_SERIES_LIMIT = 2.0;

/* Last term of these series, whose sums are about 1/6 and 1/24. */
static const double OSCILLATOR_SERIES_CUT = 1e-19;

/* Exponent that a growing solution may reach. exp(2 * 300) is still a finite number, and so is the integral of its
 * square. An excursion above rounding grows past any end stop in that time. */
static const double OSCILLATOR_MAX_GROWTH = 300.0;

/* m, an edge of the stick band per F_0 that stands for an infinite one: no torque is beyond it, once F_0 has its sign.
 * */
static const double STEEPEST_EDGE = 1e150;

/* Share of its value at the start below which a derivative at the end of a segment has died away: sign of rounding. */
static const double LINEAR_DECAYED = 1e-12;

/* Share of the rate at the start of an interval below which the rate has died away, so that its sign is rounding. */
static const double LINEAR_DECAYED_RATE = 1e-13;

/* Exponent at which the fast part of an overdamped motion has decayed below the rounding of its start. */
static const double LINEAR_FAST_DECAY = 40.0;

/* Share of the torques whose sum is M alpha below which M alpha is rounding: 45 times the unit roundoff. */
static const double LINEAR_TORQUE_ROUNDING = 1e-14;

/* Share of the start's omega and alpha in the rounding of x_i at the end. Times REACTION_ZERO_SHARE: some eps. */
static const double LINEAR_START_SHARE = 0.01;

/* Newton step times the largest rate of the motion, below which the second derivative is constant over the step. */
static const double LINEAR_NEWTON_SHORT = 0.1;

/* ---- collocation ---- */

/* Radau and Lobatto steps */
/* The iteration ends when a correction is this share of what the tolerance allows. */
static const double ITERATION_SHARE = 0.05;

/* Share of alpha (without inertia omega), or of the terms that add up to it, below which a correction is rounding. */
static const double CORRECTION_ROUNDING = 8.0 * DBL_EPSILON;

/* Share of theta by which it is uncertain: the sums of a step, and of the steps before, add up that many roundings. */
static const double ANGLE_ROUNDING = 64.0 * DBL_EPSILON;

/* Multiple of that rounding which the last correction may have when the iteration no longer converges: the rounding of
 * the forces can be that much larger than the rounding of their sum. */
static const double RADAU_STALLED = 100.0;

/* Multiple of a small correction below which the matrix of the iteration before serves once more. */
static const double RADAU_CHORD_BELOW = 1e6;

/* Stiffness of a step, h |by_omega| + h^2 |by_theta|, below which three terms of a series solve the linear system. */
static const double RADAU_SERIES_STIFFNESS = 0.05;

/* Stiffness above which the first iterate solves the equations linearised at the start: the tangent leads far off. */
static const double RADAU_TANGENT_STIFFNESS = 0.3;

/* Share of a piece's width by which a node may lie outside the piece: its polynomials still have 11 digits there. */
static const double RADAU_BEYOND_PIECE = 0.05;

/* Factor on the error estimate: keeps errors of the study of integrators below ten times the tolerance. Stiffness per
 * stage at which a step begins to lose the digits of its order 2s - 1. */
static const double RADAU_ERROR_SAFETY = 10.0, RADAU_STIFF_PER_STAGE = 1.7;

/* Share of the terms of the right-hand side below which a defect is their rounding. Seven stages weigh the rounding of
 * their values by up to 10 in the defect. */
static const double RADAU_FORCE_ROUNDING = 64.0 * DBL_EPSILON;

/* Newton iterations of one trial. A trial that needs more is repeated with a shorter step. */
enum { RADAU_NEWTON_ITERATIONS = 12 };

/* Energy balance of a step */

/* Share of the tolerance for the residual of one step, for many can pass the same energy; rounding of energies, and of
 * z. */
static const double STEP_ENERGY_SHARE = 0.1, STEP_ENERGY_ROUNDING = 32.0 * DBL_EPSILON;
static const double STEP_HEIGHT_ROUNDING = 2.0 * DBL_EPSILON;

/* Breakpoints: overshoot as a share of the narrower piece's width */

/* Between two polynomials of one smooth groove. */
static const double BREAKPOINT_OVERSHOOT = 0.02;

/* At a table knot, times the root of the tolerance: the error of the jump grows with the square of the overshoot. */
static const double BREAKPOINT_KNOT_OVERSHOOT = 0.03;

/* At a table knot along the edge of the stick band, which may have its fold there. */
static const double BREAKPOINT_EDGE_OVERSHOOT = 1e-10;

/* Step control */
/* h over the time scale of the motion below which three, or five, stages suffice; and the tolerance above which a step
 * never starts with seven stages. */
static const double STEP_FOR_3_STAGES = 0.06, STEP_FOR_5_STAGES = 0.5, STEP_7_STAGES_TOLERANCE = 1e-6;

/* First step of a vibration of angular frequency w: STEP_FIRST_LENGTH tolerance^(1/STEP_FIRST_ORDER)/w, which is 1/w at
 * the tolerance 1e-9. Measured: about the length that a step of seven stages turns out to have. */
static const double STEP_FIRST_LENGTH = 6.6, STEP_FIRST_ORDER = 11.0;

/* Margin on the factor that changes h, and the least error that the factor is made of. */
static const double STEP_SAFETY = 0.9, STEP_LEAST_ERROR = 1e-12;

/* Share of the order with which the error of a rejected step falls: the step is too long for its full order. */
static const double STEP_REJECTED_ORDER = 0.7;

/* Factors on h: after a rejected step at least MOST and at most LEAST, after an accepted one at most GROWTH, where the
 * equations have no solution UNSOLVED. */
static const double STEP_LEAST_SHORTENING = 0.8, STEP_MOST_SHORTENING = 0.1;
static const double STEP_MOST_GROWTH = 4.0, STEP_UNSOLVED_SHORTENING = 0.25;

/* Share of the proposed length above which a step takes over the proposed number of stages. */
static const double STEP_SIMILAR = 0.5;

/* Of one step; to end the step at a sample of friction. */
enum { STEP_TRIALS = 60, STEP_SAMPLE_TRIALS = 8 };

/* Event location */
/* Shares: of the step before which a crossing of an indicator that starts from zero is rounding, since the mode
 * decision has found the indicator to rise; of the largest value, below which a value within the step does not count as
 * a dip. */
static const double CROSSING_AT_ONCE = 1e-9, CROSSING_DIP = 1e-9;

/* Share of the terms of a reaction below which it passes zero together with the other one. */
static const double CROSSING_TOGETHER = 1e-6;

/* A reaction that the mode decision counts as zero leaves its flank this many times the decision's rounding below zero.
 * */
static const double CROSSING_ALLOWANCE = 2.0;

/* Share of the largest value of an indicator below which a coefficient of its polynomial is rounding. */
static const double CROSSING_COEFFICIENT = 1e-14;

/* Share of the step's length below which a change of the length is rounding. */
static const double LOCATION_ROUNDING = 4.0 * DBL_EPSILON;

/* At a stop: kinetic energy over the energy gained by errors up to which the errors alone have reached the stop. */
static const double LOCATION_STOP_GAIN = 2.0;

enum { LOCATION_ITERATIONS = 150, LOCATION_NEWTON = 30 }; /* steps tried to reach one crossing; before bisection */

/* Past a zero: the first extension as a share of the step's length, and the number of extensions, each four times the
 * one before. */
static const double LOCATION_FIRST_EXTENSION = 8.0 * DBL_EPSILON;
enum { LOCATION_EXTENSIONS = 11 };

/* An event that shows in shorter steps only: the factor on the length, and the shortest length as a share of the time
 * left. */
static const double LOCATION_SHORTENING = 0.125, LOCATION_SHORTEST = 1e-13;

/* Lobatto step */
/* Share of what the tolerance allows that the next sweep may change where the change is added: its own error is a tenth
 * or less, and in the scenes of benchmarks.friction_cost less than a hundredth. Factor by which a sweep must reduce the
 * change of the sweep before: else Newton's method is faster. Sweeps of one step. */
static const double LOBATTO_LAST_SHARE = 0.5, LOBATTO_CONTRACTION = 0.1;
enum { LOBATTO_SWEEPS = 8 };

/* Times the tolerance, the share of theta by which the last sweep may move the end of the step, where friction varies.
 * */
static const double LOBATTO_SHIFT_SHARE = 0.3;

/* Share of the distance to a breakpoint by which a step that aims at it may miss it. Ratio of the cubic term to the
 * square term, and of that to the linear one, in a motion that four nodes resolve. */
static const double LOBATTO_AIM_SHARE = 1e-8, LOBATTO_DECAY = 0.3;
/* Relative error of a peak per square of the error of its cubic over peak and second derivative. Margin, of
 * tolerance^8, after which a step is not swept again. */
static const double LOBATTO_PEAK_SHARE = 10.0, LOBATTO_FAR_OFF = 4.0;

/* ---- forward ---- */

/* Torque and load at rest, and along the edge of the stick band, are known to a few roundings, in curved grooves to the
 * digits of the transmission. At rest a difference below this share of their size counts as zero: a tie is rest. */
static const double STICK_TIE_STRAIGHT = 8.0 * DBL_EPSILON, STICK_TIE_CURVED = 2e-12;

/* The rounding of the transmission's polynomials is of the largest z and of the largest slope between the stops. These
 * shares of them count among the terms of F_0 and of a torque. */
static const double STICK_HEIGHT_SHARE = 0.1, STICK_SLOPE_SHARE = 0.01;

/* What is left of a rate of torque and the rate of the band's edge that cancel: below this share of both it is zero.
 * Helices with linear forces know both rates exactly. */
static const double STICK_RATE_CANCELLED = 1e-12;

static const double STICK_MARGIN_TIES = 4.0; /* short of the edge, where modes other than stick end: a tie is stick */

/* On the band's edge rounding can press the torque out of the band where no slip mode agrees. Then rest lasts until the
 * torque is beyond the edge by this many ties. */
static const double STICK_TIES_OF_NO_SLIP = 2.0;

/* A collocation step ends on a change of flanks to its own rounding: this many times the rounding of one balance. Share
 * of the terms of alpha, or without inertia of omega, below which it is rounding. */
static const double CANDIDATE_COARSE = 10.0, CANDIDATE_ROUNDING = 1e-11, CANDIDATE_TIES = 2.0;

/* Rounding of theta, as a share of the largest angle, over REACTION_ZERO_SHARE: a reaction that is smaller than the
 * effect of this rounding counts as zero. */
static const double CANDIDATE_ANGLE_ROUNDING = 4.0 * DBL_EPSILON / REACTION_ZERO_SHARE;

/* Breakaway: ties of torque beyond the edge of the band at which a step can resolve the motion. */
static const double BREAKAWAY_TIES = 8.0;

/* A fold is where the edge of the band stops rising. Nearer to the fold than this share of a piece's width, the
 * rounding of the torques is all that moves theta. The energies that a jump from there leaves out are of its third
 * power. */
static const double FOLD_SHARE = 3e-6;

/* A bounce whose excursion is below this share of the largest angle is lost in the rounding of theta. */
static const double BOUNCE_INVISIBLE = 16.0 * DBL_EPSILON;

/* A velocity ratio dz/dtheta below this share of the steepest slope is near enough to a dwell to run away. */
static const double NEAR_DWELL = 1e-3;

/* A solver that integrates for model exchange finds an end stop to this share of the largest angle. */
static const double AT_STOP = 1e-13;

/* Model exchange: an indicator crosses zero this much late, beyond the tie, so that a reported crossing changes the
 * mode, and rest of an imposed motion, omega = 0, is no event. Stops are not late: to fall on beyond them would make
 * the smallest bounces go on for ever. */
static const double LATE_SPEED = 1e-10; /* rad/s */
static const double LATE_TIES = 4.0;    /* ties of torque */
static const double LATE_LOADS = 1e-11; /* of the terms of a reaction; the tie of the reactions is less */

/* Model exchange: a solver may look this far beyond the stops, a share of the last piece's width. The polynomials of
 * the transmission still hold there. */
static const double SOLVER_OVERSHOOT = 0.05;

/* Play operator: the first sample of a piece is this share of its width away; each is up to twice as far from the last
 * as that from its own, up to 1/PLAY_SAMPLES of the width. Between two samples the edge crosses the torque at most
 * once. */
static const double PLAY_FIRST_SAMPLE = 1e-6;
enum { PLAY_SAMPLES = 32 };

/* Play operator: two rules that agree to the tolerance are more exact than their difference. The rounding is that of
 * the energies. */
static const double PLAY_SHARE_OF_TOLERANCE = 0.1, PLAY_ROUNDING = 64.0 * DBL_EPSILON;

/* Self-locking contacts can wedge and let go again at once (P. Painleve, 1895). */
enum { MAX_WEDGES_PER_STEP = 1000 };

/* ---- inverse ---- */

/* An imposed angle may lie beyond a stop by this share of the range between the stops: masters add up their angles.
 * From 7e-7 on test_refuses_to_go_beyond_the_stops of test_inverse.py fails; ten times the value passes. */
static const double IMPOSED_STOP_ROUNDING = 1e-9;

/* Rounding of the elastic shaft's torque and of the band's edge, as shares of the sum of the magnitudes that their
 * difference adds up. The tests pass with ten times these values. */
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

/* Share of the torques at the edge of the stick band that remains where the edge holds the torque, and of the terms of
 * omega below which slip begins at rest. Slip begins with a jump of the speed only where a contact locks. */
static const double SENSITIVITY_ROUNDING = 1e-9;

/* Distance between the angles of a central difference of order 4, as a share of the width of the transmission's piece.
 * The functions are smooth inside a piece, so that the difference has ten digits. */
static const double SENSITIVITY_DIFFERENCE = 1e-3;
/* ---- fmi ---- */

/* Relative tolerance of integration: where the master gives none, and the range that others are brought into. Below the
 * range rounding is larger; above the range the results mean nothing. */
static const double TOLERANCE_DEFAULT = 1e-9, TOLERANCE_MIN = 1e-12, TOLERANCE_MAX = 1e-2;

/* A master adds up its time on its own: the time of a step may differ from the FMU's by this share. */
static const double TIME_ROUNDING = 1e-12;

#endif
