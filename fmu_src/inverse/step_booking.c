#include "inverse/step_booking.h"

Quadrature step_booking_begin(const Inverse *m, const Ledger *ledger) {
    const Peaks *peak = &ledger->peak;
    return (Quadrature){
        .tolerance = m->params.tolerance,
        .peak = {peak->torque, peak->omega, peak->reaction[0], peak->reaction[1]},
    };
}

void step_booking_finish(const Inverse *m, const Quadrature *quadrature, double into_shaft, Ledger *ledger) {
    const double *total = quadrature->total, *peak = quadrature->peak;
    const Booking booking = {
        .work_in = total[RATE_WORK_IN] + into_shaft,
        .work_ext = total[RATE_WORK_EXT],
        .heat_cam = {total[RATE_HEAT_CAM1], total[RATE_HEAT_CAM2]},
        .heat_damper = total[RATE_HEAT_DAMPER],
        .heat_shaft = total[RATE_HEAT_SHAFT],
        .wear = {wear_per_sliding(&m->params, 0) * total[RATE_SLIDING1],
                 wear_per_sliding(&m->params, 1) * total[RATE_SLIDING2]},
    };
    ledger_book(ledger, &booking);
    if (has_wear(&m->params)) ledger_book_wear(ledger, &booking);
    ledger->peak = (Peaks){peak[SIZE_TORQUE], peak[SIZE_OMEGA], {peak[SIZE_REACTION1], peak[SIZE_REACTION2]}};
}
