/* Compiler attributes of functions.
 *
 * COLD      never called in a step, only on request: compiled for small code. Functions that start a run are not cold:
 * a
 *           study starts 200,000 runs per second.
 * NOINLINE  large and called from several places: not to be copied into each caller. */
#ifndef DUALCAM_ATTRIBUTES_H
#define DUALCAM_ATTRIBUTES_H

#define NOINLINE __attribute__((noinline))

#ifdef __clang__
#define COLD __attribute__((cold, minsize))
#else
#define COLD __attribute__((cold))
#endif

#endif
