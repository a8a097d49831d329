/* Work, heat and peaks along a way on which everything is known at every place.
 *
 * What is integrated is smooth but where another formula takes over (contacts change flanks): such places are
 * found and the way is divided there. Between them: Gauss-Kronrod with 7 and 15 points, halved until the two
 * agree to the tolerance (R. Piessens et al., QUADPACK, 1983). */
#ifndef DUALCAM_QUADRATURE_H
#define DUALCAM_QUADRATURE_H

#include <stdbool.h>

enum { RATE_WORK_IN, RATE_WORK_EXT, RATE_HEAT_CAM1, RATE_HEAT_CAM2, RATE_HEAT_DAMPER, RATE_HEAT_SHAFT, RATE_COUNT };
enum { SIZE_TORQUE, SIZE_OMEGA, SIZE_REACTION1, SIZE_REACTION2, SIZE_COUNT };

/* At one place. */
typedef struct {
    double rate[RATE_COUNT]; /* J per unit of the way's coordinate */
    double size[SIZE_COUNT]; /* N.m, rad/s, N, N: magnitudes whose peaks count */
    int branch;              /* which formula holds here, or -1: none does */
} QuadratureSample;

typedef void Integrand(const void *scene, double x, QuadratureSample *out);

typedef struct {
    Integrand *integrand;
    const void *scene;
    double tolerance;         /* relative to the sum of the magnitudes of all rates */
    double total[RATE_COUNT]; /* J, added up */
    double peak[SIZE_COUNT];  /* raised */
    double bad;               /* a place where no formula holds, if that was found */
    int panels;               /* used so far: the work is bounded, whatever is looked at */
} Quadrature;

/* Adds the way between two places, in either direction. False if no formula holds at a place of it. */
bool quadrature_over(Quadrature *quadrature, double from, double to);

#endif
