/* The platform room: all that differs between operating systems and compilers, and nothing else. It includes no other
 * room. */
#ifndef DUALCAM_PLATFORM_H
#define DUALCAM_PLATFORM_H

#include <stdbool.h>
#include <stdio.h>

/* Is the path, in UTF-8, absolute, so that current directory and drive do not matter? POSIX: "/x". Windows: "C:\x",
 * "C:/x" and shares, "\\server\share\x". */
bool platform_is_absolute(const char *path);

/* Is "//server/share/x" the path of a file on another machine? */
#ifdef _WIN32
enum { PLATFORM_HAS_SHARES = 1 };
#else
enum { PLATFORM_HAS_SHARES = 0 };
#endif

/* fopen(path, "rb") with the path in UTF-8. NULL also where the path is no file, such as a directory or a pipe. */
FILE *platform_open(const char *path);

/* The "C" locale, with a decimal point; the locale of the host application may have a decimal comma. NULL if memory is
 * short. */
typedef struct PlainLocale PlainLocale;
PlainLocale *plain_locale_new(void);
void plain_locale_free(PlainLocale *locale);

/* strtod(text, NULL) in this locale; the locale of the thread is neither used nor changed. */
double plain_number(const char *text, PlainLocale *locale);

#endif
