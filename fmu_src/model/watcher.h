/* Somebody who wants to know of the mode changes inside a step, and may end it there. */
#ifndef DUALCAM_WATCHER_H
#define DUALCAM_WATCHER_H

#include "model/mode.h"

typedef struct Watcher Watcher;
struct Watcher {
    /* The mode is another one since time last passed, and the step would go on for `left` >= 0 seconds. Returns for how
     * long it is to go on: `left`, or less. */
    double (*changed)(Watcher *watcher, double left);
    int mode;   /* in which time last passed; 0: none has */
    double cut; /* s, what the step was shortened by */
};

#endif
