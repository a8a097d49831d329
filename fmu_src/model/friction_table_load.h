/* Friction tables from CSV files. Header `v_m_s,mu`: sliding speed in m/s and friction coefficient. Header
 * `v_m_s,R_N,mu`: nominal load of one contact in N between both; all lines of the first load, then those of the next,
 * larger one, with the same speeds. The first speed is 0; speeds increase strictly; 0 < mu <= 10. */
#ifndef DUALCAM_FRICTION_TABLE_LOAD_H
#define DUALCAM_FRICTION_TABLE_LOAD_H

#include <stdbool.h>

#include "model/fault.h"
#include "model/friction_table.h"
#include "model/params.h"

/* The tables of both cams; NULL: none. */
typedef struct {
    FrictionTable *table[2]; /* owned */
} FrictionTables;

/* Reads the files that params->friction_table names, relative to the directory `resources` (NULL: there is none); a
 * table that `now` holds is not read again. Points params->cam[].law.table to them. Returns false, with the reason in
 * `fault`, if a file is refused; nothing has changed then. Else friction_tables_settle() must follow. */
bool friction_tables_load(Params *params, const FrictionTables *now, const char *resources, FrictionTables *made,
                          Fault *fault);

/* *made replaces *now if the parameters are `accepted`; else all is as before friction_tables_load(). */
void friction_tables_settle(Params *params, FrictionTables *now, FrictionTables *made, bool accepted);

/* Safe on zeroed tables, and twice. */
void friction_tables_free(FrictionTables *tables);

#endif
