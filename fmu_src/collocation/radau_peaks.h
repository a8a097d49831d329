/* The peaks of a Radau step. */
#ifndef DUALCAM_RADAU_PEAKS_H
#define DUALCAM_RADAU_PEAKS_H

#include "collocation/radau_step.h"

/* Raises the peaks to the largest |omega| and |R_i| in the step and the larger |tau| of both ends. */
void radau_step_raise_peaks(const SlipMode *slip, const RadauStep *step, Peaks *peak);

#endif
