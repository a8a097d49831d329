/* Tolerances and limits of friction that depends on the load; a part of tolerances.h. */
#ifndef DUALCAM_LOAD_TOLERANCES_H
#define DUALCAM_LOAD_TOLERANCES_H

/* Share of R_ref below which friction levels off, so that a contact may change its flank. */
static const double LEVEL_LOG_FROM = 0.01;

/* N: no load. */
static const double LOADED_LEAST_FORCE = 1e-12;

/* Share of a_i in n_i that passes on no torque. */
static const double LOADED_NO_TORQUE = 1e-6;

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

/* Factor on the error estimate of a Radau step. */
static const double RADAU_LOADED_STRICT = 10.0;

#endif
