/* The calls of the C library that the programs of core/c make: libc.c. */
#ifndef LIBC_H
#define LIBC_H
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct FILE FILE;
#define stdout ((FILE *)1)
#define stderr ((FILE *)2)
#define EXIT_SUCCESS 0
#define EXIT_FAILURE 1
#define PRId32 "d"

FILE *fopen(const char *path, const char *mode);
size_t fread(void *bytes, size_t size, size_t count, FILE *file);
size_t fwrite(const void *bytes, size_t size, size_t count, FILE *file);
int fclose(FILE *file);
int printf(const char *format, ...);
int fprintf(FILE *file, const char *format, ...);
int sprintf(char *text, const char *format, ...);
int puts(const char *text);
unsigned long strtoul(const char *text, char **end, int base);
void exit(int code) __attribute__((noreturn));
void abort(void) __attribute__((noreturn));
int memcmp(const void *a, const void *b, size_t count);
void *memcpy(void *to, const void *from, size_t count);
void *memset(void *to, int byte, size_t count);
void *memchr(const void *bytes, int byte, size_t count);
size_t strlen(const char *text);
int strcmp(const char *a, const char *b);

#ifdef __cplusplus
}
#endif
#endif
