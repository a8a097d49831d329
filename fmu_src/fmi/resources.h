/* Where the FMU's resources are: from the URI or path that the master gives to a directory. */
#ifndef DUALCAM_RESOURCES_H
#define DUALCAM_RESOURCES_H

#include <stdbool.h>

/* Sets *directory to the path that `location` names, to be freed by the caller, or to NULL if it is no file URI
 * of this machine: then relative file names have nothing to count from. Returns false if memory is short.
 *
 * Understood are file:///x, file:/x, file://localhost/x and what masters make of them: file:////x, a slash at
 * the end, blanks instead of %20, and drives, file:///C:/x. */
bool resources_directory(const char *location, char **directory);

/* The same of a path, as FMI 3.0 has it, or of a URI after all; NULL and "" are none. */
bool resources_from_path(const char *path, char **directory);

#endif
