/* The model that the FMI functions drive: one of two structs behind the same functions, chosen when an FMU is compiled.
 *
 *   MODEL_FORWARD  Mechanism (forward/state.h): torque in, motion out; functions in model_forward.c
 *   MODEL_INVERSE  Inverse (inverse/inverse.h): motion in, torque out; functions in model_inverse.c
 *
 * Both structs begin with `params` and `inputs`, in this order, and have a `state`; these three are all that a restored
 * FMU state needs. Neither FMI nor physics stands here: the functions only call forward or inverse dynamics. */
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
#include "identity.h" /* stands only inside an FMU (archive.py); the project's own build gives -DMODEL_BUILT=... */
#endif

#if MODEL_BUILT == MODEL_FORWARD
#include "forward/lifecycle.h"
#include "outputs/ode.h"
#include "outputs/outputs.h"
#define model_start mechanism_start
#define model_rebuild mechanism_rebuild
#define model_retune mechanism_retune
#define model_free mechanism_free
typedef Mechanism FmuModel;
typedef Inputs ModelInputs;
typedef State ModelState;
typedef Outputs ModelOutputs;
enum { RETURNS_EARLY = 1 };  /* a step can end at a mode change */
enum { SAMPLES_INPUTS = 1 }; /* a master can set inputs inside a step */
enum { MODEL_UNKNOWNS = 5 }; /* number of variables that have partial derivatives */
enum { CONTINUOUS_STATES = ODE_STATES, EVENT_INDICATORS = ODE_INDICATORS }; /* of model exchange */
#elif MODEL_BUILT == MODEL_INVERSE
#include "inverse/inverse.h"
#define model_start inverse_start
#define model_rebuild inverse_rebuild
#define model_retune inverse_retune
#define model_free inverse_free
typedef Inverse FmuModel;
typedef InverseInputs ModelInputs;
typedef InverseState ModelState;
typedef InverseOutputs ModelOutputs;
enum { RETURNS_EARLY = 0, SAMPLES_INPUTS = 0 }; /* the motion is imposed to the end of the step */
enum { MODEL_UNKNOWNS = 3 };
enum { CONTINUOUS_STATES = 0, EVENT_INDICATORS = 1 };
#else
#error "MODEL_BUILT must be MODEL_FORWARD or MODEL_INVERSE"
#endif

/* Where these functions return false, `fault` says why and the model is as before. */

/* A step of h > 0 seconds; m->inputs then hold their values at the end. Bit r of `derivatives_given`: derivatives of
 * the input with value reference r are given for this step. `watcher`: of mode changes (mechanism_advance()), or NULL.
 * A model that does not return early tells the watcher at the end of the step. */
bool model_advance(FmuModel *m, double h, unsigned derivatives_given, Watcher *watcher, Fault *fault);

/* Sets all derivatives of the inputs to zero. */
void model_clear_input_derivatives(ModelInputs *inputs);

/* Computes these groups of outputs (Group in variables.h) with the present inputs. */
bool model_outputs(const FmuModel *m, unsigned groups, ModelOutputs *outputs, Fault *fault);

/* Time derivative, of order 1 to MAX_OUTPUT_ORDER, of an output that model_outputs() can compute: along the motion that
 * follows with the present inputs. */
double model_output_derivative(const FmuModel *m, unsigned reference, int order);

/* The Known of a variable, or -1: no output is differentiated by this variable. */
int model_known(unsigned reference);

/* The number, below MODEL_UNKNOWNS, of an output or of the derivative of a state; -1: the variable has no partial
 * derivatives. */
int model_unknown(unsigned reference);

/* Partial derivatives of an unknown, in the present state and with the present inputs. */
bool model_partials(const FmuModel *m, unsigned reference, Partials *out, Fault *fault);

/* Model exchange begins, after model_start(): from now on the importer integrates. */
bool model_begin_model_exchange(FmuModel *m, Fault *fault);

/* x and derivative have CONTINUOUS_STATES elements, indicator has EVENT_INDICATORS. */
void model_set_states(FmuModel *m, const double x[]);
void model_get_states(const FmuModel *m, double x[]);
bool model_state_derivatives(const FmuModel *m, double derivative[], Fault *fault);
void model_indicators(const FmuModel *m, double indicator[]);

/* Value reference of a continuous state. */
unsigned model_state_reference(int state);

/* Handles the events of the present instant. */
void model_update_discrete_states(FmuModel *m);

/* The importer has completed an integrator step of h seconds to the present states and inputs. */
bool model_complete_integrator_step(FmuModel *m, double h, Fault *fault);

/* Could a run have led to this state, as far as modes, directions and the finite numbers among its values go? */
bool model_state_is_possible(const ModelState *state);

#endif
