/* A C library for QEMU's machine `sim`: no more than the programs of core/c need. QEMU opens, reads and writes the files. */
#include "libc.h"

#include <stdarg.h>

int host_call(int call, int a, int b, int c);
int main(int argc, char **argv);
void run(void);
extern void (*const constructors[])(void), (*const constructors_end[])(void);

enum { EXIT = 1, READ = 3, WRITE = 4, OPEN = 5, ARGC = 1000, ARGV_SIZE = 1001, ARGV = 1002 };

/* The compiler's division: the ESP8266, for which it compiles, has none. */
unsigned __udivsi3(unsigned number, unsigned by);
unsigned __umodsi3(unsigned number, unsigned by);
int __divsi3(int number, int by);
int __modsi3(int number, int by);

unsigned __umodsi3(unsigned number, unsigned by)
{
    return number - __udivsi3(number, by) * by;
}

unsigned __udivsi3(unsigned number, unsigned by)
{
    unsigned quotient = 0, rest = 0;
    int bit;
    for (bit = 31; bit >= 0; bit--) {
        rest = rest << 1 | (number >> bit & 1);
        if (rest >= by) {
            rest -= by;
            quotient |= 1u << bit;
        }
    }
    return quotient;
}

int __divsi3(int number, int by)
{
    unsigned quotient = __udivsi3(number < 0 ? 0u - (unsigned)number : (unsigned)number, by < 0 ? 0u - (unsigned)by : (unsigned)by);
    return (int)((number < 0) != (by < 0) ? 0u - quotient : quotient);
}

int __modsi3(int number, int by)
{
    return number - __divsi3(number, by) * by;
}

static int host_write(FILE *file, const char *bytes, size_t count)
{
    return host_call(WRITE, (int)file, (int)bytes, (int)count);
}

void exit(int code)
{
    for (;;) host_call(EXIT, code, 0, 0);
}

void abort(void)
{
    puts("abort");
    exit(97);
}

void run(void)
{
    static char *argv[64];
    void (*const *constructor)(void);
    for (constructor = constructors; constructor != constructors_end; constructor++) (*constructor)();
    if (host_call(ARGV_SIZE, 0, 0, 0) > (int)sizeof argv) abort();
    host_call(ARGV, (int)argv, 0, 0);
    exit(main(host_call(ARGC, 0, 0, 0), argv));
}

FILE *fopen(const char *path, const char *mode)
{
    int number = host_call(OPEN, (int)path, 0, 0);
    (void)mode;
    return number < 0 ? NULL : (FILE *)number;
}

size_t fread(void *bytes, size_t size, size_t count, FILE *file)
{
    size_t got = 0;
    int more;
    while (got < size * count && (more = host_call(READ, (int)file, (int)bytes + (int)got, (int)(size * count - got))) > 0) got += (size_t)more;
    return got / size;
}

size_t fwrite(const void *bytes, size_t size, size_t count, FILE *file)
{
    return host_write(file, bytes, size * count) == (int)(size * count) ? count : 0;
}

int fclose(FILE *file)
{
    (void)file;
    return 0;
}

/* Writes the digits of a number to the text; returns their end. */
static char *digits(char *text, unsigned number)
{
    char reversed[10];
    int count = 0;
    do reversed[count++] = (char)('0' + number % 10);
    while ((number /= 10) != 0);
    while (count > 0) *text++ = reversed[--count];
    return text;
}

/* Writes the format to the text, without widths; returns its end. Knows %s, %d, %u, with l or z. */
static char *formatted(char *text, const char *format, va_list list)
{
    for (; *format != 0; format++) {
        if (*format != '%') {
            *text++ = *format;
            continue;
        }
        do format++;
        while (*format == 'l' || *format == 'z' || *format == '-' || (*format >= '0' && *format <= '9'));
        if (*format == 's') {
            const char *from = va_arg(list, const char *);
            while (*from != 0) *text++ = *from++;
        } else if (*format == 'u' || *format == 'd') {
            unsigned number = va_arg(list, unsigned);
            if (*format == 'd' && (int)number < 0) {
                *text++ = '-';
                number = 0u - number;
            }
            text = digits(text, number);
        } else {
            abort();
        }
    }
    *text = 0;
    return text;
}

static int print(FILE *file, const char *format, va_list list)
{
    char line[1024];
    return host_write(file, line, (size_t)(formatted(line, format, list) - line));
}

int printf(const char *format, ...)
{
    va_list list;
    int count;
    va_start(list, format);
    count = print(stdout, format, list);
    va_end(list);
    return count;
}

int fprintf(FILE *file, const char *format, ...)
{
    va_list list;
    int count;
    va_start(list, format);
    count = print(file, format, list);
    va_end(list);
    return count;
}

int sprintf(char *text, const char *format, ...)
{
    va_list list;
    char *end;
    va_start(list, format);
    end = formatted(text, format, list);
    va_end(list);
    return (int)(end - text);
}

/* Only decimal numbers, without `end`. */
unsigned long strtoul(const char *text, char **end, int base)
{
    unsigned long number = 0;
    if (end != NULL || base != 10) abort();
    for (; *text >= '0' && *text <= '9'; text++) number = number * 10 + (unsigned long)(*text - '0');
    return number;
}

int puts(const char *text)
{
    return printf("%s\n", text);
}

int memcmp(const void *a, const void *b, size_t count)
{
    const unsigned char *x = a, *y = b;
    for (; count > 0; count--, x++, y++) {
        if (*x != *y) return *x - *y;
    }
    return 0;
}

/* Words where the addresses allow it, as in the C libraries of boards: the trackers clear and copy kilobytes. */
typedef uint32_t __attribute__((may_alias)) word;

void *memcpy(void *to, const void *from, size_t count)
{
    unsigned char *x = to;
    const unsigned char *y = from;
    if ((((uintptr_t)x | (uintptr_t)y) & 3) == 0) {
        for (; count >= 4; count -= 4, x += 4, y += 4) *(word *)x = *(const word *)y;
    }
    while (count-- > 0) *x++ = *y++;
    return to;
}

void *memset(void *to, int byte, size_t count)
{
    unsigned char *x = to;
    for (; count > 0 && ((uintptr_t)x & 3) != 0; count--) *x++ = (unsigned char)byte;
    for (; count >= 4; count -= 4, x += 4) *(word *)x = (unsigned char)byte * 0x01010101u;
    while (count-- > 0) *x++ = (unsigned char)byte;
    return to;
}

void *memchr(const void *bytes, int byte, size_t count)
{
    const unsigned char *x = bytes;
    for (; count > 0; count--, x++) {
        if (*x == (unsigned char)byte) return (void *)x;
    }
    return NULL;
}

size_t strlen(const char *text)
{
    size_t length = 0;
    while (text[length] != 0) length++;
    return length;
}

int strcmp(const char *a, const char *b)
{
    for (; *a != 0 && *a == *b; a++, b++) {
    }
    return (unsigned char)*a - (unsigned char)*b;
}
