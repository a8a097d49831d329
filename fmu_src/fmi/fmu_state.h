/* FMU states, behind the pointers that masters hold, whatever the version of FMI. Where these functions
 * return false, the log says why and names `function`, and nothing has changed. */
#ifndef DUALCAM_FMU_STATE_H
#define DUALCAM_FMU_STATE_H

#include "fmi/instance.h"

/* Takes a snapshot into *state. If *state is NULL, memory for a new one is taken. */
bool fmu_state_get(const Instance *instance, const char *function, void **state);
bool fmu_state_set(Instance *instance, const char *function, const void *state);

/* Frees *state and sets it to NULL. */
bool fmu_state_free(const Instance *instance, const char *function, void **state);

bool fmu_state_size(const Instance *instance, const char *function, const void *state, size_t *size);
bool fmu_state_serialize(const Instance *instance, const char *function, const void *state, void *bytes, size_t size);
bool fmu_state_deserialize(const Instance *instance, const char *function, const void *bytes, size_t size,
                           void **state);

#endif
