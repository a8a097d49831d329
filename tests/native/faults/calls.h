/* The binary of an FMU behind the functions of FMI 2.0, which the files of ../lifecycle call. A binary of FMI 3.0 is
 * called by the functions of FMI 3.0 that do the same. */
#ifndef FAULTS_CALLS_H
#define FAULTS_CALLS_H

#include <stdbool.h>

#include "fmi2Functions.h"

/* Ends the program if the file is no FMU's binary. */
void open_fmu(const char *path);
bool is_fmi3(void);

/* Called around each call into the binary, unless NULL: what the host is like while the FMU works. */
extern void (*before_call)(void), (*after_call)(void);

/* Instances of FMI 3.0 from here on have an intermediate update (NULL: none). */
extern void (*intermediate_update)(void);

#endif
