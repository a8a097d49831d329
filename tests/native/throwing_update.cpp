// An intermediate update of FMI 3.0 in C++ that throws: the exception goes through the FMU's step. The instance stays
// inside its step for good: further steps, a reset and freeing are refused. Other instances go on.
//
//     throwing_update binary token
#include <cstdio>
#include <stdexcept>

#include "fmi3Functions.h"
#include "library.h"

static bool throws;

static int messages;

static void log_message(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String) {
    messages++;
}

static void update(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                   fmi3Boolean *, fmi3Float64 *) {
    if (throws) throw std::runtime_error("intermediate update");
}

template <typename Type> static Type *function(void *library, const char *name) {
    Type *const found = reinterpret_cast<Type *>(library_find(library, name));
    if (found == nullptr) throw std::logic_error(name);
    return found;
}

struct Fmu {
    fmi3InstantiateCoSimulationTYPE *instantiate;
    fmi3EnterInitializationModeTYPE *enter;
    fmi3ExitInitializationModeTYPE *leave;
    fmi3DoStepTYPE *do_step;
    fmi3ResetTYPE *reset;
    fmi3FreeInstanceTYPE *release;
};

static fmi3Status step(const Fmu &fmu, fmi3Instance c, double time) {
    fmi3Boolean event, terminate, early;
    fmi3Float64 reached;
    return fmu.do_step(c, time, 1e-3, fmi3True, &event, &terminate, &early, &reached);
}

// Whether an instance whose update throws behaves as the first comment says.
static bool life(const Fmu &fmu, const char *token) {
    const fmi3Instance c = fmu.instantiate("cpp", token, nullptr, fmi3False, fmi3True, fmi3False, fmi3False, nullptr, 0,
                                           nullptr, log_message, update);
    throws = false;
    bool good = c != nullptr && fmu.enter(c, fmi3False, 0.0, 0.0, fmi3False, 0.0) == fmi3OK && fmu.leave(c) == fmi3OK &&
                step(fmu, c, 0.0) == fmi3OK;
    throws = true;
    try {
        step(fmu, c, 1e-3);
        good = false;
    } catch (const std::runtime_error &) {
    }
    messages = 0;
    good = good && step(fmu, c, 1e-3) == fmi3Error && fmu.reset(c) == fmi3Error;
    fmu.release(c);
    return good && messages == 3;
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    void *const library = library_open(argv[1]);
    if (library == nullptr) return 3;
    const Fmu fmu = {function<fmi3InstantiateCoSimulationTYPE>(library, "fmi3InstantiateCoSimulation"),
                     function<fmi3EnterInitializationModeTYPE>(library, "fmi3EnterInitializationMode"),
                     function<fmi3ExitInitializationModeTYPE>(library, "fmi3ExitInitializationMode"),
                     function<fmi3DoStepTYPE>(library, "fmi3DoStep"),
                     function<fmi3ResetTYPE>(library, "fmi3Reset"),
                     function<fmi3FreeInstanceTYPE>(library, "fmi3FreeInstance")};
    int good = 0;
    for (int k = 0; k < 100; k++) good += life(fmu, argv[2]);
    std::printf("%d of 100 lives: %s\n", good, good == 100 ? "all as it must be" : "wrong");
    return good == 100 ? 0 : 1;
}
