/* A zero of a function between two places where its signs differ. */
#ifndef DUALCAM_ROOT_H
#define DUALCAM_ROOT_H

#include "numerics/function.h"

/* To rounding: no double lies between the place returned and a change of sign. The values at a and b differ in
 * sign or one is zero; they may be infinite. */
double root_between(ScalarFunction *f, const void *context, double a, double f_a, double b, double f_b);

#endif
