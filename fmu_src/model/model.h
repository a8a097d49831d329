/* The model room describes the mechanism for all other rooms: parameters, inputs, the laws of spring and damper, modes,
 * regimes, events, the energy ledger, faults, knowns of differentiation and every tolerance. It may include platform
 * and numerics. All quantities are in SI units.
 *
 * This header includes the whole room; other rooms include the single headers that they need. */
#ifndef DUALCAM_MODEL_ROOM_H
#define DUALCAM_MODEL_ROOM_H

#include "model/elements.h"
#include "model/event_kind.h"
#include "model/fault.h"
#include "model/inputs.h"
#include "model/known.h"
#include "model/ledger.h"
#include "model/mode.h"
#include "model/params.h"
#include "model/regime.h"
#include "model/tolerances.h"
#include "model/watcher.h"

#endif
