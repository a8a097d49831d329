/* The largest |omega| and |R_i| inside a Lobatto step, where friction varies. */
#ifndef DUALCAM_LOBATTO_PEAKS_H
#define DUALCAM_LOBATTO_PEAKS_H

#include "collocation/lobatto_system.h"

/* Raises the peaks, which are the larger values of both ends of the step, to those inside. `reaction`: at the nodes, N
 * in total. False if the nodes do not show a peak exactly enough. */
bool lobatto_peaks_inside(const LobattoSystem *system, const LobattoValues reaction[2], Peaks *peaks);

#endif
