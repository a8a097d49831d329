/* The mode of the mechanism. */
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

#endif
