/* A segment of slip in closed form: where it starts, what limits it, and the quiet test.
 *
 * The quiet test answers whether no event can lie in the segment. It compares the values at the two ends only, so
 * that a step without an event needs no search. The test is sufficient, not necessary: where it fails,
 * linear_search.h searches.
 *
 * Why the values at the ends suffice: over less than half a period of the oscillator a solution of the homogeneous
 * equation (oscillator.h) has at most one zero. omega and x_i are combinations of 1, t, theta, omega and alpha, so
 * their second derivatives, and under constant inputs their first derivatives, are such solutions. A derivative with
 * the same sign at both ends then has no zero in between, and the quantity is monotone. */
#ifndef DUALCAM_LINEAR_SEGMENT_H
#define DUALCAM_LINEAR_SEGMENT_H

#include "closed_form/linear_slip.h"
#include "model/work.h"

typedef struct {
    const LinearSlipMode *linear;
    const Params *params;
    const Geometry *geometry;
    SlipStart start;
    Work *work;     /* counts evaluations, or NULL */
    double to_stop; /* rad, >= 0: angle to the end stop ahead */
    bool flanks;    /* friction acts, so the sign of the reactions matters */
    /* m, the upper and the lower edge of the stick band per F_0 > 0. For either sign of F_0 the band ends at the larger
     * one of edge[i] F_0 when loading, at the smaller one when releasing. Without inertia the pin rests as soon as the
     * torque is back inside the band. The speed is zero there too, except where the damper has put the pin on other
     * flanks than the spring. */
    double edge[2];
} LinearSegment;

/* The motion at the end of a segment of length motion.t, and the contact loads at both ends. */
typedef struct {
    LinearMotion motion;
    ContactLoadPair start, end; /* set only if friction acts or a ledger is kept */
    bool monotone;              /* omega and both x_i are monotone: each is largest and smallest at an end */
} SegmentEnds;

/* Fills `ends` for the segment of the length of `kernel`. */
void linear_segment_ends(const LinearSegment *segment, const Kernel *kernel, SegmentEnds *ends);

/* True if no event lies in (0, ends->motion.t]. False decides nothing. */
bool linear_segment_is_quiet(const LinearSegment *segment, const SegmentEnds *ends);

/* The parts of the quiet test: true if omega has no zero in the segment; true if x_i keeps its sign. */
bool linear_segment_keeps_speed(const LinearSegment *segment, const SegmentEnds *ends);
bool linear_segment_keeps_flank(const LinearSegment *segment, const SegmentEnds *ends, int i);

/* True if the pin can come to rest on edge i where its speed is not zero: see LinearSegment.edge. */
bool linear_segment_has_band_edge(const LinearSegment *segment, int i);

/* True if omega, or x_i, is monotone in the segment. */
bool linear_segment_speed_is_monotone(const LinearSegment *segment, const SegmentEnds *ends);
bool linear_segment_contact_is_monotone(const LinearSegment *segment, const SegmentEnds *ends, int i);

/* Inertial slip at constant speed: true if alpha at both ends is no more than the rounding of the torques whose sum is
 * M alpha. */
bool linear_segment_is_steady(const LinearSegment *segment, const SegmentEnds *ends);

static inline bool has_constant_inputs(const SlipStart *start) {
    return start->tau_rate == 0.0 && start->F_ext_rate == 0.0;
}

#endif
