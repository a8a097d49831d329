/* What no step ever calls is compiled for size: at the start, or when somebody asks for something rare. */
#ifndef DUALCAM_COLD_H
#define DUALCAM_COLD_H

#define COLD __attribute__((cold))

#endif
