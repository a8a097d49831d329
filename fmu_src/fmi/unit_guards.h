/* Parameters whose values are allowed, but look as if they were in another unit, such as a radius of 18 m. */
#ifndef DUALCAM_UNIT_GUARDS_H
#define DUALCAM_UNIT_GUARDS_H

#include "fmi/instance.h"

/* Logs one warning for each. */
void unit_guards_warn(const Instance *instance);

#endif
