/* The energy ledger: accounts in joules (docs/mechanism.md, section 4), and the largest values seen. */
#ifndef DUALCAM_LEDGER_H
#define DUALCAM_LEDGER_H

#include <stdbool.h>

#include "numerics/sum.h"

typedef struct {
    double torque;      /* N.m, largest |tau| */
    double omega;       /* rad/s, largest |omega| */
    double reaction[2]; /* N, largest |R_i| per pin end */
} Peaks;

typedef struct {
    Sum work_in;     /* integral of tau omega */
    Sum work_ext;    /* integral of F_ext v: work done against F_ext */
    Sum work_tuning; /* jumps of the spring's energy when its parameters change */
    Sum heat_cam[2]; /* friction at contact i */
    Sum heat_damper; /* integral of D(v) v */
    Sum heat_shaft;  /* integral of b omega^2 */
    Sum heat_stop;   /* kinetic energy lost at the end stops */
    Sum wear[2];     /* m^3, volume worn off at one contact with cam i */
    double start;    /* spring and kinetic energy at the start */
    Peaks peak;
} Ledger;

/* Separate from the accounts: the residual takes longer to compute than all accounts. */
typedef struct {
    double residual; /* J, see ledger_residual() */
} Audit;

/* The amounts that one segment adds to the accounts, J and m^3; or their rates, W and m^3/s. */
typedef struct {
    double work_in, work_ext;
    double heat_cam[2], heat_damper, heat_shaft;
    double wear[2]; /* only where has_wear() */
} Booking;

/* Is this amount of a size that 2^63 segments can add up? `motion`: a sum that must be finite too. */
bool booking_is_in_range(const Booking *booking, double motion);

/* An empty ledger of a mechanism that holds `stored` joules at the start. */
void ledger_open(Ledger *ledger, double stored);
void ledger_book(Ledger *ledger, const Booking *booking);

/* To be called only where has_wear(). */
void ledger_book_wear(Ledger *ledger, const Booking *booking);

/* J: work_in + work_tuning - work_ext - heats - (stored - start), which is zero to rounding. */
double ledger_residual(const Ledger *ledger, double stored);

/* Raises *peak to |value|. */
void peak_raise(double *peak, double value);

#endif
