/* What the controllers follow, and when they take a sample. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include <stdbool.h>

typedef struct {
    double angle, speed;
} Point;

typedef struct {
    double start, end;  /* rad */
    double move, dwell; /* s, duration of one move and of one rest */
} PickAndPlace;

/* The cycle of PickAndPlace in blocks.py: rest at `start`, go to `end` with minimum jerk, rest there, go back. */
Point pick_and_place(PickAndPlace cycle, double time);

enum { HARMONICS = 7, COEFFICIENTS = 1 + 2 * HARMONICS };

/* The derivative of this order of a Fourier series: mean, then cosine and sine of each harmonic. */
double fourier(const double coefficients[COEFFICIENTS], double period, double time, int order);

/* A controller samples at 0, tick, 2 tick, ...: whether the next of these, number *count, is where this step begins
 * (give or take half a step, since times carry rounding). If so it is counted. */
bool sample_is_due(double *count, double tick, double time, double step);

/* Why a controller refuses steps longer than its tick. */
extern const char TOO_LONG[];

#endif
