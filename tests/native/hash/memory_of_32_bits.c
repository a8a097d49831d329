/* Memory at odd multiples of 8 alone, as malloc() of 32-bit Windows may give it. The C library of a static program takes
 * these functions in place of its own. Blocks are not used again: the scenes need some MB. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ARENA = 1 << 28 /* bytes; the system gives pages that are used */ };

static _Alignas(16) unsigned char arena[ARENA];
static size_t used;

/* The size stands before the block. */
static size_t *size_of(void *block) {
    return (size_t *)((unsigned char *)block - sizeof(uint64_t));
}

void *malloc(size_t size) {
    if (size > ARENA - used - 32) return NULL;
    unsigned char *block = arena + used + 24;
    used += (size + 16 + 15) / 16 * 16;
    *size_of(block) = size;
    return block;
}

void *calloc(size_t count, size_t size) {
    if (size != 0 && count > ARENA / size) return NULL;
    return malloc(count * size); /* the arena is zero */
}

void *realloc(void *block, size_t size) {
    void *larger = malloc(size);
    if (block != NULL && larger != NULL) memcpy(larger, block, *size_of(block) < size ? *size_of(block) : size);
    return larger;
}

void free(void *block) {
    (void)block;
}
