/* The user's choice (Params).
 *
 * The room model/ describes the mechanism for all other rooms: parameters, inputs, the laws of spring and damper,
 * modes, regimes, events, the energy ledger, faults and knowns of differentiation. All values are in SI units. May
 * include: platform, elementary, numerics. */
#ifndef DUALCAM_PARAMS_H
#define DUALCAM_PARAMS_H

#include <math.h>
#include <stdbool.h>

#include "elementary/elementary.h"
#include "model/inputs.h"
#include "numerics/sum.h"

enum { PROFILE_HELIX = 1, PROFILE_ELLIPSE = 2, PROFILE_TABLE = 3, PROFILE_CYCLOID = 4 };
enum { TABLE_PATH_SIZE = 1024 }; /* bytes, terminating zero included */

typedef struct FrictionTable FrictionTable;

/* The friction law of a groove (friction_law.h). The start values are Coulomb's law. */
typedef struct {
    double peak;              /* static over kinetic coefficient, >= 1 */
    double stribeck_velocity; /* m/s, v_s > 0 */
    double viscous;           /* s/m, mu_v >= 0 */
    double load_exponent;     /* nu */
    double load;              /* N, N_ref of one contact */
    int stribeck_exponent;    /* delta: 1 or 2 */
    /* Replaces the law above unless NULL. Not owned; not of a saved state: the path is (friction_table_load.h). */
    const FrictionTable *table;
} FrictionParams;

typedef struct {
    double radius;        /* m, > 0 */
    double lead_angle;    /* rad, in [0, pi/2) */
    double ellipse_a;     /* m */
    double ellipse_b;     /* m */
    double cycloid_rise;  /* m, H */
    double cycloid_angle; /* rad, B */
    double friction;      /* kinetic coefficient mu_k; with Coulomb's law the only one */
    FrictionParams law;
    double wear; /* m^3/(N.m), specific wear rate K */
    int profile; /* PROFILE_* */
    int ellipse_curvature;
} CamParams;

typedef struct {
    double preload;    /* N */
    double stiffness;  /* N/m */
    double stiffness2; /* N/m^2 */
    double stiffness3; /* N/m^3 */
} SpringParams;

typedef struct {
    double c_load;    /* N.s/m, acts while v > 0 */
    double q_load;    /* N.s^2/m^2 */
    double c_release; /* N.s/m, acts while v < 0 */
    double q_release; /* N.s^2/m^2 */
} DamperParams;

typedef struct {
    double shaft;         /* kg.m^2, J */
    double follower_mass; /* kg, m */
    double follower;      /* kg.m^2, I */
} InertiaParams;

typedef struct {
    double damping;   /* N.m.s/rad, b */
    double stiffness; /* N.m/rad, K between port and cam 2; 0: rigid. Only inverse dynamics uses K. */
} ShaftParams;

typedef struct {
    double lower;       /* rad */
    double upper;       /* rad, > lower */
    double restitution; /* e in [0, 1] */
} StopParams;

typedef struct {
    double theta; /* rad */
    double omega; /* rad/s; not used without inertia, for then the speed is no state */
} InitialParams;

typedef struct {
    CamParams cam[2];
    SpringParams spring;
    DamperParams damper;
    InertiaParams inertia;
    ShaftParams shaft;
    StopParams stop;
    InitialParams initial;
    double tolerance;                        /* relative, of collocation; no variable of the FMU */
    int contacts;                            /* pin ends that share the load, 1 or 2 */
    bool ledger;                             /* keep the energy accounts and the peaks */
    char table[2][TABLE_PATH_SIZE];          /* path of the file with the sampled groove of each cam */
    char friction_table[2][TABLE_PATH_SIZE]; /* path of the file with the sampled friction law; "": none */
} Params;

/* The parameters that may change at a communication point. */
typedef struct {
    double friction, peak, stribeck_velocity, stribeck_exponent, viscous, load_exponent, load, wear;
} CamTunables;

typedef struct {
    CamTunables cam[2];
    SpringParams spring;
    DamperParams damper;
} Tunables;

/* rad: the largest |theta| between the stops; theta rounds by some eps of this value. */
static inline double largest_angle(const Params *p) {
    return max_of(fabs(p->stop.upper), fabs(p->stop.lower));
}

/* rad: the error that the tolerance allows theta */
static inline double angle_tolerance(const Params *p) {
    return p->tolerance * largest_angle(p);
}

/* rad: the end stop ahead in `direction` (+1 or -1) */
static inline double stop_ahead(const StopParams *stop, int direction) {
    return direction > 0 ? stop->upper : stop->lower;
}

/* rad, >= 0: how far theta is from that stop */
static inline double distance_to_stop(const StopParams *stop, int direction, Sum theta) {
    return max_of(direction * (stop_ahead(stop, direction) - theta.hi - theta.lo), 0.0);
}

/* J: (J + m z'^2 + I gamma'^2) omega^2/2, with `dpsi_dtheta` gamma'. */
static inline double kinetic_energy_of(const InertiaParams *i, double dz_dtheta, double dpsi_dtheta, double omega) {
    return 0.5 * (i->shaft + i->follower_mass * dz_dtheta * dz_dtheta + i->follower * dpsi_dtheta * dpsi_dtheta) *
           omega * omega;
}

static inline bool has_inertia(const Params *p) {
    return p->inertia.shaft > 0.0 || p->inertia.follower_mass > 0.0 || p->inertia.follower > 0.0;
}

/* No coefficient is negative, so a sum saves a branch. */
static inline bool has_friction(const Params *p) {
    return p->cam[0].friction + p->cam[1].friction > 0.0 || p->cam[0].law.viscous + p->cam[1].law.viscous > 0.0 ||
           p->cam[0].law.table || p->cam[1].law.table;
}

/* Is there a specific wear rate, so that the ledger keeps the volumes worn off? */
static inline bool has_wear(const Params *p) {
    return p->cam[0].wear + p->cam[1].wear > 0.0;
}

/* m^3 of one contact per N.m of sliding: per total reaction and sliding distance (J. F. Archard, J. Appl. Phys. 24,
 * 1953). */
static inline double wear_per_sliding(const Params *p, int i) {
    return p->cam[i].wear / p->contacts;
}

/* Are spring and damper linear? Then slip in straight grooves has a closed form. */
static inline bool is_linear(const Params *p) {
    return p->spring.stiffness2 == 0.0 && p->spring.stiffness3 == 0.0 && p->damper.q_load == 0.0 &&
           p->damper.q_release == 0.0;
}

#endif
