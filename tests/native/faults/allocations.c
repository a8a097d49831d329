#include "allocations.h"

#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>

static atomic_long blocks;
static long left; /* allocations until one fails; 0: none fails */
static bool goes_on, failed;

long blocks_in_use(void) {
    return blocks;
}

void fail_allocation(long n, bool lasting) {
    left = n, goes_on = lasting, failed = false;
}

bool allocation_failed(void) {
    return failed;
}

#if !defined(__SANITIZE_THREAD__)

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void __libc_free(void *);

static bool fails(void) {
    if (failed && goes_on) return true;
    if (left == 0 || --left > 0) return false;
    failed = true;
    return true;
}

static void *counted(void *block) {
    if (block != NULL) blocks++;
    return block;
}

static void *refused_block(void) {
    errno = ENOMEM;
    return NULL;
}

void *malloc(size_t size) {
    return fails() ? refused_block() : counted(__libc_malloc(size));
}

void *calloc(size_t count, size_t size) {
    return fails() ? refused_block() : counted(__libc_calloc(count, size));
}

void *realloc(void *block, size_t size) {
    if (block == NULL) return malloc(size);
    return fails() ? refused_block() : __libc_realloc(block, size);
}

void free(void *block) {
    if (block != NULL) blocks--;
    __libc_free(block);
}

#endif
