// The module `smr` of MicroPython: the trackers of libsmr.a as two classes, Paper and Robust. This file only converts
// arguments and results; README.md documents the module for users, smr.h the calls.
//
// Memory is on MicroPython's heap. A tracker lives in its Python object, which the garbage collector never moves. All trackers of a kind and size share
// a workspace, and all share the gray pixels converted from a color camera; a root pointer keeps both from the garbage collector.
//
// This source compiles to a part of the firmware or to a native module, which is a file.

#ifdef MICROPY_ENABLE_DYNRUNTIME
#include "native.h"
#else
#include "py/objstr.h"
#include "py/objtuple.h"
#include "py/runtime.h"
#define TABLE static const
#endif
#include "smr.h"

#if !defined(MICROPY_ENABLE_DYNRUNTIME) && !MICROPY_MODULE_BUILTIN_INIT
#error "the module smr needs MICROPY_MODULE_BUILTIN_INIT: after a soft reset it must forget its memory"
#endif

// Largest number that every board stores as a small int, not as a heap object.
#define LARGEST 0x3fffffff

typedef struct {
    mp_obj_base_t base;
    smr_tracker *tracker; // in `storage`
    void *workspace; // keeps it from the garbage collector
    uint16_t width, height; // of the buffers, as `lock` or `restore` had them
    uint8_t storage[] __attribute__((aligned(SMR_ALIGNMENT)));
} tracker_t;

// Memory that all trackers share.
typedef struct {
    void *workspaces[3]; // of Paper, of Robust, and of Robust of the small size
    uint8_t *pixels; // gray pixels of the windows
    size_t size; // bytes there
} shared_t;

#ifdef MICROPY_ENABLE_DYNRUNTIME
shared_t smr_shared;
qstr smr_states[4]; // a tracker of a former import has lost the table of names
mp_obj_full_type_t smr_type_paper, smr_type_robust;
#define SHARED (&smr_shared)
#else
MP_REGISTER_ROOT_POINTER(void *smr_shared);
#define SHARED ((shared_t *)MP_STATE_VM(smr_shared))
static const qstr smr_states[] = { MP_QSTR_tracking, MP_QSTR_leaving, MP_QSTR_uncertain, MP_QSTR_lost };
extern const mp_obj_type_t smr_type_paper, smr_type_robust;
#endif
#define PAPER ((const mp_obj_type_t *)&smr_type_paper)
#define ROBUST ((const mp_obj_type_t *)&smr_type_robust)

// Errors

#include "words.h"

// Raises an exception unless `status` is SMR_OK. If the status is about one line of the frame, `line` is that line.
static void check_line(smr_status status, uint16_t line) {
    if (status == SMR_OK) {
        return;
    }
    mp_rom_error_text_t text = words(status);
    if (text == NULL) {
        mp_raise_msg_varg(&mp_type_RuntimeError, MP_ERROR_TEXT("%s"), smr_status_name(status));
    }
    // Formats a text from `words` only if it has a placeholder, as here and in `restore`: the format buffer of
    // MicroPython 1.29 is one byte too short for the longest text.
    if (status == SMR_ERROR_LINE_TOO_SHORT) {
        mp_raise_msg_varg(&mp_type_ValueError, text, (int)line);
    }
    mp_raise_msg(status == SMR_ERROR_NOT_LOCKED ? &mp_type_RuntimeError : &mp_type_ValueError, text);
}

#define check(status) check_line(status, 0)

// Arguments

// Converts the argument `name` to an integer of `least` to `most`, or raises an exception.
static mp_int_t number(mp_obj_t value, mp_int_t least, mp_int_t most, const char *name) {
    // Every int that is a heap object counts as out of range: small ints hold all values up to `LARGEST`.
    const bool is_large = mp_obj_is_exact_type(value, &mp_type_int);
    if (!is_large && !mp_obj_is_small_int(value) && value != mp_const_true && value != mp_const_false) {
        mp_raise_msg_varg(&mp_type_TypeError, MP_ERROR_TEXT("%s must be a whole number"), name);
    }
    const mp_int_t number = is_large ? 0 : mp_obj_get_int(value);
    if (is_large || number < least || number > most) {
        mp_raise_msg_varg(&mp_type_ValueError, MP_ERROR_TEXT("%s must be %d to %d"), name, (int)least, (int)most);
    }
    return number;
}

// The `count` items of a tuple, a list or another iterable; raises an exception for another length.
static mp_obj_t *items_of(mp_obj_t value, size_t count, const char *name) {
    if (!MP_OBJ_TYPE_HAS_SLOT(mp_obj_get_type(value), iter)) {
        mp_raise_msg_varg(&mp_type_TypeError, MP_ERROR_TEXT("%s must be a tuple of %d numbers"), name, (int)count);
    }
    const mp_obj_t list = mp_call_function_n_kw(MP_OBJ_FROM_PTR(&mp_type_list), 1, 0, &value);
    size_t length;
    mp_obj_t *items;
    mp_obj_get_array(list, &length, &items);
    if (length != count) {
        mp_raise_msg_varg(&mp_type_ValueError, MP_ERROR_TEXT("%s must be %d numbers, not %d"), name, (int)count, (int)length);
    }
    return items;
}

static smr_rect box_of(mp_obj_t value) {
    const mp_obj_t *items = items_of(value, 4, "box");
    return (smr_rect) {
        number(items[0], -LARGEST, LARGEST, "box: x"), number(items[1], -LARGEST, LARGEST, "box: y"),
        number(items[2], 0, UINT16_MAX, "box: width"), number(items[3], 0, UINT16_MAX, "box: height"),
    };
}

static mp_buffer_info_t bytes_of(mp_obj_t value, qstr name) {
    mp_buffer_info_t bytes;
    if (!mp_get_buffer(value, &bytes, MP_BUFFER_READ)) {
        mp_raise_msg_varg(&mp_type_TypeError, MP_ERROR_TEXT("%q must be an object with bytes"), name);
    }
    return bytes;
}

static mp_obj_t rect(mp_int_t x, mp_int_t y, mp_int_t width, mp_int_t height) {
    const mp_obj_t items[] = { mp_obj_new_int(x), mp_obj_new_int(y), mp_obj_new_int(width), mp_obj_new_int(height) };
    return mp_obj_new_tuple(4, items);
}

// Frames

#define FORMATS(FORMAT) FORMAT(GRAY8) FORMAT(YUYV) FORMAT(UYVY) FORMAT(RGB565_BE) FORMAT(RGB565_LE) FORMAT(BAYER8) FORMAT(GRAY10)

// Pixel formats as numbers, for Python.
enum {
    #define FORMAT(name) FORMAT_##name,
    FORMATS(FORMAT)
    #undef FORMAT
};

// NULL if the number is none of a format.
static const smr_format *format_of(int32_t number) {
    switch (number) {
        #define FORMAT(name) case FORMAT_##name: return &SMR_##name;
        FORMATS(FORMAT)
        #undef FORMAT
        default: return NULL;
    }
}

// A picture from Python: a buffer of pixels with its format, size and stride.
typedef struct {
    mp_obj_t buffer;
    int32_t format;
    uint16_t width, height;
    size_t stride;
} picture_t;

// Bytes of a line without padding.
static size_t line_bytes(const picture_t *picture) {
    switch (picture->format) {
        case FORMAT_YUYV: case FORMAT_UYVY: case FORMAT_RGB565_BE: case FORMAT_RGB565_LE: return 2 * (size_t)picture->width;
        case FORMAT_GRAY10: return ((size_t)picture->width + 3) / 4 * 5;
        default: return picture->width;
    }
}

static picture_t picture_of(mp_obj_t buffer, uint16_t width, uint16_t height, mp_obj_t format, mp_obj_t stride) {
    picture_t picture = { buffer, number(format, -LARGEST, LARGEST, "format"), width, height, number(stride, 0, LARGEST, "stride") };
    const size_t least = line_bytes(&picture);
    picture.stride = picture.stride == 0 ? least : picture.stride;
    check(picture.stride < least ? SMR_ERROR_STRIDE_TOO_SMALL : SMR_OK);
    return picture;
}

static size_t area(const smr_rect *window) {
    return (size_t)window->width * window->height;
}

// Returns shared memory for `size` gray pixels, valid until the next call of this function.
static uint8_t *pixels(size_t size) {
    if (SHARED->size < size) {
        m_del(uint8_t, SHARED->pixels, SHARED->size);
        SHARED->pixels = NULL;
        SHARED->size = 0;
        SHARED->pixels = m_new0(uint8_t, size);
        SHARED->size = size;
    }
    return SHARED->pixels;
}

// The frame for a call. Gray pictures are read in place; of other formats the pixels in the windows are converted to gray.
static smr_frame frame_of(const picture_t *picture, const smr_rect windows[2]) {
    const bool is_gray = picture->format == FORMAT_GRAY8;
    const size_t size = area(&windows[0]) + area(&windows[1]);
    uint8_t *gray = is_gray ? NULL : pixels(size);
    // Gets the buffer after the allocation, which may collect garbage and so run a finaliser that changes the buffer.
    const mp_buffer_info_t bytes = bytes_of(picture->buffer, MP_QSTR_buffer);
    if (is_gray) {
        return (smr_frame) { picture->width, picture->height, { { bytes.buf, bytes.len, picture->stride, picture->width, picture->height, 0, 0 } } };
    }
    smr_readout readout;
    smr_frame frame;
    check(smr_readout_begin(&readout, format_of(picture->format), picture->width, picture->height, windows, gray, size));
    const smr_status status = smr_readout_lines(&readout, bytes.buf, bytes.len, picture->stride);
    check_line(status, readout.line);
    check(smr_readout_frame(&readout, &frame));
    return frame;
}

// Trackers

static bool is_same(const char *one, const char *other) {
    while (*one != 0 && *one == *other) {
        one++, other++;
    }
    return *one == *other;
}

// Sets the option `keyword`: a setting of the configuration, or plain_loop.
static void set_option(smr_config *config, const mp_obj_type_t *type, mp_obj_t keyword, mp_obj_t value) {
    const char *name = mp_obj_str_get_str(keyword);
    if (keyword == MP_OBJ_NEW_QSTR(MP_QSTR_plain_loop)) {
        config->plain_loop = number(value, 0, 1, "plain_loop");
        return;
    }
    smr_setting setting;
    for (size_t i = 0; smr_setting_at(config, i, &setting) == SMR_OK; i++) {
        if (is_same(setting.name, name)) {
            const mp_obj_t *items = setting.count == 1 ? &value : items_of(value, setting.count, name);
            for (size_t k = 0; k < setting.count; k++) {
                const bool is_denominator = setting.shape == 2 && k == 1 && setting.lowest == 0;
                setting.values[k] = number(items[k], setting.lowest + is_denominator, setting.highest, name);
            }
            check(smr_set(config, setting.name, setting.values, setting.count));
            return;
        }
    }
    mp_raise_msg_varg(&mp_type_TypeError, MP_ERROR_TEXT("%q has no option %s"), type->name, name);
}

// Fills `config` with a preset, by default (MP_OBJ_NULL) the first one. Returns the index of its workspace in `shared_t`.
static size_t set_preset(smr_config *config, bool is_paper, mp_obj_t preset) {
    #define IS(name) mp_obj_equal(preset, MP_OBJ_NEW_QSTR(MP_QSTR_##name))
    const bool is_first = preset == MP_OBJ_NULL || (is_paper ? IS(camera) : IS(robust));
    const bool is_small = !is_first && !is_paper && IS(small), is_small_refined = !is_first && !is_paper && IS(small_refined);
    if (!is_first && !is_small && !is_small_refined && !(is_paper ? IS(paper) : IS(refined))) {
        mp_raise_ValueError(is_paper ? MP_ERROR_TEXT("preset must be 'camera' or 'paper'")
                                     : MP_ERROR_TEXT("preset must be 'robust', 'refined', 'small' or 'small_refined'"));
    }
    const smr_status status = is_paper ? (is_first ? smr_config_camera(config) : smr_config_paper(config))
                            : is_small ? smr_config_small(config) : is_small_refined ? smr_config_small_refined(config)
                            : is_first ? smr_config_robust(config) : smr_config_refined(config);
    check(status);
    return is_paper ? 0 : is_small || is_small_refined ? 2 : 1;
}

// Applies the preset, then the options in `keywords`. `preset` is the positional argument, or MP_OBJ_NULL. Returns as `set_preset`.
static size_t configure(smr_config *config, const mp_obj_type_t *type, mp_obj_t preset, size_t count, const mp_obj_t *keywords) {
    for (size_t i = 0; i < count; i++) {
        if (keywords[2 * i] == MP_OBJ_NEW_QSTR(MP_QSTR_preset)) {
            if (preset != MP_OBJ_NULL) {
                mp_raise_msg(&mp_type_TypeError, MP_ERROR_TEXT("preset is given twice"));
            }
            preset = keywords[2 * i + 1];
        }
    }
    const size_t workspace = set_preset(config, type == PAPER, preset);
    for (size_t i = 0; i < count; i++) {
        if (keywords[2 * i] != MP_OBJ_NEW_QSTR(MP_QSTR_preset)) {
            set_option(config, type, keywords[2 * i], keywords[2 * i + 1]);
        }
    }
    return workspace;
}

static mp_obj_t make_new(const mp_obj_type_t *type, size_t n_args, size_t n_kw, const mp_obj_t *args) {
    mp_arg_check_num(n_args, n_kw, 0, 1, true);
    smr_config config;
    void **workspace = &SHARED->workspaces[configure(&config, type, n_args > 0 ? args[0] : MP_OBJ_NULL, n_kw, args + n_args)];
    const size_t size = smr_target_size(&config), room = smr_workspace_size(&config);
    if (*workspace == NULL) {
        *workspace = m_new(uint8_t, room);
    }
    tracker_t *self = m_malloc(offsetof(tracker_t, storage) + size);
    self->base.type = type;
    self->workspace = *workspace;
    self->width = self->height = 0;
    check(smr_init(self->storage, size, self->workspace, room, &config, &self->tracker));
    return MP_OBJ_FROM_PTR(self);
}

// lock(buffer, width, height, box, format=GRAY8, stride=0) -> quality
static mp_obj_t lock(size_t n_args, const mp_obj_t *args, mp_map_t *keywords) {
    enum { BUFFER, WIDTH, HEIGHT, BOX, FORMAT, STRIDE };
    TABLE mp_arg_t allowed[] = {
        { MP_QSTR_buffer, MP_ARG_REQUIRED | MP_ARG_OBJ, { 0 } },
        { MP_QSTR_width, MP_ARG_REQUIRED | MP_ARG_OBJ, { 0 } },
        { MP_QSTR_height, MP_ARG_REQUIRED | MP_ARG_OBJ, { 0 } },
        { MP_QSTR_box, MP_ARG_REQUIRED | MP_ARG_OBJ, { 0 } },
        { MP_QSTR_format, MP_ARG_OBJ, { .u_rom_obj = MP_ROM_INT(FORMAT_GRAY8) } },
        { MP_QSTR_stride, MP_ARG_OBJ, { .u_rom_obj = MP_ROM_INT(0) } },
    };
    mp_arg_val_t values[MP_ARRAY_SIZE(allowed)];
    mp_arg_parse_all(n_args - 1, args + 1, keywords, MP_ARRAY_SIZE(allowed), allowed, values);
    tracker_t *self = MP_OBJ_TO_PTR(args[0]);
    const uint16_t width = number(values[WIDTH].u_obj, 0, UINT16_MAX, "width");
    const uint16_t height = number(values[HEIGHT].u_obj, 0, UINT16_MAX, "height");
    const smr_rect target = box_of(values[BOX].u_obj);
    const picture_t picture = picture_of(values[BUFFER].u_obj, width, height, values[FORMAT].u_obj, values[STRIDE].u_obj);
    smr_rect windows[2] = { { 0, 0, 0, 0 }, { 0, 0, 0, 0 } };
    if (picture.format != FORMAT_GRAY8) {
        const uint16_t side = picture.format == FORMAT_BAYER8 ? 2 : 1; // of a mosaic, 2x2 pixels are one of the frame
        check(smr_lock_window(self->tracker, width / side, height / side, &target, &windows[0]));
    }
    const smr_frame frame = frame_of(&picture, windows);
    check(smr_lock(self->tracker, &frame, &target));
    self->width = width;
    self->height = height;
    uint16_t quality;
    check(smr_quality(self->tracker, &quality));
    return MP_OBJ_NEW_SMALL_INT(quality);
}
static MP_DEFINE_CONST_FUN_OBJ_KW(lock_obj, 1, lock);

static void print(const mp_print_t *out, mp_obj_t self_in, mp_print_kind_t kind) {
    const tracker_t *self = MP_OBJ_TO_PTR(self_in);
    smr_fine_rect box;
    smr_state state;
    if (smr_last(self->tracker, &box, &state) != SMR_OK) {
        mp_printf(out, "<%q without a target>", self->base.type->name);
    } else {
        const int sides[] = { (int)(box.x + 128) >> 8, (int)(box.y + 128) >> 8, (int)(box.width + 128) >> 8, (int)(box.height + 128) >> 8 };
        mp_printf(out, "<%q, %q at (%d, %d, %d, %d)>", self->base.type->name, smr_states[state], sides[0], sides[1], sides[2], sides[3]);
    }
}

static mp_obj_t answer_of(const smr_answer *answer) {
    TABLE qstr names[] = {
        MP_QSTR_box, MP_QSTR_fine_box, MP_QSTR_state, MP_QSTR_confidence, MP_QSTR_ratio, MP_QSTR_runner_up_ratio, MP_QSTR_alpha, MP_QSTR_identity,
        MP_QSTR_scale, MP_QSTR_found_again,
    };
    const mp_obj_t items[] = {
        rect(answer->bbox.x, answer->bbox.y, answer->bbox.width, answer->bbox.height),
        rect(answer->fine.x, answer->fine.y, answer->fine.width, answer->fine.height),
        MP_OBJ_NEW_QSTR(smr_states[answer->state]),
        MP_OBJ_NEW_SMALL_INT(answer->confidence),
        MP_OBJ_NEW_SMALL_INT(answer->ratio),
        answer->has_runner_up ? MP_OBJ_NEW_SMALL_INT(answer->runner_up_ratio) : mp_const_none,
        answer->alpha > 0 ? MP_OBJ_NEW_SMALL_INT(answer->alpha) : mp_const_none,
        answer->has_identity ? MP_OBJ_NEW_SMALL_INT(answer->identity) : mp_const_none,
        mp_obj_new_int_from_uint(answer->scale),
        mp_obj_new_bool(answer->found_again),
    };
    return mp_obj_new_attrtuple(names, MP_ARRAY_SIZE(items), items);
}

// update(buffer, format=GRAY8, stride=0, work=0) -> answer; None while work remains
static mp_obj_t update(size_t n_args, const mp_obj_t *args, mp_map_t *keywords) {
    enum { BUFFER, FORMAT, STRIDE, WORK };
    TABLE mp_arg_t allowed[] = {
        { MP_QSTR_buffer, MP_ARG_REQUIRED | MP_ARG_OBJ, { 0 } },
        { MP_QSTR_format, MP_ARG_OBJ, { .u_rom_obj = MP_ROM_INT(FORMAT_GRAY8) } },
        { MP_QSTR_stride, MP_ARG_OBJ, { .u_rom_obj = MP_ROM_INT(0) } },
        { MP_QSTR_work, MP_ARG_OBJ, { .u_rom_obj = MP_ROM_INT(0) } },
    };
    mp_arg_val_t values[MP_ARRAY_SIZE(allowed)];
    mp_arg_parse_all(n_args - 1, args + 1, keywords, MP_ARRAY_SIZE(allowed), allowed, values);
    tracker_t *self = MP_OBJ_TO_PTR(args[0]);
    const uint32_t work = number(values[WORK].u_obj, 0, LARGEST, "work");
    smr_rect windows[2];
    check(smr_windows(self->tracker, windows));
    const picture_t picture = picture_of(values[BUFFER].u_obj, self->width, self->height, values[FORMAT].u_obj, values[STRIDE].u_obj);
    const smr_frame frame = frame_of(&picture, windows);
    smr_answer answer;
    const smr_status status = work > 0 ? smr_update_step(self->tracker, &frame, work, &answer) : smr_update(self->tracker, &frame, &answer);
    if (status == SMR_UNDER_WAY) {
        return mp_const_none;
    }
    check(status);
    return answer_of(&answer);
}
static MP_DEFINE_CONST_FUN_OBJ_KW(update_obj, 1, update);

// moved(right, down), in units of 1/256 pixel
static mp_obj_t moved(mp_obj_t self_in, mp_obj_t right, mp_obj_t down) {
    tracker_t *self = MP_OBJ_TO_PTR(self_in);
    check(smr_moved(self->tracker, number(right, -LARGEST, LARGEST, "right"), number(down, -LARGEST, LARGEST, "down")));
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_3(moved_obj, moved);

// save() -> bytes
static mp_obj_t save(mp_obj_t self_in) {
    tracker_t *self = MP_OBJ_TO_PTR(self_in);
    vstr_t bytes;
    size_t size;
    check(smr_saved_size(self->tracker, &size));
    vstr_init_len(&bytes, size);
    check(smr_save(self->tracker, (uint8_t *)bytes.buf, size, &bytes.len));
    return mp_obj_new_bytes_from_vstr(&bytes);
}
static MP_DEFINE_CONST_FUN_OBJ_1(save_obj, save);

// restore(saved, width=0, height=0), with width and height of later frames in pixels; 0 keeps the previous value
static mp_obj_t restore(size_t n_args, const mp_obj_t *args) {
    tracker_t *self = MP_OBJ_TO_PTR(args[0]);
    const uint16_t width = n_args > 2 ? number(args[2], 0, UINT16_MAX, "width") : 0;
    const uint16_t height = n_args > 3 ? number(args[3], 0, UINT16_MAX, "height") : 0;
    if ((width == 0 && self->width == 0) || (height == 0 && self->height == 0)) {
        mp_raise_ValueError(MP_ERROR_TEXT("this tracker has seen no frame: restore needs width and height"));
    }
    const mp_buffer_info_t bytes = bytes_of(args[1], MP_QSTR_saved);
    const smr_status status = smr_restore(self->tracker, bytes.buf, bytes.len);
    if (status == SMR_ERROR_OTHER_CONFIG) {
        const char *setting;
        check(smr_other_setting(self->tracker, bytes.buf, bytes.len, &setting));
        mp_raise_msg_varg(&mp_type_ValueError, words(status), setting);
    }
    check(status);
    self->width = width > 0 ? width : self->width;
    self->height = height > 0 ? height : self->height;
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_VAR_BETWEEN(restore_obj, 2, 4, restore);

// The window with index `which` as a tuple; None if there is no target or the window is empty.
static mp_obj_t window_of(mp_obj_t self_in, int which) {
    tracker_t *self = MP_OBJ_TO_PTR(self_in);
    smr_rect windows[2] = { { 0, 0, 0, 0 }, { 0, 0, 0, 0 } };
    const smr_status status = smr_windows(self->tracker, windows);
    check(status == SMR_ERROR_NOT_LOCKED ? SMR_OK : status);
    const smr_rect window = windows[which];
    return area(&window) == 0 ? mp_const_none : rect(window.x, window.y, window.width, window.height);
}

#define WINDOW(name, which) \
    static mp_obj_t name(mp_obj_t self_in) { return window_of(self_in, which); } \
    static MP_DEFINE_CONST_FUN_OBJ_1(name##_obj, name);
WINDOW(window, 0)
WINDOW(sweep_window, 1)

// Lists of the methods and constants, by macros, because the firmware and the native module define them differently.
#define METHODS(METHOD) METHOD(lock) METHOD(update) METHOD(moved) METHOD(save) METHOD(restore) METHOD(window) METHOD(sweep_window)
#define STATES(STATE) STATE(TRACKING, tracking) STATE(LEAVING, leaving) STATE(UNCERTAIN, uncertain) STATE(LOST, lost)
#define TEXT(number) #number
#define JOINED(major, minor, patch) TEXT(major) "." TEXT(minor) "." TEXT(patch)
#define VERSION JOINED(SMR_VERSION_MAJOR, SMR_VERSION_MINOR, SMR_VERSION_PATCH)

#ifdef MICROPY_ENABLE_DYNRUNTIME

static void add_type(mp_obj_full_type_t *type, qstr name, mp_obj_t methods) {
    type->base.type = &mp_type_type;
    type->name = name;
    MP_OBJ_TYPE_SET_SLOT(type, make_new, make_new, 0);
    MP_OBJ_TYPE_SET_SLOT(type, print, print, 1);
    MP_OBJ_TYPE_SET_SLOT(type, locals_dict, MP_OBJ_TO_PTR(methods), 2);
    mp_store_global(name, MP_OBJ_FROM_PTR(type));
}

// Entry point of the native module. If sys.modules lacks smr, an import loads the file again, with new variables.
mp_obj_t mpy_init(mp_obj_fun_bc_t *self, size_t n_args, size_t n_kw, mp_obj_t *args) {
    MP_DYNRUNTIME_INIT_ENTRY
    const mp_obj_t methods = mp_obj_new_dict(0);
    #define METHOD(name) mp_obj_dict_store(methods, MP_OBJ_NEW_QSTR(MP_QSTR_##name), MP_OBJ_FROM_PTR(&name##_obj));
    METHODS(METHOD)
    add_type(&smr_type_paper, MP_QSTR_Paper, methods);
    add_type(&smr_type_robust, MP_QSTR_Robust, methods);
    #define FORMAT(name) mp_store_global(MP_QSTR_##name, MP_OBJ_NEW_SMALL_INT(FORMAT_##name));
    FORMATS(FORMAT)
    mp_store_global(MP_QSTR_POOR_QUALITY, MP_OBJ_NEW_SMALL_INT(SMR_POOR_QUALITY));
    #define STATE(name, word) mp_store_global(MP_QSTR_##name, MP_OBJ_NEW_QSTR(smr_states[SMR_##name] = MP_QSTR_##word));
    STATES(STATE)
    mp_store_global(MP_QSTR___version__, mp_obj_new_str(VERSION, sizeof(VERSION) - 1));
    MP_DYNRUNTIME_INIT_EXIT
}

#else

#define METHOD(name) { MP_ROM_QSTR(MP_QSTR_##name), MP_ROM_PTR(&name##_obj) },
static const mp_rom_map_elem_t methods_table[] = { METHODS(METHOD) };
static MP_DEFINE_CONST_DICT(methods, methods_table);

MP_DEFINE_CONST_OBJ_TYPE(smr_type_paper, MP_QSTR_Paper, MP_TYPE_FLAG_NONE, make_new, make_new, print, print, locals_dict, &methods);
MP_DEFINE_CONST_OBJ_TYPE(smr_type_robust, MP_QSTR_Robust, MP_TYPE_FLAG_NONE, make_new, make_new, print, print, locals_dict, &methods);

// The module

extern const mp_obj_module_t smr_module;

// Runs at every import that does not find smr in sys.modules. A soft reset clears sys.modules and the heap, so shared
// memory must be allocated anew. After `del sys.modules['smr']` and an import, old trackers keep their workspace.
static mp_obj_t init(void) {
    MP_STATE_VM(smr_shared) = m_new0(shared_t, 1);
    mp_obj_dict_store(MP_OBJ_FROM_PTR(&MP_STATE_VM(mp_loaded_modules_dict)), MP_OBJ_NEW_QSTR(MP_QSTR_smr), MP_OBJ_FROM_PTR(&smr_module));
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_0(init_obj, init);

static const MP_DEFINE_STR_OBJ(version_obj, VERSION);
static const mp_rom_map_elem_t globals_table[] = {
    { MP_ROM_QSTR(MP_QSTR___version__), MP_ROM_PTR(&version_obj) },
    { MP_ROM_QSTR(MP_QSTR___name__), MP_ROM_QSTR(MP_QSTR_smr) },
    { MP_ROM_QSTR(MP_QSTR___init__), MP_ROM_PTR(&init_obj) },
    { MP_ROM_QSTR(MP_QSTR_Paper), MP_ROM_PTR(&smr_type_paper) },
    { MP_ROM_QSTR(MP_QSTR_Robust), MP_ROM_PTR(&smr_type_robust) },
    #define FORMAT(name) { MP_ROM_QSTR(MP_QSTR_##name), MP_ROM_INT(FORMAT_##name) },
    FORMATS(FORMAT)
    { MP_ROM_QSTR(MP_QSTR_POOR_QUALITY), MP_ROM_INT(SMR_POOR_QUALITY) },
    #define STATE(name, word) { MP_ROM_QSTR(MP_QSTR_##name), MP_ROM_QSTR(MP_QSTR_##word) },
    STATES(STATE)
};
static MP_DEFINE_CONST_DICT(globals, globals_table);

const mp_obj_module_t smr_module = {
    .base = { &mp_type_module },
    .globals = (mp_obj_dict_t *)&globals,
};
MP_REGISTER_MODULE(MP_QSTR_smr, smr_module);

#endif
