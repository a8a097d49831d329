// A logger in C++ that throws: the exception goes through the FMU's call, and the instance goes on.
//
//     throwing_logger binary guid
#include <cstdio>
#include <stdexcept>

#include "fmi2Functions.h"
#include "library.h"

static void log_message(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String message, ...) {
    throw std::runtime_error(message);
}

template <typename Type> static Type *function(void *library, const char *name) {
    Type *const found = reinterpret_cast<Type *>(library_find(library, name));
    if (found == nullptr) throw std::logic_error(name);
    return found;
}

// The number of calls of a refused step and of a refused start that threw.
static int refusals(void *library, const char *guid) {
    const auto instantiate = function<fmi2InstantiateTYPE>(library, "fmi2Instantiate");
    const auto enter = function<fmi2EnterInitializationModeTYPE>(library, "fmi2EnterInitializationMode");
    const auto leave = function<fmi2ExitInitializationModeTYPE>(library, "fmi2ExitInitializationMode");
    const auto do_step = function<fmi2DoStepTYPE>(library, "fmi2DoStep");
    const auto release = function<fmi2FreeInstanceTYPE>(library, "fmi2FreeInstance");
    const fmi2CallbackFunctions callbacks = {log_message, nullptr, nullptr, nullptr, nullptr};
    int caught = 0;
    try {
        instantiate("cpp", fmi2CoSimulation, "another", nullptr, &callbacks, fmi2False, fmi2False);
    } catch (const std::runtime_error &) {
        caught++;
    }
    const fmi2Component c =
        instantiate("cpp", fmi2CoSimulation, guid, nullptr, &callbacks, fmi2False, fmi2False);
    if (c == nullptr || enter(c) != fmi2OK || leave(c) != fmi2OK) return -1;
    for (int k = 0; k < 100; k++) {
        try {
            do_step(c, 1e6, 1e-3, fmi2True);
        } catch (const std::runtime_error &) {
            caught++;
        }
        if (do_step(c, k * 1e-3, 1e-3, fmi2True) != fmi2OK) return -1;
    }
    release(c);
    return caught;
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    void *const library = library_open(argv[1]);
    if (library == nullptr) return 3;
    const int caught = refusals(library, argv[2]);
    std::printf("%d exceptions: %s\n", caught, caught == 101 ? "all as it must be" : "wrong");
    return caught == 101 ? 0 : 1;
}
