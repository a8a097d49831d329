/* Instructions of one step of benchmarks/harness/steps.c, counted by the processor: with its trap flag set it stops after every
 * instruction, and the kernel sends SIGTRAP. x86-64 and Linux. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdint.h>

typedef size_t Loop(const void *rig, const void *program);

/* A signal's handler has nothing but a global to count in. */
static volatile uint64_t traps;

static void on_trap(int number) {
    (void)number;
    traps++;
}

/* The flag is changed below the red zone of the caller. */
__attribute__((visibility("default"))) uint64_t count_traps(Loop *loop, const void *rig, const void *program) {
    struct sigaction before, action = {.sa_handler = on_trap};
    sigaction(SIGTRAP, &action, &before);
    traps = 0;
    __asm__ volatile("lea -128(%%rsp), %%rsp\n pushfq\n orq $0x100, (%%rsp)\n popfq\n lea 128(%%rsp), %%rsp" ::
                         : "cc", "memory");
    loop(rig, program);
    __asm__ volatile("lea -128(%%rsp), %%rsp\n pushfq\n andq $-257, (%%rsp)\n popfq\n lea 128(%%rsp), %%rsp" ::
                         : "cc", "memory");
    sigaction(SIGTRAP, &before, NULL);
    return traps;
}
