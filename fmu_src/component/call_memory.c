#include <stdlib.h>
#include <string.h>

#include "component/component.h"

/* A block of memory with the block that was allocated before. `content` is aligned for any type. */
typedef struct Block {
    struct Block *previous;
    _Alignas(16) char content[];
} Block;

static Block *last_block;

void *hold(size_t size) {
    Block *block = malloc(sizeof *block + size);
    if (block == NULL) __builtin_trap();
    block->previous = last_block;
    last_block = block;
    return block->content;
}

/* Frees the memory of the call: the host has read the result. */
EXPORT("release") void release(uint32_t result);
void release(uint32_t result) {
    (void)result;
    while (last_block != NULL) {
        Block *const block = last_block;
        last_block = block->previous;
        free(block);
    }
}

/* The host's allocation: memory for an argument, or more of it. */
EXPORT("allocate") void *allocate(const void *old, size_t old_size, size_t alignment, size_t new_size);
void *allocate(const void *old, size_t old_size, size_t alignment, size_t new_size) {
    (void)alignment; /* never above that of a block */
    void *const memory = hold(new_size);
    if (old_size > 0) memcpy(memory, old, old_size < new_size ? old_size : new_size);
    return memory;
}

char *hold_text(const char *begin, size_t length) {
    char *const text = hold(length + 1);
    memcpy(text, begin, length);
    text[length] = '\0';
    return text;
}

fmi3String *hold_texts(const Text *texts, size_t count) {
    fmi3String *const copies = hold(count * sizeof *copies);
    for (size_t i = 0; i < count; i++) copies[i] = hold_text(texts[i].begin, texts[i].length);
    return copies;
}

ListResult *list_result(fmi3Status status, void *items, size_t count) {
    static ListResult result;
    result = (ListResult){.refused = is_refused(status)};
    if (result.refused) result.status = (uint8_t)status;
    else {
        result.list.items = items;
        result.list.count = count;
    }
    return &result;
}
