/* The largest |omega| and |R_i| in a segment of slip in closed form. */
#ifndef DUALCAM_LINEAR_PEAKS_H
#define DUALCAM_LINEAR_PEAKS_H

#include "closed_form/linear_segment.h"

/* Raises the peaks of |omega| and |R_i| to the largest values on [0, ends->motion.t]. */
void linear_segment_peaks(const LinearSegment *segment, const SegmentEnds *ends, Peaks *peak);

#endif
