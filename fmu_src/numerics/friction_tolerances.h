/* Tolerances and limits of friction that depends on the speed or the load; a part of tolerances.h. */
#ifndef DUALCAM_FRICTION_TOLERANCES_H
#define DUALCAM_FRICTION_TOLERANCES_H

#include <float.h>

/* ---- speed ---- */

/* Where friction falls: the change of v/v_s in one step, for longer steps pass over the fall unseen; v/v_s of an excess
 * below all rounding; by tolerance the exponent at the end of the fall. */
static const double STRIBECK_SPAN_GAUSS = 1.0, STRIBECK_SPAN_TUSTIN = 2.0, STRIBECK_GONE_GAUSS = 6.1,
                    STRIBECK_GONE_TUSTIN = 37.0;
static const double STRIBECK_FALLEN = 18.0, STRIBECK_FALLEN_TIGHT = 30.0, STRIBECK_TIGHT = 1e-7;

/* Where friction falls: the most parts of a step; the halvings of a part; the least steepness of Gauss's law; in roots
 * of the tolerance the share of friction that an excess must have to need parts; v/v_s above which a first guess leaves
 * the excess out. */
enum { LOBATTO_FALL_PARTS = 8, LOBATTO_HALVINGS = 2 };
static const double LOBATTO_FALL_LEAST = 8.0, LOBATTO_FALL_FAINT = 3.0, LOBATTO_FALL_OVER = 12.0;

/* ---- load ---- */

/* Share of N_ref below which friction hardly depends on the load. */
static const double NOMINAL_LOAD_LOW = 0.1;

/* Change of the load in one step, over the least load in it plus NOMINAL_LOAD_LOW N_ref: the law's poles then lie so
 * far off that each stage gains half a digit. */
static const double NOMINAL_LOAD_SPAN = 1.0;

/* Change of N^2 + N_0^2 in a step, as a share of it, up to which six terms of a series have all digits. */
static const double LOAD_POWER_NEAR = 0.01;

/* At rest while F_ext varies: samples of the band's edge, and steps of the search between two. */
enum { LOADED_REST_SAMPLES = 32, LOADED_GOLDEN_STEPS = 20 };

#endif
