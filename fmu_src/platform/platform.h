/* What differs between operating systems, and nothing else. */
#ifndef DUALCAM_PLATFORM_H
#define DUALCAM_PLATFORM_H

#include <stdbool.h>
#include <stdio.h>

/* Does the path, in UTF-8, name its file whatever the current directory and drive are? POSIX: "/x". Windows:
 * "C:\x", "C:/x" and shares, "\\server\share\x". */
bool platform_is_absolute(const char *path);

/* fopen(path, "rb") with the path in UTF-8. */
FILE *platform_open(const char *path);

/* The "C" locale: the host application's may have a decimal comma. NULL if memory is short. */
typedef struct PlainLocale PlainLocale;
PlainLocale *plain_locale_new(void);
void plain_locale_free(PlainLocale *locale);

/* strtod(text, NULL) in that locale; the thread's own plays no part and does not change. */
double plain_number(const char *text, PlainLocale *locale);

#endif
