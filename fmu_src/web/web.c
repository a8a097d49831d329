#include "web/web.h"

#include <stddef.h>

/* One text for all instances: a page runs in one thread, and reads the text right after the call that was refused. */
static char last_message[2048];

/* The FMU doubles % and # for masters that expand them as FMI 2.0 asks. No message has arguments. */
static void keep_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                         fmi2String category, fmi2String text, ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    size_t length = 0;
    for (const char *c = text; *c != '\0' && length + 1 < sizeof last_message; c++) {
        if ((c[0] == '%' || c[0] == '#') && c[1] == c[0]) c++;
        last_message[length++] = *c;
    }
    last_message[length] = '\0';
}

fmi2Component web_instantiate(fmi2String guid, fmi2String resources) {
    static const fmi2CallbackFunctions callbacks = {.logger = keep_message};
    return fmi2Instantiate("page", fmi2CoSimulation, guid, resources, &callbacks, fmi2False, fmi2False);
}

const char *web_message(void) {
    return last_message;
}
