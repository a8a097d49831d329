#include "runs.h"

#include <string.h>

static int step3(const RunsCall *call, void *component) {
    bool needs_event = false, ends = false, is_early = false;
    double reached = 0.0;
    int status = call->function.step3(component, call->numbers[0], call->numbers[1], true, &needs_event, &ends,
                                      &is_early, &reached);
    return ends && status < (int)fmi2Discard ? (int)fmi2Discard : status;
}

static int make(const RunsCall *call, void *component, size_t run) {
    const RunsFunction *f = &call->function;
    void *values = call->line_size > 0 ? call->values + run * call->line_size : call->values;
    const double *numbers = call->numbers;
    switch ((RunsKind)call->kind) {
        case RUNS_PLAIN: return f->plain(component);
        case RUNS_STATE: return f->state(component, values);
        case RUNS_SET_UP2: return f->set_up2(component, call->has_tolerance, numbers[0], numbers[1], 0, 0.0);
        case RUNS_ENTER3: return f->enter3(component, call->has_tolerance != 0, numbers[0], numbers[1], false, 0.0);
        case RUNS_ACCESS2: return f->access2(component, call->references, call->count, values);
        case RUNS_ACCESS3: return f->access3(component, call->references, call->count, values, call->count);
        case RUNS_RATES2: return f->rates2(component, call->references, call->count, call->orders, values);
        case RUNS_STEP2: return f->step2(component, numbers[0], numbers[1], 1);
        case RUNS_STEP3: return step3(call, component);
        case RUNS_COPY: memcpy(call->target, values, call->count); return (int)fmi2OK;
    }
    return (int)fmi2Error;
}

void runs_make(const RunsCall calls[], size_t call_count, void *component, size_t first, size_t last, RunsEnd *end) {
    for (size_t run = first; run < last; run++) {
        int worst = (int)fmi2OK;
        for (size_t k = 0; k < call_count; k++) {
            int status = make(&calls[k], component, run);
            if (status > worst) worst = status;
            if (status <= (int)fmi2Warning) continue;
            *end = (RunsEnd){run, k, status};
            return;
        }
        if (worst == (int)fmi2OK) continue;
        *end = (RunsEnd){run + 1, 0, worst};
        return;
    }
    *end = (RunsEnd){last, 0, (int)fmi2OK};
}
