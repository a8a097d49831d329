#include "fmi/resources.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "platform/platform.h"

/* Locale-free, unlike <ctype.h>. */
static char lower(char c) {
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

/* The rest of `text` after `prefix`, or NULL if `text` does not begin with it. `prefix` is in lower case; the case of
 * `text` does not matter. */
static const char *after(const char *text, const char *prefix) {
    for (; *prefix != '\0'; text++, prefix++) /* at most one turn per character */
        if (lower(*text) != *prefix) return NULL;
    return text;
}

/* Does the path begin with a drive of Windows, "C:"? */
static bool is_drive(const char *path) {
    return lower(path[0]) >= 'a' && lower(path[0]) <= 'z' && path[1] == ':';
}

/* The encoded path, or NULL if the URI is not that of a file that can be opened. "file://server/share/x" is the file
 * "//server/share/x" where there are shares. The wrong URI "file://C:/x", which some masters make, is the
 * file "C:/x". */
static const char *path_of(const char *location) {
    const char *rest = location != NULL ? after(location, "file:") : NULL;
    if (rest == NULL) return NULL;
    const char *authority = after(rest, "//");
    if (authority == NULL) return *rest == '/' ? rest : NULL;
    const char *host = after(authority, "localhost");
    const char *path = host != NULL ? host : authority;
    if (*path == '/') return path;
    if (!PLATFORM_HAS_SHARES || *authority == '\0') return NULL;
    return is_drive(authority) ? authority : authority - 2;
}

static int hex(char c) {
    const char digit = lower(c);
    if (digit >= '0' && digit <= '9') return digit - '0';
    return digit >= 'a' && digit <= 'f' ? digit - 'a' + 10 : -1;
}

/* Replaces percent codes; a percent sign alone stays. The text does not get longer. */
static void decode(const char *encoded, char *text) {
    while (*encoded != '\0') { /* at most one turn per character */
        const int high = *encoded == '%' ? hex(encoded[1]) : -1;
        const int low = high >= 0 ? hex(encoded[2]) : -1;
        *text++ = low >= 0 ? (char)(16 * high + low) : *encoded;
        encoded += low >= 0 ? 3 : 1;
    }
    *text = '\0';
}

/* "//x" becomes "/x", unless this is a share; "/C:/x" becomes "C:/x". */
static const char *without_extra_slash(const char *path) {
    const size_t slashes = strspn(path, "/");
    const char *rest = path + slashes;
    if (slashes == 0 || is_drive(rest)) return rest;
    return rest - (PLATFORM_HAS_SHARES && slashes > 1 ? 2 : 1);
}

static void drop_last_slashes(char *path) {
    for (size_t n = strlen(path); n > 1 && path[n - 1] == '/' && path[n - 2] != ':'; n--) path[n - 1] = '\0';
}

bool resources_directory(const char *location, char **directory) {
    *directory = NULL;
    const char *encoded = path_of(location);
    if (encoded == NULL) return true;
    char *path = malloc(strlen(encoded) + 1);
    if (path == NULL) return false;
    decode(encoded, path);
    const char *rest = without_extra_slash(path);
    memmove(path, rest, strlen(rest) + 1);
    drop_last_slashes(path);
    *directory = path;
    return true;
}

bool resources_from_path(const char *path, char **directory) {
    *directory = NULL;
    if (path == NULL || *path == '\0') return true;
    if (after(path, "file:") != NULL) return resources_directory(path, directory);
    const size_t size = strlen(path) + 1;
    *directory = malloc(size);
    if (*directory == NULL) return false;
    memcpy(*directory, path, size);
    drop_last_slashes(*directory);
    return true;
}
