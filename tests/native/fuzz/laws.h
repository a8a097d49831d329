/* What must hold for every run, whatever its mechanism. */
#ifndef FUZZ_LAWS_H
#define FUZZ_LAWS_H

#include "run.h"

/* All numbers that the FMU can be asked for are numbers, in the present phase. */
void check_values(Run *run);
/* After a step of h seconds: the angle is between the stops; energies add up; no heat falls. */
void check_energies(Run *run, double h);
/* The energies of the next check are counted from now on. */
void restart_account(Run *run);

#endif
