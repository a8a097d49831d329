/* Quadrature of several integrands over an interval of one coordinate, with the peaks of several magnitudes.
 *
 * The integrands are smooth except where another formula takes over, as when contacts change flanks. Such points are
 * located, and the interval is divided there. Between these points the Gauss-Kronrod rules with 7 and 15 points are
 * applied, and the interval is halved until both rules agree to the tolerance (R. Piessens et al., QUADPACK, 1983). */
#ifndef DUALCAM_QUADRATURE_H
#define DUALCAM_QUADRATURE_H

#include <stdbool.h>

enum { RATE_WORK_IN, RATE_WORK_EXT, RATE_HEAT_CAM1, RATE_HEAT_CAM2, RATE_HEAT_DAMPER, RATE_HEAT_SHAFT, RATE_ENERGIES };
enum { RATE_SLIDING1 = RATE_ENERGIES, RATE_SLIDING2, RATE_COUNT }; /* reaction times sliding distance, or 0 */
enum { SIZE_TORQUE, SIZE_OMEGA, SIZE_REACTION1, SIZE_REACTION2, SIZE_COUNT };

/* Integrands and magnitudes at one point. */
typedef struct {
    double rate[RATE_COUNT]; /* J, or N.m, per unit of the coordinate; the energies decide where to divide */
    double size[SIZE_COUNT]; /* N.m, rad/s, N, N: magnitudes whose peaks are wanted */
    int branch;              /* the number of the formula that holds here, or -1: none */
} QuadratureSample;

typedef void Integrand(const void *scene, double x, QuadratureSample *out);

typedef struct {
    Integrand *integrand;
    const void *scene;
    double tolerance;         /* relative to the magnitudes of all energies; sliding shares their panels */
    double rounding;          /* J: an error that counts as none */
    double total[RATE_COUNT]; /* J, the integrals are added */
    double peak[SIZE_COUNT];  /* raised to the peaks found */
    double bad;               /* a point where no formula holds, if quadrature_over() has returned false */
    int panels;               /* used so far, at most QUADRATURE_MAX_PANELS */
} Quadrature;

/* Adds the integrals over [from, to], in either direction. False if no formula holds at a point between. */
bool quadrature_over(Quadrature *quadrature, double from, double to);

#endif
