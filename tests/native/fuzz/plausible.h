/* Values as a designer or a master would choose them, over some decades. With these alone the energies of a run must
 * add up. */
#ifndef FUZZ_PLAUSIBLE_H
#define FUZZ_PLAUSIBLE_H

#include "run.h"

/* Sets one parameter or input of the input's choice. */
bool set_plausible(Run *run);
/* Sets the file of cam 1 or 2 as a groove table. */
bool set_groove_table(Run *run, unsigned cam, const char *file);
/* Sets the inputs of the FMU. */
void set_plausible_inputs(Run *run);

/* The files that names of tables may stand for. */
void write_tables(void);
/* The name of a file, there or not. */
const char *take_file_name(Run *run);

#endif
