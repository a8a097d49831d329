/* The web room: what a page in a browser needs besides the functions of FMI 2.0. A page cannot give the FMU a callback
 * in C. So this room takes the messages of the FMU and keeps the last one for the page.
 *
 * Only build/web/<model>.wasm holds this room; no FMU does. It includes no other room, only the header of FMI 2.0. */
#ifndef DUALCAM_WEB_H
#define DUALCAM_WEB_H

#include "fmi2Functions.h"

/* fmi2Instantiate() for co-simulation, with a logger that keeps the message. */
FMI2_Export fmi2Component web_instantiate(fmi2String guid, fmi2String resources);

/* The text of the last message, as the FMU means it; "" before the first one. */
FMI2_Export const char *web_message(void);

#endif
