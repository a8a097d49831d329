/* Loggers that do not return, and loggers that call the instance. */
#include "allocations.h"
#include "faults.h"

#include <math.h>
#include <setjmp.h>

#include "fmi3Functions.h"

static jmp_buf way_out;
static fmi2Component calling; /* the instance that its logger and its update call */
static bool disturbed;        /* its next step is to be refused */

static void leave(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                  fmi2String message, ...) {
    (void)environment, (void)instance, (void)status, (void)category, (void)message;
    longjmp(way_out, 1);
}

static void call_back(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                      fmi2String message, ...) {
    (void)environment, (void)instance, (void)status, (void)category, (void)message;
    messages++;
    if (calling != NULL) (void)picture(calling);
}

static const fmi2CallbackFunctions leaving = {leave, NULL, NULL, NULL, NULL};
static const fmi2CallbackFunctions calling_back = {call_back, NULL, NULL, NULL, NULL};

/* ---- refused calls ---- */

static void set_nan(fmi2Component c) {
    const fmi2ValueReference vr = reference("F_ext");
    const double nothing = NAN;
    (void)fmi2SetReal(c, &vr, 1, &nothing);
}

static void step_elsewhere(fmi2Component c) {
    (void)fmi2DoStep(c, 1e6, 1e-3, fmi2True);
}

static void restore_nothing(fmi2Component c) {
    (void)fmi2SetFMUstate(c, NULL);
}

static void read_damaged_state(fmi2Component c) {
    fmi2FMUstate state = NULL;
    (void)fmi2DeSerializeFMUstate(c, "damaged", 7, &state);
}

/* Outputs of the inverse FMU depend on the tuned friction. */
static void jam(fmi2Component c) {
    const fmi2ValueReference vr[] = {reference("cam1.friction"), reference("cam2.friction")};
    const double friction[] = {1.8, 1.8};
    (void)fmi2SetReal(c, vr, COUNT_OF(vr), friction);
}

/* In FMI 3.0 the master has set a torque inside the step whose derivatives overflow. */
static void set_huge_torque(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean sets, fmi3Boolean gets,
                            fmi3Boolean finished, fmi3Boolean may_end, fmi3Boolean *ends, fmi3Float64 *end_time) {
    (void)environment, (void)time, (void)gets, (void)finished, (void)may_end, (void)end_time;
    *ends = false;
    if (sets && disturbed) set_real(calling, "tau", 1e308);
}

static void step_under_huge_torque(fmi2Component c) {
    if (intermediate_update == NULL) {
        step_elsewhere(c);
        return;
    }
    disturbed = true;
    (void)fmi2DoStep(c, 0.0, 1e-3, fmi2True);
}

static void (*const refused_calls[])(fmi2Component c) = {
    set_nan, step_elsewhere, restore_nothing, read_damaged_state, jam, step_under_huge_torque};

/* The logger must leave the call. */
static void leave_call(void (*call)(fmi2Component), fmi2Component c) {
    if (setjmp(way_out) == 0) {
        call(c);
        REQUIRE(!"the logger was called");
    }
}

static void check_calls(const fmi2CallbackFunctions *functions, const Scene *scene) {
    const fmi2Component c = instantiate(functions), undisturbed = instantiate(&callbacks);
    REQUIRE(begin(c, scene) && begin(undisturbed, scene));
    calling = c;
    for (size_t i = 0; i < COUNT_OF(refused_calls); i++) {
        double time = 0.0;
        if (functions == &leaving) leave_call(refused_calls[i], c);
        else refused_calls[i](c);
        disturbed = false;
        REQUIRE(fmi2Reset(undisturbed) == fmi2OK && begin(undisturbed, scene));
        const Picture expected = replay(undisturbed, 0.0, scene, 1);
        random_state = 1;
        for (int k = 0; k < REPLAY; k++) random_step(c, &time, scene);
        const Picture found = picture(c);
        REQUIRE(same(&found, &expected));
        REQUIRE(fmi2Reset(c) == fmi2OK && begin(c, scene));
    }
    calling = NULL;
    fmi2FreeInstance(undisturbed);
    fmi2FreeInstance(c);
}

/* A start that is refused for a table, and a call that gives no instance. */
static void begin_without_table(fmi2Component c) {
    size_t count;
    const Scene *without = possible_scenes(&count) + count;
    (void)begin(c, without);
}

static void instantiate_another_fmu(fmi2Component c) {
    (void)c;
    (void)fmi2Instantiate("logger", fmi2CoSimulation, "another", NULL, &leaving, fmi2False, fmi2False);
}

static void check_starts(void) {
    const fmi2Component c = instantiate(&leaving);
    leave_call(begin_without_table, c);
    leave_call(instantiate_another_fmu, NULL);
    REQUIRE(fmi2Reset(c) == fmi2OK && begin(c, scene_called("default")));
    fmi2FreeInstance(c);
}

void check_loggers(void) {
    const long blocks = blocks_in_use();
    if (is_fmi3() && !is_inverse()) intermediate_update = (void (*)(void))set_huge_torque;
    check_calls(&leaving, scene_called("default"));
    check_calls(&leaving, scene_called("ellipses"));
    check_calls(&calling_back, scene_called("ellipses"));
    check_starts();
    intermediate_update = NULL;
    REQUIRE(blocks_in_use() == blocks);
}
