/* Derivatives by value reference, whatever the version of FMI: time derivatives of inputs and outputs, and partial
 * derivatives. Where these functions return false, the log says why and names `function`, and nothing has changed. */
#ifndef DUALCAM_DERIVATIVES_H
#define DUALCAM_DERIVATIVES_H

#include "fmi/access.h"

/* Time derivatives of inputs, orders 1 to INPUT_ORDER. They hold for one step: without new ones the inputs are
 * constant over the following step. The old ones stay until then, since the derivatives of outputs at the end of a
 * step depend on them. */
bool derivatives_set_of_inputs(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                               const int32_t order[], const double value[]);

/* Time derivatives of outputs, orders 1 to MAX_OUTPUT_ORDER. `phases`: where this version of FMI allows the
 * function. */
bool derivatives_get_of_outputs(Instance *instance, const char *function, unsigned phases, const ValueReference vr[],
                                size_t n, const int32_t order[], double value[]);

/* The matrix of the partial derivatives of the unknowns (rows) by the knowns (columns). */
typedef struct {
    const ValueReference *unknown, *known;
    size_t unknowns, knowns;
} Jacobian;

/* product = Jacobian, or transposed Jacobian, times seed: one seed for each known and one product for each unknown, or
 * the other way round. */
bool derivatives_product(Instance *instance, const char *function, const Jacobian *jacobian, bool transposed,
                         const double seed[], double product[]);

#endif
