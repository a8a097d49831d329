/* Dual numbers: a value and its derivative by one variable, which is theta unless a comment says otherwise. The
 * arithmetic computes the derivative exactly, up to rounding (forward mode: A. Griewank, A. Walther, Evaluating
 * Derivatives, 2nd ed., chapter 3.) */
#ifndef DUALCAM_DUAL_H
#define DUALCAM_DUAL_H

typedef struct {
    double value;
    double slope;
} Dual;

static inline Dual dual_add(Dual a, Dual b) {
    return (Dual){a.value + b.value, a.slope + b.slope};
}

static inline Dual dual_scale(double factor, Dual a) {
    return (Dual){factor * a.value, factor * a.slope};
}

/* offset + factor a */
static inline Dual dual_line(double offset, double factor, Dual a) {
    return (Dual){offset + factor * a.value, factor * a.slope};
}

static inline Dual dual_multiply(Dual a, Dual b) {
    return (Dual){a.value * b.value, a.slope * b.value + a.value * b.slope};
}

#endif
