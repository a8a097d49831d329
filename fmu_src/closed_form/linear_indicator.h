/* An indicator function of the closed form: a quantity whose zero crossing ends a segment of slip.
 *
 * The indicator is sign times the quantity. The event is the indicator's downward crossing of zero. The second
 * derivative of every quantity obeys the homogeneous equation of oscillator.h, because the quantity is a combination
 * of 1, t, theta, omega and alpha with constant coefficients. */
#ifndef DUALCAM_LINEAR_INDICATOR_H
#define DUALCAM_LINEAR_INDICATOR_H

#include "closed_form/linear_segment.h"

typedef enum {
    QUANTITY_CONTACT_1, /* N/m, x_1 = R_1/hypot(r_1, a_1) */
    QUANTITY_CONTACT_2, /* N/m, x_2 */
    QUANTITY_SPEED,     /* rad/s, omega */
    QUANTITY_EDGE_1,    /* N.m, torque beyond an edge of the stick band: tau - edge[0] F_0 */
    QUANTITY_EDGE_2,    /* tau - edge[1] F_0 */
    QUANTITY_TO_STOP    /* rad, angle left to the end stop; the sign applies to dtheta */
} LinearQuantity;

static inline LinearQuantity linear_quantity_of_contact(int i) {
    return i == 0 ? QUANTITY_CONTACT_1 : QUANTITY_CONTACT_2;
}

static inline LinearQuantity linear_quantity_of_edge(int i) {
    return i == 0 ? QUANTITY_EDGE_1 : QUANTITY_EDGE_2;
}

typedef struct {
    const LinearSegment *segment;
    LinearQuantity quantity;
    double sign;
    Kernel *kernel; /* of the latest sample */
} LinearIndicator;

/* The indicator and its first three time derivatives at time t after the start of the segment. */
typedef struct {
    double t, value, rate, second, third;
    double rounding; /* a smaller |value| is rounding */
} IndicatorSample;

IndicatorSample linear_indicator_at_start(const LinearIndicator *indicator);

/* At t > 0; leaves the kernel of t in *indicator->kernel. */
IndicatorSample linear_indicator_at(const LinearIndicator *indicator, double t);

#endif
