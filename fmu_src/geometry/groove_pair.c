#include "geometry/groove_pair.h"

#include <math.h>
#include <stdio.h>

#include "geometry/pin_position.h"
#include "model/csv_file.h"
#include "numerics/tolerances.h"

/* The parameter that decides the shape of a groove, as "cam1.ellipse_a = 0.05". */
typedef struct {
    char text[QUOTED_PATH + 32];
} ParameterText;

static ParameterText parameter_text(const Groove *groove, int i) {
    ParameterText name;
    if (groove->path != NULL)
        snprintf(name.text, sizeof name.text, "cam%d.table = \"%.*s\"", i + 1, csv_quoted(groove->path, QUOTED_PATH),
                 groove->path);
    else
        snprintf(name.text, sizeof name.text, "cam%d.%s = %s", i + 1, groove->parameter,
                 shortest_decimal(groove->size).text);
    return name;
}

/* The last theta between 0 and `stop` at which the grooves meet, by bisection. */
static double last_reachable(const Groove groove[2], double stop) {
    double good = 0.0, bad = stop;
    for (int i = 0; i < ROOT_MAX_ITERATIONS; i++) {
        const double middle = 0.5 * (good + bad);
        if (middle == good || middle == bad) break;
        if (pin_is_reachable(groove, middle)) good = middle;
        else bad = middle;
    }
    return good;
}

/* Where a groove's law ends in the direction of a stop, rad. */
static double end_of(const Groove *groove, bool upper) {
    return upper ? groove->last : groove->first;
}

/* The index of the groove that ends nearest to the pin at theta = `end`. */
static int ending_groove(const Groove groove[2], double end, bool upper) {
    const GammaRange in = pin_gamma_range(groove, end);
    const double gamma = pin_gamma(groove, end, 0.5 * (in.lower + in.upper));
    const double first = fabs(end_of(&groove[0], upper) - gamma);
    const double second = fabs(end_of(&groove[1], upper) - (end - gamma));
    return second < first ? 1 : 0;
}

static bool refuse_end(const Groove groove[2], double end, double stop, Fault *fault) {
    const bool upper = stop > 0.0;
    const int i = ending_groove(groove, end, upper);
    const GrooveLaw *law = groove[i].law;
    const ParameterText name = parameter_text(&groove[i], i);
    snprintf(fault->text, sizeof fault->text,
             "%s: the %s groove of cam %d ends at psi = %.10g rad, reached at theta = %.10g rad, "
             "before %s = %.10g rad: %s",
             name.text, law->adjective, i + 1, end_of(&groove[i], upper), end, upper ? "stop.upper" : "stop.lower",
             stop, law->reach);
    return false;
}

static bool check_end(const Groove groove[2], double stop, Fault *fault) {
    if (pin_is_reachable(groove, stop)) return true;
    const double end = last_reachable(groove, stop);
    return fabs(stop - end) <= GROOVE_END_SLACK * (1.0 + fabs(stop)) || refuse_end(groove, end, stop, fault);
}

/* The grooves meet at theta = 0, so they meet everywhere between 0 and an angle where they meet. */
bool groove_pair_check_ends(const Groove groove[2], const Params *p, Fault *fault) {
    const double lower = p->stop.lower, upper = p->stop.upper;
    if (upper > 0.0 && !check_end(groove, upper, fault)) return false;
    return !(lower < 0.0) || check_end(groove, lower, fault);
}

bool groove_pair_refuse_level(const Groove groove[2], double theta, double z, Fault *fault) {
    const ParameterText first = parameter_text(&groove[0], 0), second = parameter_text(&groove[1], 1);
    snprintf(fault->text, sizeof fault->text,
             "%s and %s: both grooves are level at theta = %.10g rad, z = %.10g m: between the stops at "
             "least one slope must be > 0, or nothing fixes the pin",
             first.text, second.text, theta, z);
    return false;
}
