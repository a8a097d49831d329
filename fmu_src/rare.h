/* What runs at the start, or when somebody asks, but never in a step: its code is to be small rather than fast. */
#ifndef DUALCAM_RARE_H
#define DUALCAM_RARE_H

#ifdef __clang__
#define RARE __attribute__((cold, minsize))
#else
#define RARE __attribute__((cold))
#endif

#endif
