// Functions that smr.c needs but py/dynruntime.h lacks. That header is a native module's only interface to MicroPython.

#include <stdarg.h>
#include "py/dynruntime.h"

// Qualifier of constant tables in functions. They cannot be static: their names and types are known only after loading.
#define TABLE const

bool mp_obj_equal(mp_obj_t one, mp_obj_t other) {
    return mp_binary_op(MP_BINARY_OP_EQUAL, one, other) == mp_const_true;
}

void *m_malloc0(size_t size) {
    return memset(m_malloc(size), 0, size);
}

// Functions that Rust calls on a host. Without the attribute, GCC would replace the loop by a call of strlen itself.
__attribute__((optimize("no-tree-loop-distribute-patterns"))) size_t strlen(const char *text) {
    size_t length = 0;
    while (text[length] != 0) {
        length++;
    }
    return length;
}

int bcmp(const void *one, const void *other, size_t size) {
    const byte *a = one, *b = other;
    while (size > 0 && *a == *b) {
        a++, b++, size--;
    }
    return size > 0;
}

#define vstr_init_len(vstr, size) ((vstr)->buf = m_malloc(size), (vstr)->len = (size))

mp_obj_t mp_obj_new_bytes_from_vstr(vstr_t *vstr) {
    const mp_obj_t bytes = mp_obj_new_bytes((const byte *)vstr->buf, vstr->len);
    m_free(vstr->buf);
    return bytes;
}

// A buffer for the text of an error, which is cut after 128 bytes.
typedef struct {
    size_t length;
    char text[128];
} message_t;

static void add_text(void *data, const char *text, size_t length) {
    message_t *message = data;
    for (size_t i = 0; i < length && message->length < sizeof(message->text); i++) {
        message->text[message->length++] = text[i];
    }
}

void mp_raise_msg_varg(const mp_obj_type_t *type, mp_rom_error_text_t format, ...) {
    message_t message = { 0 };
    const mp_print_t print = { &message, add_text };
    va_list values;
    va_start(values, format);
    mp_vprintf(&print, format, values);
    va_end(values);
    nlr_raise(mp_obj_new_exception_arg1(type, mp_obj_new_str(message.text, message.length)));
}

// The named tuple class of answers. Variables of a native module must not be static.
mp_obj_t smr_answer_class;

mp_obj_t mp_obj_new_attrtuple(const qstr *names, size_t count, const mp_obj_t *items) {
    if (smr_answer_class == MP_OBJ_NULL) {
        const mp_obj_t fields = mp_obj_new_list(0, NULL);
        for (size_t i = 0; i < count; i++) {
            mp_obj_list_append(fields, MP_OBJ_NEW_QSTR(names[i]));
        }
        const mp_obj_t collections = mp_import_name(MP_QSTR_collections, mp_const_none, MP_OBJ_NEW_SMALL_INT(0));
        const mp_obj_t arguments[] = { MP_OBJ_NEW_QSTR(MP_QSTR_answer), fields };
        smr_answer_class = mp_call_function_n_kw(mp_load_attr(collections, MP_QSTR_namedtuple), 2, 0, arguments);
    }
    return mp_call_function_n_kw(smr_answer_class, count, 0, items);
}
