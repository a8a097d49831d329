/* How deep the calls go, in a thread with a small stack. */
#define _GNU_SOURCE
#include "faults.h"

#include <pthread.h>
#include <sys/mman.h>

enum { STACK = 64 << 10, OWN = 512 };

static const uint64_t PAINT = 0xA5A5A5A5A5A5A5A5u;

static uint64_t *lowest;      /* of the thread's stack */
static size_t deepest;        /* bytes, of a call */
static uintptr_t call_begins; /* the address of its caller's frame */

/* Paints the stack below the present frame. */
static void paint(void) {
    volatile uint64_t here = 0;
    call_begins = (uintptr_t)&here;
    const volatile uint64_t *const top = &here - OWN / sizeof here;
    for (volatile uint64_t *p = lowest; p < top; p++) *p = PAINT;
}

static void note(void) {
    const uint64_t *p = lowest;
    while (*p == PAINT) p++;
    const size_t used = call_begins - (uintptr_t)p;
    if (used > deepest && used > OWN) deepest = used;
}

static void *live_here(void *unused) {
    (void)unused;
    size_t count;
    const Scene *scene = possible_scenes(&count);
    for (size_t i = 0; i < count; i++) {
        (void)life(&scene[i]);
        (void)exchanged_life(&scene[i]);
    }
    /* refusals: of a table, of parameters, of a call */
    const fmi2Component c = instantiate(&callbacks);
    REQUIRE(!begin(c, &scene[count]));
    REQUIRE(fmi2DoStep(c, 0.0, 1e-3, fmi2True) == fmi2Error);
    fmi2FreeInstance(c);
    return NULL;
}

void check_stack(void) {
    const size_t page = 4096;
    char *const memory = mmap(NULL, STACK + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(memory != MAP_FAILED && mprotect(memory, page, PROT_NONE) == 0);
    lowest = (uint64_t *)(void *)(memory + page);
    pthread_attr_t attributes;
    pthread_t thread;
    REQUIRE(pthread_attr_init(&attributes) == 0 && pthread_attr_setstack(&attributes, lowest, STACK) == 0);
    before_call = paint, after_call = note;
    REQUIRE(pthread_create(&thread, &attributes, live_here, NULL) == 0 && pthread_join(thread, NULL) == 0);
    before_call = after_call = NULL;
    printf("deepest call: %zu bytes\n", deepest);
    REQUIRE(munmap(memory, STACK + page) == 0);
}
