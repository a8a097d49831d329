/* The cycloidal law, z = H (psi/B - sin(2 pi psi/B)/(2 pi)) for 0 <= psi <= B: level at both ends, without a jump of the
 * second derivative against a dwell. */
#include "elementary/elementary.h"
#include "geometry/groove.h"

static const double PI = 3.141592653589793;

static bool build(Groove *groove, const GrooveSource *source, Fault *fault) {
    (void)fault;
    groove->parameter = "cycloid_angle";
    groove->size = source->cam->cycloid_angle;
    groove->height = source->cam->cycloid_rise;
    groove->last = groove->size;
    return true;
}

/* y - sin(y) for 0 <= y <= pi, by its series where the difference cancels: the ninth term is 1e-17 of the first. */
static double less_sine(double y) {
    if (y > 1.0) return y - elementary_sin_cos(y).sin;
    double sum = 1.0;
    for (int n = 16; n >= 2; n -= 2) sum = 1.0 - y * y / ((n + 2) * (n + 3)) * sum;
    return y * y * y / 6.0 * sum;
}

/* The upper half is the lower one, turned about the middle. */
static GroovePoint at(const Groove *g, double psi) {
    const double B = g->size, H = g->height;
    const bool upper = psi > 0.5 * B;
    const double x = (upper ? B - psi : psi) / B, rise = H * less_sine(2.0 * PI * x) / (2.0 * PI);
    const SinCos half = elementary_sin_cos(PI * x);
    const double bend = 4.0 * PI * H / (B * B) * half.sin * half.cos;
    return (GroovePoint){
        .z = upper ? H - rise : rise,
        .slope = 2.0 * H / B * half.sin * half.sin,
        .dslope_dpsi = upper ? -bend : bend,
    };
}

/* y - sin(y) = c: Newton's method. Six steps from the first term of the series reach rounding. */
static double angle(const Groove *g, double z) {
    const double B = g->size, share = max_of(min_of(z / g->height, 1.0), 0.0);
    const double c = 2.0 * PI * min_of(share, 1.0 - share);
    double y = elementary_cbrt(6.0 * c);
    for (int n = 0; n < 6 && y > 0.0; n++) {
        const double sine = elementary_sin_cos(0.5 * y).sin;
        y = min_of(y - (less_sine(y) - c) / (2.0 * sine * sine), PI);
    }
    const double psi = B * y / (2.0 * PI);
    return share > 0.5 ? B - psi : psi;
}

const GrooveLaw GROOVE_CYCLOID = {"cycloidal", "psi must stay in [0, cycloid_angle]", build, at, angle};
