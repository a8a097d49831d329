/* Start, tuning and end of a mechanism, and the return to the start of its latest step.
 *
 * Functions that return false fill `fault` with the reason. */
#ifndef DUALCAM_LIFECYCLE_H
#define DUALCAM_LIFECYCLE_H

#include "forward/state.h"
#include "model/fault.h"

/* Starts from m->params and m->inputs: builds the model, sets the state to its start values and decides the mode for
 * the present inputs. False if the parameters cannot work: stops out of order, a start angle beyond the stops, a groove
 * that ends too early or that lies outside the
 * domain (contact/domain.h), a table that cannot be read. Then only m->model has changed. */
bool mechanism_start(Mechanism *m, Fault *fault);

/* Builds the model from m->params and forgets cached values; the state stays. To be called after params, state and
 * inputs came from a snapshot. A transmission of the same cams and stops is kept. False if the parameters cannot
 * work. */
bool mechanism_rebuild(Mechanism *m, Fault *fault);

/* Replaces m->params at a communication point. Only friction, spring and damper may differ. Books the jump of the
 * spring's stored energy as work_tuning. False, with nothing changed, if the parameters cannot work. */
bool mechanism_retune(Mechanism *m, const Params *params, Fault *fault);

/* Brings state, inputs and tunable parameters back to the start of the latest step; the ledger stays. */
void mechanism_rewind(Mechanism *m);

/* Frees what the model owns. Safe on a zeroed Mechanism, and twice. */
void mechanism_free(Mechanism *m);

/* Forgets values that a step can compute again. */
void forget_cache(Cache *cache);

/* ---- the latest step ---- */

/* Describes a step of h seconds that starts from the present state. Member by member: compilers copy a whole struct by
 * way of the stack. */
static inline void begin_step(const Mechanism *m, double h, Step *step) {
    const State *s = &m->state;
    step->theta = s->theta;
    step->omega = s->omega;
    step->inputs = m->inputs;
    step->energy_gained = s->energy_gained;
    step->h = h;
    step->mode = s->mode;
    step->flank[0] = s->flank[0];
    step->flank[1] = s->flank[1];
    step->retuned = 0;
}

/* Clears the tunable parameters of the latest step: the present step takes its place. */
static inline void forget_tunables(State *s) {
    if (s->step.retuned) s->tunables = (Tunables){.spring = {.preload = 0.0}};
}

/* Remembers the start of a step that can no longer fail, before the step moves anything. */
static inline void remember_step(Mechanism *m, double h) {
    forget_tunables(&m->state);
    begin_step(m, h, &m->state.step);
}

#endif
