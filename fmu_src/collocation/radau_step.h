/* One step of the motion in one slip mode: Radau IIA collocation with 3, 5 or 7 stages, and its error.
 *
 * The motion over the step is a polynomial in time, on which events are located. The integrals of work and heat are
 * taken at its nodes, with order 2s - 1 as well.
 *
 * Error estimate: the polynomial through the nodes misses the derivative at the start by a defect d_0. Between the
 * nodes the defect is about d_0 prod(1 - c/c_i); its integrals over the step are the errors of speed and angle
 * (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8).
 *
 * A one-step method: the result depends on the start of the step only, not on earlier steps. */
#ifndef DUALCAM_RADAU_STEP_H
#define DUALCAM_RADAU_STEP_H

#include "contact/balance.h"
#include "numerics/radau.h"

typedef struct {
    const Radau *method;
    double h; /* s */
    Balance start;
    Balance node[RADAU_MAX];       /* the last one is the end of the step */
    double node_dtheta[RADAU_MAX]; /* rad, theta at the node less theta at the start, not rounded to theta's digits */
    double dtheta, domega;         /* rad, rad/s: increments over the step; domega only with inertia */
    Booking booking;               /* J, work and heat over the step */
    double error;                  /* estimate over the error that the tolerance allows: the step is good up to 1 */
    double energy_error;           /* residual of the energy balance, likewise: see step_energy.h */
    double energy_gained;          /* J, this residual, see step_energy.h */
    double angle_noise;            /* rad, rate-independent only: how far the rounding of the torques moves theta */
    bool at_sample;                /* shortened to end at a sample of a friction table (step_control.h) */
} RadauStep;

/* What the next step tries first: a length, s, which may be infinite, and the least number of stages. */
typedef struct {
    double h;
    int stages;
} StepProposal;

/* The step of length h from `start`, the balance at the time of slip->inputs. False if Newton's method does not
 * converge, or if a node leaves the range in which the slip mode is possible: then a shorter step may succeed. */
bool radau_step_solve(const SlipMode *slip, const Balance *start, double h, int stages, RadauStep *step);

static inline const Balance *radau_step_end(const RadauStep *step) {
    return &step->node[step->method->stages - 1];
}

/* Raises the peaks to the largest |omega| and |R_i| in the step and the larger |tau| of both ends. */
void radau_step_raise_peaks(const SlipMode *slip, const RadauStep *step, Peaks *peak);

/* A small change of angle and speed for each known from `first` to `end` - 1, per unit of the known. Without inertia
 * the angle alone is a state. */
typedef struct {
    int first, end;
    double theta[KNOWN_COUNT], omega[KNOWN_COUNT]; /* rad, rad/s */
} Variation;

/* Replaces the variation at the start of the step by the variation at its end. Inputs change by a constant over the
 * whole step. Not for the rate-independent regime. False if the equations have no solution, or if quadratic damping alone
 * rules the speed. */
bool radau_step_vary(const SlipMode *slip, const RadauStep *step, Variation *v);

#endif
