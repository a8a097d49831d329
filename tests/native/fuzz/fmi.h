/* One name each for what FMI 2.0 and FMI 3.0 call differently. */
#ifndef FUZZ_FMI_H
#define FUZZ_FMI_H

/* FMI(name): a name of both versions. FMI_2_3(name2, name3): its names in FMI 2.0 and in FMI 3.0. VALUES(n): the
 * argument with the number of values, which FMI 2.0 does not have. */
#if FMI_VERSION == 2
#include "fmi2Functions.h"
#define FMI(name) fmi2##name
#define FMI_2_3(name2, name3) fmi2##name2
#define VALUES(n)
#else
#include "fmi3Functions.h"
#define FMI(name) fmi3##name
#define FMI_2_3(name2, name3) fmi3##name3
#define VALUES(n) , n
#endif

static inline bool is_ok(FMI(Status) status) {
    return status == FMI(OK);
}

#endif
