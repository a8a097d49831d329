#include "numerics/quadrature.h"

#include <math.h>
#include <stddef.h>

#include "elementary/elementary.h"
#include "numerics/golden_section.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

enum { KNOTS = 15, POINTS = KNOTS + 2 };

/* Knots and weights on [-1, 1], from the end to the middle; every second knot is a Gauss point. */
static const double KNOT[8] = {0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                               0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                               0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
                               0.207784955007898467600689403773245, 0.0};
static const double KRONROD[8] = {0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                                  0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                                  0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                  0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
static const double GAUSS[4] = {0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                                0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

/* Samples at the start of an interval (index 0), at the knots (1 to 15) and at the end (16). */
typedef struct {
    double x[POINTS];
    QuadratureSample sample[POINTS];
} Panel;

/* 0 to 14 -> 0 to 7 and back to 0 */
static int mirrored(int j) {
    return j < 8 ? j : 14 - j;
}

static void sample_panel(const Quadrature *s, double from, double to, Panel *panel) {
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    panel->x[0] = from;
    panel->x[POINTS - 1] = to;
    for (int j = 0; j < KNOTS; j++) panel->x[j + 1] = middle + (j < 8 ? -half : half) * KNOT[mirrored(j)];
    for (int k = 0; k < POINTS; k++) s->integrand(s->scene, panel->x[k], &panel->sample[k]);
}

/* ---- integrals ---- */

/* Returns the largest difference of the two rules, J. *size is the sum of the magnitudes of all energies, J. */
static double integrate(const Panel *panel, double total[RATE_COUNT], double *size) {
    const double half = 0.5 * (panel->x[POINTS - 1] - panel->x[0]);
    double error = 0.0;
    *size = 0.0;
    for (int c = 0; c < RATE_COUNT; c++) {
        double kronrod = 0.0, gauss = 0.0, magnitude = 0.0;
        for (int j = 0; j < KNOTS; j++) {
            const double rate = panel->sample[j + 1].rate[c];
            kronrod += KRONROD[mirrored(j)] * rate;
            magnitude += KRONROD[mirrored(j)] * fabs(rate);
            if (j % 2 == 1) gauss += GAUSS[mirrored(j) / 2] * rate;
        }
        total[c] = half * kronrod;
        if (c >= RATE_ENERGIES) continue;
        error = max_of(error, fabs(half * (kronrod - gauss)));
        *size += fabs(half) * magnitude;
    }
    return error;
}

/* ---- peaks ---- */

/* One of the magnitudes of the integrand as a function of the coordinate. */
typedef struct {
    const Quadrature *quadrature;
    int component;
} Magnitude;

static double magnitude_at(const void *context, double x) {
    const Magnitude *magnitude = context;
    QuadratureSample sample;
    magnitude->quadrature->integrand(magnitude->quadrature->scene, x, &sample);
    return sample.size[magnitude->component];
}

/* The largest value of magnitude c between a and b. */
static double maximum(const Quadrature *s, int c, double a, double b) {
    const Magnitude magnitude = {s, c};
    return golden_section_maximum(magnitude_at, &magnitude, a, b, GOLDEN_STEPS).value;
}

static void raise_peaks(Quadrature *s, const Panel *panel) {
    for (int c = 0; c < SIZE_COUNT; c++) {
        int best = 0;
        for (int k = 1; k < POINTS; k++)
            if (panel->sample[k].size[c] > panel->sample[best].size[c]) best = k;
        const double top = panel->sample[best].size[c];
        const bool inside = best > 0 && best < POINTS - 1;
        const double drop =
            inside ? top - min_of(panel->sample[best - 1].size[c], panel->sample[best + 1].size[c]) : 0.0;
        if (drop > QUADRATURE_PEAK_ROUNDING * top && top + drop > s->peak[c])
            s->peak[c] = max_of(s->peak[c], maximum(s, c, panel->x[best - 1], panel->x[best + 1]));
        s->peak[c] = max_of(s->peak[c], top);
    }
}

/* ---- division of the interval ---- */

/* Bisects to the point between a and b at which the formula `branch` ceases to hold: *before is the last double where
 * this formula holds, *after the next double. */
static void find_change(const Quadrature *s, double a, double b, int branch, double *before, double *after) {
    for (int n = 0; n < BISECTIONS_MAX; n++) {
        const double middle = 0.5 * (a + b);
        if (middle == a || middle == b) break;
        QuadratureSample sample;
        s->integrand(s->scene, middle, &sample);
        if (sample.branch == branch) a = middle;
        else b = middle;
    }
    *before = a;
    *after = b;
}

/* The scale of an interval. */
typedef struct {
    double width;
    double size; /* J, sum of the magnitudes of all energies, nearly */
} Scale;

static bool is_known(Quadrature *s, const Panel *panel) {
    for (int k = 0; k < POINTS; k++) {
        if (panel->sample[k].branch >= 0) continue;
        s->bad = panel->x[k];
        return false;
    }
    return true;
}

/* The index of the first sample at which another formula holds than at the sample before, or 0. */
static int first_change(const Panel *panel) {
    for (int k = 1; k < POINTS; k++)
        if (panel->sample[k].branch != panel->sample[k - 1].branch) return k;
    return 0;
}

typedef enum { PANEL_COVERS, PANEL_DIVIDES, PANEL_UNKNOWN } PanelVerdict;

/* Integrates over [from, to] by one panel, or divides the interval into [from, cut[0]] and [cut[1], to]. The panel does
 * not stay on the stack while the parts are covered. */
NOINLINE static PanelVerdict try_panel(Quadrature *s, const Scale *whole, double from, double to, bool spent,
                                       Scale *own, double cut[2]) {
    Panel panel;
    sample_panel(s, from, to, &panel);
    s->panels++;
    if (!is_known(s, &panel)) return PANEL_UNKNOWN;
    double total[RATE_COUNT];
    own->width = fabs(to - from);
    const double error = integrate(&panel, total, &own->size);
    const Scale *scale = whole != NULL ? whole : own;
    const int change = spent || own->width < QUADRATURE_NARROW * scale->width ? 0 : first_change(&panel);
    if (change > 0) {
        find_change(s, panel.x[change - 1], panel.x[change], panel.sample[change - 1].branch, &cut[0], &cut[1]);
        return PANEL_DIVIDES;
    }
    const double allowed = s->rounding + max_of(s->tolerance * max_of(own->size, QUADRATURE_NEGLIGIBLE * scale->size),
                                                QUADRATURE_ROUNDING * own->size);
    if (error > allowed && !spent) {
        cut[0] = cut[1] = 0.5 * (from + to);
        return PANEL_DIVIDES;
    }
    for (int c = 0; c < RATE_COUNT; c++) s->total[c] += total[c];
    raise_peaks(s, &panel);
    return PANEL_COVERS;
}

/* Integrates over [from, to], divided as far as necessary. `whole` is the scale of the interval asked for, or NULL if
 * [from, to] is this interval. */
static bool cover(Quadrature *s, const Scale *whole, double from, double to, int depth) {
    if (from == to) return true;
    Scale own;
    double cut[2];
    const bool spent = depth >= QUADRATURE_MAX_DEPTH || s->panels + 1 >= QUADRATURE_MAX_PANELS;
    const PanelVerdict verdict = try_panel(s, whole, from, to, spent, &own, cut);
    if (verdict != PANEL_DIVIDES) return verdict == PANEL_COVERS;
    const Scale *scale = whole != NULL ? whole : &own;
    return cover(s, scale, from, cut[0], depth + 1) && cover(s, scale, cut[1], to, depth + 1);
}

bool quadrature_over(Quadrature *quadrature, double from, double to) {
    return cover(quadrature, NULL, from, to, 0);
}
