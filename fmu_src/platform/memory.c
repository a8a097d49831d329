#include "platform/memory.h"

#include <stdint.h>
#include <stdlib.h>

#include "platform/attributes.h"

enum { VECTOR_SIZE = 16 };

/* The byte before the memory is its distance from the block, 1 to 16. */
COLD void *memory_new(size_t size) {
    if (size > SIZE_MAX - VECTOR_SIZE) return NULL;
    unsigned char *block = calloc(1, size + VECTOR_SIZE);
    if (block == NULL) return NULL;
    const size_t distance = VECTOR_SIZE - (uintptr_t)block % VECTOR_SIZE;
    block[distance - 1] = (unsigned char)distance;
    return block + distance;
}

COLD void memory_free(void *memory) {
    if (memory == NULL) return;
    unsigned char *first = memory;
    free(first - first[-1]);
}
