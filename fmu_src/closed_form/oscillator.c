#include "closed_form/oscillator.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

static const double PI = 3.14159265358979323846;

/* The roots of the characteristic equation times t are |x| <= 3.24 at OSCILLATOR_SERIES_LIMIT (2a t = w t = 2):
 * 3.24^30/34! * 24 = 2e-22. */
enum { SERIES_TERMS = 30 };

/* 1/n!. The series of p3 and p4 read the table from 1/4! and 1/5! on. */
/* clang-format off */
static const double INVERSE_FACTORIAL[SERIES_TERMS + 5] = {
    1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362880.0,
    1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0, 1.0 / 87178291200.0,
    1.0 / 1307674368000.0, 1.0 / 20922789888000.0, 1.0 / 355687428096000.0, 1.0 / 6402373705728000.0,
    1.0 / 121645100408832000.0, 1.0 / 2432902008176640000.0, 1.0 / 51090942171709440000.0,
    1.0 / 1124000727777607680000.0, 1.0 / 25852016738884976640000.0, 1.0 / 620448401733239439360000.0,
    1.0 / 15511210043330985984000000.0, 1.0 / 403291461126605635584000000.0, 1.0 / 10888869450418352160768000000.0,
    1.0 / 304888344611713860501504000000.0, 1.0 / 8841761993739701954543616000000.0,
    1.0 / 265252859812191058636308480000000.0, 1.0 / 8222838654177922817725562880000000.0,
    1.0 / 263130836933693530167218012160000000.0, 1.0 / 8683317618811886495518194401280000000.0,
    1.0 / 295232799039604140847618609643520000000.0,
};
/* clang-format on */

Oscillator oscillator_of(double decay2, double stiffness) {
    const double a = 0.5 * decay2;
    const double separation = a * a - stiffness;
    const double frequency = sqrt(fabs(separation));
    const double growth = separation > 0.0 ? frequency - a : -a; /* of the faster solution */
    return (Oscillator){
        .decay2 = decay2,
        .stiffness = stiffness,
        .separation = separation,
        .frequency = frequency,
        .half_period = separation < 0.0 ? PI / frequency : INFINITY,
        .rate = max_of(fabs(decay2), sqrt(fabs(stiffness))),
        .horizon = growth > 0.0 ? OSCILLATOR_MAX_GROWTH / growth : INFINITY,
    };
}

/* p3/t^4 and p4/t^5, where p4 is the integral of p3. */
typedef struct {
    double p3, p4;
} SeriesSums;

static SeriesSums sum_series(double a, double w) {
    double older = 0.0, newer = 1.0; /* n-th derivative of s at 0, times t^(n-1): n = 0, 1 */
    SeriesSums sum = {0.0, 0.0};
    for (int n = 1; n <= SERIES_TERMS; n++) {
        sum.p3 += newer * INVERSE_FACTORIAL[n + 3];
        sum.p4 += newer * INVERSE_FACTORIAL[n + 4];
        const double next = -a * newer - w * older;
        older = newer;
        newer = next;
        if ((fabs(newer) + fabs(older)) * INVERSE_FACTORIAL[n + 4] < OSCILLATOR_SERIES_CUT) break;
    }
    return sum;
}

/* The same for a = 0: every other derivative of s vanishes. */
static SeriesSums sum_undamped_series(double w) {
    double derivative = 1.0;
    SeriesSums sum = {0.0, 0.0};
    for (int n = 1; n <= SERIES_TERMS; n += 2) {
        sum.p3 += derivative * INVERSE_FACTORIAL[n + 3];
        sum.p4 += derivative * INVERSE_FACTORIAL[n + 4];
        derivative *= -w;
        if (fabs(derivative) * INVERSE_FACTORIAL[n + 5] < OSCILLATOR_SERIES_CUT) break;
    }
    return sum;
}

/* p3 and p4 by series; p2, p1, s and s' from the equation integrated four, three, two times and once:
 * s' + 2a s + w2 p1 = 1, s + 2a p1 + w2 p2 = t, ... In each the first term on the right dominates. */
static void fill_by_series(const Oscillator *osc, double t, Kernel *k) {
    const double w = osc->stiffness * t * t;
    const SeriesSums sum = osc->decay2 == 0.0 ? sum_undamped_series(w) : sum_series(osc->decay2 * t, w);
    const double t2 = t * t, t3 = t2 * t;
    const double p4 = sum.p4 * t2 * t3;
    k->p3 = sum.p3 * t2 * t2;
    k->p2 = t3 / 6.0 - osc->decay2 * k->p3 - osc->stiffness * p4;
    k->p1 = 0.5 * t2 - osc->decay2 * k->p2 - osc->stiffness * k->p3;
    k->s = t - osc->decay2 * k->p1 - osc->stiffness * k->p2;
    k->ds = 1.0 - osc->decay2 * k->s - osc->stiffness * k->p1;
}

/* p1, p2, p3 from s and s' by the integrated equation. Rounding grows by 12/(w2 t^2) in p3; here w2 t^2 >= 3/4. */
static void integrate_closed(const Oscillator *osc, double t, Kernel *k) {
    k->p1 = (1.0 - k->ds - osc->decay2 * k->s) / osc->stiffness;
    k->p2 = (t - k->s - osc->decay2 * k->p1) / osc->stiffness;
    k->p3 = (0.5 * t * t - k->p1 - osc->decay2 * k->p2) / osc->stiffness;
}

static void fill_underdamped(const Oscillator *osc, double t, Kernel *k) {
    const double a = 0.5 * osc->decay2, w = osc->frequency;
    const double envelope = a == 0.0 ? 1.0 : elementary_exp(-a * t);
    const SinCos turn = elementary_sin_cos(w * t);
    k->s = envelope * turn.sin / w;
    k->ds = envelope * turn.cos - a * k->s;
    integrate_closed(osc, t, k);
}

/* phi_k(x) = sum x^n/(n+k)!, k = 1, 2, 3. Above |x| = 1 the recurrence phi_{k+1} = (phi_k - 1/k!)/x loses at most one
 * digit. Below |x| = 1 the series gives phi_3, and the recurrence runs backwards. */
static void phi_functions(double x, double out[3]) {
    if (fabs(x) > 1.0) {
        out[0] = elementary_expm1(x) / x;
        out[1] = (out[0] - 1.0) / x;
        out[2] = (out[1] - 0.5) / x;
        return;
    }
    double sum = 0.0;
    for (int n = 17; n >= 0; n--) sum = sum * x + INVERSE_FACTORIAL[n + 3]; /* 1/20! = 4e-19 */
    out[2] = sum;
    out[1] = 0.5 + x * out[2];
    out[0] = 1.0 + x * out[1];
}

/* Real roots that differ by 1/t or more: p_k is the divided difference of t^k phi_k over the two roots. */
static void fill_overdamped(const Oscillator *osc, double t, Kernel *k) {
    const double a = 0.5 * osc->decay2, w = osc->frequency;
    const double large = a >= 0.0 ? -a - w : -a + w; /* no cancellation; the product of roots is w2 */
    const double small = osc->stiffness / large;
    double fast[3], slow[3];
    phi_functions(large * t, fast);
    phi_functions(small * t, slow);
    const double scale = t / (small - large);
    k->s = scale * (small * slow[0] - large * fast[0]);
    k->ds = 1.0 + large * t * fast[0] + small * k->s;
    k->p1 = scale * (slow[0] - fast[0]);
    k->p2 = scale * t * (slow[1] - fast[1]);
    k->p3 = scale * t * t * (slow[2] - fast[2]);
}

/* Real roots that differ by less than 1/t. */
static void fill_nearly_critical(const Oscillator *osc, double t, Kernel *k) {
    const double a = 0.5 * osc->decay2, w = osc->frequency;
    const double envelope = elementary_exp((w - a) * t); /* slow root; s = envelope (1 - exp(-2wt))/(2w) */
    k->s = w > 0.0 ? envelope * -elementary_expm1(-2.0 * w * t) / (2.0 * w) : envelope * t;
    k->ds = elementary_exp(-(a + w) * t) + (w - a) * k->s;
    integrate_closed(osc, t, k);
}

/* True if damping settles the motion within t. A motion that vibrates long before it settles does not count: b0
 * would be far larger than the speeds, and its terms would cancel again. */
static bool is_settled(const Oscillator *osc, double t) {
    return fabs(osc->decay2) * t > 1.0 && osc->decay2 * osc->decay2 >= osc->stiffness;
}

void oscillator_kernel(const Oscillator *osc, double t, Kernel *kernel) {
    kernel->t = t;
    kernel->lead = is_settled(osc, t) ? 1.0 / osc->decay2 : 0.0;
    kernel->has_square = false;
    if (osc->rate * t <= OSCILLATOR_SERIES_LIMIT) {
        fill_by_series(osc, t, kernel);
    } else if (osc->separation < 0.0) {
        fill_underdamped(osc, t, kernel);
    } else if (2.0 * osc->frequency * t >= 1.0) {
        fill_overdamped(osc, t, kernel);
    } else {
        fill_nearly_critical(osc, t, kernel);
    }
}

/* Adds weight times the square of omega = of_b b0 + of_alpha alpha0 + of_drive U. */
static void add_products(double weight, double of_b, double of_alpha, double of_drive, double q[6]) {
    q[0] += weight * of_b * of_b;
    q[1] += weight * of_b * of_alpha;
    q[2] += weight * of_b * of_drive;
    q[3] += weight * of_alpha * of_alpha;
    q[4] += weight * of_alpha * of_drive;
    q[5] += weight * of_drive * of_drive;
}

typedef struct {
    double reach; /* rate times t up to which the rule is exact to rounding */
    int count;
    double node[10], weight[10]; /* on [-1, 1] */
} QuadratureRule;

/* Gauss-Legendre quadrature with n points. The rates r of the integrand are at most twice the roots, r t <= 3.3
 * reach. So the error t^(2n+1) (n!)^4 / ((2n+1) (2n)!^3) r^(2n) is below 1e-17 t for the first rule, 1e-19 t for
 * the second one. (M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 25.4.30 and table 25.4) */
static const QuadratureRule QUADRATURE_RULES[2] = {
    {
        .reach = 0.1,
        .count = 5,
        .node = {0.0, 0.53846931010568309, -0.53846931010568309, 0.90617984593866399, -0.90617984593866399},
        .weight = {0.56888888888888889, 0.47862867049936647, 0.47862867049936647, 0.23692688505618909,
                   0.23692688505618909},
    },
    {
        .reach = 1.0,
        .count = 10,
        .node = {0.14887433898163121, -0.14887433898163121, 0.43339539412924719, -0.43339539412924719,
                 0.67940956829902441, -0.67940956829902441, 0.86506336668898451, -0.86506336668898451,
                 0.97390652851717172, -0.97390652851717172},
        .weight = {0.29552422471475287, 0.29552422471475287, 0.26926671930999636, 0.26926671930999636,
                   0.21908636251598204, 0.21908636251598204, 0.14945134915058059, 0.14945134915058059,
                   0.066671344308688138, 0.066671344308688138},
    },
};

/* s(x t)/t and p1(x t)/t^2 as polynomials in x; the coefficients follow from the derivatives of s at 0. Returns the
 * number of terms that matter for x <= 1. */
static int power_series(const Oscillator *osc, double t, double s[SERIES_TERMS], double p1[SERIES_TERMS]) {
    const double a = osc->decay2 * t, w = osc->stiffness * t * t;
    double older = 0.0, newer = 1.0;
    for (int n = 0; n < SERIES_TERMS; n++) {
        s[n] = newer * INVERSE_FACTORIAL[n + 1];
        p1[n] = newer * INVERSE_FACTORIAL[n + 2];
        const double next = -a * newer - w * older;
        older = newer;
        newer = next;
        if ((fabs(newer) + fabs(older)) * INVERSE_FACTORIAL[n + 2] < OSCILLATOR_SERIES_CUT) return n + 1;
    }
    return SERIES_TERMS;
}

/* With c = 1 - w2 p1: omega = c omega0 + s alpha0 + p1 U = c b0 + (s - lead c) alpha0 + p1 U. */
static void square_by_quadrature(const Oscillator *osc, double lead, double t, double q[6]) {
    const QuadratureRule *rule = &QUADRATURE_RULES[osc->rate * t <= QUADRATURE_RULES[0].reach ? 0 : 1];
    double s_of_x[SERIES_TERMS], p1_of_x[SERIES_TERMS];
    const int terms = power_series(osc, t, s_of_x, p1_of_x);
    for (int i = 0; i < 6; i++) q[i] = 0.0;
    for (int i = 0; i < rule->count; i++) {
        const double x = 0.5 * (1.0 + rule->node[i]);
        double s = 0.0, p1 = 0.0;
        for (int n = terms - 1; n >= 0; n--) {
            s = s * x + s_of_x[n];
            p1 = p1 * x + p1_of_x[n];
        }
        s *= t * x;
        p1 *= t * t * x * x;
        const double c = 1.0 - osc->stiffness * p1;
        add_products(0.5 * t * rule->weight[i], c, s - lead * c, p1, q);
    }
}

/* Extends the quadratic form from [0, t] to [0, 2t]. The second half starts from b(t), alpha(t) and the same U.
 * Only sums of squares arise, so nothing cancels. */
static void double_square(const Oscillator *osc, double lead, const Kernel *k, double q[6]) {
    /* row i, column j: the share of (b0, alpha0, U)[i] in (b, alpha, U)[j] at t. With lead = 1/(2a) the share of alpha0
     * in b, s - lead c + lead s', vanishes but for the term in lead^2. */
    const double pull = osc->stiffness * k->s;
    const double row[3][3] = {
        {1.0 - osc->stiffness * k->p1 - lead * pull, -pull, 0.0},
        {(lead != 0.0 ? 0.0 : k->s) + lead * lead * pull, k->ds + lead * pull, 0.0},
        {k->p1 + lead * k->s, k->s, 1.0},
    };
    double half[3][3]; /* Q applied to each row */
    for (int i = 0; i < 3; i++) {
        half[i][0] = q[0] * row[i][0] + q[1] * row[i][1] + q[2] * row[i][2];
        half[i][1] = q[1] * row[i][0] + q[3] * row[i][1] + q[4] * row[i][2];
        half[i][2] = q[2] * row[i][0] + q[4] * row[i][1] + q[5] * row[i][2];
    }
    static const unsigned char first[6] = {0, 0, 0, 1, 1, 2}, second[6] = {0, 1, 2, 1, 2, 2};
    for (int i = 0; i < 6; i++) {
        const double *left = row[first[i]], *right = half[second[i]];
        q[i] += left[0] * right[0] + left[1] * right[1] + left[2] * right[2];
    }
}

void oscillator_square(const Oscillator *osc, Kernel *kernel) {
    const double lead = kernel->lead;
    int doublings = 0;
    double t = kernel->t;
    while (osc->rate * t > QUADRATURE_RULES[1].reach && doublings < BISECTIONS_MAX) { /* at most BISECTIONS_MAX turns */
        t *= 0.5;
        doublings++;
    }
    square_by_quadrature(osc, lead, t, kernel->square);
    for (; doublings > 0; doublings--, t *= 2.0) { /* at most BISECTIONS_MAX turns */
        Kernel k;
        oscillator_kernel(osc, t, &k);
        double_square(osc, lead, &k, kernel->square);
    }
    kernel->has_square = true;
}

static double underdamped_zero(const Oscillator *osc, double y0, double dy0) {
    const double w = osc->frequency;
    const double t = elementary_atan2(y0 * w, -(dy0 + 0.5 * osc->decay2 * y0)) / w;
    return t > 0.0 ? t : t + osc->half_period;
}

/* y = A exp(l1 t) + B exp(l2 t), l1 > l2: exp((l1 - l2) t) = -B/A = 1 - (l1 - l2) y0/(dy0 - l2 y0) */
static double real_zero(const Oscillator *osc, double y0, double dy0) {
    const double a = 0.5 * osc->decay2, w = osc->frequency;
    /* l2 = -a - w, for a < 0 as w2/(w - a): no cancellation */
    const double lower = a >= 0.0 ? -a - w : osc->stiffness / (w - a);
    const double slope = dy0 - lower * y0;
    if (slope == 0.0) return INFINITY;
    const double ratio = -y0 / slope;
    if (!(ratio > 0.0)) return INFINITY;
    return w > 0.0 ? elementary_log1p(2.0 * w * ratio) / (2.0 * w) : ratio;
}

double oscillator_zero(const Oscillator *osc, double y0, double dy0) {
    if (y0 == 0.0 && dy0 == 0.0) return INFINITY;
    return osc->separation < 0.0 ? underdamped_zero(osc, y0, dy0) : real_zero(osc, y0, dy0);
}

/* y'' is -w2 times what oscillates of y. With u = tan(w t/2)/(w/2), cos(w t) = (1 - (w u/2)^2)/(1 + (w u/2)^2) and
 * sin(w t)/w = u/(1 + (w u/2)^2):
 *     0 = y0 + dy0 u + (ddy0 + w2 y0/2) u^2/2 */
double oscillator_offset_zero(const Oscillator *osc, double y0, double dy0, double ddy0) {
    const double w2 = osc->stiffness, w = sqrt(fabs(w2));
    const double root = sqrt(dy0 * dy0 - 2.0 * y0 * ddy0 - w2 * y0 * y0);
    const double u = 2.0 * y0 / ((y0 > 0.0 ? root : -root) - dy0);
    const double x = 0.5 * w * u;
    if (w == 0.0) return u;
    if (w2 < 0.0) return elementary_log1p(2.0 * x / (1.0 - x)) / w; /* 2 artanh(x)/w */
    return 2.0 * (u < 0.0 ? elementary_atan(x) + PI : elementary_atan(x)) / w;
}
