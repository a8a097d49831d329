/* The mode of the mechanism, the regime of its motion, and the events that end a segment of slip. */
#ifndef DUALCAM_MODE_H
#define DUALCAM_MODE_H

/* Values of the variable `mode`. */
typedef enum {
    MODE_STICK = 1,      /* at rest inside the stick band */
    MODE_LOADING = 2,    /* omega > 0, or about to become so: the follower rises and compresses the spring */
    MODE_RELEASING = 3,  /* omega < 0, or about to become so */
    MODE_LOWER_STOP = 4, /* at rest, pressed into the lower end stop */
    MODE_UPPER_STOP = 5, /* at rest, pressed into the upper end stop */
    MODE_WEDGED = 6      /* at rest, pushed in a direction in which no torque moves it: see contact/contact.h */
} Mode;

/* The order of the equation of motion, by which resistances are zero (docs/mechanism.md, section 6). */
typedef enum {
    REGIME_INERTIAL,        /* inertia: the balance gives alpha */
    REGIME_VISCOUS,         /* no inertia, but damping: the balance gives omega */
    REGIME_RATE_INDEPENDENT /* neither: theta follows the edge of the stick band */
} Regime;

typedef enum {
    EVENT_NONE,
    EVENT_REST, /* the speed becomes zero */
    EVENT_STOP, /* theta reaches an end stop */
    EVENT_FLANK /* the reaction of a contact changes its sign */
} EventKind;

#endif
