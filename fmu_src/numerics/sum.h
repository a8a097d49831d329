/* Compensated sums.
 *
 * A million steps add a million roundings of size eps |sum|. When the increments are equal, the roundings are equal
 * too, and the error grows with the number of steps. A compensated sum keeps the part that rounding cuts off in `lo`;
 * its error is that of the increments alone (two-sum; D. E. Knuth, The Art of Computer Programming, vol. 2, 4.2.2,
 * theorem B). The method needs IEEE arithmetic: no -ffast-math. */
#ifndef DUALCAM_SUM_H
#define DUALCAM_SUM_H

typedef struct {
    double hi; /* the sum, correctly rounded */
    double lo; /* the exact sum less hi */
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
