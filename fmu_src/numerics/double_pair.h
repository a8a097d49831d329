/* Two doubles that share one vector register: one instruction computes both. */
#ifndef DUALCAM_DOUBLE_PAIR_H
#define DUALCAM_DOUBLE_PAIR_H

typedef double DoublePair __attribute__((vector_size(2 * sizeof(double))));

#endif
