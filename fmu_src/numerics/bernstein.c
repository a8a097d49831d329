#include "numerics/bernstein.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/sign.h"

/* De Casteljau's algorithm. */
double bernstein_value(const Bernstein *p, double x) {
    double c[BERNSTEIN_MAX + 1];
    for (int i = 0; i <= p->degree; i++) c[i] = p->c[i];
    for (int level = p->degree; level > 0; level--)
        for (int i = 0; i < level; i++) c[i] += x * (c[i + 1] - c[i]);
    return c[0];
}

bool bernstein_is_monotone(const Bernstein *p) {
    bool rises = true, falls = true;
    for (int i = 0; i < p->degree; i++) {
        rises = rises && p->c[i + 1] >= p->c[i];
        falls = falls && p->c[i + 1] <= p->c[i];
    }
    return rises || falls;
}

/* The halves of p, each on [0, 1] again (de Casteljau). */
static void halve(const Bernstein *p, Bernstein *left, Bernstein *right) {
    const int n = p->degree;
    left->degree = right->degree = n;
    *right = *p;
    for (int level = 0; level <= n; level++) {
        left->c[level] = right->c[0];
        for (int i = 0; i < n - level; i++) right->c[i] = 0.5 * (right->c[i] + right->c[i + 1]);
    }
}

/* False also where a coefficient is not a number: halving would go on for ever. */
static bool has_negative(const Bernstein *p) {
    bool negative = false;
    for (int i = 0; i <= p->degree; i++) {
        if (isnan(p->c[i])) return false;
        negative |= p->c[i] < 0.0;
    }
    return negative;
}

/* 0 also where a coefficient is not a number. */
static int sign_changes(const Bernstein *p) {
    int changes = 0;
    double last = 0.0;
    for (int i = 0; i <= p->degree; i++) {
        if (isnan(p->c[i])) return 0;
        if (p->c[i] == 0.0) continue;
        if (last != 0.0 && (last > 0.0) != (p->c[i] > 0.0)) changes++;
        last = p->c[i];
    }
    return changes;
}

/* The zero of sign p in (left, right], to `width`, by two steps of regula falsi and one of bisection in turn. The
 * values of sign p at the ends are f_left >= 0 and f_right <= 0. */
static double zero_between(const Bernstein *p, double sign, double left, double f_left, double right, double f_right,
                           double width) {
    for (int n = 0; n < BRACKET_ITERATIONS && right - left > width; n++) {
        const double span = f_left - f_right;
        double x = n % 3 == 2 || !(span > 0.0) ? 0.5 * (left + right) : left + (right - left) * f_left / span;
        if (!(x > left && x < right)) x = 0.5 * (left + right);
        const double f = sign * bernstein_value(p, x);
        if (f > 0.0) {
            left = x;
            f_left = f;
        } else {
            right = x;
            f_right = f;
        }
    }
    return right;
}

/* The only zero of p in (0, 1]; p > 0 before the zero and p < 0 after the zero. */
static double only_zero(const Bernstein *p) {
    return zero_between(p, 1.0, 0.0, max_of(p->c[0], 0.0), 1.0, min_of(p->c[p->degree], 0.0), BERNSTEIN_ZERO_WIDTH);
}

/* bernstein_descent() of a p that does not fall at 0, after `depth` halvings. */
static double descent(const Bernstein *p, int depth) {
    if (!has_negative(p)) return INFINITY;
    if (sign_changes(p) == 1 && p->c[p->degree] < 0.0) return only_zero(p);
    if (depth >= BERNSTEIN_MAX_DEPTH) return p->c[p->degree] < 0.0 ? 1.0 : INFINITY;
    Bernstein left, right;
    halve(p, &left, &right);
    double x = descent(&left, depth + 1);
    if (x < INFINITY) return 0.5 * x;
    if (left.c[left.degree] < 0.0) return 0.5; /* within rounding p falls at the middle */
    x = descent(&right, depth + 1);
    return x < INFINITY ? 0.5 + 0.5 * x : INFINITY;
}

double bernstein_descent(const Bernstein *p) {
    Bernstein q = *p;
    int first = 0; /* the first coefficient that is not zero */
    /* At most BERNSTEIN_MAX + 1 turns. */
    while (first <= q.degree && !(q.c[first] > 0.0) && !(q.c[first] < 0.0)) first++;
    if (first > q.degree) return INFINITY;
    if (q.c[0] < 0.0) {
        if (q.degree == 0 || !(q.c[1] > q.c[0])) return 0.0;
        q.c[0] = 0.0;
        return descent(&q, 0);
    }
    if (q.c[first] < 0.0) return 0.0;
    return descent(&q, 0);
}

/* The sign of the first (step 1) or last (step -1) coefficient that is not zero, or 0. */
static int outer_sign(const Bernstein *p, int step) {
    for (int i = step > 0 ? 0 : p->degree; i >= 0 && i <= p->degree; i += step) /* at most BERNSTEIN_MAX + 1 turns */
        if (p->c[i] != 0.0) return sign_of(p->c[i]);
    return 0;
}

/* The only x in (0, 1] at which p changes its sign. */
static double only_crossing(const Bernstein *p) {
    Bernstein falling = *p;
    const double sign = outer_sign(p, 1);
    for (int i = 0; i <= p->degree; i++) falling.c[i] *= sign;
    return only_zero(&falling);
}

/* Appends to x the sign changes of p, which stands for the whole polynomial on [from, from + width]. Returns the new
 * number of sign changes. */
static int collect_crossings(const Bernstein *p, double from, double width, int depth, double *x, int count) {
    const int changes = sign_changes(p);
    if (changes == 0 || (depth >= BERNSTEIN_MAX_DEPTH && changes % 2 == 0) || count >= BERNSTEIN_MAX) return count;
    if (changes == 1 || depth >= BERNSTEIN_MAX_DEPTH) {
        x[count] = from + width * only_crossing(p);
        return count + 1;
    }
    Bernstein left, right;
    halve(p, &left, &right);
    count = collect_crossings(&left, from, 0.5 * width, depth + 1, x, count);
    const bool between = right.c[0] == 0.0 && outer_sign(&left, -1) * outer_sign(&right, 1) < 0;
    if (between && count < BERNSTEIN_MAX) x[count++] = from + 0.5 * width;
    return collect_crossings(&right, from + 0.5 * width, 0.5 * width, depth + 1, x, count);
}

int bernstein_crossings(const Bernstein *p, double x[BERNSTEIN_MAX]) {
    return collect_crossings(p, 0.0, 1.0, 0, x, 0);
}
Bernstein bernstein_derivative(const Bernstein *p) {
    Bernstein d = {.degree = p->degree > 0 ? p->degree - 1 : 0};
    for (int i = 0; i < p->degree; i++) d.c[i] = p->degree * (p->c[i + 1] - p->c[i]);
    return d;
}

/* The largest of 17 samples, or the maximum of |p| beside this sample, where the derivative of p is zero. */
double bernstein_peak(const Bernstein *p) {
    enum { SAMPLES = 16 };
    int best = 0;
    double largest = -1.0;
    for (int i = 0; i <= SAMPLES; i++) {
        const double size = fabs(bernstein_value(p, (double)i / (int)SAMPLES));
        if (size > largest) {
            largest = size;
            best = i;
        }
    }
    const double sign = bernstein_value(p, (double)best / (int)SAMPLES) < 0.0 ? -1.0 : 1.0;
    const Bernstein d = bernstein_derivative(p);
    double left = max_of(best - 1.0, 0.0) / (int)SAMPLES,
           right = min_of(best + 1.0, (double)(int)SAMPLES) / (int)SAMPLES;
    const double rises = sign * bernstein_value(&d, left), falls = sign * bernstein_value(&d, right);
    if (rises <= 0.0 || falls >= 0.0) return (double)best / (int)SAMPLES; /* no maximum beside the sample */
    return zero_between(&d, sign, left, rises, right, falls, BERNSTEIN_PEAK_WIDTH);
}

/* ---- polynomials of degree 3 in time ---- */

Bernstein bernstein_of_taylor(const double u[4], double t_end) {
    const double a0 = u[0], a1 = u[1] * t_end, a2 = u[2] * t_end * t_end / 2.0, a3 = u[3] * t_end * t_end * t_end / 6.0;
    return (Bernstein){
        .degree = 3,
        .c = {a0, a0 + a1 / 3.0, a0 + 2.0 * a1 / 3.0 + a2 / 3.0, a0 + a1 + a2 + a3},
    };
}

/* The sign of the first derivative of u that is not zero: u moves that way at first. */
static int first_direction(const double u[4]) {
    for (int k = 1; k <= 3; k++)
        if (u[k] != 0.0) return sign_of(u[k]);
    return 0;
}

/* The times after 0 at which the rate u_1 + u_2 t + u_3 t^2/2 changes its sign, in order; infinity: none. No difference
 * cancels in them. */
static void turning_times(const double u[4], double t[2]) {
    t[0] = t[1] = INFINITY;
    const double root = sqrt(max_of(u[2] * u[2] - 2.0 * u[3] * u[1], 0.0));
    if (!(root > 0.0)) return;
    const double sum = u[2] + copysign(root, u[2]);
    if (sign_of(u[1]) * sign_of(sum) < 0) t[0] = -2.0 * u[1] / sum;
    if (sign_of(u[3]) * sign_of(sum) < 0) t[1] = -sum / u[3];
    if (t[0] > t[1]) {
        const double later = t[0];
        t[0] = t[1];
        t[1] = later;
    }
}

/* Between two turns u is monotone. So the first turn outside the strip tells the sign, or what follows the last turn.
 * */
int taylor_leaving_sign(const double u[4], double width) {
    int direction = first_direction(u);
    double t[2];
    turning_times(u, t);
    for (int i = 0; i < 2; i++) {
        if (!(t[i] < INFINITY)) break;
        const double value = u[0] + t[i] * (u[1] + t[i] / 2.0 * (u[2] + t[i] / 3.0 * u[3]));
        if (fabs(value) > width) return direction;
        direction = -direction;
    }
    return direction;
}
