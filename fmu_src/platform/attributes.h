/* How functions are compiled where that is not left to the compiler.
 *
 * COLD      a function that no step calls: its code stands apart from the code of a step. A function that starts a run
 *           is not cold: a study starts 200,000 runs a second
 * NOINLINE  a large function with several callers, which is not to be copied into each of them
 * ALWAYS_INLINE  a function of a step that the compiler would not copy into its callers */
#ifndef DUALCAM_ATTRIBUTES_H
#define DUALCAM_ATTRIBUTES_H

#define COLD __attribute__((cold))
#define NOINLINE __attribute__((noinline))
#define ALWAYS_INLINE __attribute__((always_inline))

#endif
