/* Friction heat, temperatures and the grease of the spring clamp.
 *
 * The heat is what the energy balance of the cam leaves over, so the part needs no more than the cam's torque, which is
 * constant over a step, and the cam's outputs: work of the torque less what the spring and the inertia store. Once per
 * period the mean power goes into a network of two masses, TwoMassNetwork of dualcam/systems/blocks/thermal_network.py:
 *
 *     C_c dT_c/dt = P - G_c (T_c - T_h)      C_h dT_h/dt = G_c (T_c - T_h) - G_a (T_h - T_a)
 *
 * The temperature of the contact zone gives the viscosity by Vogel's law, and the viscosity the two coefficients of
 * friction that move with it (dualcam/systems/blocks/grease.py).
 */
#include <math.h>
#include <stddef.h>

#include "part.h"
#include "part_variables.h"

static double stored(const double v[]) {
    const double spring = v[Z] * (v[SPRING_PRELOAD] + 0.5 * v[SPRING_STIFFNESS] * v[Z]);
    return spring + 0.5 * v[INERTIA] * v[OMEGA] * v[OMEGA];
}

/* Vogel's law over its value at the reference temperature: the factor A cancels. */
static double relative_viscosity(const double v[], double temperature) {
    const double span = v[OIL_SPAN] + (temperature - v[OIL_REFERENCE]); /* temperature less Vogel's C */
    return exp(v[OIL_B] / span - v[OIL_B] / v[OIL_SPAN]);
}

static void set_friction(double v[]) {
    const double ratio = relative_viscosity(v, v[TEMPERATURE_CONTACT]);
    v[STRIBECK_VELOCITY] = v[REFERENCE_STRIBECK_VELOCITY] / ratio;
    v[FRICTION_VISCOUS] = v[REFERENCE_FRICTION_VISCOUS] * ratio;
}

/* Both temperatures after `duration` under a constant power. In the masses' own modes the network is
 * x' = rate (x - x_end); a mode is (1, shape) with shape = T_h/T_c, both less the settled temperatures. */
static void advance(double v[], double power, double duration) {
    const double to_housing = v[CONDUCTANCE_CONTACT], to_air = v[CONDUCTANCE_AIR];
    const double a = to_housing / v[CAPACITY_CONTACT], b = to_housing / v[CAPACITY_HOUSING];
    const double c = to_air / v[CAPACITY_HOUSING];
    const double mean = 0.5 * (a + b + c), root = sqrt(mean * mean - a * c);
    const double rate[2] = {-mean - root, -a * c / (mean + root)};
    const double end_housing = v[AIR] + power / to_air, end_contact = end_housing + power / to_housing;
    const double contact = v[TEMPERATURE_CONTACT] - end_contact, housing = v[TEMPERATURE_HOUSING] - end_housing;
    const double shape[2] = {1.0 + rate[0] / a, 1.0 + rate[1] / a};
    const double second = (housing - shape[0] * contact) / (shape[1] - shape[0]);
    const double share[2] = {contact - second, second};
    double area = (end_housing - v[AIR]) * duration; /* integral of T_h - T_a */
    v[TEMPERATURE_CONTACT] = end_contact;
    v[TEMPERATURE_HOUSING] = end_housing;
    for (int i = 0; i < 2; i++) {
        v[TEMPERATURE_CONTACT] += share[i] * exp(rate[i] * duration);
        v[TEMPERATURE_HOUSING] += share[i] * shape[i] * exp(rate[i] * duration);
        area += share[i] * shape[i] * expm1(rate[i] * duration) / rate[i];
    }
    v[HEAT_OUT] += to_air * area;
}

void part_initialize(double v[]) {
    v[TEMPERATURE_CONTACT] = v[TEMPERATURE_HOUSING] = v[AIR];
    v[HEAT_IN] = v[HEAT_OUT] = v[PERIODS] = v[WORK] = v[LAST_TAU] = 0.0;
    v[THETA] = v[LAST_THETA] = v[INITIAL_THETA];
    v[OMEGA] = v[INITIAL_OMEGA];
    v[Z] = v[INITIAL_Z];
    v[LAST_STORED] = stored(v);
    set_friction(v);
}

const char *part_step(double v[], double time, double step) {
    v[WORK] += v[LAST_TAU] * (v[THETA] - v[LAST_THETA]); /* of the step that ends now */
    v[LAST_THETA] = v[THETA];
    v[LAST_TAU] = v[TAU];
    const double periods = floor((time + step) / v[PERIOD] + 1e-6);
    if (periods <= v[PERIODS]) return NULL;
    const double heat = v[WORK] - (stored(v) - v[LAST_STORED]);
    const double duration = (periods - v[PERIODS]) * v[PERIOD];
    v[PERIODS] = periods;
    v[WORK] = 0.0;
    v[LAST_STORED] = stored(v);
    v[HEAT_IN] += heat;
    advance(v, heat / duration, duration);
    set_friction(v);
    return NULL;
}
