#include "station.h"

#include <float.h>
#include <math.h>

/* A reaction below this share of what adds up to it is none, and suits either flank. */
static const double NO_REACTION = 16.0 * DBL_EPSILON;

/* gamma' = a_2/(a_1 + a_2) and z' = a_1 a_2/(a_1 + a_2) by the quotient rule, with b_i = da_i/dtheta:
 *     gamma'' = (a_1 b_2 - a_2 b_1)/(a_1 + a_2)^2    z'' = (a_2^2 b_1 + a_1^2 b_2)/(a_1 + a_2)^2 */
Station station_at(const Params *params, const Piece *piece, double theta) {
    const Spot spot = piece_at(piece, theta);
    Station station = {
        .geometry = cam_geometry(params->cam, spot.slope), .bend = {spot.bend[0], spot.bend[1]}, .z = spot.z};
    const double *turn = station.geometry.turn, sum = spot.slope[0] + spot.slope[1];
    station.turn_rate = (turn[1] * spot.bend[1] - turn[0] * spot.bend[0]) / sum;
    station.lift_rate = turn[0] * turn[0] * spot.bend[0] + turn[1] * turn[1] * spot.bend[1];
    return station;
}

/* ---- flanks ---- */

static void bear(const Burden *b, Bearing *bearing) {
    const Transfer *t = &bearing->transfer;
    bearing->torque = t->rho * b->axial + t->rho_kappa1 * b->twist;
    for (int i = 0; i < 2; i++) bearing->x[i] = t->axial[i] * b->axial + t->twist[i] * b->twist;
}

bool station_is_idle(const Bearing *bearing, const Burden *b, int i) {
    const Transfer *t = &bearing->transfer;
    const double size = fabs(t->axial[i]) * b->axial_size + fabs(t->twist[i]) * b->twist_size;
    return fabs(bearing->x[i]) <= NO_REACTION * size;
}

static bool agrees(const Burden *b, const Bearing *bearing) {
    if (!bearing->transfer.regular || !isfinite(bearing->torque)) return false;
    for (int i = 0; i < 2; i++)
        if (bearing->flank[i] * bearing->x[i] < 0.0 && !station_is_idle(bearing, b, i)) return false;
    return true;
}

bool station_bearing(const Station *station, int direction, const Burden *burden, Bearing *bearing) {
    const int s = burden->axial < -NO_REACTION * burden->axial_size ? -1 : 1;
    const int candidate[4][2] = {{s, s}, {s, -s}, {-s, s}, {-s, -s}};
    for (int k = 0; k < 4; k++) {
        bearing->flank[0] = candidate[k][0];
        bearing->flank[1] = candidate[k][1];
        bearing->transfer = contact_transfer(&station->geometry, direction, bearing->flank);
        bear(burden, bearing);
        if (agrees(burden, bearing)) return true;
    }
    return false;
}

/* For F_0 < 0 both flanks change and so does the direction that decides (same products). */
bool station_edge(const Station *station, int direction, double F_0, Bearing *bearing) {
    const int side = F_0 < 0.0 ? -1 : 1;
    if (!contact_edge(&station->geometry, side * direction, bearing->flank, &bearing->transfer)) return false;
    for (int i = 0; i < 2; i++) bearing->flank[i] *= side;
    const Burden burden = {.axial = F_0};
    bear(&burden, bearing);
    return true;
}

/* rho = r_1 r_2 n_1 n_2/Delta, n_i = a_i + c_i r_i, d_i = r_i - c_i a_i, c_i = sigma e_i mu_i,
 * Delta = r_2 d_1 n_2 + r_1 d_2 n_1; with b_i = da_i/dtheta, n_i' = b_i and d_i' = -c_i b_i. */
double station_rho_rate(const Station *station, int direction, const Bearing *bearing) {
    const Geometry *g = &station->geometry;
    double n[2], d[2], n_rate[2], d_rate[2];
    for (int i = 0; i < 2; i++) {
        const double c = direction * bearing->flank[i] * g->friction[i];
        n[i] = g->slope[i] + c * g->radius[i];
        d[i] = g->radius[i] - c * g->slope[i];
        n_rate[i] = station->bend[i];
        d_rate[i] = -c * station->bend[i];
    }
    const double r1 = g->radius[0], r2 = g->radius[1];
    const double delta = r2 * d[0] * n[1] + r1 * d[1] * n[0];
    const double delta_rate =
        r2 * (d_rate[0] * n[1] + d[0] * n_rate[1]) + r1 * (d_rate[1] * n[0] + d[1] * n_rate[0]);
    return (r1 * r2 * (n_rate[0] * n[1] + n[0] * n_rate[1]) - bearing->transfer.rho * delta_rate) / delta;
}

/* mu_i |R_i| times the sliding speed |psi_i'| hypot(r_i, a_i) (section 4) */
double station_heat(const Station *station, const Bearing *bearing, int i) {
    const Geometry *g = &station->geometry;
    return cam_heat(g, i) * fabs(bearing->x[i]);
}
