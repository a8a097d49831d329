/* The knowns of differentiation: the variables by which an output can be differentiated. */
#ifndef DUALCAM_KNOWN_H
#define DUALCAM_KNOWN_H

typedef enum {
    KNOWN_THETA, /* a state of the forward FMU, an input of the inverse FMU; likewise omega */
    KNOWN_OMEGA,
    KNOWN_ALPHA,
    KNOWN_TAU,
    KNOWN_F_EXT,
    KNOWN_FRICTION_1, /* tunable parameters from here on */
    KNOWN_FRICTION_2,
    KNOWN_PEAK_1, /* of the friction law; [cam 1, cam 2] as KNOWN_FRICTION_* */
    KNOWN_PEAK_2,
    KNOWN_STRIBECK_VELOCITY_1,
    KNOWN_STRIBECK_VELOCITY_2,
    KNOWN_VISCOUS_1,
    KNOWN_VISCOUS_2,
    KNOWN_LOAD_EXPONENT_1,
    KNOWN_LOAD_EXPONENT_2,
    KNOWN_LOAD_1, /* N_ref */
    KNOWN_LOAD_2,
    KNOWN_PRELOAD,
    KNOWN_STIFFNESS,
    KNOWN_STIFFNESS2,
    KNOWN_STIFFNESS3,
    KNOWN_C_LOAD,
    KNOWN_Q_LOAD,
    KNOWN_C_RELEASE,
    KNOWN_Q_RELEASE,
    KNOWN_COUNT
} Known;

typedef struct {
    double by[KNOWN_COUNT]; /* unit of the output per unit of the known */
} Partials;

#endif
