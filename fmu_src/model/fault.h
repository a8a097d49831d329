/* Message of a refused parameter set: names the variable, its value and what is allowed. */
#ifndef DUALCAM_FAULT_H
#define DUALCAM_FAULT_H

typedef struct {
    char text[512];
} Fault;

#endif
