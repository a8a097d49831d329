/* The order of the equation of motion, by which resistances are zero (docs/mechanism.md, section 6). */
#ifndef DUALCAM_REGIME_H
#define DUALCAM_REGIME_H

typedef enum {
    REGIME_INERTIAL,        /* inertia: the balance gives alpha */
    REGIME_VISCOUS,         /* no inertia, but damping: the balance gives omega */
    REGIME_RATE_INDEPENDENT /* neither: theta follows the edge of the stick band */
} Regime;

#endif
