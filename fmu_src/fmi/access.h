/* Reading and setting variables by value reference, whatever the version of FMI. Where these functions return false,
 * the log says why and names `function`, and nothing has changed. */
#ifndef DUALCAM_ACCESS_H
#define DUALCAM_ACCESS_H

#include "fmi/instance.h"

typedef unsigned ValueReference;

/* Read and write element i of the master's array: the versions of FMI differ in the type of a Boolean. */
typedef bool ReadBoolean(const void *value, size_t i);
typedef void WriteBoolean(void *value, size_t i, bool content);

bool access_get_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n, double value[]);
bool access_get_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         int32_t value[]);
bool access_get_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n, void *value,
                         WriteBoolean *write);
bool access_get_texts(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const char *value[]);

/* A call that sets inputs alone belongs to every step: values are checked, then stored. Any other call is carried
 * out on a draft, which replaces the values only if all of the call is allowed. */
bool access_set_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const double value[]);
bool access_set_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const int32_t value[]);
bool access_set_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const void *value, ReadBoolean *read);
bool access_set_texts(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const char *const value[]);

/* Element 0 is the value of an input; elements 1 to INPUT_ORDER are its derivatives. */
double *access_input(Instance *instance, ValueReference reference);

/* The variable with this reference and type, or NULL, with the reason in the log. */
const Variable *access_find(const Instance *instance, const char *function, ValueReference reference, Type type);

/* Are the values read finite? Extreme inputs can make an infinite one, or NaN: such a value is refused. */
bool access_are_numbers(const Instance *instance, const char *function, const ValueReference vr[], size_t n,
                        const double value[]);

/* Are the arrays of references and values there, if n > 0? */
bool access_has_arrays(const Instance *instance, const char *function, size_t n, const ValueReference vr[],
                       const void *values);

#endif
