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

/* PickAndPlace of dualcam/systems/blocks/motions.py: rest at `start`, move to `end` with minimum jerk, rest, move back. */
Point pick_and_place(PickAndPlace cycle, double time);

enum { HARMONICS = 7, COEFFICIENTS = 1 + 2 * HARMONICS };

/* The derivative of this order of a Fourier series: mean, then cosine and sine of each harmonic. */
double fourier(const double coefficients[COEFFICIENTS], double period, double time, int order);

/* What a controller is about to compute: its command for the tick that begins at `time`, `lead` from now. */
typedef struct {
    double time, lead; /* s */
} Sample;

/* Whether the step that begins at `time` computes the command of a new tick; *newest is the number of the last one.
 *
 * A command acts on the cam two steps later: one through the motor's part, one from there. So it is computed two steps
 * before its tick begins (give or take half a step, since times carry rounding), for the state that the joint will
 * have then. That of tick 0 belongs to the initialization. */
bool tick_is_due(double *newest, double tick, double time, double step, Sample *sample);

/* Where the joint will be after `lead`, if it accelerates as is planned for the tick between two points. */
Point carried_on(Point joint, double lead, Point now, Point then, double tick);

/* Why a controller refuses steps longer than its tick. */
extern const char TOO_LONG[];

#endif
