#include "forward/step.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "elementary/elementary.h"
#include "forward/closed_form_slip.h"
#include "forward/collocation_slip.h"
#include "forward/decide.h"
#include "forward/impact.h"
#include "forward/jump.h"
#include "forward/lifecycle.h"
#include "forward/rest.h"
#include "model/friction_law.h"
#include "model/work.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

enum { REASON_SIZE = 400 }; /* bytes */

typedef enum {
    OUTCOME_DONE,
    OUTCOME_GOES_ON,
    OUTCOME_STOPPED, /* the visitor has stopped the step */
    OUTCOME_NOT_FINITE,
    OUTCOME_LOST, /* D of the pair of flanks falls to zero */
    OUTCOME_TOO_MANY_WEDGES,
    OUTCOME_TOO_MANY_SEGMENTS,
    OUTCOME_TOO_MUCH_WORK,
} Outcome;

/* A step that is being made. */
typedef struct {
    double left;           /* s, time left */
    StepVisitor *visitor;  /* or NULL */
    bool settles;          /* decides the mode even if no time is left */
    bool decided;          /* the mode has been decided in this step */
    bool rests_on;         /* the latest segment is rest under constant inputs: no decision is due */
    bool goes_on;          /* the latest segment is a collocation step without event: its mode probably lasts */
    LobattoHint hint;      /* for the next segment */
    int segments, wedges;  /* so far; Lobatto steps and segments that only end at a breakpoint do not count */
    Work work;             /* so far; all segments and all searches count */
    int next_check;        /* stall guard: the number of segments at which the progress is checked */
    double left_at_check;  /* s, time left at the latest check */
    double least_progress; /* s, between two checks */
} StepRun;

static StepRun run_of(const Mechanism *m, double h, StepVisitor *visitor) {
    return (StepRun){
        .left = h,
        .visitor = visitor,
        .work = work_of_call(m->work_limit),
        .left_at_check = INFINITY,
        .least_progress = STALL_GUARD_PROGRESS * h,
    };
}

/* ---- limits ---- */

/* Bounds the work of a step, and finds a step in which time does not advance. */
static Outcome check_limits(StepRun *run) {
    if (run->wedges >= MAX_WEDGES_PER_STEP) return OUTCOME_TOO_MANY_WEDGES;
    if (run->segments >= MAX_SEGMENTS_PER_STEP) return OUTCOME_TOO_MANY_SEGMENTS;
    if (work_is_spent(&run->work)) return OUTCOME_TOO_MUCH_WORK;
    if (run->segments < run->next_check) return OUTCOME_GOES_ON;
    if (run->left_at_check - run->left < run->least_progress) return OUTCOME_TOO_MANY_SEGMENTS;
    run->left_at_check = run->left;
    run->next_check = run->segments + STALL_GUARD_SEGMENTS;
    return OUTCOME_GOES_ON;
}

/* ---- one segment ---- */

static void decide_mode(Mechanism *m, StepRun *run) {
    StepVisitor *visitor = run->visitor;
    if (visitor != NULL && visitor->before_decision != NULL) visitor->before_decision(visitor, m);
    enter_decided_mode(m);
    run->decided = true;
    if (visitor != NULL) run->left = visitor->after_decision(visitor, m, run->left);
}

static void propose_closed_form(Mechanism *m, double left, Segment *segment) {
    const LinearSlipMode *linear = kept_linear_slip(m, present_slip_index(m));
    const bool may_jump = linear->regime == REGIME_RATE_INDEPENDENT;
    if (!may_jump || !jump_of_helices(m, linear, segment)) closed_form_slip_propose(m, left, segment);
}

/* Proposes a segment in the mode that has been decided. */
static SlipProposal propose_segment(Mechanism *m, double left, EventLocation *location, Segment *segment) {
    if (is_wedging(m)) wedge_propose(m, segment);
    else if (!is_slip(m->state.mode)) rest_propose(m, left, segment);
    else if (is_closed_form(m)) propose_closed_form(m, left, segment);
    else if (jump_is_due(m)) jump_propose(m, left, segment);
    else return collocation_slip_propose(m, left, location, segment);
    return SLIP_PROPOSED;
}

/* The reactions that have passed zero, and the slips that end so at this place. */
static void note_crossing(Mechanism *m, const Segment *segment, unsigned slip, bool has_moved) {
    for (int i = 0; i < 2; i++) m->crossed[i] = segment->crossed[i];
    const bool crosses = segment->crossed[0] || segment->crossed[1];
    m->ended_slips = crosses && !has_moved ? m->ended_slips | slip : 0;
}

/* Applies the segment, handles its event and updates the run. Returns false if the visitor stops the step. */
static bool carry_out(Mechanism *m, StepRun *run, const Segment *segment) {
    StepVisitor *visitor = run->visitor;
    SegmentPast past;
    past.mode = m->state.mode;
    const unsigned slip = is_slip(past.mode) ? 1u << present_slip_index(m) : 0u;
    if (visitor != NULL) past.inputs = m->inputs;
    segment_apply(m, segment);
    past.omega = m->state.omega.hi;
    handle_event(m, direction_of(past.mode), segment->end);
    if (segment->finds_speed) jump_find_speed(m);
    note_crossing(m, segment, slip, segment->duration > DBL_EPSILON * run->left);
    run->left = max_of(run->left - segment->duration, 0.0); /* a rounding can locate an event past the end */
    run->rests_on = segment->kind == SEGMENT_REST && !segment->varies;
    run->goes_on = (segment->kind == SEGMENT_RADAU || segment->kind == SEGMENT_LOBATTO) && segment->end == EVENT_NONE;
    run->hint = (LobattoHint){.refused = false};
    const bool passes_breakpoint = segment->ends_at_breakpoint && segment->end == EVENT_NONE;
    const bool counts = segment->kind != SEGMENT_LOBATTO && !passes_breakpoint;
    run->segments += counts;
    work_add(&run->work, WORK_OF_SEGMENT);
    run->wedges += segment->kind == SEGMENT_WEDGE;
    return visitor == NULL || visitor->after_segment(visitor, m, segment, &past);
}

/* ---- the step ---- */

/* Is the mode at the end of the step known without a decision? */
static bool is_mode_known(const StepRun *run) {
    return run->left == 0.0 && !run->settles && (run->rests_on || !run->decided);
}

/* The mode has been decided: is the step complete? A wedge at its end takes the speed, for the mechanism then rests. */
static bool is_over(const Mechanism *m, const StepRun *run) {
    return run->left == 0.0 && !is_wedging(m);
}

/* Proposes the next segment in the present mode, if a short test shows that the mode lasts. */
static SlipProposal go_on(Mechanism *m, StepRun *run, EventLocation *location, Segment *segment) {
    const bool may = run->goes_on && run->left > 0.0 && !(run->visitor != NULL && run->visitor->every_decision);
    return may ? collocation_slip_continue(m, run->left, &run->hint, location, segment) : SLIP_UNDECIDED;
}

/* While time is left: decide the mode, propose a segment in it, apply the segment, handle its event. */
NOINLINE static Outcome make_segments(Mechanism *m, StepRun *run) {
    EventLocation location;
    Segment segment;
    for (;;) { /* at most MAX_WORK turns, see check_limits() */
        if (is_mode_known(run)) return OUTCOME_DONE;
        const Outcome limits = run->left > 0.0 || run->settles ? check_limits(run) : OUTCOME_GOES_ON;
        if (limits != OUTCOME_GOES_ON) return limits;
        SlipProposal proposal = go_on(m, run, &location, &segment);
        if (proposal == SLIP_UNDECIDED) {
            decide_mode(m, run);
            if (is_over(m, run)) return OUTCOME_DONE;
            proposal = propose_segment(m, run->left, &location, &segment);
        }
        if (proposal == SLIP_LOST) return OUTCOME_LOST;
        if (!segment_is_in_range(&segment)) return OUTCOME_NOT_FINITE;
        if (!carry_out(m, run, &segment)) return OUTCOME_STOPPED;
    }
}

/* A search that ended because the work was spent has found nothing: what followed from it does not count. */
static Outcome go_through(Mechanism *m, StepRun *run) {
    m->work = &run->work;
    const Outcome outcome = make_segments(m, run);
    m->work = NULL;
    m->crossed[0] = m->crossed[1] = false;
    m->ended_slips = 0;
    return work_is_spent(&run->work) ? OUTCOME_TOO_MUCH_WORK : outcome;
}

/* ---- failures ---- */

/* Where D of the present pair of flanks falls to zero in the motion: the place and the coefficients. */
static void describe_loss(const Mechanism *m, char text[REASON_SIZE]) {
    const SlipMode slip = slip_mode_from_here(m, present_slip_index(m));
    const Balance now = balance_from_here(m, &slip);
    snprintf(
        text, REASON_SIZE,
        "at theta = %s, omega = %s the contacts, with mu1 = %s and mu2 = %s, take the inertia that the torque feels "
        "to zero; a larger inertia.shaft, or less friction%s, would work",
        shortest_decimal(now.theta).text, shortest_decimal(now.omega).text,
        shortest_decimal(fabs(now.friction[0])).text, shortest_decimal(fabs(now.friction[1])).text,
        any_friction_depends_on_speed(&m->params) ? " at this speed" : "");
}

/* The reason of a failed step; `m` is the mechanism at the instant of the failure. */
static void describe_reason(const Mechanism *m, Outcome outcome, char text[REASON_SIZE]) {
    static const char *const reason[] = {
        [OUTCOME_NOT_FINITE] = "the motion leaves the range of numbers",
        [OUTCOME_TOO_MANY_WEDGES] = "the contacts wedge and let go without end",
        [OUTCOME_TOO_MANY_SEGMENTS] = "the step needs too many segments",
        [OUTCOME_TOO_MUCH_WORK] = "the step needs too many evaluations of the motion",
    };
    if (outcome == OUTCOME_LOST) describe_loss(m, text);
    else snprintf(text, REASON_SIZE, "%s", reason[outcome]);
}

/* Describes why a step of h seconds is refused; undo() has brought `m` back to the start of the step. */
static void describe_failure(Fault *fault, const Mechanism *m, double h, const char *reason) {
    snprintf(
        fault->text, sizeof fault->text,
        "step of %s s at theta = %s, omega = %s, tau = %s: %s; allowed are finite values and "
        "at most %d segments, %d wedges and %d evaluations of the motion; any %d segments in a row must advance %g "
        "of the step",
        shortest_decimal(h).text, shortest_decimal(m->state.theta.hi).text, shortest_decimal(m->state.omega.hi).text,
        shortest_decimal(m->inputs.tau[0]).text, reason, (int)MAX_SEGMENTS_PER_STEP, (int)MAX_WEDGES_PER_STEP,
        (int)work_of_call(m->work_limit).most, (int)STALL_GUARD_SEGMENTS, STALL_GUARD_PROGRESS);
}

/* Do the inputs stay finite in the step? */
static bool check_inputs(const Inputs *in, double h, Fault *fault) {
    const bool torque = input_stays_finite(in->tau, h);
    if (torque && input_stays_finite(in->F_ext, h)) return true;
    const double *u = torque ? in->F_ext : in->tau;
    snprintf(fault->text, sizeof fault->text,
             "step of %s s: %s = %s with the derivatives %s, %s, %s is not finite at its end; allowed are finite "
             "values",
             shortest_decimal(h).text, torque ? "F_ext" : "tau", shortest_decimal(u[0]).text,
             shortest_decimal(u[1]).text, shortest_decimal(u[2]).text, shortest_decimal(u[3]).text);
    return false;
}

static void undo(Mechanism *m, const State *state, const Inputs *inputs) {
    m->state = *state;
    m->inputs = *inputs;
    update_configuration(m);
    forget_cache(&m->cache);
}

/* Brings a failed step back to its start. Its texts are large: the function stands apart from the stack of a step. */
COLD NOINLINE static void refuse(Mechanism *m, Outcome outcome, double h, const State *state, const Inputs *inputs,
                                 Fault *fault) {
    char reason[REASON_SIZE];
    describe_reason(m, outcome, reason);
    undo(m, state, inputs);
    describe_failure(fault, m, h, reason);
}

/* ---- steps of the master ---- */

/* Tells the watcher of mode changes. */
typedef struct {
    StepVisitor visitor; /* first member: go_through() passes a pointer to it */
    Watcher *watcher;
} WatchingVisitor;

static double tell_of_decision(StepVisitor *visitor, const Mechanism *m, double left) {
    Watcher *watcher = ((WatchingVisitor *)visitor)->watcher;
    const int mode = (int)m->state.mode;
    if (watcher->mode == 0 || watcher->mode == mode || is_wedging(m)) return left;
    watcher->mode = mode;
    const double on = watcher->changed(watcher, left);
    watcher->cut += left - on;
    return on;
}

static bool tell_of_segment(StepVisitor *visitor, const Mechanism *m, const Segment *segment, const SegmentPast *past) {
    (void)m;
    if (segment->duration > 0.0) ((WatchingVisitor *)visitor)->watcher->mode = (int)past->mode;
    return true;
}

/* Makes the step segment by segment. `first`: the first segment, if it is known already, else NULL. */
static bool advance_by_segments(Mechanism *m, double h, const Segment *first, const LobattoHint *hint, Watcher *watcher,
                                Fault *fault) {
    const State state = m->state;
    const Inputs inputs = m->inputs;
    WatchingVisitor watching = {{.after_decision = tell_of_decision, .after_segment = tell_of_segment}, watcher};
    StepRun run = run_of(m, h, watcher != NULL ? &watching.visitor : NULL);
    Step step;
    begin_step(m, h, &step);
    m->cache.proposal = (StepProposal){INFINITY, 0}; /* a step depends on state and inputs only */
    run.goes_on = !is_closed_form(m);
    run.hint = *hint;
    if (first != NULL) carry_out(m, &run, first);
    const Outcome outcome = go_through(m, &run);
    if (outcome == OUTCOME_DONE) {
        if (watcher != NULL) step.h -= watcher->cut;
        forget_tunables(&m->state);
        m->state.step = step;
        return true;
    }
    refuse(m, outcome, h, &state, &inputs, fault);
    return false;
}

/* A step that is one segment in the mode of the latest step needs no decision. This is the common case. */
bool mechanism_advance(Mechanism *m, double h, Watcher *watcher, Fault *fault) {
    const bool constant = inputs_constant(&m->inputs);
    if (constant && rest_goes_on(m)) {
        remember_step(m, h);
        return true;
    }
    if (!constant && !check_inputs(&m->inputs, h, fault)) return false;
    const bool closed_form = constant ? m->model.closed_form : is_closed_form(m);
    Segment segment;
    LobattoHint hint = {.refused = true};
    const bool quiet = closed_form ? closed_form_slip_quiet(m, h, &segment) && segment_is_in_range(&segment)
                                   : collocation_slip_quiet(m, h, &hint, &segment);
    if (quiet && segment.duration == h) {
        remember_step(m, h);
        segment_apply(m, &segment);
        return true;
    }
    return advance_by_segments(m, h, quiet ? &segment : NULL, &hint, watcher, fault);
}

bool mechanism_go_through(Mechanism *m, double h, StepVisitor *visitor) {
    StepRun run = run_of(m, h, visitor);
    return go_through(m, &run) == OUTCOME_DONE;
}

/* ---- mode changes without time ---- */

/* A solver ends at a stop, or at speed zero, to the solver's own rounding, on either side. Sets angle and speed to the
 * exact values. */
static void land_where_it_is(Mechanism *m) {
    if (!is_slip(m->state.mode)) return;
    const int direction = direction_of(m->state.mode);
    if (direction * m->state.omega.hi <= 0.0) m->state.omega = sum_of(0.0);
    if (angle_to_stop(m, direction) <= AT_STOP * largest_angle(&m->params)) hit_stop(m, direction);
}

void mechanism_settle(Mechanism *m) {
    const Ledger before = m->state.ledger;
    if (m->continuous) land_where_it_is(m); /* in co-simulation the step has done so */
    StepRun run = run_of(m, 0.0, NULL);
    run.settles = true;
    (void)go_through(m, &run); /* at most one wedge, which takes the speed: no limit of a step is reached */
    if (m->continuous) m->state.ledger = before;
}
