/* Variables by value reference, whatever the version of FMI: reading, setting, derivatives. Where these return
 * false they have logged why, naming `function`, and have changed nothing. */
#ifndef DUALCAM_ACCESS_H
#define DUALCAM_ACCESS_H

#include "fmi/instance.h"

typedef unsigned ValueReference;

/* Element i of the caller's array, and back: FMI's versions differ in what a Boolean is. */
typedef bool ReadBoolean(const void *value, size_t i);
typedef void WriteBoolean(void *value, size_t i, bool content);

bool access_get_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n, double value[]);
bool access_get_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         int32_t value[]);
bool access_get_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n, void *value,
                         WriteBoolean *write);
bool access_get_texts(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const char *value[]);

/* A call that sets nothing but inputs is the hot path: checked, then stored. Any other is carried out on a
 * draft, which replaces the values only if all of the call is good. */
bool access_set_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const double value[]);
bool access_set_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const int32_t value[]);
bool access_set_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const void *value, ReadBoolean *read);
bool access_set_texts(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const char *const value[]);

/* The value of an input; its derivatives of orders 1 to INPUT_ORDER follow. */
double *access_input(Instance *instance, ValueReference reference);

/* Time derivatives of inputs, orders 1 to INPUT_ORDER. They hold for one step: without new ones the inputs are
 * constant over the next. The old ones stay until then, since the derivatives of outputs at the end of a step
 * depend on them. */
bool access_set_input_derivatives(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                                  const int32_t order[], const double value[]);

/* Time derivatives of outputs, orders 1 to MAX_OUTPUT_ORDER. */
bool access_get_output_derivatives(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                                   const int32_t order[], double value[]);

/* The matrix of partial derivatives of the unknowns (rows) by the knowns (columns): times a seed per known, or,
 * transposed, times a seed per unknown. */
typedef struct {
    const ValueReference *unknown, *known;
    size_t unknowns, knowns;
} Jacobian;

bool access_directional(Instance *instance, const char *function, const Jacobian *jacobian, const double seed[],
                        double product[]);
bool access_adjoint(Instance *instance, const char *function, const Jacobian *jacobian, const double seed[],
                    double product[]);

#endif
