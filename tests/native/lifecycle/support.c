#include "support.h"

#include <string.h>

static int arguments;
static char **argument;

void use_command_line(int argc, char **argv) { arguments = argc, argument = argv; }

const char *directory(void) { return argument[1]; }

bool find_reference(const char *name, fmi2ValueReference *found) {
    const size_t length = strlen(name);
    for (int i = 2; i < arguments; i++) {
        if (strncmp(argument[i], name, length) != 0 || argument[i][length] != '=') continue;
        *found = (fmi2ValueReference)strtoul(argument[i] + length + 1, NULL, 10);
        return true;
    }
    return false;
}

fmi2ValueReference reference(const char *name) {
    fmi2ValueReference found = 0;
    if (find_reference(name, &found)) return found;
    fprintf(stderr, "lifecycle: no value reference given for %s\n", name);
    exit(1);
}

bool is_inverse(void) {
    fmi2ValueReference found;
    return find_reference("shaft.stiffness", &found);
}

_Thread_local char latest_message[LONGEST_MESSAGE] = "none";
_Thread_local int messages;

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String message, ...) {
    (void)environment, (void)status;
    snprintf(latest_message, sizeof latest_message, "%s [%s]: %s", instance, category, message);
    messages++;
}

const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
const fmi2CallbackFunctions no_callbacks = {NULL, NULL, NULL, NULL, NULL};

_Thread_local uint64_t random_state = 88172645463325252u;
double random_in(double low, double high) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}

bool chance(double share) { return random_in(0.0, 1.0) < share; }

void write_table(const char *name, double slope, double bend) {
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", directory(), name);
    FILE *file = fopen(path, "w");
    REQUIRE(file != NULL);
    fprintf(file, "psi_rad,z_m\n");
    for (int k = -20; k <= 20; k++)
        fprintf(file, "%.17g,%.17g\n", 0.1 * k, slope * 0.1 * k + bend * 0.01 * k * k);
    REQUIRE(fclose(file) == 0);
}

void write_text(const char *name, const char *text) {
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", directory(), name);
    FILE *file = fopen(path, "w");
    REQUIRE(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

void remove_table(const char *name) {
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", directory(), name);
    REQUIRE(remove(path) == 0);
}
