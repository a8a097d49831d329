/* A stretch of slip through grooves of any shape, to its end: the step's end, or the first event in it. */
#ifndef DUALCAM_PASSAGE_H
#define DUALCAM_PASSAGE_H

#include "event.h"
#include "leap.h"

typedef struct {
    Leap leap;
    EventKind kind;     /* what ended it */
    bool at_border;     /* it ended at the end of a piece */
    bool for_border;    /* its length was that to the end of a piece, as far as could be told */
    Stride next;        /* to try for the next one */
    double reaction[2]; /* N, largest |R_i| on the way, total */
    double omega;       /* rad/s, largest |omega| on the way */
} Passage;

/* The end of the piece ahead, rad from the start on, and how far a step may go beyond. */
typedef struct {
    double distance, beyond;
} Border;

Border passage_border(const Way *way, double theta);

/* Time, s, in which constant acceleration takes it over `distance`, rad; speed and alpha in the direction of the way.
 * Infinite if it never gets there. */
double passage_ballistic_time(double speed, double alpha, double distance);

/* The longest passage of at most `left` seconds from `start`. `room` is the way to the end stop ahead, rad; `first` what
 * to try first. Returns false where the contacts jam it on the spot. */
bool passage_find(const Way *way, const Balance *start, double room, double left, const Stride *first, Passage *passage);

/* Fills in the largest speed and reactions; below `known` they are not looked for closely. */
void passage_peaks(const Way *way, Passage *passage, double known_omega, const double known_reaction[2]);

#endif
