/* Scenes: settings of the FMU, and how large its inputs are. */
#ifndef LIFECYCLE_SCENES_H
#define LIFECYCLE_SCENES_H

#include "support.h"

enum { MAX_SETTINGS = 16 };

typedef struct {
    const char *name;
    double value;
    const char *text; /* of a text variable */
} Setting;

typedef struct {
    const char *name;
    double torque;   /* N.m, amplitude; inverse: N, of the axial force */
    bool polynomial; /* inputs with derivatives up to the third */
    Setting settings[MAX_SETTINGS];
} Scene;

/* All scenes of the FMU. The last one is of a table that does not exist. */
const Scene *scenes(size_t *count);
/* Ends the program if there is no such scene. */
const Scene *scene_called(const char *name);
/* Writes the tables that the scenes name. */
void write_tables(void);
/* Value of a setting of the scene, or `otherwise` if it has none of that name. */
double setting_of(const Scene *scene, const char *name, double otherwise);

#endif
