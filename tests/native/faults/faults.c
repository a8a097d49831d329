/* An FMU's binary in a host that does not help.
 *
 *     faults directory check binary name=reference ...
 *
 * with a directory to write tables into, the name of a check of faults.h, and the value references of
 * modelDescription.xml. The environment variable MODEL_GUID is the GUID or token of the FMU. Exits with 0, or with 1 at
 * the first thing that is not as it must be. Linked with the files of ../lifecycle but its main program. */
#include "faults.h"

#include <string.h>

static const struct {
    const char *name;
    void (*run)(void);
} checks[] = {
    {"arithmetic", check_arithmetic}, {"memory", check_memory},   {"stack", check_stack},
    {"loggers", check_loggers},       {"threads", check_threads}, {"locale", check_locale},
};

int main(int argc, char **argv) {
    if (argc < 5) return 2;
    use_command_line(argc, argv);
    open_fmu(argv[3]);
    write_tables();
    for (size_t i = 0; i < COUNT_OF(checks); i++) {
        if (strcmp(checks[i].name, argv[2]) != 0) continue;
        checks[i].run();
        printf("%s: all as it must be\n", argv[2]);
        return 0;
    }
    fprintf(stderr, "faults: no check %s\n", argv[2]);
    return 2;
}
