/* One instance of the FMU under the fuzzer, and what the checks know about it. */
#ifndef FUZZ_RUN_H
#define FUZZ_RUN_H

#include <stdio.h>
#include <stdlib.h>

#include "bytes.h"
#include "fmi/variables.h" /* value references VR_..., names and limits */

typedef enum { USE_CO_SIMULATION, USE_MODEL_EXCHANGE, USE_HYBRID, USES } Use;

/* Ends the program, which the fuzzer then reports with its input, where `condition` is not true. */
#define REQUIRE(run, condition)                                                                                        \
    do {                                                                                                               \
        if (!(condition)) require_failed(run, __FILE__, __LINE__, #condition);                                         \
    } while (0)

enum { LONGEST_MESSAGE = 1200, SLOTS = 2, MAX_REFERENCES = 8 };

/* The energies that a step turns over, for the check that their sum is kept. */
typedef struct {
    bool known; /* those of the latest communication point */
    double turned_over, force, rounding;
    double flow[16];
} Account;

/* A saved FMU state, and what belongs to it outside of the FMU. */
typedef struct {
    void *state;
    double time;
    Account account;
} Slot;

typedef struct {
    Bytes in;
    void *c; /* the instance */
    Use use;
    unsigned options; /* of the instance, see call_instantiate() */
    double time;      /* s, that of the FMU */
    double begin;     /* s, of the latest step, as the master gave it: it may differ from the FMU's by rounding */
    double tolerance; /* relative */
    bool wild;        /* numbers of no plausible size have been set, so energies may have lost their digits */
    bool forged;      /* a forged state acts: its numbers are not compared with one another (fmu_state.c) */
    bool inside;      /* inside a step, called by the FMU */
    bool event;       /* the latest step of co-simulation asks for event mode */
    bool logs;        /* errors are logged */
    int messages;     /* logged so far */
    int explained;    /* refused calls that each have logged one message */
    char message[LONGEST_MESSAGE];
    void *before; /* FMU state before the present call */
    Slot slot[SLOTS];
    Account account;
} Run;

_Noreturn void require_failed(const Run *run, const char *file, int line, const char *condition);

/* Is there a variable with this value reference? */
static inline bool has_variable(unsigned vr) {
    return variable_find(vr) != NULL;
}

/* The folder for files of tables: of the environment variable FUZZ_DIRECTORY, else the current one. */
const char *directory(void);
void write_file(const char *name, const void *content, size_t size);

#endif
