/* What an output can be differentiated by. */
#ifndef DUALCAM_KNOBS_H
#define DUALCAM_KNOBS_H

typedef enum {
    KNOB_THETA, /* state of the forward FMU, input of the inverse; so omega */
    KNOB_OMEGA,
    KNOB_ALPHA,
    KNOB_TAU,
    KNOB_F_EXT,
    KNOB_FRICTION_1, /* tunable parameters from here on */
    KNOB_FRICTION_2,
    KNOB_PRELOAD,
    KNOB_STIFFNESS,
    KNOB_STIFFNESS2,
    KNOB_STIFFNESS3,
    KNOB_C_LOAD,
    KNOB_Q_LOAD,
    KNOB_C_RELEASE,
    KNOB_Q_RELEASE,
    KNOB_COUNT
} Knob;

typedef struct {
    double by[KNOB_COUNT]; /* unit of the output per unit of the knob */
} Partials;

#endif
