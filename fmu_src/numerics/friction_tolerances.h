/* Tolerances and limits of friction that depends on the speed or the load; a part of tolerances.h. */
#ifndef DUALCAM_FRICTION_TOLERANCES_H
#define DUALCAM_FRICTION_TOLERANCES_H

#include <float.h>

/* ---- speed ---- */

/* The search for a speed that friction limits. Where friction falls: the change of v/v_s in one step, for longer steps
 * pass over the fall unseen; by tolerance the exponent at its end; v/v_s of an excess below all rounding. */
enum { VISCOUS_ITERATIONS = 200 };
static const double VISCOUS_ROUNDING = 4.0 * DBL_EPSILON, VISCOUS_BLOCKED = 1e-12 /* before a lock */,
                    STRIBECK_SPAN_GAUSS = 1.0, STRIBECK_SPAN_TUSTIN = 2.0, STRIBECK_GONE_GAUSS = 6.1,
                    STRIBECK_GONE_TUSTIN = 37.0;
static const double STRIBECK_FALLEN = 18.0, STRIBECK_FALLEN_TIGHT = 30.0, STRIBECK_TIGHT = 1e-7;

/* A coefficient that only a torque at the limit of all friction reaches. */
static const double FRICTION_BOUNDLESS = 1e10;

/* Where friction falls: the most parts of a step; the halvings of a part; the least steepness of Gauss's law; in roots
 * of the tolerance the share of friction that an excess must have to need parts; v/v_s above which a first guess leaves
 * the excess out. */
enum { LOBATTO_FALL_PARTS = 8, LOBATTO_HALVINGS = 2 };
static const double LOBATTO_FALL_LEAST = 8.0, LOBATTO_FALL_FAINT = 3.0, LOBATTO_FALL_OVER = 12.0;

/* ---- load ---- */

/* Share of R_ref below which friction levels off, so that a contact may change its flank. */
static const double LEVEL_LOG_FROM = 0.01;

/* N: no load. */
static const double LOADED_LEAST_FORCE = 1e-12;

/* Share of a_i in n_i that passes on no torque. */
static const double LOADED_NO_TORQUE = 1e-6;

/* Share of the terms of Delta below which the reactions from A and W have lost more than half of their digits. */
static const double LOADED_FAINT_DELTA = 1e-8;

/* Newton's method for both reactions ends at a relative change of LOADED_LAST_CHANGE, or where the changes stop falling
 * below LOADED_STALLED. Each change must fall by the share LOADED_SHARE_GAINED of the change made before, else less of the
 * next one is made, at least LOADED_LEAST_SHARE of it. */
enum { LOADED_ITERATIONS = 80 };
static const double LOADED_LAST_CHANGE = 1e-13, LOADED_STALLED = 1e-9, LOADED_ZERO = 1e-13, LOADED_SHARE_GAINED = 0.25,
                    LOADED_LEAST_SHARE = 0.02;

/* The search samples a reaction from 1/LOADED_SEARCH_RANGE of the load without friction up, each sample
 * LOADED_SEARCH_FACTOR times the one before: to LOADED_SEARCH_RANGE times this load, or to 1e12 times beside a level
 * groove. */
enum { LOADED_SEARCH_SAMPLES = 59, LOADED_FAR_SAMPLES = 89 };
static const double LOADED_SEARCH_RANGE = 1e6, LOADED_SEARCH_FACTOR = 1.6;

/* Samples of the band's edge in a step, and at rest while F_ext varies. At rest the edge is followed to another reason of
 * wedging up to LOADED_REST_CHANGE of the time. */
enum { LOADED_EDGE_SAMPLES = 16, LOADED_REST_SAMPLES = 32, LOADED_GOLDEN_STEPS = 20 };
static const double LOADED_REST_CHANGE = 1e-6;

/* Shares: of the step by which a step ends past or before the place where Newton's method loses the reactions; of the terms
 * of a reaction, above which the reaction is not zero there. */
static const double LOCATION_LOSS = 64.0 * DBL_EPSILON, LOCATION_LOST_SHARE = 1e-6;

/* Where a reaction changes its sign: this many times the reaction at the start of the step tells a pole from a zero. */
static const double LOCATION_POLE = 1e3;

/* Where Newton's method loses the reactions: a search goes on with them if they change by no more than this share in this share
 * of the motion's time scale. */
static const double LOST_CHANGE = 0.01, LOST_AHEAD = 1e-9;

/* Before a change of flanks the other reaction is looked at, each time this factor closer to the event. */
static const double LOCATION_CLOSER = 0.1;
enum { LOCATION_LOOKS_BACK = 8 };

/* Share of the loads up to which a change of an input from step to step is none. */
static const double INPUT_JUMP = 0.1;

/* Factor on the error estimate of a Radau step. */
static const double RADAU_LOADED_STRICT = 10.0;

/* Iterations for the loads at the start: with a power of the load; with tables alone, whose curve is then followed. */
enum { LOBATTO_LOAD_GUESSES = 2, LOBATTO_TABLE_GUESSES = 1 };

/* Share of the terms of alpha. The location of the edge at which a motion begins misses less; an answer whose alpha points
 * backwards by more is no start. */
static const double CANDIDATE_BACKWARD = 1e-6;

#endif
