/* The directory of the FMU's resources, from the URI or path that the master gives. */
#ifndef DUALCAM_RESOURCES_H
#define DUALCAM_RESOURCES_H

#include <stdbool.h>

/* Sets *directory to the path that `location` names; the caller frees it. Sets NULL if `location` is not a file URI of
 * this machine; then there is no directory that relative file names start from. False if memory is short.
 *
 * Accepted are file:///x, file:/x and file://localhost/x, and the forms that masters make of them: file:////x, a slash
 * at the end, blanks instead of %20, and drives, file:///C:/x. */
bool resources_directory(const char *location, char **directory);

/* The same from a path, as FMI 3.0 asks for; a URI is accepted too. NULL and "" name no directory. */
bool resources_from_path(const char *path, char **directory);

#endif
