/* A function of one variable, as root finding and maximization take it. */
#ifndef DUALCAM_FUNCTION_H
#define DUALCAM_FUNCTION_H

/* f(x); `context` holds all other arguments. */
typedef double ScalarFunction(const void *context, double x);

#endif
