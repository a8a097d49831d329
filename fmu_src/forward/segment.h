/* A segment: a part of a step in one mode. A method proposes a segment, segment_apply() applies the segment, and
 * handle_event() handles the event that ends it (impact.h). */
#ifndef DUALCAM_SEGMENT_H
#define DUALCAM_SEGMENT_H

#include <math.h>

#include "collocation/event_location.h"
#include "forward/configuration.h"
#include "forward/state.h"
#include "numerics/tolerances.h"

typedef enum {
    SEGMENT_REST,        /* at rest */
    SEGMENT_CLOSED_FORM, /* slip, known in closed form */
    SEGMENT_LOBATTO,     /* slip, one Lobatto step */
    SEGMENT_RADAU,       /* slip, one Radau step */
    SEGMENT_JUMP,     /* without inertia and damping: along the band's edge, until it holds the torque, or to a stop */
    SEGMENT_WEDGE,    /* no time passes: the contacts wedge and take the speed */
    SEGMENT_AT_EVENT, /* no time passes: at a stop into which the mechanism moves */
} SegmentKind;

typedef struct {
    SegmentKind kind;
    EventKind end;           /* the event that ends the segment */
    double duration;         /* s */
    double dtheta;           /* rad, increment */
    double energy_gained;    /* J, by the error of integration, see step_energy.h */
    double omega;            /* rad/s, at the end, before its event is handled; or the increment */
    bool omega_is_increment; /* inertial slip, whose speed is a sum of increments */
    bool books;              /* booking is set */
    bool varies;             /* the inputs vary and time passes */
    bool finds_speed;        /* the speed follows from the mode that is decided at the end, see jump.c */
    bool ends_at_breakpoint; /* the length of the segment was chosen as the time to a breakpoint of the transmission */
    bool crossed[2];         /* of EVENT_FLANK: the reactions that pass zero at the end */
    Booking booking;         /* J; only with a ledger */
    Peaks peak;              /* largest values of the run up to the end; only with a ledger */
    const EventLocation *location; /* of SEGMENT_RADAU: the collocation step */
} Segment;

/* Sets all members to those of a segment that ends at rest where it began, except booking. */
static inline void segment_begin(const Mechanism *m, SegmentKind kind, Segment *segment) {
    segment->kind = kind;
    segment->end = EVENT_NONE;
    segment->duration = segment->dtheta = segment->omega = segment->energy_gained = 0.0;
    segment->omega_is_increment = segment->books = segment->varies = false;
    segment->finds_speed = segment->ends_at_breakpoint = false;
    segment->crossed[0] = segment->crossed[1] = false;
    segment->peak = m->state.ledger.peak;
    segment->location = NULL;
}

/* Are all amounts finite, and of a size that the ledger can add up? */
static inline bool segment_is_in_range(const Segment *segment) {
    const double motion = segment->dtheta + segment->omega;
    return segment->books ? booking_is_in_range(&segment->booking, motion) : fabs(motion) <= LARGEST_ENERGY;
}

/* Applies the segment: the only place where a step changes angle, speed, accounts and inputs. Member by member: the
 * copy of a whole struct would wait until its members, just written, are in memory. */
static inline void segment_apply(Mechanism *m, const Segment *segment) {
    State *state = &m->state;
    if (m->params.ledger) {
        Peaks *peak = &state->ledger.peak;
        if (segment->books) {
            ledger_book(&state->ledger, &segment->booking);
            if (has_wear(&m->params)) ledger_book_wear(&state->ledger, &segment->booking);
        }
        peak_raise(&peak->torque, segment->peak.torque);
        peak_raise(&peak->omega, segment->peak.omega);
        for (int i = 0; i < 2; i++) peak_raise(&peak->reaction[i], segment->peak.reaction[i]);
    }
    state->energy_gained += segment->energy_gained;
    if (segment->omega_is_increment) sum_add(&state->omega, segment->omega);
    else state->omega = sum_of(segment->omega);
    if (segment->dtheta != 0.0) {
        state->theta = theta_after(m, segment->dtheta);
        update_configuration(m);
    }
    if (segment->varies) inputs_advance(&m->inputs, segment->duration);
}

/* For inputs that are curved in time: raises the segment's peak of |tau| to the largest |tau| of its first t seconds,
 * and at rest also the peaks of the reactions. Constant inputs and ramps are largest at the ends of the segment. */
void segment_raise_input_peaks(const Mechanism *m, double t, Segment *segment);

#endif
