/* What the FMI functions drive: one of two structs, chosen when an FMU is compiled, behind the same calls.
 *
 *   MODEL_FORWARD  Mechanism (mechanism.h): torque in, motion out
 *   MODEL_INVERSE  Inverse (inverse.h): motion in, torque out
 *
 * Either begins with `params` and `inputs`, in this order, and has a `state` that is all a restored run needs
 * besides them. No FMI here, and no physics: model_forward.c and model_inverse.c only hand on. */
#ifndef DUALCAM_MODEL_H
#define DUALCAM_MODEL_H

#include <stdbool.h>

#include "model/fault.h"
#include "model/known.h"
#include "model/watcher.h"

#define MODEL_FORWARD 1
#define MODEL_INVERSE 2

enum { MAX_OUTPUT_ORDER = 2 }; /* highest time derivative of an output */

#ifndef MODEL_BUILT
#include "identity.h" /* only inside an FMU, see archive.py; the project's own build gives -DMODEL_BUILT=... */
#endif

#if MODEL_BUILT == MODEL_FORWARD
#include "forward/ode.h"
#include "forward/state.h"
typedef Mechanism Machine;
typedef Inputs MachineInputs;
typedef State MachineState;
typedef Outputs MachineOutputs;
enum { RETURNS_EARLY = 1 };                                                 /* can a step end at a mode change? */
enum { SAMPLES_INPUTS = 1 };                                                /* can inputs be given inside a step? */
enum { MODEL_ROWS = 5 };                                                    /* variables that can be differentiated */
enum { CONTINUOUS_STATES = ODE_STATES, EVENT_INDICATORS = ODE_INDICATORS }; /* of model exchange */
#elif MODEL_BUILT == MODEL_INVERSE
#include "inverse/inverse.h"
typedef Inverse Machine;
typedef InverseInputs MachineInputs;
typedef InverseState MachineState;
typedef InverseOutputs MachineOutputs;
enum { RETURNS_EARLY = 0, SAMPLES_INPUTS = 0 }; /* the motion to the end of the step is imposed */
enum { MODEL_ROWS = 3 };
enum { CONTINUOUS_STATES = 0, EVENT_INDICATORS = 1 };
#else
#error "MODEL_BUILT must be MODEL_FORWARD or MODEL_INVERSE"
#endif

/* Where these return false, `fault` says why and the machine is as before. */

/* Checks m->params, builds what they imply and sets the state to its start. */
bool model_start(Machine *m, Fault *fault);

/* Builds what params imply; to be called after params, inputs and state came from a snapshot. */
bool model_rebuild(Machine *m, Fault *fault);

/* Replaces m->params at a communication point; only tunable ones differ. */
bool model_retune(Machine *m, const Params *params, Fault *fault);

/* Frees what the machine owns; safe on a zeroed machine, and twice. */
void model_free(Machine *m);

/* Moves on by h > 0 seconds and leaves in m->inputs their values at the end. Bit r of `with_rates` tells that
 * derivatives of the input with value reference r are given for this step. */
bool model_advance(Machine *m, double h, unsigned with_rates, Fault *fault);

/* The same with a watcher, see mechanism_advance_watched(). One that does not return early is told at its end. */
bool model_advance_watched(Machine *m, double h, unsigned with_rates, Watcher *watcher, Fault *fault);

/* Makes all derivatives of the inputs zero. */
void model_forget_rates(MachineInputs *inputs);

/* Computes these groups of outputs (see Group in variables.h) with the present inputs. */
bool model_outputs(const Machine *m, unsigned groups, MachineOutputs *outputs, Fault *fault);

/* Time derivative of order 1 to MAX_OUTPUT_ORDER of the output with that value reference, which model_outputs() can
 * compute: of what comes next with the present inputs. */
double model_output_derivative(const Machine *m, unsigned reference, int order);

/* The knob that a variable is, or -1: nothing is differentiated by it. */
int model_known(unsigned reference);

/* Place among MODEL_ROWS of a variable that can be differentiated, an output or the derivative of a state; or -1. */
int model_row(unsigned reference);

/* Its partial derivatives, in the present state and with the present inputs. */
bool model_partials(const Machine *m, unsigned reference, Partials *out, Fault *fault);

/* From now on somebody else integrates: model exchange. The machine has started. */
bool model_begin_exchange(Machine *m, Fault *fault);

/* x, rate: CONTINUOUS_STATES; indicator: EVENT_INDICATORS of them. */
void model_set_states(Machine *m, const double x[]);
void model_get_states(const Machine *m, double x[]);
bool model_state_rates(const Machine *m, double rate[], Fault *fault);
void model_indicators(const Machine *m, double indicator[]);

/* Value reference of a continuous state. */
unsigned model_state_reference(int state);

/* Carries out the events that are due. */
bool model_settle(Machine *m, Fault *fault);

/* The solver's step to the present states and inputs, which took h seconds, is good. */
bool model_accept(Machine *m, double h, Fault *fault);

/* Bytes that belong to no member, so that equal states have equal bytes. */
void model_clear_padding(MachineState *state);

#endif
