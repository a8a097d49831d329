#define _GNU_SOURCE /* strtod_l */

#include "platform/platform.h"

#include <locale.h>
#include <stdlib.h>

#ifdef _WIN32

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

static bool is_slash(char c) {
    return c == '/' || c == '\\';
}

static bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool platform_is_absolute(const char *path) {
    if (is_letter(path[0])) return path[1] == ':' && is_slash(path[2]);
    return is_slash(path[0]) && is_slash(path[1]);
}

FILE *platform_open(const char *path) {
    const int size = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, NULL, 0);
    wchar_t *wide = size > 0 ? malloc((size_t)size * sizeof *wide) : NULL;
    if (wide == NULL) return NULL;
    const bool good = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, wide, size) == size;
    FILE *file = good ? _wfopen(wide, L"rb") : NULL;
    free(wide);
    return file;
}

PlainLocale *plain_locale_new(void) {
    return (PlainLocale *)_create_locale(LC_ALL, "C");
}

void plain_locale_free(PlainLocale *locale) {
    _free_locale((_locale_t)locale);
}

double plain_number(const char *text, PlainLocale *locale) {
    return _strtod_l(text, NULL, (_locale_t)locale);
}

#else

#ifdef __APPLE__
#include <xlocale.h>
#endif
#ifndef __wasi__
#include <sys/stat.h>
#endif

bool platform_is_absolute(const char *path) {
    return path[0] == '/';
}

#ifdef __wasi__ /* has only files, and no other locale */

FILE *platform_open(const char *path) {
    return fopen(path, "rb");
}

PlainLocale *plain_locale_new(void) {
    static char plain;
    return (PlainLocale *)&plain;
}

void plain_locale_free(PlainLocale *locale) {
    (void)locale;
}

double plain_number(const char *text, PlainLocale *locale) {
    (void)locale;
    return strtod(text, NULL);
}

#else

/* To open a pipe would wait for its writer. */
FILE *platform_open(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode) ? fopen(path, "rb") : NULL;
}

PlainLocale *plain_locale_new(void) {
    return (PlainLocale *)newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

void plain_locale_free(PlainLocale *locale) {
    freelocale((locale_t)locale);
}

double plain_number(const char *text, PlainLocale *locale) {
    return strtod_l(text, NULL, (locale_t)locale);
}

#endif

#endif
