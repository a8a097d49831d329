/* The geometry room holds the shape of the mechanism: the groove laws g_i(psi) and tables of samples (groove.h), the
 * pin in both grooves (pin_position.h), the transmission, which is the pair of grooves as functions of theta
 * (transmission.h), and the kinematics at one theta (cam.h). It may include platform, numerics and model.
 *
 * This header includes the whole room; other rooms include the single headers that they need. */
#ifndef DUALCAM_GEOMETRY_H
#define DUALCAM_GEOMETRY_H

#include "geometry/cam.h"
#include "geometry/groove.h"
#include "geometry/pin_position.h"
#include "geometry/transmission.h"

#endif
