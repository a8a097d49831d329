/* Where the pin is when cam 2 has turned by theta: the root gamma of g1(gamma) = g2(theta - gamma), from the groove
 * laws (docs/mechanism.md, section 2). */
#ifndef DUALCAM_PIN_POSITION_H
#define DUALCAM_PIN_POSITION_H

#include <stdbool.h>

#include "geometry/groove.h"

typedef struct {
    double gamma;       /* rad */
    double z;           /* m */
    double slope[2];    /* m/rad, a_i */
    double rounding[2]; /* m/rad, error of a_i that the rounding of gamma and z causes */
} PinPosition;

/* The interval of gamma in which both laws hold, rad; empty if lower > upper. */
typedef struct {
    double lower, upper;
} GammaRange;

GammaRange pin_gamma_range(const Groove groove[2], double theta);

/* Do the grooves meet at theta? */
bool pin_is_reachable(const Groove groove[2], double theta);

/* gamma to rounding, from the nearby `guess`. Both grooves must be bounded. */
double pin_gamma(const Groove groove[2], double theta, double guess);

/* The height z, taken from the flatter groove: there an error of the angle moves z least. */
double pin_height(GroovePoint first, GroovePoint second);

PinPosition pin_position(const Groove groove[2], double theta, double guess);

/* Are both grooves level there, so that nothing fixes the pin? */
bool pin_is_undetermined(const Groove groove[2], const PinPosition *position);

#endif
