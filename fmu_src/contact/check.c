#include "contact/check.h"

#include <math.h>
#include <stdio.h>

#include "contact/contact_factors.h"
#include "contact/loaded_contacts.h"
#include "elementary/elementary.h"
#include "geometry/transmission_build.h"
#include "model/csv_file.h"
#include "model/elements.h"
#include "model/friction_law.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

COMPACT_BEGIN

static bool is_level_helix(const CamParams *cam) {
    return cam->profile == PROFILE_HELIX && cam->lead_angle == 0.0;
}

bool check_params(const Params *p, Fault *fault) {
    if (is_level_helix(&p->cam[0]) && is_level_helix(&p->cam[1])) {
        snprintf(fault->text, sizeof fault->text,
                 "cam1.lead_angle = 0 and cam2.lead_angle = 0: at least one must be > 0, or nothing fixes the pin");
        return false;
    }
    if (!(p->stop.lower < p->stop.upper)) {
        snprintf(fault->text, sizeof fault->text, "stop.lower = %s must be < stop.upper = %s",
                 shortest_decimal(p->stop.lower).text, shortest_decimal(p->stop.upper).text);
        return false;
    }
    return true;
}

bool check_initial(const Params *p, Fault *fault) {
    if (p->initial.theta >= p->stop.lower && p->initial.theta <= p->stop.upper) return true;
    const bool below = p->initial.theta < p->stop.lower;
    snprintf(fault->text, sizeof fault->text, "initial.theta = %s must be %s %s = %s",
             shortest_decimal(p->initial.theta).text, below ? ">=" : "<=", below ? "stop.lower" : "stop.upper",
             shortest_decimal(below ? p->stop.lower : p->stop.upper).text);
    return false;
}

/* ---- friction law ---- */

bool check_falling_friction(const Params *p, const char *cause, const char *remedy, Fault *fault) {
    for (int i = 0; i < 2; i++) {
        const FrictionTable *table = p->cam[i].law.table;
        if (table && !isnan(table->falls_at)) {
            snprintf(fault->text, sizeof fault->text,
                     "cam%d.friction_table = \"%.*s\" falls to v_m_s = %s, %s: friction that falls with the sliding "
                     "speed would make the angle jump; allowed is a table that does not fall, or %s",
                     i + 1, csv_quoted(table->path, QUOTED_PATH), table->path, shortest_decimal(table->falls_at).text,
                     cause, remedy);
            return false;
        }
        if (table || !(p->cam[i].law.peak > 1.0 && p->cam[i].friction > 0.0)) continue;
        snprintf(fault->text, sizeof fault->text,
                 "cam%d.friction_peak = %s %s: friction that falls with the sliding speed would make the angle jump; "
                 "allowed is cam%d.friction_peak = 1, or %s",
                 i + 1, shortest_decimal(p->cam[i].law.peak).text, cause, i + 1, remedy);
        return false;
    }
    return true;
}

/* Does friction grow without bound as the load vanishes? */
static bool grows_without_load(const CamParams *cam) {
    const FrictionTable *table = cam->law.table;
    if (!friction_depends_on_load(cam)) return false;
    for (size_t j = 0; table && j <= table->count; j++)
        if (friction_table_under(table, table->speed[j], table->load[1]).by_load < 0.0) return true;
    return !table && cam->law.load_exponent < 0.0;
}

bool check_loaded_friction(const Params *p, const char *remedy, Fault *fault) {
    const DamperParams *d = &p->damper;
    const bool damped = d->c_load + d->q_load + d->c_release + d->q_release + p->shaft.damping > 0.0 ||
                        p->cam[0].law.viscous > 0.0 || p->cam[1].law.viscous > 0.0;
    for (int i = 0; i < 2 && damped; i++) {
        const FrictionParams *law = &p->cam[i].law;
        if (!grows_without_load(&p->cam[i])) continue;
        char cause[QUOTED_PATH + 32];
        if (law->table)
            snprintf(cause, sizeof cause, "friction_table = \"%.*s\"", csv_quoted(law->table->path, QUOTED_PATH),
                     law->table->path);
        else snprintf(cause, sizeof cause, "friction_load_exponent = %s", shortest_decimal(law->load_exponent).text);
        snprintf(fault->text, sizeof fault->text,
                 "cam%d.%s without inertia: where damping takes the load off the contact, friction grows "
                 "and the reaction would jump; allowed is friction that does not fall with the load, no damping "
                 "(damper.*, shaft.damping, cam*.friction_viscous), or %s",
                 i + 1, cause, remedy);
        return false;
    }
    return true;
}

bool check_limited_speed(const Params *p, const char *remedy, Fault *fault) {
    const DamperParams *d = &p->damper;
    const bool damped = p->shaft.damping > 0.0 || (d->c_load + d->q_load > 0.0 && d->c_release + d->q_release > 0.0);
    for (int i = 0; i < 2 && !damped; i++) {
        const FrictionTable *table = p->cam[i].law.table;
        if (!table) continue;
        snprintf(fault->text, sizeof fault->text,
                 "cam%d.friction_table = \"%.*s\" without inertia and damping: friction is constant from v_m_s = %s "
                 "on, so nothing limits the speed; allowed is shaft.damping > 0, a damper in both directions, or %s",
                 i + 1, csv_quoted(table->path, QUOTED_PATH), table->path,
                 shortest_decimal(table->speed[table->count]).text, remedy);
        return false;
    }
    return true;
}

COMPACT_END

/* ---- jam ---- */

/* m^3: Delta of the supporting flanks when loading (docs/mechanism.md, section 3). With n_i = a_i + mu_i r_i >= 0 Delta
 * has the sign of kappa_1 + kappa_2 = d_1/(r_1 n_1) + d_2/(r_2 n_2). */
static double load_margin(const Params *p, const double slope[2]) {
    ContactFactors f;
    for (int i = 0; i < 2; i++) contact_factors_set(&f, i, p->cam[i].radius, friction_static(&p->cam[i]), slope[i]);
    contact_factors_multiply(&f);
    return f.delta;
}

/* Where friction depends on the load: under the spring's force. */
static bool loads_under_spring(const Params *p, const TransmissionPoint *point) {
    const double F_s = spring_force(&p->spring, point->z);
    Geometry g = cam_geometry(p->cam, point->slope);
    int flank[2];
    Transfer transfer;
    return F_s == 0.0 || contact_edge_under(p, &g, fabs(F_s), 1, flank, &transfer, NULL);
}

COMPACT static bool loads_at(const Params *p, const TransmissionPiece *piece, double theta) {
    const TransmissionPoint point = piece_at(piece, theta);
    if (any_friction_depends_on_load(p)) return loads_under_spring(p, &point);
    return load_margin(p, point.slope) > 0.0;
}

/* In straight grooves the margin is the same everywhere. */
static bool loads_in_straight(const Params *p, const TransmissionPiece *piece) {
    const double slope[2] = {piece->slope[0][0], piece->slope[0][1]};
    return load_margin(p, slope) > 0.0;
}

/* The first theta, to rounding, at which the contacts jam; they do not at `good` and do at `bad`. */
static double first_jam(const Params *p, const TransmissionPiece *piece, double good, double bad) {
    for (int n = 0; n < BISECTIONS_MAX; n++) {
        const double middle = 0.5 * (good + bad);
        if (!(middle > good && middle < bad)) break;
        if (loads_at(p, piece, middle)) good = middle;
        else bad = middle;
    }
    return bad;
}

/* The first theta in the piece at which the contacts jam, or NAN. */
static double jam_in(const Params *p, const TransmissionPiece *piece, int samples) {
    double good = piece->lower;
    if (!loads_at(p, piece, good)) return good;
    for (int k = 1; k <= samples; k++) {
        const double theta = k == samples ? piece->upper : piece->lower + (piece->upper - piece->lower) * k / samples;
        if (!loads_at(p, piece, theta)) return first_jam(p, piece, good, theta);
        good = theta;
    }
    return NAN;
}

COMPACT_BEGIN

/* Of a helix the parameter, as `cam1.lead_angle = 1.5`; of other grooves the lead angle at this slope. */
static void name_lead(char text[80], const Params *p, int i, double slope) {
    if (p->cam[i].profile == PROFILE_HELIX)
        snprintf(text, 80, "cam%d.lead_angle = %s", i + 1, shortest_decimal(p->cam[i].lead_angle).text);
    else
        snprintf(text, 80, "lead angle %s of cam%d there",
                 shortest_decimal(elementary_atan(slope / p->cam[i].radius)).text, i + 1);
}

static void name_friction(char text[100], const CamParams *cam, int i) {
    const FrictionParams *law = &cam->law;
    if (law->table)
        snprintf(text, 100, "cam%d.friction_table with mu = %s at rest", i + 1,
                 shortest_decimal(law->table->at_rest).text);
    else if (law->peak == 1.0) snprintf(text, 100, "cam%d.friction = %s", i + 1, shortest_decimal(cam->friction).text);
    else
        snprintf(text, 100, "cam%d.friction = %s times cam%d.friction_peak = %s at rest", i + 1,
                 shortest_decimal(cam->friction).text, i + 1, shortest_decimal(law->peak).text);
}

static void describe_jam(Fault *fault, const Params *p, const TransmissionPiece *piece, double theta) {
    const TransmissionPoint point = piece_at(piece, theta); /* of a helix only the parameter is named */
    char lead[2][80];
    for (int i = 0; i < 2; i++) name_lead(lead[i], p, i, point.slope[i]);
    char friction[2][100], load[120] = "";
    for (int i = 0; i < 2; i++) name_friction(friction[i], &p->cam[i], i);
    if (p->cam[0].law.load_exponent != 0.0 || p->cam[1].law.load_exponent != 0.0)
        snprintf(load, sizeof load, ", cam1.friction_load_exponent = %s, cam2.friction_load_exponent = %s",
                 shortest_decimal(p->cam[0].law.load_exponent).text,
                 shortest_decimal(p->cam[1].law.load_exponent).text);
    snprintf(fault->text, sizeof fault->text,
             "the contacts jam when loading at theta = %s: %s and %s with %s and %s%s; kappa_1 + kappa_2 must be > 0 "
             "from stop.lower to stop.upper",
             shortest_decimal(theta).text, lead[0], lead[1], friction[0], friction[1], load);
}

bool check_jam(const Params *p, const Transmission *transmission, Fault *fault) {
    const int samples = transmission->count < JAM_MANY_PIECES ? JAM_SAMPLES : JAM_SAMPLES_OF_MANY;
    const bool loaded = any_friction_depends_on_load(p);
    if (transmission->straight && !loaded && loads_in_straight(p, transmission->piece)) return true;
    for (size_t i = 0; i < transmission->count; i++) {
        const TransmissionPiece *piece = &transmission->piece[i];
        const double theta = transmission->straight && !loaded ? piece->lower : jam_in(p, piece, samples);
        if (isnan(theta)) continue;
        describe_jam(fault, p, piece, theta);
        return false;
    }
    return true;
}

bool check_transmission(const Params *p, const char *resources, Transmission *transmission, Fault *fault) {
    if (transmission_is_of(transmission, p)) return check_jam(p, transmission, fault);
    Transmission made;
    if (!transmission_build(&made, p, resources, fault)) return false;
    const bool good = check_jam(p, &made, fault);
    transmission_free(good ? transmission : &made);
    if (good) *transmission = made;
    return good;
}

COMPACT_END
