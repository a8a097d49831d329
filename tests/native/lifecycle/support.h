/* What every part of the lifecycle test uses: command line, messages, random numbers and files of tables. */
#ifndef LIFECYCLE_SUPPORT_H
#define LIFECYCLE_SUPPORT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

/* Ends the program with 1 and a message where `condition` is not true. */
#define REQUIRE(condition)                                                                                     \
    do {                                                                                                       \
        if (!(condition)) {                                                                                    \
            fprintf(stderr, "%s:%d: not true: %s (latest message: %s)\n", __FILE__, __LINE__, #condition,      \
                    latest_message);                                                                           \
            exit(1);                                                                                           \
        }                                                                                                      \
    } while (0)
#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])

enum { PATH = 1024, LONGEST_MESSAGE = 512 };

/* ---- the command line ---- */

void use_command_line(int argc, char **argv);
const char *directory(void); /* for tables */
/* False without `name=reference` on the command line. */
bool find_reference(const char *name, fmi2ValueReference *found);
/* Ends the program without `name=reference` on the command line. */
fmi2ValueReference reference(const char *name);
/* Is the FMU that of inverse dynamics? */
bool is_inverse(void);

/* ---- messages of the FMU ---- */

extern _Thread_local char latest_message[LONGEST_MESSAGE];
extern _Thread_local int messages; /* since they were last set to 0 */
extern const fmi2CallbackFunctions callbacks, no_callbacks;

/* ---- random numbers: xorshift64, the same ones on every machine ---- */

extern _Thread_local uint64_t random_state;
double random_in(double low, double high);
/* True with a probability of `share`. */
bool chance(double share);

/* ---- tables ---- */

/* z = slope psi + bend psi^2 in metres, on [-2, 2] rad */
void write_table(const char *name, double slope, double bend);
void write_text(const char *name, const char *text);
void remove_table(const char *name);

#endif
