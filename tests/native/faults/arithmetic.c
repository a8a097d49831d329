/* Rounding, flushing of small numbers to zero, and traps of the host. */
#define _GNU_SOURCE /* feenableexcept() */
#include "faults.h"

#include <fenv.h>

#include "fmi3Functions.h"
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

typedef struct {
    const char *name;
    int rounding;
    int traps;
    unsigned flushing; /* bits of the control register of SSE */
} Arithmetic;

static const int ERRORS = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;
static const unsigned TO_ZERO = 0x8040; /* FTZ and DAZ */

static Arithmetic chosen = {"usual", FE_TONEAREST, 0, 0};
static fenv_t usual;

static unsigned control_of_sse(void) {
#ifdef __SSE2__
    return _mm_getcsr() & ~0x3Fu; /* without the flags of past operations */
#else
    return 0;
#endif
}

static void choose(void) {
    REQUIRE(fegetenv(&usual) == 0);
    REQUIRE(fesetround(chosen.rounding) == 0);
#ifdef __SSE2__
    _mm_setcsr(_mm_getcsr() | chosen.flushing);
#endif
    feclearexcept(FE_ALL_EXCEPT);
    REQUIRE(feenableexcept(chosen.traps) != -1);
}

static unsigned control_at_start;
static long updates; /* of the master inside steps */

static void choose_and_note(void) {
    choose();
    control_at_start = control_of_sse();
}

static bool is_as_chosen(void) {
    return fegetround() == chosen.rounding && fegetexcept() == chosen.traps;
}

static void check_and_restore(void) {
    const bool unchanged = is_as_chosen() && control_of_sse() == control_at_start;
    fedisableexcept(FE_ALL_EXCEPT);
    REQUIRE(fesetenv(&usual) == 0);
    if (unchanged) return;
    fprintf(stderr, "faults: the FMU has changed the host's arithmetic (%s)\n", chosen.name);
    exit(1);
}

/* The intermediate update of FMI 3.0: the master is in its own arithmetic while it has control. */
static void look(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean sets, fmi3Boolean gets,
                 fmi3Boolean finished, fmi3Boolean may_end, fmi3Boolean *ends, fmi3Float64 *end_time) {
    (void)environment, (void)time, (void)sets, (void)gets, (void)finished, (void)may_end, (void)end_time;
    updates++;
    REQUIRE(is_as_chosen());
    *ends = false;
}

static Picture under(Arithmetic arithmetic, Picture (*run)(const Scene *), const Scene *scene) {
    chosen = arithmetic;
    before_call = choose_and_note, after_call = check_and_restore;
    const Picture end = run(scene);
    before_call = after_call = NULL;
    chosen = (Arithmetic){"usual", FE_TONEAREST, 0, 0};
    return end;
}

static void compare(const Scene *scene, const char *kind, Picture (*run)(const Scene *)) {
    const Arithmetic all[] = {
        {"upward", FE_UPWARD, 0, 0},
        {"downward", FE_DOWNWARD, 0, 0},
        {"toward zero", FE_TOWARDZERO, 0, 0},
#ifdef __SSE2__
        {"small numbers to zero", FE_TONEAREST, 0, TO_ZERO},
#endif
        {"traps", FE_TONEAREST, ERRORS, 0},
    };
    const Picture expected = run(scene);
    messages = 0;
    for (size_t i = 0; i < COUNT_OF(all); i++) {
        const Picture found = under(all[i], run, scene);
        messages = 0;
        if (same(&found, &expected)) continue;
        printf("%s, %s: other numbers under %s\n", scene->name, kind, all[i].name);
        exit(1);
    }
}

void check_arithmetic(void) {
    size_t count;
    const Scene *scene = possible_scenes(&count);
    for (size_t i = 0; i < count; i++) {
        compare(&scene[i], "co-simulation", life);
        compare(&scene[i], "model exchange", exchanged_life);
        if (!is_fmi3()) continue;
        intermediate_update = (void (*)(void))look;
        compare(&scene[i], "intermediate updates", life);
        intermediate_update = NULL;
    }
    REQUIRE(!is_fmi3() || updates > 0);
}
