/* What a pair of grooves must fulfil between the stops: reach from stop to stop, and never be level both at once. */
#ifndef DUALCAM_GROOVE_PAIR_H
#define DUALCAM_GROOVE_PAIR_H

#include <stdbool.h>

#include "geometry/groove.h"
#include "model/fault.h"
#include "model/params.h"

/* Do the grooves reach both stops? If not, returns false with the groove that ends first in `fault`. */
bool groove_pair_check_ends(const Groove groove[2], const Params *params, Fault *fault);

/* Writes into `fault` that both grooves are level at theta and z; returns false. */
bool groove_pair_refuse_level(const Groove groove[2], double theta, double z, Fault *fault);

#endif
