#include "contact/check.h"

#include <stdio.h>

#include "geometry/transmission_build.h"
#include "model/csv_file.h"
#include "model/friction_law.h"

bool check_initial(const Params *p, Fault *fault) {
    if (p->initial.theta >= p->stop.lower && p->initial.theta <= p->stop.upper) return true;
    const bool below = p->initial.theta < p->stop.lower;
    snprintf(fault->text, sizeof fault->text, "initial.theta = %s must be %s %s = %s",
             shortest_decimal(p->initial.theta).text, below ? ">=" : "<=", below ? "stop.lower" : "stop.upper",
             shortest_decimal(below ? p->stop.lower : p->stop.upper).text);
    return false;
}

/* ---- friction law ---- */

/* The variable that makes friction depend on the speed. */
static void name_speed_law(char text[QUOTED_PATH + 40], const CamParams *cam, int i) {
    const FrictionParams *law = &cam->law;
    if (law->table)
        snprintf(text, QUOTED_PATH + 40, "cam%d.friction_table = \"%.*s\"", i + 1,
                 csv_quoted(law->table->path, QUOTED_PATH), law->table->path);
    else if (law->viscous > 0.0)
        snprintf(text, QUOTED_PATH + 40, "cam%d.friction_viscous = %s", i + 1, shortest_decimal(law->viscous).text);
    else snprintf(text, QUOTED_PATH + 40, "cam%d.friction_peak = %s", i + 1, shortest_decimal(law->peak).text);
}

bool check_speed_friction(const Params *p, const char *cause, const char *remedy, Fault *fault) {
    for (int i = 0; i < 2; i++) {
        if (!friction_depends_on_speed(&p->cam[i])) continue;
        char variable[QUOTED_PATH + 40];
        name_speed_law(variable, &p->cam[i], i);
        snprintf(fault->text, sizeof fault->text,
                 "%s %s: friction that varies with the sliding speed needs an inertia; allowed is friction that does "
                 "not vary with the speed, or %s",
                 variable, cause, remedy);
        return false;
    }
    return true;
}

bool check_damped_load(const Params *p, const char *remedy, Fault *fault) {
    const DamperParams *d = &p->damper;
    if (d->c_load + d->q_load + d->c_release + d->q_release == 0.0 || !any_friction_depends_on_load(p)) return true;
    const int i = friction_depends_on_load(&p->cam[0]) ? 0 : 1;
    snprintf(fault->text, sizeof fault->text,
             "cam%d.friction_load_exponent = %s with a damper and without inertia: the damper's force would change the "
             "friction with the speed; allowed is damper.* = 0, friction that does not depend on the load, or %s",
             i + 1, shortest_decimal(p->cam[i].law.load_exponent).text, remedy);
    return false;
}

/* ---- transmission ---- */

bool check_transmission(const Params *p, const char *resources, double F_ext, TransmissionCheck *check,
                        Transmission *transmission, Fault *fault) {
    if (transmission_is_of(transmission, p)) return check(p, transmission, F_ext, fault);
    Transmission made;
    if (!transmission_build(&made, p, resources, fault)) return false;
    const bool good = check(p, &made, F_ext, fault);
    transmission_free(good ? transmission : &made);
    if (good) *transmission = made;
    return good;
}
