/* The memory of the process: counted, and refused on demand. The functions malloc() and the like of this program take
 * the place of those of glibc, also for the FMU's binary. Under ThreadSanitizer nothing is refused. */
#ifndef FAULTS_ALLOCATIONS_H
#define FAULTS_ALLOCATIONS_H

#include <stdbool.h>

/* Blocks that are not freed. */
long blocks_in_use(void);

/* The n-th allocation from now on fails; n = 0: none. With `lasting` all later ones fail, too, until the next call. */
void fail_allocation(long n, bool lasting);

/* Has an allocation failed since fail_allocation()? */
bool allocation_failed(void);

#endif
