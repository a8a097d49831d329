/* The events that end a segment of slip. */
#ifndef DUALCAM_EVENT_KIND_H
#define DUALCAM_EVENT_KIND_H

typedef enum {
    EVENT_NONE,
    EVENT_REST, /* the speed becomes zero */
    EVENT_STOP, /* theta reaches an end stop */
    EVENT_FLANK /* the reaction of a contact changes its sign */
} EventKind;

#endif
