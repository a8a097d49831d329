/* Every tolerance and every limit of the core, each with its reason, by the room that uses it.
 *
 * A tolerance is a share of the size named beside it. Where a test fails once the tolerance is ten times larger, the
 * test is named. Limits bound the work of one call. */
#ifndef DUALCAM_TOLERANCES_H
#define DUALCAM_TOLERANCES_H

#include <float.h>

/* ---- numerics ---- */

/* ---- geometry ---- */

/* ---- contact ---- */

/* ---- closed_form ---- */

/* ---- collocation ---- */

/* ---- forward ---- */

/* ---- inverse ---- */

/* ---- sensitivity ---- */

/* ---- fmi ---- */

#endif
