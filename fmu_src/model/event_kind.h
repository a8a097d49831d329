/* The events that end a segment of slip. */
#ifndef DUALCAM_EVENT_KIND_H
#define DUALCAM_EVENT_KIND_H

typedef enum {
    EVENT_NONE,
    EVENT_REST,  /* the speed becomes zero */
    EVENT_STOP,  /* theta reaches an end stop */
    EVENT_FLANK, /* the reaction of a contact changes its sign */
    EVENT_LOST,  /* Newton's method loses the reactions: see loaded_contacts.h */
    EVENT_LET_GO /* the axial load vanishes where friction is about to jam: see step_indicator.h */
} EventKind;

#endif
