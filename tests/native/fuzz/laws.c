#include "laws.h"

#include <math.h>
#include <string.h>

#include "calls.h"

/* A residual is compared with what is turned over. The shares are those of tests/test_properties.py. */
static const double RELATIVE_ERROR = 10.0;      /* of the tolerance */
static const double ROUNDING_OF_WAY = 1e-14;    /* of the largest torque times the way */
static const double ROUNDING_OF_TRAVEL = 1e-15; /* of the largest force times */
static const double TRAVEL = 2.0;               /* m, no plausible follower travels farther */
static const double NOTHING = 1e-200;           /* J */

enum { HEATS = 5 };
static const unsigned flows[] = {VR_ENERGY_HEAT_CAM1, VR_ENERGY_HEAT_CAM2, VR_ENERGY_HEAT_DAMPER, VR_ENERGY_HEAT_SHAFT,
                                 VR_ENERGY_HEAT_STOP, VR_ENERGY_WORK_IN,   VR_ENERGY_WORK_EXT,    VR_ENERGY_WORK_TUNING,
                                 VR_ENERGY_SPRING,    VR_ENERGY_KINETIC};
enum { FLOWS = sizeof flows / sizeof flows[0] };

static double get(Run *run, unsigned vr) {
    double value = 0.0;
    return call_get_reals(run, &vr, 1, &value) ? value : NAN;
}

/* All at once; if one of them is refused, the outputs alone. */
void check_values(Run *run) {
    unsigned vr[REFERENCE_END];
    double value[REFERENCE_END];
    size_t n = 0;
    for (unsigned k = 0; k < REFERENCE_END; k++)
        if (variable_find(k) != NULL && VARIABLES[k].type == TYPE_REAL) vr[n++] = k;
    if (call_get_reals(run, vr, n, value)) return;
    for (size_t i = 0; i < n; i++)
        if (VARIABLES[vr[i]].causality == CAUSALITY_OUTPUT) call_get_reals(run, vr + i, 1, value);
}

static void read_flows(Run *run, double flow[FLOWS]) {
    REQUIRE(run, call_get_reals(run, flows, FLOWS, flow));
}

void restart_account(Run *run) {
    Account *account = &run->account;
    *account = (Account){.known = true};
    read_flows(run, account->flow);
    for (int i = 0; i < FLOWS; i++) account->turned_over += fabs(account->flow[i]);
}

static double range_of_stops(Run *run) {
    return get(run, VR_STOP_UPPER) - get(run, VR_STOP_LOWER);
}

/* J, how much rounding changes the residual in a step of h seconds. The residual is that of all steps since the start,
 * so that the roundings add up. Where no energy has flowed, nothing was added to an account. */
static double rounding_of_step(Run *run, const double before[FLOWS], double h) {
    if (memcmp(before, run->account.flow, sizeof run->account.flow[0] * FLOWS) == 0) return 0.0;
    const double way = fmin(range_of_stops(run), get(run, VR_PEAK_OMEGA) * h);
    return ROUNDING_OF_WAY * get(run, VR_PEAK_TORQUE) * way;
}

static double allowed_error(const Run *run) {
    const Account *account = &run->account;
    return RELATIVE_ERROR * run->tolerance * account->turned_over + account->rounding +
           ROUNDING_OF_TRAVEL * TRAVEL * account->force + NOTHING;
}

static void check_stops(Run *run) {
    if (MODEL_BUILT != MODEL_FORWARD || run->forged) return;
    const double theta = get(run, VR_THETA);
    REQUIRE(run, theta >= get(run, VR_STOP_LOWER) && theta <= get(run, VR_STOP_UPPER));
}

void check_energies(Run *run, double h) {
    Account *account = &run->account;
    double before[FLOWS];
    check_stops(run);
    if (run->wild || !account->known) return;
    memcpy(before, account->flow, sizeof before);
    read_flows(run, account->flow);
    for (int i = 0; i < FLOWS; i++) account->turned_over += fabs(account->flow[i] - before[i]);
    account->force = fmax(account->force, fabs(get(run, VR_SPRING_FORCE)) + fabs(get(run, VR_F_EXT)));
    account->rounding += rounding_of_step(run, before, h);
    const double allowed = allowed_error(run);
    REQUIRE(run, fabs(get(run, VR_ENERGY_RESIDUAL)) <= allowed);
    for (int i = 0; i < HEATS; i++) REQUIRE(run, account->flow[i] - before[i] >= -allowed);
}
