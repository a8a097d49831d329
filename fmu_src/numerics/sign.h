/* The sign of a number. */
#ifndef DUALCAM_SIGN_H
#define DUALCAM_SIGN_H

/* +1, 0 or -1; 0 of NAN */
static inline int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

#endif
