/* The largest |omega| and |R_i| in a Radau step. */
#ifndef DUALCAM_RADAU_PEAKS_H
#define DUALCAM_RADAU_PEAKS_H

#include "collocation/radau_step.h"

typedef struct {
    double omega;       /* rad/s */
    double reaction[2]; /* N, total of all contacts at cam i */
} RadauPeaks;

/* Values below `known` are not searched for: the result may then be the larger value of both ends. */
RadauPeaks radau_step_peaks(const SlipMode *slip, const RadauStep *step, const RadauPeaks *known);

#endif
