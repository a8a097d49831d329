/* The message of a refused parameter set: it names the variable, its value and the values allowed. */
#ifndef DUALCAM_FAULT_H
#define DUALCAM_FAULT_H

typedef struct {
    char text[512];
} Fault;

#endif
