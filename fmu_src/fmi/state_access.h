/* Snapshots as masters handle them, behind pointers, whatever the version of FMI. Where these return false they
 * have logged why, naming `function`, and have changed nothing. */
#ifndef DUALCAM_STATE_ACCESS_H
#define DUALCAM_STATE_ACCESS_H

#include "fmi/instance.h"

/* Takes a snapshot into *state, which is one from before or NULL: then it is made. */
bool state_get(const Instance *instance, const char *function, void **state);
bool state_set(Instance *instance, const char *function, const void *state);

/* Frees *state and makes it NULL; nothing to do if it is. */
bool state_free(const Instance *instance, const char *function, void **state);

bool state_size(const Instance *instance, const char *function, const void *state, size_t *size);
bool state_serialize(const Instance *instance, const char *function, const void *state, void *bytes, size_t size);
bool state_deserialize(const Instance *instance, const char *function, const void *bytes, size_t size, void **state);

#endif
