/* The tables of grooves and friction that the component holds. The draft does not say how a host shows the FMU's
 * resources to a component, and a component without files runs in every host. So export_fmu() writes the tables of a
 * design into the component, and the component answers the system calls of its C library itself. The project's own
 * component holds no table. */
#ifndef DUALCAM_RESOURCE_FILES_H
#define DUALCAM_RESOURCE_FILES_H

#include <stdint.h>

/* The directory of the tables, by which the FMU finds a table with a relative path. */
#define RESOURCES_DIRECTORY "/"

#define FILES_MARK "dualcam table files, layout 2\n" /* in dualcam/export/component_files.py, too */
enum { FILES_MARK_SIZE = 32, FILE_COUNT = 4, FILE_NAME_SIZE = 32 };

/* A file in linear memory. An empty name: no file. */
typedef struct {
    char name[FILE_NAME_SIZE];
    uint32_t address, size;
} ResourceFile;

typedef struct {
    char mark[FILES_MARK_SIZE];
    ResourceFile file[FILE_COUNT];
} ResourceFiles;

#endif
