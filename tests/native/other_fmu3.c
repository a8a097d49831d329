/* An FMU of FMI 3.0 that is no cam: one variable of each of several types, and a clock x that ends the simulation
   when x is above 1 s. The file needs no header of FMI. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK = 0, ERROR = 3 };

typedef void (*Log)(void *environment, int status, const char *category, const char *message);

typedef struct Model {
    Log log;
    void *environment;
    double x;
    float single;
    int8_t small;
    uint64_t large;
    int64_t choice;
    bool flag;
    char text[64];
} Model;

static void set_start_values(Model *m) {
    m->x = 0.0;
    m->single = 1.5f;
    m->small = -3;
    m->large = 7;
    m->choice = 1;
    m->flag = false;
    strcpy(m->text, "start");
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                         bool logging, bool events, bool early, const unsigned *required, size_t count,
                                         void *environment, Log log, void *update) {
    (void)visible, (void)logging, (void)required, (void)update;
    size_t length = strlen(resources);
    if (!*name || strcmp(token, "other") != 0 || events || early || count != 0 || resources[length - 1] != '/') {
        log(environment, ERROR, "logStatusError", "what was given is not 100 % as FMI 3.0 says");
        return NULL;
    }
    Model *m = malloc(sizeof *m);
    if (m) {
        m->log = log;
        m->environment = environment;
        set_start_values(m);
    }
    return m;
}

EXPORT void fmi3FreeInstance(void *m) {
    free(m);
}

EXPORT int fmi3Reset(void *m) {
    set_start_values(m);
    return OK;
}

EXPORT int fmi3EnterInitializationMode(void *m, bool has_tolerance, double tolerance, double start, bool has_stop,
                                       double stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((Model *)m)->x = start;
    return OK;
}

EXPORT int fmi3ExitInitializationMode(void *m) {
    (void)m;
    return OK;
}

EXPORT int fmi3DoStep(void *instance, double time, double size, bool no_return, bool *event, bool *ends, bool *early,
                      double *reached) {
    Model *m = instance;
    (void)no_return;
    m->x = time + size;
    *event = *early = false;
    *ends = m->x > 1.0;
    *reached = m->x;
    return OK;
}

#define ACCESS(Name, Type, field)                                                                                      \
    EXPORT int fmi3Get##Name(void *m, const unsigned *references, size_t n, Type *values, size_t count) {              \
        (void)references;                                                                                              \
        if (n != 1 || count != 1) return ERROR;                                                                        \
        values[0] = ((Model *)m)->field;                                                                               \
        return OK;                                                                                                     \
    }                                                                                                                  \
    EXPORT int fmi3Set##Name(void *m, const unsigned *references, size_t n, const Type *values, size_t count) {        \
        (void)references;                                                                                              \
        if (n != 1 || count != 1) return ERROR;                                                                        \
        ((Model *)m)->field = values[0];                                                                               \
        return OK;                                                                                                     \
    }

ACCESS(Float64, double, x)
ACCESS(Float32, float, single)
ACCESS(Int8, int8_t, small)
ACCESS(UInt64, uint64_t, large)
ACCESS(Int64, int64_t, choice)
ACCESS(Boolean, bool, flag)

EXPORT int fmi3GetString(void *m, const unsigned *references, size_t n, const char **values, size_t count) {
    (void)references;
    if (n != 1 || count != 1) return ERROR;
    values[0] = ((Model *)m)->text;
    return OK;
}

EXPORT int fmi3SetString(void *m, const unsigned *references, size_t n, const char *const *values, size_t count) {
    (void)references;
    if (n != 1 || count != 1 || strlen(values[0]) >= sizeof((Model *)m)->text) return ERROR;
    strcpy(((Model *)m)->text, values[0]);
    return OK;
}
