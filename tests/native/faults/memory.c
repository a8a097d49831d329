/* No memory at the n-th allocation, for each n. */
#include <string.h>

#include "allocations.h"
#include "faults.h"

enum { ALLOCATIONS_MAX = 2000, STEPS = 8 };

static bool reached; /* the allocation that fails */

/* fopen() needs memory, too, and does not tell what it lacked. */
static bool gives_reason(void) {
    return strstr(latest_message, "memory") != NULL || strstr(latest_message, "cannot be opened") != NULL;
}

/* False where the call was refused for want of memory, with one message that says so. The call is then made again, with
 * memory. */
static bool carried_out(fmi2Status status) {
    if (status == fmi2OK) return true;
    REQUIRE(status == fmi2Error && allocation_failed() && messages == 1 && gives_reason());
    reached = true;
    fail_allocation(0, false);
    messages = 0;
    return false;
}

static fmi2Component patient_instance(void) {
    char location[PATH];
    snprintf(location, sizeof location, "file://%s", directory());
    for (;;) {
        const fmi2Component c =
            fmi2Instantiate("memory", fmi2CoSimulation, MODEL_GUID, location, &callbacks, fmi2False, fmi2False);
        if (carried_out(c != NULL ? fmi2OK : fmi2Error)) return c;
    }
}

static void patient_start(fmi2Component c, const Scene *scene) {
    if (!carried_out(begin(c, scene) ? fmi2OK : fmi2Error)) REQUIRE(fmi2ExitInitializationMode(c) == fmi2OK);
}

/* The state of `c`, as bytes, in `other`, which goes on as before where the state is refused. */
static void patient_copy(fmi2Component c, fmi2Component other) {
    fmi2FMUstate state = NULL, other_state = NULL;
    static fmi2Byte bytes[1 << 15];
    size_t size = 0;
    while (!carried_out(fmi2GetFMUstate(c, &state))) REQUIRE(state == NULL);
    REQUIRE(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK && size <= sizeof bytes);
    REQUIRE(fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK);
    while (!carried_out(fmi2DeSerializeFMUstate(other, bytes, size, &other_state))) REQUIRE(other_state == NULL);
    const Picture before = picture(other);
    while (!carried_out(fmi2SetFMUstate(other, other_state))) {
        const Picture now = picture(other);
        REQUIRE(same(&now, &before));
    }
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && fmi2FreeFMUstate(other, &other_state) == fmi2OK);
}

static void steps_of(fmi2Component c, const Scene *scene) {
    double time = 0.0;
    random_state = 1;
    for (int i = 0; i < STEPS; i++) random_step(c, &time, scene);
}

/* A life in two instances, whose n-th allocation fails. */
static Picture life_without(long n, bool lasting, const Scene *scene) {
    reached = false;
    fail_allocation(n, lasting);
    const fmi2Component c = patient_instance();
    patient_start(c, scene);
    steps_of(c, scene);
    const fmi2Component other = patient_instance();
    patient_start(other, scene_called("default"));
    patient_copy(c, other);
    const Picture there = picture(other), here = picture(c);
    REQUIRE(same(&there, &here));
    REQUIRE(fmi2Reset(c) == fmi2OK);
    patient_start(c, scene);
    steps_of(c, scene);
    const Picture again = picture(c);
    REQUIRE(same(&again, &here) && messages == 0);
    fmi2FreeInstance(c);
    fmi2FreeInstance(other);
    return again;
}

/* Returns the number of allocations. */
static long check_scene(const Scene *scene, bool lasting) {
    const Picture expected = life_without(0, false, scene);
    const long blocks = blocks_in_use();
    for (long n = 1; n <= ALLOCATIONS_MAX; n++) {
        const Picture found = life_without(n, lasting, scene);
        REQUIRE(same(&found, &expected) && blocks_in_use() == blocks);
        if (!reached) return n - 1;
    }
    REQUIRE(!"the scene has an end of allocations");
    return 0;
}

/* The scenes with tables make the allocations of all others, and more. */
void check_memory(void) {
    size_t count;
    const Scene *scene = possible_scenes(&count);
    long all = 0;
    for (size_t i = 0; i < count; i++) {
        const char *name = scene[i].name;
        const bool reads_or_builds = strstr(name, "table") != NULL || strstr(name, "ellipses") != NULL;
        if (!reads_or_builds || strstr(name, "shaft") != NULL) continue; /* steps of an elastic shaft are long */
        all += check_scene(&scene[i], false) + check_scene(&scene[i], true);
    }
    printf("%ld allocations failed\n", all);
}
