/* How functions are compiled where that is not left to the compiler.
 *
 * COLD      a function that no step calls: its code stands apart from the code of a step. A function that starts a run
 *           is not cold: a study starts 200,000 runs a second
 * NOINLINE  a large function with several callers, which is not to be copied into each of them
 * ALWAYS_INLINE  a function of a step that the compiler would not copy into its callers
 * COMPACT   a function that no step calls and that is called often enough not to be cold: its code is kept small, and
 *           is not copied into its callers
 * COMPACT_BEGIN, COMPACT_END  around functions that no step calls in stick or slip: their code is kept small.
 *           A function between them may be copied into its callers. Functions that copy large structs stay outside:
 *           compact code copies them slowly */
#ifndef DUALCAM_ATTRIBUTES_H
#define DUALCAM_ATTRIBUTES_H

#define COLD __attribute__((cold))
#define NOINLINE __attribute__((noinline))
#define ALWAYS_INLINE __attribute__((always_inline))

#if __has_attribute(minsize)
#define COMPACT __attribute__((minsize, noinline))
#else
#define COMPACT NOINLINE
#endif

#ifdef __clang__
#define COMPACT_BEGIN _Pragma("clang attribute push(__attribute__((minsize)), apply_to = function)")
#define COMPACT_END _Pragma("clang attribute pop")
#else
#define COMPACT_BEGIN
#define COMPACT_END
#endif

#endif
