/* Instances of the FMU, and random steps of them. */
#ifndef LIFECYCLE_RUN_H
#define LIFECYCLE_RUN_H

#include "scenes.h"

enum { REPLAY = 40, ORDERS = 3 };

/* ---- values by name ---- */

void set_real(fmi2Component c, const char *name, double value);
double get_real(fmi2Component c, const char *name);
int get_integer(fmi2Component c, const char *name);

/* ---- instances ---- */

/* Messages are counted and kept if `functions` is `callbacks`. */
fmi2Component instantiate_for(fmi2Type use, const fmi2CallbackFunctions *functions);
fmi2Component instantiate(const fmi2CallbackFunctions *functions);
/* Settings, then initialization mode and out of it. False if the FMU refuses the settings. */
bool begin(fmi2Component c, const Scene *scene);
/* A new instance after `begin`, which must not fail. */
fmi2Component begun(const Scene *scene);

/* Everything a reader can see that depends on the past, as bits. */
enum { REALS = 12 };
typedef struct {
    double real[REALS];
    int integer[2];
} Picture;

Picture picture(fmi2Component c);
bool same(const Picture *a, const Picture *b);

/* ---- random steps ---- */

/* One step of a random size under inputs that are held for a random number of steps. */
void random_step(fmi2Component c, double *time, const Scene *scene);
/* REPLAY random steps from this seed on; returns the picture after them. */
Picture replay(fmi2Component c, double time, const Scene *scene, uint64_t seed);

#endif
