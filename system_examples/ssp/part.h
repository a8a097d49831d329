/* What a part of a system is: values of named variables and a way to advance them.
 *
 * part_variables.h is written by compilation.py from the part's table: an enum with an index for each variable,
 * and VARIABLES. All of a part's state is in its values. The parts know nothing of FMI; fmi2.c wraps them.
 */
#ifndef PART_H
#define PART_H

#define PI 3.14159265358979323846 /* C17 has none */

/* At the start: outputs from parameters alone, so that they do not depend on how a master passes on first values. */
void part_initialize(double v[]);

/* Over [time, time + step] with the inputs as they are; NULL, or why it cannot be done. */
const char *part_step(double v[], double time, double step);

#endif
