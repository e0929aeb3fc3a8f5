/**
 * @file smr.h
 * @brief Follows one target through 8-bit gray frames by the Similarity Matching Ratio (SMR).
 *
 * The target's last appearance, the template, is compared with every offset of a search window around its last
 * position; the best one is the target's new box, and its patch the next template.
 *
 * @code
 * static smr_storage storage;           // all the memory there is; nothing is allocated
 * smr_config config;
 * smr_tracker *tracker;
 * smr_answer answer;
 *
 * smr_config_camera(&config);
 * if (smr_init(&storage, sizeof storage, &config, &tracker) != SMR_OK) { ... }
 * if (smr_lock(tracker, &first_frame, &target) != SMR_OK) { ... }
 * while (next(&frame)) {
 *     if (smr_update(tracker, &frame, &answer) == SMR_OK && answer.state != SMR_LOST) { use(answer.bbox); }
 * }
 * @endcode
 *
 * The robust tracker, smr_robust_*, is called in the same way. It goes beyond the paper: it holds when light, size and view
 * change, says when the target is not seen, and looks for it then; it takes more memory and time.
 *
 * - **Errors.** Every call checks its pointers (NULL, alignment) and sizes and returns an #smr_status;
 *   #smr_status_name names it. A call that fails changes nothing.
 * - **What cannot be checked**: a pointer that is neither NULL nor misaligned points to as much memory as its type, or the
 *   size beside it, says; what it points to is initialised where it is read; and nobody else writes there during the
 *   call. A tracker pointer comes from #smr_init or #smr_robust_init.
 * - **Threads and interrupts.** There are no globals: calls on different trackers may overlap in time, calls on one
 *   may not.
 * - **Where pixels may be.** On Cortex-M4, M7, M33 and up words of pixels are loaded from any address. Normal memory allows
 *   that; Device memory, which external RAM is (0xA0000000 to 0xDFFFFFFF) until the MPU says otherwise, faults. Set up the MPU,
 *   or `plain_loop` of #smr_config.
 * - **Stack.** Measured on a Cortex-M4, with all that is called: #smr_update, #smr_step and #smr_finish 1.5 KB, every
 *   other call less than 512 bytes; on a robust tracker at most 5.1 KB. Builds that are not optimised take more.
 * - **Exactness.** Integers only. The same frames give the same answers, bit for bit, on every machine.
 *
 * This file is written by cbindgen from core/c/src: change it there.
 */


#ifndef SMR_H
#define SMR_H

#include <stddef.h>
#include <stdint.h>

/**
 * The largest area of a box, in pixels, and the most offsets of the search window on an axis: how much a tracker holds.
 *
 * They are fixed when the library is built, by environment variables of the same names. Whoever builds the library with
 * others defines these before including this file, to the same numbers. If it is forgotten, #smr_init says so where the
 * storage is too small; #SMR_ERROR_BOX_TOO_LARGE and #SMR_ERROR_WINDOW_TOO_LARGE are the library's word on what it holds.
 */
#ifndef SMR_PIXELS
#define SMR_PIXELS 4096
#endif
/** See #SMR_PIXELS. */
#ifndef SMR_SPAN
#define SMR_SPAN 161
#endif
#if SMR_PIXELS < 1 || SMR_PIXELS > 65537 || SMR_SPAN < 1
#error "SMR_PIXELS is 1 to 65537 (more pixels could overflow a score), SMR_SPAN at least 1"
#endif

/** Size of a tracker's storage in bytes, a constant expression. A program linked to the library can ask #smr_tracker_size. */
#define SMR_TRACKER_SIZE \
    (((size_t)(SMR_PIXELS) + 7) / 8 * 16 + (20 * (size_t)(SMR_SPAN) + 7) / 8 * 8 + 28 * sizeof(size_t) + 656)

/** Alignment of a tracker's storage in bytes, a constant expression. */
#define SMR_TRACKER_ALIGN (sizeof(size_t))

/** Storage for one tracker, of the right size and alignment: static, on the stack or inside something larger. */
typedef union smr_storage {
    /** For the alignment. */
    size_t alignment;
    /** For the size. */
    unsigned char bytes[SMR_TRACKER_SIZE];
} smr_storage;

/** Compiles only if the storage is of the size it is said to be. */
typedef char smr_storage_is_as_large_as_stated[sizeof(smr_storage) == SMR_TRACKER_SIZE ? 1 : -1];

/** The most pixels of a robust tracker's template, on its grid. */
#define SMR_ROBUST_PIXELS 1600

/** Size of a robust tracker's storage in bytes, a constant expression; #smr_robust_tracker_size says the same. */
#define SMR_ROBUST_TRACKER_SIZE (46592 + 22 * sizeof(size_t))

/** Alignment of a robust tracker's storage in bytes, a constant expression. */
#define SMR_ROBUST_TRACKER_ALIGN 8

/** Storage for one robust tracker, of the right size and alignment: static, or inside something larger. */
typedef union smr_robust_storage {
    /** For the alignment. */
    uint64_t alignment;
    /** For the size. */
    unsigned char bytes[SMR_ROBUST_TRACKER_SIZE];
} smr_robust_storage;

/** Compiles only if the storage is of the size it is said to be. */
typedef char smr_robust_storage_is_as_large_as_stated[
    sizeof(smr_robust_storage) == SMR_ROBUST_TRACKER_SIZE ? 1 : -1];


/**
 * `SMR_ROBUST_TRACKER_ALIGN` of the header.
 */
#define ROBUST_STORAGE_ALIGN 8

/**
 * Version of this header, major.minor.patch: a program can compare it with #smr_version.
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
 * How a call ended. The numbers stay as they are from version to version; new ones may be added.
 *
 * A call that does not end with #SMR_OK has changed nothing, except that #smr_init and #smr_robust_init set their
 * `*tracker` to NULL.
 */
enum smr_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Done.
   */
  SMR_OK = 0,
  /**
   * A pointer is NULL.
   */
  SMR_ERROR_NULL = 1,
  /**
   * A pointer is not aligned for what it points to.
   */
  SMR_ERROR_MISALIGNED = 2,
  /**
   * The storage is smaller than #smr_tracker_size, or #smr_robust_tracker_size.
   */
  SMR_ERROR_STORAGE_TOO_SMALL = 3,
  /**
   * The tracker was not made by #smr_init or #smr_robust_init, or was moved or overwritten since; or the table was not
   * made by #smr_table_init.
   */
  SMR_ERROR_NOT_INITIALISED = 4,
  /**
   * The scale of a table is not in 1..4096.
   */
  SMR_ERROR_SCALE_OUT_OF_RANGE = 5,
  /**
   * A fraction of the configuration has a denominator of 0.
   */
  SMR_ERROR_ZERO_DENOMINATOR = 6,
  /**
   * `k` or `first_threshold` is 0: no pixel would ever count.
   */
  SMR_ERROR_NOTHING_COUNTS = 7,
  /**
   * `window_limit` is smaller than `window`.
   */
  SMR_ERROR_LIMIT_BELOW_WINDOW = 8,
  /**
   * Width or height of a frame is 0.
   */
  SMR_ERROR_FRAME_EMPTY = 9,
  /**
   * The stride is smaller than the width.
   */
  SMR_ERROR_STRIDE_TOO_SMALL = 10,
  /**
   * `size` ends before the last pixel of the last row.
   */
  SMR_ERROR_FRAME_TOO_SHORT = 11,
  /**
   * `size` is more than any object can have (PTRDIFF_MAX).
   */
  SMR_ERROR_FRAME_TOO_LARGE = 12,
  /**
   * The pixels lie in the tracker's own storage.
   */
  SMR_ERROR_FRAME_OVERLAPS_TRACKER = 13,
  /**
   * The part in memory reaches beyond the edge of the full frame.
   */
  SMR_ERROR_OUTSIDE_FRAME = 14,
  /**
   * The box has no pixels.
   */
  SMR_ERROR_BOX_EMPTY = 15,
  /**
   * A part of the box lies outside the frame.
   */
  SMR_ERROR_BOX_OUTSIDE_FRAME = 16,
  /**
   * The box has more than #SMR_PIXELS pixels.
   */
  SMR_ERROR_BOX_TOO_LARGE = 17,
  /**
   * A part of the box lies within the frame, but not in the part of it that is in memory.
   */
  SMR_ERROR_BOX_NOT_IN_MEMORY = 18,
  /**
   * The window could grow to more than #SMR_SPAN offsets on an axis.
   */
  SMR_ERROR_WINDOW_TOO_LARGE = 19,
  /**
   * There is no target yet: #smr_lock, or #smr_robust_lock, comes first.
   */
  SMR_ERROR_NOT_LOCKED = 20,
  /**
   * The full frame is not of the size of the one that was locked on.
   */
  SMR_ERROR_FRAME_SIZE_CHANGED = 21,
  /**
   * The part of the frame in memory does not cover #smr_window, or #smr_robust_window.
   */
  SMR_ERROR_WINDOW_NOT_IN_MEMORY = 22,
  /**
   * No update was begun, or it was finished, or the tracker has locked since: #smr_begin comes first.
   */
  SMR_ERROR_NOT_BEGUN = 23,
  /**
   * The part of the frame in memory does not cover #smr_robust_lock_window.
   */
  SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY = 24,
  /**
   * The memory for the pixels is too small for the template.
   */
  SMR_ERROR_BUFFER_TOO_SMALL = 25,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_status smr_status;
#else
typedef int32_t smr_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the robust tracker holds of its target after a frame.
 */
enum smr_robust_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The early template agrees, part by part: this is the target.
   */
  SMR_ROBUST_TRACKING = 0,
  /**
   * It hardly agrees: the target is partly hidden or changes quickly, or something else is followed.
   */
  SMR_ROBUST_UNCERTAIN = 1,
  /**
   * It has not agreed for some frames: the target is not seen. The box is what is followed meanwhile. Nothing is learned
   * from it, and the target is looked for elsewhere.
   */
  SMR_ROBUST_LOST = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_robust_state smr_robust_state;
#else
typedef int32_t smr_robust_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the tracker holds of its target after a frame.
 */
enum smr_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The target was found inside the picture. Its patch is the new template if it lies in `update_zone` of #smr_config.
   */
  SMR_TRACKING = 0,
  /**
   * The target was found, partly outside the picture; the template is kept.
   */
  SMR_LEAVING = 1,
  /**
   * The peak did not stand out as the gate demands. The box is the last one that was believed, template and alpha are
   * kept, and the window grows with every further frame.
   */
  SMR_LOST = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_state smr_state;
#else
typedef int32_t smr_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Follows one target whose size, light and view may change. Lives in storage that the caller gives to #smr_robust_init;
 * needs no clean-up.
 *
 * Several targets are several trackers. Calls on one tracker must not overlap in time; calls on different ones may.
 */
typedef struct smr_robust_tracker smr_robust_tracker;

/**
 * Follows one target. Lives in storage that the caller gives to #smr_init; needs no clean-up.
 *
 * Several targets are several trackers. Calls on one tracker must not overlap in time; calls on different ones may.
 */
typedef struct smr_tracker smr_tracker;

/**
 * The parts of the robust tracker. Fill it with #smr_robust_config_default first, then change what is to be changed.
 *
 * Each of the first six is 0 to leave the part out, else the part is there.
 */
typedef struct smr_robust_config {
  /**
   * A target that moves is expected to go on. Without, it is expected where it was.
   */
  uint8_t velocity;
  /**
   * Places far from where the target is expected must answer more clearly.
   */
  uint8_t near;
  /**
   * The box follows the target's size.
   */
  uint8_t size;
  /**
   * An early template tells whether it is still the target. Without, the state is always #SMR_ROBUST_TRACKING.
   */
  uint8_t verification;
  /**
   * What does not agree with the early template is not learned; needs `verification`.
   */
  uint8_t caution;
  /**
   * A lost target is looked for all over the frame; needs `verification`.
   */
  uint8_t sweep;
  /**
   * 0: the fastest way that the processor has. Else: the plain loop, which loads single bytes; a frame in Device memory
   * (external RAM before the MPU makes it Normal) needs it, as unaligned loads of words fault there. It changes no answer.
   */
  uint8_t plain_loop;
} smr_robust_config;

/**
 * A rectangle in whole pixels of the full frame. It may reach outside the frame.
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
 * One frame of the camera: 8-bit gray pixels, the part of it that is in memory, and where in the full frame that is.
 *
 * A frame that is in memory as a whole has x = y = 0, full_width = width and full_height = height.
 * Pixels are only read, and only during the call.
 */
typedef struct smr_frame {
  /**
   * The top left pixel in memory.
   */
  const uint8_t *pixels;
  /**
   * Bytes that may be read from `pixels` on: at least (height - 1) * stride + width.
   */
  size_t size;
  /**
   * Bytes from a pixel to the one below it: at least `width`.
   */
  size_t stride;
  /**
   * Pixels of a row in memory; at least 1.
   */
  uint16_t width;
  /**
   * Rows in memory; at least 1.
   */
  uint16_t height;
  /**
   * Where the part in memory begins: column of the full frame.
   */
  uint16_t x;
  /**
   * Where the part in memory begins: row of the full frame.
   */
  uint16_t y;
  /**
   * Width of the full frame; at least x + width.
   */
  uint16_t full_width;
  /**
   * Height of the full frame; at least y + height.
   */
  uint16_t full_height;
} smr_frame;

/**
 * A rectangle in units of 1/256 pixel of the full frame. It may reach outside the frame.
 */
typedef struct smr_fine_rect {
  /**
   * Left edge, to the right of the frame's left edge; may be negative.
   */
  int32_t x;
  /**
   * Top edge, below the frame's top edge; may be negative.
   */
  int32_t y;
  /**
   * Width.
   */
  uint32_t width;
  /**
   * Height.
   */
  uint32_t height;
} smr_fine_rect;

/**
 * The answer of #smr_robust_update.
 */
typedef struct smr_robust_answer {
  /**
   * The target's box, in units of 1/256 pixel.
   */
  struct smr_fine_rect fine;
  /**
   * The same in whole pixels, each edge rounded.
   */
  struct smr_rect bbox;
  /**
   * Whether the box is to be believed.
   */
  smr_robust_state state;
  /**
   * How much speaks for it, 0 to 65535: a running mean of the early template's agreement, two thirds, and of the filter's
   * response, one third. Below 15733 the target is lost, below 26666 it is uncertain.
   */
  uint16_t confidence;
  /**
   * How well the early template agrees in this frame, in units of 1/65535: the fourth least ratio of its 16 parts.
   */
  uint16_t ratio;
  /**
   * The filter's response at the place, in units of 1/16384: about 1 where the target looks as it did.
   */
  int32_t response;
  /**
   * The target's size against that of the box that was locked on, in units of 1/65536.
   */
  uint32_t scale;
  /**
   * Products of the filter and comparisons of the template that it took.
   */
  uint32_t work;
  /**
   * 1 if the sweep found the target, in this frame; else 0.
   */
  uint8_t found_again;
} smr_robust_answer;

/**
 * 8-bit gray pixels, row by row without a gap.
 */
typedef struct smr_image {
  /**
   * width * height bytes.
   */
  const uint8_t *pixels;
  /**
   * Pixels of a row.
   */
  uint16_t width;
  /**
   * Rows.
   */
  uint16_t height;
} smr_image;

/**
 * A table of similarities: entry d is exp(-d / scale) in units of 1/65535. Filled by #smr_table_init, 512 bytes.
 *
 * Only needed for another scale than the paper's 255, which is built in.
 */
typedef struct smr_table {
  /**
   * By difference of two pixels, in gray levels.
   */
  uint16_t entries[256];
} smr_table;

/**
 * numerator / denominator; the denominator is at least 1.
 */
typedef struct smr_fraction {
  /**
   * What stands above the line.
   */
  uint16_t numerator;
  /**
   * What stands below the line; at least 1.
   */
  uint16_t denominator;
} smr_fraction;

/**
 * How far the search window reaches to each side of the last position, in pixels: offsets -x..x and -y..y.
 */
typedef struct smr_radius {
  /**
   * To the left and to the right.
   */
  uint16_t x;
  /**
   * Up and down.
   */
  uint16_t y;
} smr_radius;

/**
 * How many pixels a box keeps from each edge of the picture.
 */
typedef struct smr_margins {
  /**
   * Columns to the left of the box.
   */
  uint16_t left;
  /**
   * Rows above it.
   */
  uint16_t top;
  /**
   * Columns to the right of it.
   */
  uint16_t right;
  /**
   * Rows below it.
   */
  uint16_t bottom;
} smr_margins;

/**
 * How clearly the peak must stand above the runner-up before a frame is believed.
 *
 * The first four are ratios of the two scores that the peak must exceed. A ratio below 1 demands nothing of a peak that
 * scores at all.
 */
typedef struct smr_gate {
  /**
   * While the target stays inside the picture.
   */
  struct smr_fraction tracking;
  /**
   * When the box at the peak is partly outside the picture.
   */
  struct smr_fraction leaving;
  /**
   * When the box at the peak is inside, but one has not been before: until a lost target is found again.
   */
  struct smr_fraction returning;
  /**
   * To be found again when lost, wherever that is.
   */
  struct smr_fraction lost;
  /**
   * The other way to be believed, in every state: the peak is more than this many fully similar pixels above the
   * runner-up.
   */
  uint16_t lead;
  /**
   * The least similarity matching ratio of the peak, in units of 1/65535; below it no frame is believed. 0 demands
   * nothing, which is the paper's.
   */
  uint16_t least_ratio;
} smr_gate;

/**
 * The numbers of the method. Fill it with #smr_config_camera (or #smr_config_paper) first, then change what is to be changed.
 */
typedef struct smr_config {
  /**
   * The similarity of two pixels by their difference, or NULL for the paper's, exp(-d / 255). A table given here is
   * not copied: see #smr_table_init.
   */
  const struct smr_table *table;
  /**
   * k in alpha = k * (largest change of a pixel of the template); more than 0.
   */
  struct smr_fraction k;
  /**
   * alpha before the first update, in gray levels: a pixel counts if its difference is below it. At least 1.
   */
  uint8_t first_threshold;
  /**
   * The least alpha after an update, in gray levels. 0 and 1 are the same, and the paper's: after a still scene a slight
   * change of light then leaves no pixel that counts.
   */
  uint8_t least_threshold;
  /**
   * Width of the virtual border of zeroes around the frame, in pixels: how far a box may leave the picture.
   */
  uint16_t padding;
  /**
   * The search window around the last position.
   */
  struct smr_radius window;
  /**
   * How many pixels the window grows on each side, for each frame that the target stays lost.
   */
  uint16_t growth;
  /**
   * Where that growth ends; at least `window`. On each axis 2 * limit + 1 offsets must fit #SMR_SPAN, unless the
   * padded frame is smaller than that.
   */
  struct smr_radius window_limit;
  /**
   * The runner-up is the best score more than this many pixels away from the peak, in x or in y.
   */
  uint16_t neighbourhood;
  /**
   * What a box keeps from the edges of the picture for its patch to become the template.
   */
  struct smr_margins update_zone;
  /**
   * When a frame is believed.
   */
  struct smr_gate gate;
  /**
   * 0: the fastest way that the processor has. Else: the plain loop, which loads single bytes; a frame in Device memory
   * (external RAM before the MPU makes it Normal) needs it, as unaligned loads of words fault there. It changes no answer.
   */
  uint8_t plain_loop;
  /**
   * 0: the runner-up is looked for when the gate's decision depends on it. Else: in every frame, which multiplies the
   * time.
   */
  uint8_t runner_up_always;
} smr_config;

/**
 * A position of the template's top left corner in the frame, and its score.
 */
typedef struct smr_peak {
  /**
   * Left edge of the box, in the frame.
   */
  int32_t x;
  /**
   * Top edge of the box, in the frame.
   */
  int32_t y;
  /**
   * The sum of the similarities, in units of 1/65535 of a fully similar pixel.
   */
  uint32_t score;
} smr_peak;

/**
 * The answer of #smr_update. Ratios are in units of 1/65535, so 65535 is 1.0.
 */
typedef struct smr_answer {
  /**
   * The target's box; when lost, the last one that was believed.
   */
  struct smr_rect bbox;
  /**
   * Whether the box is to be believed.
   */
  smr_state state;
  /**
   * The similarity matching ratio: the peak's score over the number of pixels, rounded down.
   */
  uint16_t ratio;
  /**
   * The same of the runner-up; 0 if the window does not reach beyond the peak's neighbourhood, or if there is none.
   */
  uint16_t runner_up_ratio;
  /**
   * The threshold that this frame was scored with, in gray levels (0..256): alpha, rounded up. A pixel counted if it
   * differed by less.
   */
  uint16_t alpha;
  /**
   * The best offset, believed or not.
   */
  struct smr_peak peak;
  /**
   * The runner-up's score, in the peak's unit; 0 if there is none.
   */
  uint32_t runner_up;
  /**
   * 1 if the runner-up was looked for, 0 if nothing depended on it: see `runner_up_always` in #smr_config.
   */
  uint8_t has_runner_up;
} smr_answer;





#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The size that storage must have, in bytes: #SMR_ROBUST_TRACKER_SIZE.
 *
 * @return  Bytes.
 */
size_t smr_robust_tracker_size(void);

/**
 * Makes a robust tracker without a target.
 *
 * @param storage  Memory for the tracker, such as an #smr_robust_storage; aligned to #SMR_ROBUST_TRACKER_ALIGN. It must
 *                 stay where it is, untouched, as long as the tracker is used; then it may be used for anything.
 * @param size     Bytes at `storage`; at least #smr_robust_tracker_size.
 * @param config   Is copied.
 * @param tracker  Is set to the tracker, or to NULL if there is none.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_STORAGE_TOO_SMALL.
 */
smr_status smr_robust_init(void *storage,
                           size_t size,
                           const struct smr_robust_config *config,
                           struct smr_robust_tracker **tracker);

/**
 * The pixels of a frame that #smr_robust_lock reads for a target. Firmware may read out just these.
 *
 * @param full_width   Width of the full frame.
 * @param full_height  Height of the full frame.
 * @param target       The box, wholly inside the frame, of any size.
 * @param window       Is set to the rectangle, always inside the frame; left alone after an error.
 * @return             #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_BOX_EMPTY or #SMR_ERROR_BOX_OUTSIDE_FRAME.
 */
smr_status smr_robust_lock_window(uint16_t full_width,
                                  uint16_t full_height,
                                  const struct smr_rect *target,
                                  struct smr_rect *window);

/**
 * Starts on the target in a box, at any time; whatever was followed before is forgotten.
 *
 * Of the frame only the pixels in #smr_robust_lock_window are read: the target and its surroundings.
 * Cost: about that of five calls of #smr_robust_update.
 *
 * @param tracker  Made by #smr_robust_init.
 * @param frame    The frame, or a part of it that covers #smr_robust_lock_window.
 * @param target   The box, wholly inside the frame, of any size.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
 *                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_BOX_EMPTY,
 *                 #SMR_ERROR_BOX_OUTSIDE_FRAME or #SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY. After an error the tracker goes on
 *                 with what it had.
 */
smr_status smr_robust_lock(struct smr_robust_tracker *tracker,
                           const struct smr_frame *frame,
                           const struct smr_rect *target);

/**
 * Looks for the target in the next frame.
 *
 * Of the frame only the pixels in #smr_robust_window are read; the rest need not be in memory.
 * Cost, for a filter of W weights (at most 2000) and a template of P pixels (at most #SMR_ROBUST_PIXELS): 307 W products to
 * look for the target and its size; then, to learn, up to 2028 W products, or, while it is lost, 289 W products to look
 * elsewhere; and 9 P comparisons for each look.
 *
 * @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
 * @param frame    The frame, or a part of it that covers #smr_robust_window.
 * @param answer   Is set to the answer; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
 *                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED,
 *                 #SMR_ERROR_FRAME_SIZE_CHANGED or #SMR_ERROR_WINDOW_NOT_IN_MEMORY. After an error the tracker is as it
 *                 was before.
 */
smr_status smr_robust_update(struct smr_robust_tracker *tracker,
                             const struct smr_frame *frame,
                             struct smr_robust_answer *answer);

/**
 * The pixels of the frame that the next #smr_robust_update may read. Firmware may read out just these. While the target is
 * uncertain or lost, the place where it is looked for next is in it, too.
 *
 * @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
 * @param window   Is set to the rectangle, always inside the frame; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
 */
smr_status smr_robust_window(const struct smr_robust_tracker *tracker,
                             struct smr_rect *window);

/**
 * The early template, by which the track is verified.
 *
 * @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
 * @param pixels   Memory for its pixels, outside of the tracker's storage: they are copied there, row by row, without gaps.
 * @param size     Bytes at `pixels`; #SMR_ROBUST_PIXELS are always enough.
 * @param image    Is set to the pixels and their shape. After an error it is left alone, and so are the pixels.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_NOT_LOCKED or
 *                 #SMR_ERROR_BUFFER_TOO_SMALL.
 */
smr_status smr_robust_early_template(const struct smr_robust_tracker *tracker,
                                     uint8_t *pixels,
                                     size_t size,
                                     struct smr_image *image);

/**
 * Fills a configuration with all parts.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_robust_config_default(struct smr_robust_config *config);

/**
 * The name of a status as it is written here, for logs.
 *
 * @param status  Any number.
 * @return        A string that is always there, never NULL; "SMR_ERROR_UNKNOWN" for a number that is no status.
 */
const char *smr_status_name(int32_t status);

/**
 * Fills a table for #smr_config.
 *
 * @param table  Memory for the table. Trackers that are configured with it read it in every update: it must stay
 *               where it is, unchanged, as long as any of them is used.
 * @param scale  1 (almost only equal pixels are similar) to 4096 (almost all are), in gray levels. The paper's is 255.
 * @return       #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_SCALE_OUT_OF_RANGE.
 */
smr_status smr_table_init(struct smr_table *table,
                          uint16_t scale);

/**
 * The size that storage must have, in bytes: #SMR_TRACKER_SIZE of the library as it was built.
 *
 * @return  Bytes; differs from #SMR_TRACKER_SIZE if this program defines other capacities than the library was built with.
 */
size_t smr_tracker_size(void);

/**
 * Makes a tracker without a target.
 *
 * @param storage  Memory for the tracker, such as an #smr_storage; aligned to #SMR_TRACKER_ALIGN. It must stay where it
 *                 is, untouched, as long as the tracker is used; then it may be used for anything.
 * @param size     Bytes at `storage`; at least #smr_tracker_size.
 * @param config   Is copied, except for a table of its own: see #smr_config.
 * @param tracker  Is set to the tracker, or to NULL if there is none.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
 *                 #SMR_ERROR_NOT_INITIALISED (the table), #SMR_ERROR_ZERO_DENOMINATOR, #SMR_ERROR_NOTHING_COUNTS or
 *                 #SMR_ERROR_LIMIT_BELOW_WINDOW.
 */
smr_status smr_init(void *storage,
                    size_t size,
                    const struct smr_config *config,
                    struct smr_tracker **tracker);

/**
 * Starts on the target in a box, at any time; whatever was followed before is forgotten. Only the pixels of the box are
 * read.
 *
 * @param tracker  Made by #smr_init.
 * @param frame    The frame, or a part of it that covers the box.
 * @param target   The box, wholly inside the frame, of at most #SMR_PIXELS pixels.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
 *                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), what is wrong with the box
 *                 (#SMR_ERROR_BOX_EMPTY to #SMR_ERROR_BOX_NOT_IN_MEMORY) or #SMR_ERROR_WINDOW_TOO_LARGE. After an
 *                 error the tracker goes on with what it had.
 */
smr_status smr_lock(struct smr_tracker *tracker,
                    const struct smr_frame *frame,
                    const struct smr_rect *target);

/**
 * Looks for the target in the next frame.
 *
 * Of the frame only the pixels in #smr_window are read; the rest need not be in memory.
 * Cost: at most (offsets in the window) x (pixels of the template) comparisons and about an eighth of it more; far fewer
 * where the target is seen clearly. In the frame in which a tracked target begins to leave the picture, at most twice that.
 * #smr_begin, #smr_step and #smr_finish do the same in parts.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param frame    The frame, or a part of it that covers #smr_window.
 * @param answer   Is set to the answer; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
 *                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED,
 *                 #SMR_ERROR_FRAME_SIZE_CHANGED or #SMR_ERROR_WINDOW_NOT_IN_MEMORY. After an error the tracker is as it
 *                 was before.
 */
smr_status smr_update(struct smr_tracker *tracker,
                      const struct smr_frame *frame,
                      struct smr_answer *answer);

/**
 * Begins an update that is made in steps of a bounded amount of work, for those who have a deadline. The answer is that of
 * #smr_update, however it is cut. An update that was begun before, and not finished, is forgotten.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param frame    The frame, or a part of it that covers #smr_window. Its pixels must stay as they are until #smr_finish.
 * @return         As #smr_update.
 */
smr_status smr_begin(struct smr_tracker *tracker,
                     const struct smr_frame *frame);

/**
 * Goes on with the update that #smr_begin has begun.
 *
 * @param tracker  As for #smr_begin.
 * @param frame    The same frame, with the same pixels.
 * @param work     Comparisons of bytes to be made; a few more are, to come to a stop: at most the template's pixels or
 *                 twice the pixels of a row of #smr_window, whichever is more, and seven for each of #SMR_SPAN offsets.
 *                 0 is taken for 1.
 * @param done     Is set to 1 if nothing is left to do but #smr_finish, else to 0; left alone after an error.
 * @return         As #smr_update, or #SMR_ERROR_NOT_BEGUN.
 */
smr_status smr_step(struct smr_tracker *tracker,
                    const struct smr_frame *frame,
                    uint32_t work,
                    uint8_t *done);

/**
 * Does what is left of the update that #smr_begin has begun, and gives its answer.
 *
 * @param tracker  As for #smr_begin.
 * @param frame    The same frame, with the same pixels.
 * @param answer   Is set to the answer; left alone after an error.
 * @return         As #smr_update, or #SMR_ERROR_NOT_BEGUN.
 */
smr_status smr_finish(struct smr_tracker *tracker,
                      const struct smr_frame *frame,
                      struct smr_answer *answer);

/**
 * The pixels of the frame that the next #smr_update may read. Firmware may read out just these.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param window   Is set to the rectangle, always inside the frame; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
 */
smr_status smr_window(const struct smr_tracker *tracker,
                      struct smr_rect *window);

/**
 * The template: the target's last believed appearance.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param image    Is set to the pixels, in the tracker's storage: they are good until the next call of #smr_lock or
 *                 #smr_update on this tracker, and may only be read. Left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
 */
smr_status smr_template(const struct smr_tracker *tracker,
                        struct smr_image *image);

/**
 * alpha of the next #smr_update.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param alpha    Is set to alpha in gray levels, rounded up (0..256); left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
 */
smr_status smr_alpha(const struct smr_tracker *tracker,
                     uint16_t *alpha);

/**
 * The version of the library that is linked, as "major.minor.patch".
 *
 * @return  A string that is always there, never NULL.
 */
const char *smr_version(void);

/**
 * Fills a configuration with the values for cameras: the paper's with a bounded window, so that time and memory are, too.
 *
 * Beside #smr_config_paper the window of a lost target grows by at most 20 pixels on each side (an #SMR_SPAN of 161 holds
 * it), the template is updated up to the edge of the picture, a peak inside the picture need not exceed the runner-up, alpha
 * is at least 10 gray levels, and a peak of less than a twentieth of what is possible is not believed.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_camera(struct smr_config *config);

/**
 * Fills a configuration with the values of the paper and its authors' program, for frames of about 320x240.
 *
 * The window of a lost target grows until it is the padded frame: #SMR_SPAN must be at least frame + 40 - box + 1 on each
 * axis, or #smr_lock answers #SMR_ERROR_WINDOW_TOO_LARGE. For firmware see #smr_config_camera.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_paper(struct smr_config *config);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SMR_H */
