#include "model/ledger.h"

#include <math.h>
#include <stddef.h>

#include "numerics/tolerances.h"

bool booking_is_in_range(const Booking *b, double motion) {
    const double heat = fabs(b->heat_cam[0]) + fabs(b->heat_cam[1]) + fabs(b->heat_damper) + fabs(b->heat_shaft);
    return fabs(motion) + fabs(b->work_in) + fabs(b->work_ext) + heat <= LARGEST_ENERGY;
}

void ledger_open(Ledger *ledger, double stored) {
    *ledger = (Ledger){.start = stored};
}

/* Most scenes lack these sinks: an amount of 0 costs a comparison instead of a compensated sum. */
static void add(Sum *account, double joule) {
    if (joule != 0.0) sum_add(account, joule);
}

void ledger_book(Ledger *ledger, const Booking *booking) {
    sum_add(&ledger->work_in, booking->work_in);
    sum_add(&ledger->heat_cam[0], booking->heat_cam[0]);
    sum_add(&ledger->heat_cam[1], booking->heat_cam[1]);
    add(&ledger->work_ext, booking->work_ext);
    add(&ledger->heat_damper, booking->heat_damper);
    add(&ledger->heat_shaft, booking->heat_shaft);
}

void ledger_book_wear(Ledger *ledger, const Booking *booking) {
    for (int i = 0; i < 2; i++) sum_add(&ledger->wear[i], booking->wear[i]);
}

double ledger_residual(const Ledger *ledger, double stored) {
    const Sum *sink[] = {&ledger->work_ext,    &ledger->heat_cam[0], &ledger->heat_cam[1],
                         &ledger->heat_damper, &ledger->heat_shaft,  &ledger->heat_stop};
    Sum residual = ledger->work_in;
    sum_add(&residual, ledger->work_tuning.hi);
    sum_add(&residual, ledger->work_tuning.lo);
    for (size_t i = 0; i < sizeof sink / sizeof sink[0]; i++) {
        sum_add(&residual, -sink[i]->hi);
        sum_add(&residual, -sink[i]->lo);
    }
    sum_add(&residual, ledger->start);
    sum_add(&residual, -stored);
    return residual.hi;
}

void peak_raise(double *peak, double value) {
    const double size = fabs(value);
    *peak = size > *peak ? size : *peak; /* without a branch: the processor cannot predict the branch */
}
