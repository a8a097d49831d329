/* Memory for structs that hold vectors. malloc() of 32-bit Windows gives multiples of 8, and a vector must stand at a
 * multiple of its size, 16: the processor traps elsewhere. */
#ifndef DUALCAM_MEMORY_H
#define DUALCAM_MEMORY_H

#include <stddef.h>

/* `size` zero bytes at a multiple of 16, or NULL. For memory_free() alone, not for free(). */
void *memory_new(size_t size);
void memory_free(void *memory);

#endif
