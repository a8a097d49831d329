/* Two doubles that share one vector register: one instruction computes both. */
#ifndef DUALCAM_VECTOR2_H
#define DUALCAM_VECTOR2_H

typedef double Vector2 __attribute__((vector_size(2 * sizeof(double))));

#endif
