/* Both contacts at one instant, where friction depends on the reaction: mu_i and R_i together.
 *
 * With x_i = R_i n/hypot(r_i, a_i), n contacts, the balance of forces (contact_factors.h) reads
 *     d_1 x_1 + d_2 x_2 = A    r_2 n_2 x_2 - r_1 n_1 x_1 = W    r_2 n_2 x_2 = T
 * with n_i = a_i + f_i r_i, d_i = r_i - f_i a_i and f_i = sigma e_i mu_i(v_i, |x_i| hypot(r_i, a_i)/n): R_i stands on both
 * sides. Newton's method solves the balance. At an iterate the friction force is a line in x_i, of the slope
 *     f'_i = sigma e_i (mu_i + R_i dmu_i/dR_i), the tangent coefficient,
 * so that each iteration is the linear balance with f'_i and shifted loads.
 *
 * One answer. The torque of a contact, r_i n_i x_i, grows with R_i where a_i + f'_i r_i > 0; for e_i sigma = -1 this is
 * s_i > mu_i + R_i dmu_i/dR_i, which is (1 + nu) mu_i - nu mu_v v_i. Where it does not grow and yet n_i > 0, two
 * reactions give the same torque: the contact counts as locked, and without alpha the pair of flanks does not move. In a
 * motion with inertia a locked contact moves on at reactions that settle. With a coefficient that no load changes, a
 * contact with n_i = 0 passes no torque at any load, and the balance has one answer. Where the determinant with f'_i has
 * lost the sign of Delta, the load does not grow with the torque: the pair jams.
 *
 * Several answers. In a motion the balance can have several answers, on the flanks and off them. Newton's method starts as
 * if no friction acted. Along a motion it can lose the answer that it has followed, and end at another one off the flanks.
 * The reactions of slightly elastic flanks stay with their answer there. Such a motion goes on with LoadedPin.searches. */
#ifndef DUALCAM_LOADED_CONTACTS_H
#define DUALCAM_LOADED_CONTACTS_H

#include "contact/contact.h"
#include "contact/contact_factors.h"
#include "model/friction_law.h"
#include "model/params.h"
#include "model/work.h"

typedef struct {
    const Params *params;
    int direction, flank[2];
    bool searches;   /* where Newton's method ends off the flanks, the answer of a motion is searched on the flanks */
    double slope[2]; /* m/rad, a_i */
    double speed[2]; /* m/s, v_i */
    Work *work;      /* counts iterations, or NULL */
} LoadedPin;

/* T = torque - by_alpha.torque alpha, A = axial + by_alpha.axial alpha, W likewise. */
typedef struct {
    double torque, axial, moment; /* N.m, N, N.m */
    double size; /* N, the sum of the magnitudes of what adds up to the axial load: x_i below its rounding is 0 */
} LoadTerms;

typedef struct {
    bool possible;          /* there is an answer; without alpha: and the balance has one answer */
    bool single;            /* the balance has one answer */
    double alpha;           /* rad/s^2, if it was to be found */
    double x[2];            /* N/m */
    LoadedFriction mu[2];   /* mu_i and its derivatives */
    double friction[2];     /* f_i */
    ContactFactors tangent; /* with f'_i */
} LoadedContacts;

/* Under known loads A and W; T is not used. */
void loaded_contacts_under(const LoadedPin *pin, const LoadTerms *loads, LoadedContacts *out);

/* In a known motion T is known, too, and one of the three equations is left over. Where Delta is rounding, x_i from A and W
 * have no digits: the torques T - W and T then give x_i. The solution that misses the three equations least is taken. */
void loaded_contacts_in_motion(const LoadedPin *pin, const LoadTerms *loads, LoadedContacts *out);

/* Finds alpha, too. */
void loaded_contacts_moving(const LoadedPin *pin, const LoadTerms *loads, const LoadTerms *by_alpha,
                            LoadedContacts *out);

/* Changes to first order: of A and W; of f_i and a_i themselves, at constant x_i. */
typedef struct {
    double axial, moment;
    double friction[2], slope[2];
} LoadChange;

/* What the changes leave to x_i and alpha to balance: of T, A and W. */
LoadTerms loaded_contacts_unbalanced(const LoadedPin *pin, const LoadedContacts *contacts, const LoadChange *change);

/* The changes of x_i and, R_i included, of f_i. */
typedef struct {
    double x[2], friction[2];
} LoadResponse;

LoadResponse loaded_contacts_response(const LoadedPin *pin, const LoadedContacts *contacts, const LoadChange *change);

/* rad/m: the change of f_i with a_i at constant x_i, through the groove's length in R_i. */
double loaded_pin_friction_by_slope(const LoadedPin *pin, const LoadedContacts *contacts, int i);

/* At rest: the response to a change of a_i by `dslope`, under constant loads. The groove's length per angle, and with it
 * R_i per x_i, changes too. */
LoadResponse loaded_contacts_along_groove(const LoadedPin *pin, const LoadedContacts *contacts, const double dslope[2]);

/* N, R_i of one contact per |x_i|, N/m. */
double loaded_pin_reaction(const LoadedPin *pin, int i);

/* ---- the stick band ---- */

/* As contact_edge() and contact_band() for the axial load F_0 > 0. `g` receives the friction coefficients on the edge.
 * Where friction does not depend on the load these functions are contact_edge() and contact_band(). `work` may be NULL. */
bool contact_edge_under(const Params *params, Geometry *g, double F_0, int direction, int flank[2], Transfer *transfer,
                        Work *work);
BandFactors contact_band_under(const Params *params, const Geometry *g, double F_0, Work *work);

#endif
