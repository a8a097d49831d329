/* The processor's control of floating-point arithmetic: rounding, flushing of small numbers to zero, and traps. A host
 * may have changed the control: Delphi unmasks traps, compilers of Intel flush to zero. Where the model computes, the
 * control is that of a new process: rounding to nearest, no flushing, no traps. So results do not depend on the host,
 * and no operation of the model ends the host's process. */
#ifndef DUALCAM_ARITHMETIC_H
#define DUALCAM_ARITHMETIC_H

#include <stdbool.h>
#include <stdint.h>

/* The host's control. */
typedef struct {
    unsigned sse;  /* x86: MXCSR */
    uint16_t x87;  /* x86: control word; strtod() of glibc rounds by it, 32-bit functions return numbers in the unit */
    uint64_t fpcr; /* aarch64 */
    bool differs;  /* from that of a new process */
} HostArithmetic;

/* Keeps loads and stores of the model's numbers on their side of the change. */
static inline void arithmetic_barrier(void) {
    __asm__ volatile("" ::: "memory");
}

#if defined(__SSE2__)

#include <xmmintrin.h>

enum { SSE_FLAGS = 0x3F, /* what past operations have raised; no control */ SSE_USUAL = 0x1F80 };
enum { X87_MASKS = 0x3F, X87_ROUNDING = 0xC00 };

static inline void arithmetic_set_x87(uint16_t control) {
    /* without fnclex, a flag that is raised and no longer masked traps at the next operation */
    __asm__ volatile("fnclex\n\tfldcw %0" ::"m"(control));
}

static inline HostArithmetic arithmetic_host(void) {
    HostArithmetic host = {.sse = _mm_getcsr()};
    __asm__ volatile("fnstcw %0" : "=m"(host.x87));
    host.differs =
        (host.sse & ~(unsigned)SSE_FLAGS) != SSE_USUAL || (host.x87 & (X87_MASKS | X87_ROUNDING)) != X87_MASKS;
    return host;
}

static inline void arithmetic_set_usual(HostArithmetic host) {
    _mm_setcsr(SSE_USUAL);
    arithmetic_set_x87((uint16_t)((host.x87 & ~X87_ROUNDING) | X87_MASKS));
}

static inline void arithmetic_set_host(HostArithmetic host) {
    _mm_setcsr(host.sse);
    arithmetic_set_x87(host.x87);
}

#elif defined(__aarch64__)

static inline void arithmetic_set_fpcr(uint64_t control) {
    __asm__ volatile("msr fpcr, %0" ::"r"(control));
}

static inline HostArithmetic arithmetic_host(void) {
    HostArithmetic host = {.sse = 0};
    __asm__ volatile("mrs %0, fpcr" : "=r"(host.fpcr));
    host.differs = host.fpcr != 0;
    return host;
}

static inline void arithmetic_set_usual(HostArithmetic host) {
    (void)host;
    arithmetic_set_fpcr(0);
}

static inline void arithmetic_set_host(HostArithmetic host) {
    arithmetic_set_fpcr(host.fpcr);
}

#else /* WebAssembly has no control; of other processors none is known here */

static inline HostArithmetic arithmetic_host(void) {
    return (HostArithmetic){.differs = false};
}

static inline void arithmetic_set_usual(HostArithmetic host) {
    (void)host;
}

static inline void arithmetic_set_host(HostArithmetic host) {
    (void)host;
}

#endif

/* Before the model computes; the result is for arithmetic_end(). Writing a control takes longer than reading, and
 * happens only where the host's differs. */
static inline HostArithmetic arithmetic_begin(void) {
    const HostArithmetic host = arithmetic_host();
    if (host.differs) arithmetic_set_usual(host);
    arithmetic_barrier();
    return host;
}

/* Gives the host its control back, with the flags of SSE as they were. */
static inline void arithmetic_end(HostArithmetic host) {
    arithmetic_barrier();
    if (host.differs) arithmetic_set_host(host);
}

#endif
