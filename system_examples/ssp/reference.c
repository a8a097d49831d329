#include "reference.h"

#include <math.h>

#include "part.h"

const char TOO_LONG[] = "longer than the controller's tick";

Point pick_and_place(PickAndPlace cycle, double time) {
    const double half = cycle.move + cycle.dwell;
    const double phase = fmod(time, 2.0 * half);
    const bool there = phase < half;
    const double s = fmin(fmax(((there ? phase : phase - half) - cycle.dwell) / cycle.move, 0.0), 1.0);
    const double way = s * s * s * (10.0 + s * (6.0 * s - 15.0));
    const double rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / cycle.move;
    const double length = cycle.end - cycle.start;
    return there ? (Point){cycle.start + length * way, length * rate}
                 : (Point){cycle.end - length * way, -length * rate};
}

double fourier(const double coefficients[COEFFICIENTS], double period, double time, int order) {
    double total = order == 0 ? coefficients[0] : 0.0;
    for (int n = 1; n <= HARMONICS; n++) {
        const double rate = 2.0 * PI * n / period;
        const double angle = rate * time + 0.5 * PI * order; /* each derivative turns by a quarter */
        total += pow(rate, order) * (coefficients[2 * n - 1] * cos(angle) + coefficients[2 * n] * sin(angle));
    }
    return total;
}

bool tick_is_due(double *newest, double tick, double time, double step, Sample *sample) {
    const double due = floor((time + 2.5 * step) / tick);
    if (due <= *newest) return false;
    *newest = due;
    const double beside = due * tick - (time + 2.0 * step); /* rounding, if a tick is a whole number of steps */
    *sample = (Sample){due * tick, fabs(beside) < 1e-6 * step ? 2.0 * step : 2.0 * step + beside};
    return true;
}

Point carried_on(Point joint, double lead, Point now, Point then, double tick) {
    const double gained = lead * (then.speed - now.speed) / tick;
    return (Point){joint.angle + lead * (joint.speed + 0.5 * gained), joint.speed + gained};
}
