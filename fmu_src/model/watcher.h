/* A watcher is told of the mode changes inside a step and may end the step there. */
#ifndef DUALCAM_WATCHER_H
#define DUALCAM_WATCHER_H

#include "model/mode.h"

typedef struct Watcher Watcher;
struct Watcher {
    /* Called when the mode is another than when time last advanced; the step would go on for `left` >= 0 seconds.
     * Returns the time, s, for which the step is to go on: `left` or less. */
    double (*changed)(Watcher *watcher, double left);
    int mode;   /* in which time last advanced; 0: time has not advanced yet */
    double cut; /* s, by which the step was shortened */
};

#endif
