/* The message of a refused parameter set: it names the variable, its value and the values allowed. Numbers in a message
 * have as few digits as read back as the same number. */
#ifndef DUALCAM_FAULT_H
#define DUALCAM_FAULT_H

typedef struct {
    char text[512];
} Fault;

typedef struct {
    char text[32];
} ShortestDecimal;

/* The decimal number with the fewest digits that reads back as `value`. */
ShortestDecimal shortest_decimal(double value);

#endif
