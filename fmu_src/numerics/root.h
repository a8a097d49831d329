/* The zero of a function between two points where its signs differ. */
#ifndef DUALCAM_ROOT_H
#define DUALCAM_ROOT_H

#include "numerics/numerics.h"

/* The zero to rounding: no double lies between the x returned and a change of sign. The values f_a and f_b at a and b
 * differ in sign, or one of them is zero; they may be infinite. */
double root_between(ScalarFunction *f, const void *context, double a, double f_a, double b, double f_b);

#endif
