/* A sum that does not forget what rounding cuts off.
 *
 * A million steps add a million roundings of size eps |sum|; when the increments are alike, the
 * roundings are too, and drift grows with the number of steps. Keeping the cut-off part in `lo`
 * makes the error that of the increments alone (Knuth's two-sum; D. E. Knuth, The Art of Computer
 * Programming, vol. 2, 4.2.2, theorem B). Needs IEEE arithmetic: no -ffast-math. */
#ifndef DUALCAM_SUM_H
#define DUALCAM_SUM_H

typedef struct {
    double hi; /* the sum, correctly rounded */
    double lo; /* what hi lacks */
} Sum;

static inline Sum sum_of(double x) {
    return (Sum){.hi = x, .lo = 0.0};
}

static inline void sum_add(Sum *sum, double x) {
    const double s = sum->hi + x;
    const double added = s - sum->hi;
    const double lost = (sum->hi - (s - added)) + (x - added);
    const double lo = sum->lo + lost;
    sum->hi = s + lo;
    sum->lo = lo - (sum->hi - s);
}

#endif
