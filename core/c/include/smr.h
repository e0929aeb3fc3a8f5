/**
 * @file smr.h
 * @brief Follows one target through 8-bit gray frames by the Similarity Matching Ratio (SMR).
 *
 * Four calls are enough: #smr_config_robust, #smr_init, #smr_lock, #smr_update.
 *
 * @code
 * static smr_robust_target storage;       // kept from frame to frame; nothing is allocated
 * static smr_robust_workspace workspace;  // scratch memory: all trackers of this kind can share it
 * smr_config config;
 * smr_tracker *tracker;
 * smr_answer answer;
 * smr_frame frame = {320, 240, {{pixels, 320 * 240, 320, 320, 240, 0, 0}}};  // one part: all of it
 * smr_rect bbox = {150, 100, 40, 48};
 *
 * smr_config_robust(&config);
 * if (smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker) != SMR_OK) { ... }
 * if (smr_lock(tracker, &frame, &bbox) != SMR_OK) { ... }
 * while (next(pixels)) {
 *     if (smr_update(tracker, &frame, &answer) == SMR_OK && answer.state != SMR_LOST) { use(answer.bbox); }
 * }
 * @endcode
 *
 * Programs with a deadline call #smr_update_step; those that read out only a part of the sensor ask #smr_windows first.
 *
 * There are two trackers, and the configuration chooses one: the paper's (#smr_config_camera, #smr_config_paper) or the robust
 * one (#smr_config_robust, #smr_config_refined, and with less memory #smr_config_small, #smr_config_small_refined). The paper tracker compares the target's last appearance, the template, with every offset in a search
 * window; the best offset is the new box, and its pixels are the next template. The robust tracker goes beyond the paper: it follows changes of light, size and view, reports
 * when the target is not visible, and searches for it then. It takes more memory and time. All calls are the same.
 *
 * - **Errors.** Every call checks its pointers (NULL, alignment) and sizes and returns an #smr_status;
 *   #smr_status_name gives its name. A call that fails changes nothing: neither a tracker, nor a lock or update that is under way in
 *   steps, nor the memory for its results. Exceptions: #smr_init sets its handle to NULL, and a readout keeps the lines before the
 *   wrong one and the index of that line.
 * - **What cannot be checked.** A pointer that is neither NULL nor misaligned must point to memory of the size of its type, or of the
 *   stated size. Memory that a call reads must be initialised. Nobody else may write there during the call. A tracker
 *   pointer must come from #smr_init, and `method` of an #smr_config must be NULL or unchanged.
 * - **Threads and interrupts.** There are no globals. Calls on different trackers may overlap in time. Calls on the same
 *   tracker, or on trackers with the same workspace, may not.
 * - **Where pixels may be.** On Cortex-M4, M7, M33 and above the library loads words from unaligned addresses. Normal memory
 *   allows that. Device memory faults, and external RAM (0xA0000000 to 0xDFFFFFFF) is Device memory by default. Set up the MPU,
 *   or set `plain_loop` in #smr_config.
 * - **Stack.** With all called functions, measured on a Cortex-M4: at most 1.4 KB for either
 *   tracker, with the refiner or without, and 0.2 KB in #smr_init. Builds without optimisation take more.
 * - **Exactness.** Integers only. The same frames give the same answers, bit for bit, on every machine.
 *
 * cbindgen writes this file from core/c/src and core/c/cbindgen.toml. Do not edit it here.
 */


#ifndef SMR_H
#define SMR_H

#include <stddef.h>
#include <stdint.h>

/**
 * The capacity of the paper tracker: the largest area of a box in pixels, and the most offsets of the search window on an axis.
 *
 * Both are fixed when the library is built, by environment variables of the same names. If you build the library with other
 * numbers, define these macros to the same numbers before you include this file. If you forget it, #smr_init may report memory
 * that is too small, and #SMR_ERROR_BOX_TOO_LARGE and #SMR_ERROR_WINDOW_TOO_LARGE follow the library's numbers.
 */
#ifndef SMR_PIXELS
#define SMR_PIXELS 4096
#endif
/** See #SMR_PIXELS. */
#ifndef SMR_SPAN
#define SMR_SPAN 161
#endif
#if SMR_PIXELS < 1 || SMR_PIXELS > 65537 || SMR_SPAN < 1
#error "SMR_PIXELS must be 1 to 65537 (more pixels could overflow a score), SMR_SPAN at least 1"
#endif

/**
 * 1 if the library has the refiner, 0 if not: the packages for CMake and pkg-config define it. Without a definition it is 1,
 * and storage has room for either library; with 0 a robust tracker takes 1056 bytes less. If the library has the refiner and
 * your program defines 0, #smr_init returns #SMR_ERROR_STORAGE_TOO_SMALL.
 */
#ifndef SMR_REFINER
#define SMR_REFINER 1
#endif

/** The most pixels of the early template, which the robust tracker keeps from the first frames. */
#define SMR_ROBUST_PIXELS 1600
/** The most pixels of the early template of the small robust tracker. */
#define SMR_ROBUST_SMALL_PIXELS 1296

/** Alignment of storage and workspace, in bytes. */
#define SMR_ALIGNMENT 8

/** Bytes of storage for a paper tracker, a constant expression. At run time, ask #smr_target_size. */
#define SMR_PAPER_TARGET_SIZE ((sizeof(char) * (SMR_PIXELS) + 7) / 8 * 8 + 12 * sizeof(size_t) + 120)
/** Bytes of a workspace for any number of the paper trackers, a constant expression. */
#define SMR_PAPER_WORKSPACE_SIZE \
    ((sizeof(char) * (SMR_PIXELS) + 7) / 8 * 8 + (20 * sizeof(char) * (SMR_SPAN) + 7) / 8 * 8 + 22 * sizeof(size_t) + 1184)
/** The most bytes that #smr_save writes for the paper tracker. */
#define SMR_PAPER_SAVED_SIZE (sizeof(char) * (SMR_PIXELS) + 94)
/** Bytes of storage for one robust tracker, a constant expression. */
#define SMR_ROBUST_TARGET_SIZE (11352 + 1056 * (SMR_REFINER) + 10 * sizeof(size_t))
/** Bytes of a workspace for any number of robust trackers, a constant expression. */
#define SMR_ROBUST_WORKSPACE_SIZE (39672 + 16 * sizeof(size_t))
/** The most bytes that #smr_save writes for a robust tracker. */
#define SMR_ROBUST_SAVED_SIZE 12356
/** Bytes of storage for one small robust tracker, a constant expression. */
#define SMR_ROBUST_SMALL_TARGET_SIZE (9224 + 1056 * (SMR_REFINER) + 10 * sizeof(size_t))
/** Bytes of a workspace for any number of small robust trackers, a constant expression. */
#define SMR_ROBUST_SMALL_WORKSPACE_SIZE (34624 + 16 * sizeof(size_t))
/** The most bytes that #smr_save writes for a small robust tracker. */
#define SMR_ROBUST_SMALL_SAVED_SIZE 10228

/** A target with a lower quality may slip along its own texture unnoticed: see #smr_quality. */
#define SMR_POOR_QUALITY 1023

/** Storage for a paper tracker, with the right size and alignment: static, on the stack or in a larger object. */
typedef union smr_paper_target {
    /** Sets the alignment. */
    uint64_t alignment;
    /** Gives the type its size; do not access. */
    unsigned char bytes[SMR_PAPER_TARGET_SIZE];
} smr_paper_target;

/** A workspace for any number of the paper trackers. */
typedef union smr_paper_workspace {
    /** Sets the alignment. */
    uint64_t alignment;
    /** Gives the type its size; do not access. */
    unsigned char bytes[SMR_PAPER_WORKSPACE_SIZE];
} smr_paper_workspace;

/** Storage for one robust tracker. */
typedef union smr_robust_target {
    /** Sets the alignment. */
    uint64_t alignment;
    /** Gives the type its size; do not access. */
    unsigned char bytes[SMR_ROBUST_TARGET_SIZE];
} smr_robust_target;

/** A workspace for any number of robust trackers. */
typedef union smr_robust_workspace {
    /** Sets the alignment. */
    uint64_t alignment;
    /** Gives the type its size; do not access. */
    unsigned char bytes[SMR_ROBUST_WORKSPACE_SIZE];
} smr_robust_workspace;

/** Storage for one small robust tracker: see #smr_config_small. */
typedef union smr_robust_small_target {
    /** Sets the alignment. */
    uint64_t alignment;
    /** Gives the type its size; do not access. */
    unsigned char bytes[SMR_ROBUST_SMALL_TARGET_SIZE];
} smr_robust_small_target;

/** A workspace for any number of small robust trackers. */
typedef union smr_robust_small_workspace {
    /** Sets the alignment. */
    uint64_t alignment;
    /** Gives the type its size; do not access. */
    unsigned char bytes[SMR_ROBUST_SMALL_WORKSPACE_SIZE];
} smr_robust_small_workspace;

/** Compiles only if storage and workspace have the stated sizes. */
typedef char smr_memory_is_as_large_as_stated[
    sizeof(smr_paper_target) == SMR_PAPER_TARGET_SIZE && sizeof(smr_paper_workspace) == SMR_PAPER_WORKSPACE_SIZE &&
    sizeof(smr_robust_target) == SMR_ROBUST_TARGET_SIZE && sizeof(smr_robust_workspace) == SMR_ROBUST_WORKSPACE_SIZE &&
    sizeof(smr_robust_small_target) == SMR_ROBUST_SMALL_TARGET_SIZE && sizeof(smr_robust_small_workspace) == SMR_ROBUST_SMALL_WORKSPACE_SIZE ? 1 : -1];

/**
 * The result of a call. The numbers never change; later versions may add new ones.
 *
 * A call that returns an error changes nothing, except that #smr_init sets `*tracker` to NULL and a read-out notes the line.
 */
enum smr_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif
 {
  /**
   * The call succeeded.
   */
  SMR_OK = 0,
  /**
   * A pointer is NULL.
   */
  SMR_ERROR_NULL = 1,
  /**
   * A pointer is not aligned for its type.
   */
  SMR_ERROR_MISALIGNED = 2,
  /**
   * The storage is smaller than #smr_target_size.
   */
  SMR_ERROR_STORAGE_TOO_SMALL = 3,
  /**
   * The workspace is smaller than #smr_workspace_size.
   */
  SMR_ERROR_WORKSPACE_TOO_SMALL = 4,
  /**
   * Storage and workspace overlap.
   */
  SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE = 5,
  /**
   * The tracker was not made by #smr_init, it or its workspace was moved or overwritten since, or the configuration
   * was not filled by one of the calls smr_config_...
   */
  SMR_ERROR_NOT_INITIALISED = 6,
  /**
   * The call or the saved target belongs to the robust tracker but this is the paper's, or the reverse; or the saved
   * target is one of the other size (#smr_config_small).
   */
  SMR_ERROR_OTHER_METHOD = 7,
  /**
   * No setting of this tracker has this name.
   */
  SMR_ERROR_SETTING_UNKNOWN = 8,
  /**
   * The number of values is wrong for the setting.
   */
  SMR_ERROR_SETTING_COUNT = 9,
  /**
   * `window_limit` is smaller than `window`.
   */
  SMR_ERROR_LIMIT_BELOW_WINDOW = 10,
  /**
   * A setting is outside its range, which is stated beside its field.
   */
  SMR_ERROR_CONFIG_OUT_OF_RANGE = 11,
  /**
   * Width or height of a part of the frame is 0.
   */
  SMR_ERROR_FRAME_EMPTY = 12,
  /**
   * The stride is smaller than the width.
   */
  SMR_ERROR_STRIDE_TOO_SMALL = 13,
  /**
   * `size` is less than (height - 1) * stride + width bytes.
   */
  SMR_ERROR_FRAME_TOO_SHORT = 14,
  /**
   * `size` is larger than any object can be (PTRDIFF_MAX).
   */
  SMR_ERROR_MEMORY_TOO_LARGE = 15,
  /**
   * A call's pixels or bytes overlap the tracker's storage or workspace, or a line overlaps its readout's pixels.
   */
  SMR_ERROR_OVERLAPS_TRACKER = 16,
  /**
   * A part of the frame reaches beyond the frame's edge.
   */
  SMR_ERROR_OUTSIDE_FRAME = 17,
  /**
   * The box has no pixels.
   */
  SMR_ERROR_BOX_EMPTY = 18,
  /**
   * The box reaches beyond the frame's edge.
   */
  SMR_ERROR_BOX_OUTSIDE_FRAME = 19,
  /**
   * The box has more than #SMR_PIXELS pixels. The robust tracker takes a box of any size.
   */
  SMR_ERROR_BOX_TOO_LARGE = 20,
  /**
   * The search window could grow to more than #SMR_SPAN offsets on an axis. Never from the robust tracker.
   */
  SMR_ERROR_WINDOW_TOO_LARGE = 21,
  /**
   * The parts in memory do not cover #smr_lock_window.
   */
  SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY = 22,
  /**
   * There is no target yet: call #smr_lock first.
   */
  SMR_ERROR_NOT_LOCKED = 23,
  /**
   * The frame's size differs from that at #smr_lock.
   */
  SMR_ERROR_FRAME_SIZE_CHANGED = 24,
  /**
   * The parts in memory do not cover #smr_windows.
   */
  SMR_ERROR_WINDOW_NOT_IN_MEMORY = 25,
  /**
   * Work remains: call #smr_update_step or #smr_lock_step again. Not an error.
   */
  SMR_UNDER_WAY = 26,
  /**
   * The memory for the result is too small.
   */
  SMR_ERROR_BUFFER_TOO_SMALL = 27,
  /**
   * The bytes are not a saved target.
   */
  SMR_ERROR_NOT_SAVED = 28,
  /**
   * The target was saved by another version of the library.
   */
  SMR_ERROR_OTHER_VERSION = 29,
  /**
   * The saved target ends too early.
   */
  SMR_ERROR_TRUNCATED = 30,
  /**
   * The bytes have changed since they were saved: the checksum is wrong.
   */
  SMR_ERROR_DAMAGED = 31,
  /**
   * The target was saved with another configuration, so answers would differ: #smr_other_setting names the setting.
   */
  SMR_ERROR_OTHER_CONFIG = 32,
  /**
   * The saved target is too large for this tracker.
   */
  SMR_ERROR_SAVED_TOO_LARGE = 33,
  /**
   * An error for which this interface has no number yet.
   */
  SMR_ERROR_UNKNOWN = 34,
  /**
   * The pixel format is NULL, or the frame is to be shrunk by another number than 1 to 4.
   */
  SMR_ERROR_FORMAT_UNKNOWN = 35,
  /**
   * The line arrived already, or a later line did.
   */
  SMR_ERROR_LINE_OUT_OF_ORDER = 36,
  /**
   * The line has fewer bytes than its format needs.
   */
  SMR_ERROR_LINE_TOO_SHORT = 37,
  /**
   * The sensor has no such line.
   */
  SMR_ERROR_LINE_OUTSIDE_FRAME = 38,
  /**
   * A line of a window is missing.
   */
  SMR_ERROR_LINE_MISSING = 39,
  /**
   * The configuration enables the refiner, but the library lacks it: core/c/install.sh --refiner builds it in.
   */
  SMR_ERROR_REFINER_NOT_BUILT_IN = 40,
  /**
   * `uncertain_below` is smaller than `lost_below`.
   */
  SMR_ERROR_UNCERTAIN_BELOW_LOST = 41,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_status smr_status;
#else
typedef int32_t smr_status;
#endif
#endif


/**
 * The version of this header, major.minor.patch. A program can compare it with #smr_version.
 */
#define SMR_VERSION_MAJOR 0

/**
 * See #SMR_VERSION_MAJOR.
 */
#define SMR_VERSION_MINOR 1

/**
 * See #SMR_VERSION_MAJOR.
 */
#define SMR_VERSION_PATCH 0

/**
 * The state of the target after a frame, as the tracker judges it.
 */
enum smr_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The target is in the box. Paper's tracker: the box is inside the frame. Robust tracker: the box matches, tile by
   * tile, the early template, which is a running mean of the target's pixels that learns very slowly.
   */
  SMR_TRACKING = 0,
  /**
   * The box, with the target in it, is partly outside the frame. The template is not updated. Paper's tracker only.
   */
  SMR_LEAVING = 1,
  /**
   * The box hardly matches the early template: the target is partly hidden or changes quickly, or the tracker
   * follows something else. The paper tracker never returns this state.
   */
  SMR_UNCERTAIN = 2,
  /**
   * The target is not visible; the search continues. The box is the last accepted one (paper tracker) or the
   * current best guess (robust tracker). Nothing is learned, unless only the refiner judges the target lost.
   */
  SMR_LOST = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_state smr_state;
#else
typedef int32_t smr_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The kind of an entry of a flight record, the log that #smr_record writes.
 */
enum smr_entry_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The end of the record.
   */
  SMR_ENTRY_END = 0,
  /**
   * A tracker begins. Its configuration is `robust` if `is_robust` is 1, else `paper`.
   */
  SMR_ENTRY_BEGIN = 1,
  /**
   * A lock on `bbox` in `frame`.
   */
  SMR_ENTRY_LOCK = 2,
  /**
   * A turn of the camera, which moved the picture by `right` and `down`.
   */
  SMR_ENTRY_MOVED = 3,
  /**
   * An update with `frame` begins.
   */
  SMR_ENTRY_WINDOW = 4,
  /**
   * The update ended with `answer`.
   */
  SMR_ENTRY_ANSWER = 5,
  /**
   * The tracker continues with a `saved` target.
   */
  SMR_ENTRY_RESTORED = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_entry_kind smr_entry_kind;
#else
typedef int32_t smr_entry_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The format in which a camera sends its pixels: the address of one of the constants SMR_GRAY8 to SMR_GRAY10. A program
 * links only the formats that it names.
 */
typedef struct smr_format smr_format;

/**
 * One of the trackers, opaque in C: its constructor and the sizes of its memory.
 */
typedef struct smr_method smr_method;

/**
 * A tracker of one target, in storage that the caller gives to #smr_init. It needs no clean-up and must not move.
 *
 * Calls on the same tracker, or on trackers that share a workspace, must not overlap in time. Other calls may.
 */
typedef struct smr_tracker smr_tracker;

/**
 * A fraction: numerator / denominator.
 */
typedef struct smr_fraction {
  /**
   * Numerator; its range depends on the setting.
   */
  uint16_t numerator;
  /**
   * Denominator; at least 1.
   */
  uint16_t denominator;
} smr_fraction;

/**
 * A search radius in pixels: offsets of -x to x and -y to y around the last position.
 */
typedef struct smr_radius {
  /**
   * The largest offset to the left and to the right.
   */
  uint16_t x;
  /**
   * The largest offset up and down.
   */
  uint16_t y;
} smr_radius;

/**
 * Distances of a box from the four edges of the frame, in pixels.
 */
typedef struct smr_margins {
  /**
   * Pixels from the frame's left edge to the box.
   */
  uint16_t left;
  /**
   * Pixels from the frame's top edge to the box.
   */
  uint16_t top;
  /**
   * Pixels from the box to the frame's right edge.
   */
  uint16_t right;
  /**
   * Pixels from the box to the frame's bottom edge.
   */
  uint16_t bottom;
} smr_margins;

/**
 * The settings of the paper tracker.
 */
typedef struct smr_paper_config {
  /**
   * The factor of alpha: the next alpha is `k` times the largest change of a pixel in an update of the template. 1 to
   * 65535.
   */
  struct smr_fraction k;
  /**
   * The ratio of peak and runner-up that is needed while the target stays inside the frame. Below 1 every peak above
   * 0 is accepted.
   */
  struct smr_fraction gate_tracking;
  /**
   * The ratio of peak and runner-up that is needed if the box at the peak is partly outside the frame.
   */
  struct smr_fraction gate_leaving;
  /**
   * The ratio of peak and runner-up that is needed after a box was partly outside the frame, until a lost target is
   * found again.
   */
  struct smr_fraction gate_returning;
  /**
   * The ratio of peak and runner-up that is needed to find a lost target again.
   */
  struct smr_fraction gate_lost;
  /**
   * The lead of the peak over the runner-up that is enough whatever their ratio is, in fully similar pixels.
   */
  uint16_t gate_lead;
  /**
   * The least similarity matching ratio of an accepted peak, in units of 1/65535. 0, the paper's value, also turns
   * off the check for a covered lens: a patch inside the frame needs a quarter of the template's contrast (mean
   * absolute deviation), and its pixels at 0 or 255 may exceed those of the template by at most half of all pixels.
   */
  uint16_t least_ratio;
  /**
   * alpha of the first update, in gray levels. Pixels that differ by less are similar. 1 to 255.
   */
  uint8_t first_threshold;
  /**
   * The least alpha of later updates, in gray levels. 0 (the paper's value) and 1 set no bound, so that after a still
   * scene a change of light leaves no pixel that matches. 0 to 255.
   */
  uint8_t least_threshold;
  /**
   * The width of the black border around the frame, in pixels: how far a box may leave the frame.
   */
  uint16_t padding;
  /**
   * The radius of the search window around the last position, in pixels.
   */
  struct smr_radius window;
  /**
   * The growth of the window in each frame while the target is lost, in pixels on each side.
   */
  uint16_t growth;
  /**
   * The largest radius while the target is lost, in pixels; at least `window`. The padded frame always bounds it.
   */
  struct smr_radius window_limit;
  /**
   * The runner-up is the best score more than this many pixels from the peak, in x or in y.
   */
  uint16_t neighbourhood;
  /**
   * The distances that a box must keep from the edges of the frame for the tracker to learn from it, in pixels.
   */
  struct smr_margins update_zone;
  /**
   * The runner-up is searched in every frame, which takes several times as long, not only if the gate needs it. 0 or
   * 1.
   */
  uint8_t runner_up_always;
} smr_paper_config;

/**
 * The settings of the robust tracker.
 */
typedef struct smr_robust_config {
  /**
   * The radius of the search in cells. The side of a cell is a tenth of the root of the target's area. The work of an
   * update grows with the square of 2 `reach` + 1. At most 7 in a tracker of the small size. 4 to 8.
   */
  uint8_t reach;
  /**
   * The box follows the size of the target. 0 or 1.
   */
  uint8_t size;
  /**
   * Windows in which each frame is searched for a lost target, besides the one around its last place. From frame to
   * frame they sweep the whole picture. Each takes about as much work as the search of a frame. 0: no sweep. 0 to
   * 255.
   */
  uint8_t sweep;
  /**
   * A small learned network corrects the box. It keeps the box to a target that comes nearer, turns or changes its
   * shape, reads more of the frame, and can make the state *uncertain* or *lost*. In firmware a build without the
   * feature `refiner` refuses it. 0 or 1.
   */
  uint8_t refiner;
  /**
   * The part of its value that the confidence keeps in each frame, in units of 1/256. A higher one holds on to the
   * target for longer: through short occlusions, but also through errors. 0 to 255.
   */
  uint8_t patience;
  /**
   * The target is lost while the confidence is below this, in units of 1/65535.
   */
  uint16_t lost_below;
  /**
   * The target is uncertain while the confidence is below this, in units of 1/65535; at least `lost_below`.
   */
  uint16_t uncertain_below;
  /**
   * The learning rate of the filter, in units of 1/256: 0 keeps the filter of the first frame, 256 takes the exact
   * step for the present frame. 0 to 256.
   */
  uint16_t learning_rate;
  /**
   * The learning rate of the early template, in units of 1/1024. 0 to 1024.
   */
  uint16_t early_rate;
} smr_robust_config;

/**
 * The choice of a tracker and its settings. Fill it with #smr_config_camera, #smr_config_paper, #smr_config_robust,
 * #smr_config_refined, #smr_config_small or #smr_config_small_refined, then change the settings that you need.
 */
typedef struct smr_config {
  /**
   * Points to the chosen tracker's code; do not change it. A program contains the code of a tracker only if it calls
   * one of the functions smr_config_... for that tracker.
   */
  const struct smr_method *method;
  /**
   * 0: the tracker uses the fastest code for the processor. Otherwise: it uses plain loops that load single bytes,
   * and gives the same answers. This is for frames in Device memory (external RAM that the MPU has not made Normal),
   * where unaligned word loads fault.
   */
  uint8_t plain_loop;
  /**
   * Settings of the paper tracker; all 0 if the preset is of the robust one.
   */
  struct smr_paper_config paper;
  /**
   * Settings of the robust tracker; all 0 if the preset is of the paper's.
   */
  struct smr_robust_config robust;
} smr_config;

/**
 * The name, range and values of a setting, as #smr_setting_at returns them.
 */
typedef struct smr_setting {
  /**
   * The name as a static string: that of the field in #smr_paper_config or #smr_robust_config.
   */
  const char *name;
  /**
   * The kind of values. 0: a number. 1: a switch. 2: numerator, denominator. 3: x, y. 4: left, top, right, bottom.
   */
  uint8_t shape;
  /**
   * The number of values, 1 to 4.
   */
  uint8_t count;
  /**
   * The lowest value that the setting may have; a denominator must also be at least 1.
   */
  uint16_t lowest;
  /**
   * The highest value that the setting may have.
   */
  uint16_t highest;
  /**
   * The values in the configuration; unused entries are 0.
   */
  uint16_t values[4];
} smr_setting;

/**
 * A rectangle in whole pixels of the frame. It may reach outside the frame.
 */
typedef struct smr_rect {
  /**
   * Left edge, in pixels to the right of the frame's left edge; may be negative.
   */
  int32_t x;
  /**
   * Top edge, in pixels below the frame's top edge; may be negative.
   */
  int32_t y;
  /**
   * Width in pixels.
   */
  uint16_t width;
  /**
   * Height in pixels.
   */
  uint16_t height;
} smr_rect;

/**
 * A rectangular part of a frame in memory: 8-bit gray pixels and their position in the frame.
 */
typedef struct smr_part {
  /**
   * Address of the top left pixel.
   */
  const uint8_t *pixels;
  /**
   * Readable bytes from `pixels` on: at least (height - 1) * stride + width.
   */
  size_t size;
  /**
   * Bytes from a pixel to the pixel below it: at least `width`.
   */
  size_t stride;
  /**
   * Width in pixels; at least 1.
   */
  uint16_t width;
  /**
   * Height in pixels; at least 1.
   */
  uint16_t height;
  /**
   * Column of the frame at which the part begins.
   */
  uint16_t x;
  /**
   * Row of the frame at which the part begins.
   */
  uint16_t y;
} smr_part;

/**
 * A camera frame: its size, and its parts in memory. A call only reads the pixels, and does not keep their address.
 *
 * For a whole frame, pass one part of the frame's size at x = y = 0. If you read out only what the tracker needs, pass
 * #smr_windows as the parts, the second only if it is not empty.
 */
typedef struct smr_frame {
  /**
   * Width of the whole frame in pixels.
   */
  uint16_t width;
  /**
   * Height of the whole frame in pixels.
   */
  uint16_t height;
  /**
   * The parts in memory. If there is no second part, its `pixels` are NULL.
   */
  struct smr_part parts[2];
} smr_frame;

/**
 * A rectangle in units of 1/256 pixel of the frame. It may reach outside the frame.
 */
typedef struct smr_fine_rect {
  /**
   * Left edge, in 1/256 pixel to the right of the frame's left edge; may be negative.
   */
  int32_t x;
  /**
   * Top edge, in 1/256 pixel below the frame's top edge; may be negative.
   */
  int32_t y;
  /**
   * Width in 1/256 pixel.
   */
  uint32_t width;
  /**
   * Height in 1/256 pixel.
   */
  uint32_t height;
} smr_fine_rect;

/**
 * The result of #smr_update. Ratios and confidence are in units of 1/65535: 65535 is 1.0.
 */
typedef struct smr_answer {
  /**
   * The target's box in whole pixels.
   */
  struct smr_rect bbox;
  /**
   * The target's box in units of 1/256 pixel. The paper tracker returns only multiples of 256, that is, whole
   * pixels.
   */
  struct smr_fine_rect fine;
  /**
   * The reliability of the box: tracking, leaving, uncertain or lost.
   */
  smr_state state;
  /**
   * The target's size relative to its size at the lock, in units of 1/65536; always 65536 from the paper tracker.
   */
  uint32_t scale;
  /**
   * The confidence in the box. The paper tracker: `ratio`, or 0 when lost. The robust tracker: 2/3 of the running
   * mean, over the frames, of the evidence. A frame's evidence is the agreement with the early template (0 to 1)
   * plus the filter response (clamped to 0 to 1/2).
   */
  uint16_t confidence;
  /**
   * The similarity of the box to the template. The paper tracker: the similarity matching ratio, rounded down. The
   * robust tracker: the fourth lowest of the similarity matching ratios of the early template's 16 tiles.
   */
  uint16_t ratio;
  /**
   * The ratio of the runner-up, which is the best match outside the neighbourhood of the best match (see
   * `neighbourhood` in #smr_paper_config); 0 if there is no runner-up.
   */
  uint16_t runner_up_ratio;
  /**
   * Alpha, the threshold of this frame, rounded up to whole gray levels (1 to 256): a pixel matched if it differed
   * from the template by less. 0 from the robust tracker, whose threshold follows the contrast of each patch.
   */
  uint16_t alpha;
  /**
   * The judgement of the refiner's network that the box shows the target of the lock, a running mean over about four
   * frames: 65535 is certain, 32768 undecided, 0 certain that it shows something else. Below 38229 the state is
   * #SMR_UNCERTAIN or #SMR_LOST. 0 without the refiner.
   */
  uint16_t identity;
  /**
   * 1 if the tracker searched for the runner-up; 0 if no decision needed a runner-up (see setting `runner_up_always`
   * in #smr_paper_config). Always 0 from the robust tracker.
   */
  uint8_t has_runner_up;
  /**
   * 1 if the answer has an identity, that is, from the robust tracker with the refiner; else 0.
   */
  uint8_t has_identity;
  /**
   * 1 if the target was lost in the previous frame and is found in this one; else 0.
   */
  uint8_t found_again;
} smr_answer;

/**
 * An image of 8-bit gray pixels, row by row without gaps.
 */
typedef struct smr_image {
  /**
   * Address of width * height bytes.
   */
  const uint8_t *pixels;
  /**
   * Width in pixels.
   */
  uint16_t width;
  /**
   * Height in pixels.
   */
  uint16_t height;
} smr_image;

/**
 * The state of a frame that is being read out. #smr_readout_begin fills it; programs read only `line`.
 *
 * Lines may arrive in an interrupt while the main loop polls #smr_readout_frame:
 * - #smr_readout_begin writes every field: call it in the interrupt, or while the interrupt is off.
 * - Only #smr_readout_line writes `next` and `line`. It writes no pixel of the windows after #smr_readout_frame has
 *   succeeded, so the interrupt may stay on during #smr_lock and #smr_update. Begin the next frame after the
 *   update, or in other memory.
 * - #smr_readout_frame only reads, and may be interrupted at any point.
 *
 * The interrupt must run on the processor core of the main loop. You must prevent all other overlaps: two calls of
 * #smr_readout_line, or #smr_readout_lines and any other call.
 */
typedef struct smr_readout {
  /**
   * The pixel format.
   */
  const struct smr_format *format;
  /**
   * Columns of the sensor.
   */
  uint16_t columns;
  /**
   * Lines of the sensor.
   */
  uint16_t lines;
  /**
   * Index of the next line. It increases after the pixels of a line are written.
   */
  uint16_t next;
  /**
   * Index of the line that caused the last error SMR_ERROR_LINE_...
   */
  uint16_t line;
  /**
   * The frame is shrunk by this: 1 to 4.
   */
  uint16_t shrink;
  /**
   * The windows to keep. If there is no second one, its width and height are 0.
   */
  struct smr_rect windows[2];
  /**
   * The gray pixels of the first window, then those of the second.
   */
  uint8_t *pixels;
  /**
   * Size of the memory at `pixels`, in bytes.
   */
  size_t size;
} smr_readout;

/**
 * The recorder of a tracker: see #smr_record. Fill in `write` and `context`; set all other fields to 0.
 */
typedef struct smr_recorder {
  /**
   * Stores bytes in flash, a file or elsewhere. A call passes one row of pixels, one saved target or at most 64
   * bytes. Returns 0 on success.
   */
  int32_t (*write)(void *context, const uint8_t *bytes, size_t size);
  /**
   * The first argument of `write`.
   */
  void *context;
  /**
   * The number of entries written.
   */
  uint32_t entries;
  /**
   * 1 once `write` has failed or an entry would have more than 4 GiB; then nothing more is written.
   */
  uint8_t failed;
  /**
   * The recorded tracker.
   */
  struct smr_tracker *tracker;
} smr_recorder;

/**
 * An entry of a flight record. Only the fields that belong to its kind are set; the others are 0.
 */
typedef struct smr_entry {
  /**
   * The kind of this entry; it determines which fields are set.
   */
  smr_entry_kind kind;
  /**
   * The frame of a lock or an update. Its parts are the windows that the tracker read.
   */
  struct smr_frame frame;
  /**
   * The box of a lock.
   */
  struct smr_rect bbox;
  /**
   * Motion of the picture to the right, in units of 1/256 pixel.
   */
  int32_t right;
  /**
   * Motion of the picture downwards, in units of 1/256 pixel.
   */
  int32_t down;
  /**
   * The result of an update.
   */
  struct smr_answer answer;
  /**
   * Address of a saved target inside the record.
   */
  const uint8_t *saved;
  /**
   * Size of the saved target in bytes.
   */
  size_t saved_size;
  /**
   * The tracker of #SMR_ENTRY_BEGIN: 1 for the robust one, 0 for the paper's.
   */
  uint8_t is_robust;
  /**
   * The size of the robust tracker: 1 for that of #smr_config_small, else 0.
   */
  uint8_t is_small;
  /**
   * Settings of the paper tracker.
   */
  struct smr_paper_config paper;
  /**
   * Settings of the robust tracker.
   */
  struct smr_robust_config robust;
} smr_entry;

/* Each type has the size that it has in the library, with pointers of 4 and of 8 bytes. */
#if defined(__cplusplus) && __cplusplus >= 201103L
#define SMR_UNPACKED(type, holds) static_assert(holds, #type " must not be packed: a header before smr.h has left #pragma pack on")
#else
#define SMR_UNPACKED(type, holds) typedef char type##_must_not_be_packed[(holds) ? 1 : -1]
#endif
#define SMR_SIZE(type, on_32_bits, on_64_bits) \
    SMR_UNPACKED(type, sizeof(type) == (sizeof(void *) == 8 ? on_64_bits : on_32_bits))
SMR_SIZE(smr_fraction, 4, 4);
SMR_SIZE(smr_radius, 4, 4);
SMR_SIZE(smr_margins, 8, 8);
SMR_SIZE(smr_paper_config, 50, 50);
SMR_SIZE(smr_robust_config, 14, 14);
SMR_SIZE(smr_config, 72, 80);
SMR_SIZE(smr_setting, 20, 24);
SMR_SIZE(smr_rect, 12, 12);
SMR_SIZE(smr_part, 20, 32);
SMR_SIZE(smr_frame, 44, 72);
SMR_SIZE(smr_fine_rect, 16, 16);
SMR_SIZE(smr_answer, 52, 52);
SMR_SIZE(smr_image, 8, 16);
SMR_SIZE(smr_readout, 48, 64);
SMR_SIZE(smr_recorder, 20, 32);
SMR_SIZE(smr_entry, 196, 240);
#ifndef __i386__ /* where members of a struct have an alignment of at most 4 */
struct smr_storage {
    char before;
    smr_paper_target storage;
};
SMR_UNPACKED(smr_storage, offsetof(struct smr_storage, storage) == SMR_ALIGNMENT);
#endif
#undef SMR_SIZE
#undef SMR_UNPACKED

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * One byte per pixel: gray.
 */
extern const struct smr_format SMR_GRAY8;

/**
 * Two bytes per pixel: Y U Y V. Gray is Y.
 */
extern const struct smr_format SMR_YUYV;

/**
 * Two bytes per pixel: U Y V Y. Gray is Y.
 */
extern const struct smr_format SMR_UYVY;

/**
 * Two bytes per pixel, the high byte first: five bits red, six green, five blue. Gray is (19595 R + 38470 G + 7471
 * B + 32768) >> 16, with R, G and B widened to eight bits by repeating their high bits.
 */
extern const struct smr_format SMR_RGB565_BE;

/**
 * RGB565 with the low byte first.
 */
extern const struct smr_format SMR_RGB565_LE;

/**
 * One byte per pixel, behind a mosaic of color filters. 2x2 pixels become one gray pixel: width and height halve.
 */
extern const struct smr_format SMR_BAYER8;

/**
 * Four gray pixels of ten bits in five bytes (MIPI RAW10). The low two bits are dropped.
 */
extern const struct smr_format SMR_GRAY10;

/**
 * The name of a status, for logs: "SMR_OK" and so on.
 *
 * @param status  Any number.
 * @return        A static string, never NULL; "SMR_ERROR_UNKNOWN" for a number that is no status.
 */
const char *smr_status_name(int32_t status);

/**
 * The version of the linked library, as "major.minor.patch".
 *
 * @return  A static string, never NULL.
 */
const char *smr_version(void);

/**
 * Fills a configuration of the paper tracker with values for cameras. They limit the tracker's time and memory.
 *
 * Unlike with #smr_config_paper, the window of a lost target grows by at most 20 pixels on each side, and all windows
 * fit #SMR_SPAN; the template is updated up to the edge of the frame, a peak inside the frame need not exceed the
 * runner-up, alpha is at least 10 gray levels, and a peak with a ratio below 1/20 is rejected.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_camera(struct smr_config *config);

/**
 * Fills a configuration of the paper tracker with the values of the authors' program, for frames of about 320x240.
 *
 * The window of a lost target grows to the padded frame, so #SMR_SPAN must be at least frame + 40 - box + 1 on each
 * axis; otherwise #smr_lock returns #SMR_ERROR_WINDOW_TOO_LARGE. For firmware use #smr_config_camera.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_paper(struct smr_config *config);

/**
 * Fills a configuration of the robust tracker without the refiner. It follows changes of light, size and view, reports
 * when the target is not visible, and then searches for it. It takes more memory and time than the paper tracker.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_robust(struct smr_config *config);

/**
 * Fills a configuration of the robust tracker with the refiner: a small learned network that fits the box to a target
 * that approaches, turns or changes its shape. This preset is the default of host-sim, Python and JavaScript.
 *
 * #smr_init accepts it only in a library with the feature `refiner` (core/c/install.sh --refiner), and else returns
 * #SMR_ERROR_REFINER_NOT_BUILT_IN.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_refined(struct smr_config *config);

/**
 * Fills a configuration of the small robust tracker without the refiner. It takes 7 KB less memory than that of
 * #smr_config_robust and a fifth less time, and follows equally well on 90 recordings: its template has at most
 * #SMR_ROBUST_SMALL_PIXELS pixels, and its `reach` is at most 7. Its memory are #smr_robust_small_target and
 * #smr_robust_small_workspace. Saved targets and flight records of one size cannot be continued with the other.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_small(struct smr_config *config);

/**
 * Fills a configuration of the small robust tracker with the refiner: see #smr_config_small and #smr_config_refined.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_small_refined(struct smr_config *config);

/**
 * Sets a setting by its name, such as "window" to { 16, 16 }, for names from a file, a console or another language. If
 * the name is known when you compile, set the field of the configuration instead.
 *
 * @param config  Filled by one of the calls smr_config_...
 * @param name    The name of a field of #smr_paper_config or #smr_robust_config, whichever the configuration is for.
 * @param values  The values, in the order of the field.
 * @param count   The number of values.
 * @return        #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED (the configuration),
 *                #SMR_ERROR_SETTING_UNKNOWN, #SMR_ERROR_SETTING_COUNT or #SMR_ERROR_CONFIG_OUT_OF_RANGE.
 */
smr_status smr_set(struct smr_config *config,
                   const char *name,
                   const uint16_t *values,
                   size_t count);

/**
 * Returns the name, range and values of the setting at an index; #SMR_ERROR_SETTING_UNKNOWN after the last one.
 *
 * @param config   Filled by one of the calls smr_config_...
 * @param index    Index of the setting, from 0.
 * @param setting  Is set; unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED (the configuration) or
 *                 #SMR_ERROR_SETTING_UNKNOWN.
 */
smr_status smr_setting_at(const struct smr_config *config,
                          size_t index,
                          struct smr_setting *setting);

/**
 * Bytes of a tracker's storage: the value that #SMR_PAPER_TARGET_SIZE or #SMR_ROBUST_TARGET_SIZE had when the library
 * was built.
 *
 * @param config  Filled by one of the calls smr_config_...
 * @return        Bytes; 0 if `config` is NULL or not filled. Can differ from the macro: see #SMR_PIXELS.
 */
size_t smr_target_size(const struct smr_config *config);

/**
 * Bytes of a tracker's workspace: the value that #SMR_PAPER_WORKSPACE_SIZE or #SMR_ROBUST_WORKSPACE_SIZE had when the
 * library was built.
 *
 * @param config  Filled by one of the calls smr_config_...
 * @return        As #smr_target_size.
 */
size_t smr_workspace_size(const struct smr_config *config);

/**
 * Constructs a tracker in the caller's memory. It has no target before #smr_lock.
 *
 * @param storage         Memory of the tracker, such as an #smr_paper_target or an #smr_robust_target, aligned to
 *                        #SMR_ALIGNMENT. It must stay where it is, untouched, as long as the tracker is used.
 * @param storage_size    Bytes at `storage`; at least #smr_target_size.
 * @param workspace       Scratch memory for updates, such as an #smr_paper_workspace or an #smr_robust_workspace. It
 *                        must be aligned and stay as `storage` must, but trackers of the same kind may share it.
 *                        #smr_init cancels an update that another tracker has begun in it.
 * @param workspace_size  Bytes at `workspace`; at least #smr_workspace_size.
 * @param config          The choice of a tracker and its settings. It is copied.
 * @param tracker         Is set to the tracker, or to NULL after an error.
 * @return                #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
 *                        #SMR_ERROR_WORKSPACE_TOO_SMALL, #SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE,
 *                        #SMR_ERROR_NOT_INITIALISED (the configuration) or an error of a setting
 *                        (#SMR_ERROR_CONFIG_OUT_OF_RANGE, #SMR_ERROR_LIMIT_BELOW_WINDOW,
 *                        #SMR_ERROR_UNCERTAIN_BELOW_LOST or #SMR_ERROR_REFINER_NOT_BUILT_IN).
 */
smr_status smr_init(void *storage,
                    size_t storage_size,
                    void *workspace,
                    size_t workspace_size,
                    const struct smr_config *config,
                    struct smr_tracker **tracker);

/**
 * Computes the window that #smr_lock reads for a given box. Firmware need not read out the frame's other pixels.
 *
 * @param tracker  Made by #smr_init.
 * @param width    Width of the frame in pixels.
 * @param height   Height of the frame in pixels.
 * @param bbox     The box, completely inside the frame.
 * @param window   Is set to a rectangle inside the frame. The paper tracker: the box. The robust tracker: the box
 *                 and its surroundings. Unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_BOX_EMPTY or
 *                 #SMR_ERROR_BOX_OUTSIDE_FRAME.
 */
smr_status smr_lock_window(const struct smr_tracker *tracker,
                           uint16_t width,
                           uint16_t height,
                           const struct smr_rect *bbox,
                           struct smr_rect *window);

/**
 * Starts to follow the target in a box, and forgets any previous target. Reads only the pixels in #smr_lock_window.
 *
 * Cost: a copy of the box and two comparisons per pixel (paper tracker), or two to three updates (robust tracker).
 *
 * @param tracker  Made by #smr_init.
 * @param frame    The frame. Its parts in memory cover #smr_lock_window.
 * @param bbox     The box, completely inside the frame; for the paper tracker at most #SMR_PIXELS pixels.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
 *                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME) or of the box (#SMR_ERROR_BOX_EMPTY to
 *                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY).
 */
smr_status smr_lock(struct smr_tracker *tracker,
                    const struct smr_frame *frame,
                    const struct smr_rect *bbox);

/**
 * Does one bounded step of a lock, for programs with a deadline. Begins a lock, or continues the one under way if
 * `bbox` and the frame's size are unchanged. Call it again while it returns #SMR_UNDER_WAY; the tracker has no target
 * before the last step. A lock takes at most 11.2 million units of work (see #smr_update_step). The paper tracker
 * locks in one step.
 *
 * @param tracker  Made by #smr_init.
 * @param frame    As for #smr_lock. Its pixels are the same in every step.
 * @param bbox     As for #smr_lock.
 * @param work     Units of work to do; 0 means 1.
 * @return         #SMR_UNDER_WAY, or as #smr_lock.
 */
smr_status smr_lock_step(struct smr_tracker *tracker,
                         const struct smr_frame *frame,
                         const struct smr_rect *bbox,
                         uint32_t work);

/**
 * Finds the target in the next frame. Reads only the pixels in #smr_windows.
 *
 * Cost of the paper tracker, for boxes of at least 8x8 pixels and windows of at least +-4: at most 1.25 * (offsets
 * in the window) * (pixels of the template) comparisons, twice that in the frame in which the target begins to leave,
 * and far fewer if it is clearly visible. Cost of the robust tracker: at most 726 * 2000 products.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param frame    The frame. Its parts in memory cover #smr_windows.
 * @param answer   Is set to the answer; unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
 *                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED, #SMR_ERROR_FRAME_SIZE_CHANGED or
 *                 #SMR_ERROR_WINDOW_NOT_IN_MEMORY.
 */
smr_status smr_update(struct smr_tracker *tracker,
                      const struct smr_frame *frame,
                      struct smr_answer *answer);

/**
 * Does one bounded step of an update, for programs with a deadline. Begins an update, or continues the one under way.
 * Call it again while it returns #SMR_UNDER_WAY. The answer equals that of #smr_update, however small the steps. Any
 * other call that changes the tracker cancels the update; so does a lock or an update of another tracker in the same
 * workspace. A call that fails, of this or the other tracker, does not.
 *
 * The unit of work depends on the tracker:
 * - The paper's: a comparison of two bytes. A step may exceed `work` by at most max(pixels of the template, 2 * pixels
 *   of a row of the first of #smr_windows) + 7 * #SMR_SPAN.
 * - The robust one: about an instruction of a Cortex-M4. A step may exceed `work` by at most 128,000. An update takes
 *   at most 13.8 million units (17.4 with the refiner), or 6.1 (8.1) with a `sweep` of 1.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param frame    As for #smr_update. Its pixels are the same in every step.
 * @param work     Units of work to do; 0 means 1.
 * @param answer   Is set to the answer; unchanged unless the status is #SMR_OK.
 * @return         #SMR_UNDER_WAY, or as #smr_update.
 */
smr_status smr_update_step(struct smr_tracker *tracker,
                           const struct smr_frame *frame,
                           uint32_t work,
                           struct smr_answer *answer);

/**
 * The two windows of the next frame that #smr_update may read. Firmware need not read out other pixels.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param windows  Are set to two rectangles inside the frame. The first is never empty. The second, where the robust
 *                 tracker searches for a lost target, is empty in most frames. Unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
 */
smr_status smr_windows(const struct smr_tracker *tracker,
                       struct smr_rect windows[2]);

/**
 * Reports a turn of the camera since the last frame: what was at (x, y) is expected at (x + right, y + down). Moves
 * the box and the search window by this motion, but keeps the box in or near the frame. The paper tracker rounds the
 * motion to whole pixels. Cancels a lock or an update under way. Without a target, nothing moves.
 *
 * @param tracker  Made by #smr_init.
 * @param right    Motion to the right in units of 1/256 pixel.
 * @param down     Motion downwards in units of 1/256 pixel.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
 */
smr_status smr_moved(struct smr_tracker *tracker,
                     int32_t right,
                     int32_t down);

/**
 * Quality of the target at the lock: its difference from shifted copies of itself. It is 0 for a flat target, an edge
 * along an axis or a single pixel: the tracker follows such a target, but may slip along it without noticing.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param quality  Is set to the quality in units of 1/65535, poor below #SMR_POOR_QUALITY; unchanged after an error.
 * @return         As #smr_windows.
 */
smr_status smr_quality(const struct smr_tracker *tracker,
                       uint16_t *quality);

/**
 * The current box and state: those of the last answer, or as #smr_lock or #smr_restore has set them.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param bbox     Is set to the box; unchanged after an error.
 * @param state    Is set to the state; unchanged after an error.
 * @return         As #smr_windows.
 */
smr_status smr_last(const struct smr_tracker *tracker,
                    struct smr_fine_rect *bbox,
                    smr_state *state);

/**
 * Copies the current template (paper tracker) or the early template, which verifies the target (robust tracker).
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param pixels   Memory for the pixels, row by row without gaps, outside the tracker's own memory.
 * @param size     Bytes at `pixels`; #SMR_PIXELS or #SMR_ROBUST_PIXELS are always enough.
 * @param image    Is set to the pixels and their width and height. After an error it and the pixels are unchanged.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
 *                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_NOT_LOCKED or #SMR_ERROR_BUFFER_TOO_SMALL.
 */
smr_status smr_template(const struct smr_tracker *tracker,
                        uint8_t *pixels,
                        size_t size,
                        struct smr_image *image);

/**
 * Largest size of this tracker's saved target in bytes. Equals the value of #SMR_PAPER_SAVED_SIZE,
 * #SMR_ROBUST_SAVED_SIZE or #SMR_ROBUST_SMALL_SAVED_SIZE with which the library was built.
 *
 * @param tracker  Made by #smr_init.
 * @param size     Is set to the number of bytes; unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
 */
smr_status smr_saved_size(const struct smr_tracker *tracker, size_t *size);

/**
 * Saves the target and the tracker's settings as bytes, the same on every platform. #smr_restore needs equal settings.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param bytes    Memory outside the tracker's own; unchanged after an error.
 * @param size     Bytes at `bytes`; #smr_saved_size are always enough.
 * @param written  Is set to the number of bytes written; unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
 *                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_NOT_LOCKED or #SMR_ERROR_BUFFER_TOO_SMALL.
 */
smr_status smr_save(const struct smr_tracker *tracker,
                    uint8_t *bytes,
                    size_t size,
                    size_t *written);

/**
 * Continues with a target that #smr_save wrote. Given the same frames, answers equal those of the saving tracker.
 *
 * @param tracker  Made by #smr_init with the same configuration.
 * @param bytes    The bytes that #smr_save wrote, on any platform, outside the tracker's own memory.
 * @param size     The number of bytes; excess bytes are ignored.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
 *                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_OTHER_METHOD or an error of the bytes (#SMR_ERROR_NOT_SAVED to
 *                 #SMR_ERROR_SAVED_TOO_LARGE).
 */
smr_status smr_restore(struct smr_tracker *tracker,
                       const uint8_t *bytes,
                       size_t size);

/**
 * Names the tracker's first setting whose saved value differs, after #smr_restore returned #SMR_ERROR_OTHER_CONFIG.
 *
 * @param tracker  Made by #smr_init.
 * @param bytes    The bytes that #smr_save wrote, on any platform, outside the tracker's own memory.
 * @param size     The number of bytes; excess bytes are ignored.
 * @param name     Is set to the field's name, a static string such as "gate_lost"; to NULL if no setting differs.
 * @return         #SMR_OK, or an error of #smr_restore other than #SMR_ERROR_OTHER_CONFIG.
 */
smr_status smr_other_setting(const struct smr_tracker *tracker,
                             const uint8_t *bytes,
                             size_t size,
                             const char **name);

/**
 * Begins the read-out of a frame.
 *
 * Windows are in pixels of the gray frame, which has the sensor's size, or half its width and height with #SMR_BAYER8.
 * Pass #smr_windows; before a lock pass #smr_lock_window and an empty one.
 *
 * @param readout  Is filled; need not be initialised. Unchanged after an error.
 * @param format   The address of a constant, such as &SMR_YUYV: see #smr_format.
 * @param columns  Columns of the sensor.
 * @param lines    Lines of the sensor.
 * @param windows  Two windows inside the gray frame. Only the second may be empty.
 * @param pixels   Initialised memory for the gray pixels of the first window, then of the second, row by row without
 *                 gaps. It must stay until the tracker was called with the frame.
 * @param size     Bytes at `pixels`; at least width * height of both windows.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, #SMR_ERROR_FORMAT_UNKNOWN,
 *                 #SMR_ERROR_OUTSIDE_FRAME or #SMR_ERROR_BUFFER_TOO_SMALL.
 */
smr_status smr_readout_begin(struct smr_readout *readout,
                             const struct smr_format *format,
                             uint16_t columns,
                             uint16_t lines,
                             const struct smr_rect windows[2],
                             uint8_t *pixels,
                             size_t size);

/**
 * #smr_readout_begin for a frame that is shrunk as its lines arrive, so that a large target needs a small buffer: each
 * of its pixels is the mean of `shrink` x `shrink` gray pixels. Windows, boxes and answers are in pixels of the small
 * frame, whose size is that of the gray frame divided by `shrink`.
 *
 * The first of the lines of a block stores the means of `shrink` pixels, rounded. The k-th moves the stored pixel by the
 * k-th part of its difference to the mean of the new line, `(difference * ceil(65536 / k) + 32768) >> 16`. The result
 * is at most 1.0, 1.4 or 1.7 gray levels from the exact mean (`shrink` = 2, 3, 4), with #SMR_BAYER8 at most 2.2, 2.8 or
 * 3.2.
 *
 * @param readout  As of #smr_readout_begin, and so for all that is not named here.
 * @param format   See above.
 * @param columns  See above.
 * @param lines    See above.
 * @param shrink   1 to 4; with 1 the call is #smr_readout_begin. #SMR_ERROR_FORMAT_UNKNOWN for another number.
 * @param windows  Two windows inside the small frame.
 * @param pixels   See above.
 * @param size     See above.
 * @return         As #smr_readout_begin.
 */
smr_status smr_readout_begin_shrunk(struct smr_readout *readout,
                                    const struct smr_format *format,
                                    uint16_t columns,
                                    uint16_t lines,
                                    uint16_t shrink,
                                    const struct smr_rect windows[2],
                                    uint8_t *pixels,
                                    size_t size);

/**
 * Converts a line of the sensor, for example in a DMA interrupt: see #smr_readout. Lines must come in order; lines
 * outside the windows may be skipped. Only pixels in the windows cost time.
 *
 * @param readout  Filled by #smr_readout_begin. After an error only its `line` is changed.
 * @param y        Index of the line, from 0.
 * @param bytes    The bytes of the line.
 * @param size     The number of bytes; excess bytes are ignored.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, #SMR_ERROR_LINE_OUT_OF_ORDER,
 *                 #SMR_ERROR_LINE_TOO_SHORT, #SMR_ERROR_LINE_OUTSIDE_FRAME, #SMR_ERROR_LINE_MISSING,
 *                 #SMR_ERROR_OVERLAPS_TRACKER if the line lies in the memory of a window, or an error of #smr_readout_begin
 *                 if the readout was changed.
 */
smr_status smr_readout_line(struct smr_readout *readout,
                            uint16_t y,
                            const uint8_t *bytes,
                            size_t size);

/**
 * Converts all lines of a frame in memory. Not for interrupts, because it returns only after the last line.
 *
 * @param readout  Filled by #smr_readout_begin. After an error the lines before its `line` are converted.
 * @param bytes    The bytes of the frame.
 * @param size     The number of bytes.
 * @param stride   Bytes from the start of a line to the start of the next.
 * @return         As #smr_readout_line. A frame that ends early has lines that are too short.
 */
smr_status smr_readout_lines(struct smr_readout *readout,
                             const uint8_t *bytes,
                             size_t size,
                             size_t stride);

/**
 * Fills a frame for #smr_lock and #smr_update once all window lines have come. About interrupts see #smr_readout.
 *
 * @param readout  Filled by #smr_readout_begin.
 * @param frame    Is filled; need not be initialised. Points to the windows' memory. Unchanged after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_LINE_MISSING as long as a line of a
 *                 window has not come, or an error of #smr_readout_begin if the readout was changed.
 */
smr_status smr_readout_frame(const struct smr_readout *readout,
                             struct smr_frame *frame);

/**
 * Starts a flight record of a tracker: passes each later lock, update, move and restored target to `write`. `host-sim
 * replay FILE` replays the record and reports where the replay first differs. smr_core::record documents every byte.
 *
 * Call it before #smr_lock; for a tracker with a target call #smr_save, #smr_record, #smr_restore. `write` runs inside
 * the recorded calls. A call that fails is not recorded.
 *
 * @param tracker   Made by #smr_init.
 * @param recorder  Must stay in place, for this tracker alone, while it is used. NULL or #smr_init ends the record.
 * @return          #SMR_OK, #SMR_ERROR_NULL (also `write`), #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
 */
smr_status smr_record(struct smr_tracker *tracker,
                      struct smr_recorder *recorder);

/**
 * Reads the next entry of a flight record in memory. With these entries, a test of firmware can replay the record and
 * compare answers.
 *
 * @param record  The bytes of the record.
 * @param size    The number of bytes.
 * @param at      Offset of the entry in bytes, at first 0. Is set to that of the next one; unchanged after an error.
 * @param entry   Is set to the entry, which points into the record; unchanged after an error.
 * @return        #SMR_OK (also at the end), #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE,
 *                #SMR_ERROR_DAMAGED (no whole entry begins at `at`: the record was cut off), #SMR_ERROR_OTHER_VERSION
 *                or #SMR_ERROR_OTHER_CONFIG (a table of similarities other than the paper's).
 */
smr_status smr_next_entry(const uint8_t *record,
                          size_t size,
                          size_t *at,
                          struct smr_entry *entry);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SMR_H */
