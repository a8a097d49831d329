/* How functions are compiled where that is not left to the compiler.
 *
 * COLD   runs when somebody asks, but never in a step: its code is to be small rather than fast. What starts a run is
 *        not rare: a study starts 200,000 a second
 * NOINLINE  large, and called from several places: not to be drawn into each */
#ifndef DUALCAM_ATTRIBUTES_H
#define DUALCAM_ATTRIBUTES_H

#define NOINLINE __attribute__((noinline))

#ifdef __clang__
#define COLD __attribute__((cold, minsize))
#else
#define COLD __attribute__((cold))
#endif

#endif
