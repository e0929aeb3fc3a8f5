/**
 * @file smr.h
 * @brief Follows one target through 8-bit gray frames by the Similarity Matching Ratio (SMR).
 *
 * The target's last appearance, the template, is compared with every offset of a search window around its last
 * position; the best one is the target's new box, and its patch the next template.
 *
 * @code
 * static smr_paper_target storage;       // all the memory there is; nothing is allocated
 * static smr_paper_workspace workspace;  // scratch: one serves any number of trackers of its kind
 * smr_config config;
 * smr_tracker *tracker;
 * smr_answer answer;
 *
 * smr_config_camera(&config);
 * if (smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker) != SMR_OK) { ... }
 * if (smr_lock(tracker, &first_frame, &target) != SMR_OK) { ... }
 * while (next(&frame)) {
 *     if (smr_update(tracker, &frame, &answer) == SMR_OK && answer.state != SMR_LOST) { use(answer.bbox); }
 * }
 * @endcode
 *
 * There are two trackers, and the configuration chooses: the paper's (#smr_config_camera, #smr_config_paper) and the robust one
 * (#smr_config_robust), which goes beyond the paper: it holds when light, size and view change, says when the target is not seen,
 * and looks for it then; it takes more memory and time. All calls are the same.
 *
 * - **Errors.** Every call checks its pointers (NULL, alignment) and sizes and returns an #smr_status;
 *   #smr_status_name names it. A call that fails changes nothing, not even an update that is under way.
 * - **What cannot be checked**: a pointer that is neither NULL nor misaligned points to as much memory as its type, or the
 *   size beside it, says; what it points to is initialised where it is read; and nobody else writes there during the
 *   call. A tracker pointer comes from #smr_init, and `method` of an #smr_config is NULL or as it was filled in.
 * - **Threads and interrupts.** There are no globals: calls on different trackers may overlap in time, calls on one, or on
 *   trackers with one workspace, may not.
 * - **Where pixels may be.** On Cortex-M4, M7, M33 and up words of pixels are loaded from any address. Normal memory allows
 *   that; Device memory, which external RAM is (0xA0000000 to 0xDFFFFFFF) until the MPU says otherwise, faults. Set up the MPU,
 *   or `plain_loop` of #smr_config.
 * - **Stack.** Measured on a Cortex-M4, with all that is called: the paper's tracker at most 1.6 KB, the robust one 1.5 KB, and either
 *   0.3 KB in #smr_init. Builds that are not optimised take more.
 * - **Exactness.** Integers only. The same frames give the same answers, bit for bit, on every machine.
 *
 * This file is written by cbindgen from core/c/src: change it there.
 */


#ifndef SMR_H
#define SMR_H

#include <stddef.h>
#include <stdint.h>

/**
 * The largest area of a box, in pixels, and the most offsets of the search window on an axis: how much the paper's tracker holds.
 *
 * They are fixed when the library is built, by environment variables of the same names. Whoever builds the library with
 * others defines these before including this file, to the same numbers. If it is forgotten, #smr_init says so where the
 * memory is too small; #SMR_ERROR_BOX_TOO_LARGE and #SMR_ERROR_WINDOW_TOO_LARGE are the library's word on what it holds.
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

/** The most pixels of the robust tracker's template, on its grid. */
#define SMR_ROBUST_PIXELS 1600

/** Alignment of all memory that is given to #smr_init, in bytes. */
#define SMR_ALIGNMENT 8

/** Bytes of storage for one tracker of the paper, a constant expression. A program linked to the library can ask #smr_target_size. */
#define SMR_PAPER_TARGET_SIZE (((size_t)(SMR_PIXELS) + 7) / 8 * 8 + 8 * sizeof(size_t) + 96)
/** Bytes of a workspace for any number of them, a constant expression. */
#define SMR_PAPER_WORKSPACE_SIZE \
    (((size_t)(SMR_PIXELS) + 7) / 8 * 8 + (20 * (size_t)(SMR_SPAN) + 7) / 8 * 8 + 22 * sizeof(size_t) + 648)
/** The most bytes that #smr_save writes of one of them. */
#define SMR_PAPER_SAVED_SIZE ((size_t)(SMR_PIXELS) + 42)
/** Bytes of storage for one robust tracker, a constant expression. */
#define SMR_ROBUST_TARGET_SIZE (11344 + 6 * sizeof(size_t))
/** Bytes of a workspace for any number of them, a constant expression. */
#define SMR_ROBUST_WORKSPACE_SIZE (39872 + 16 * sizeof(size_t))
/** The most bytes that #smr_save writes of one of them. */
#define SMR_ROBUST_SAVED_SIZE 11276

/** A target of less quality can hardly be told from what lies beside it: see #smr_quality. */
#define SMR_POOR_QUALITY 1023

/** Storage for one tracker of the paper, of the right size and alignment: static, on the stack or inside something larger. */
typedef union smr_paper_target {
    /** For the alignment. */
    uint64_t alignment;
    /** For the size. */
    unsigned char bytes[SMR_PAPER_TARGET_SIZE];
} smr_paper_target;

/** A workspace for trackers of the paper. */
typedef union smr_paper_workspace {
    /** For the alignment. */
    uint64_t alignment;
    /** For the size. */
    unsigned char bytes[SMR_PAPER_WORKSPACE_SIZE];
} smr_paper_workspace;

/** Storage for one robust tracker. */
typedef union smr_robust_target {
    /** For the alignment. */
    uint64_t alignment;
    /** For the size. */
    unsigned char bytes[SMR_ROBUST_TARGET_SIZE];
} smr_robust_target;

/** A workspace for robust trackers. */
typedef union smr_robust_workspace {
    /** For the alignment. */
    uint64_t alignment;
    /** For the size. */
    unsigned char bytes[SMR_ROBUST_WORKSPACE_SIZE];
} smr_robust_workspace;

/** Compiles only if storage and workspace are of the size they are said to be. */
typedef char smr_memory_is_as_large_as_stated[
    sizeof(smr_paper_target) == SMR_PAPER_TARGET_SIZE && sizeof(smr_paper_workspace) == SMR_PAPER_WORKSPACE_SIZE &&
    sizeof(smr_robust_target) == SMR_ROBUST_TARGET_SIZE && sizeof(smr_robust_workspace) == SMR_ROBUST_WORKSPACE_SIZE ? 1 : -1];

/**
 * How a call ended. The numbers stay as they are from version to version; new ones may be added.
 *
 * A call that does not end with #SMR_OK has changed nothing, except that #smr_init sets its `*tracker` to NULL.
 */
enum smr_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif
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
   * The storage is smaller than #smr_target_size.
   */
  SMR_ERROR_STORAGE_TOO_SMALL = 3,
  /**
   * The workspace is smaller than #smr_workspace_size.
   */
  SMR_ERROR_WORKSPACE_TOO_SMALL = 4,
  /**
   * Storage and workspace share memory.
   */
  SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE = 5,
  /**
   * The tracker was not made by #smr_init, or was moved or overwritten since, or its workspace was; the configuration was not
   * made by one of the calls smr_config_...; or the table was not made by #smr_table_init.
   */
  SMR_ERROR_NOT_INITIALISED = 6,
  /**
   * The other method's tracker is asked, or the target was saved by one.
   */
  SMR_ERROR_OTHER_METHOD = 7,
  /**
   * The scale of a table is not in 1..4096.
   */
  SMR_ERROR_SCALE_OUT_OF_RANGE = 8,
  /**
   * A fraction of the configuration has a denominator of 0.
   */
  SMR_ERROR_ZERO_DENOMINATOR = 9,
  /**
   * `k` or `first_threshold` is 0: no pixel would ever count.
   */
  SMR_ERROR_NOTHING_COUNTS = 10,
  /**
   * `window_limit` is smaller than `window`.
   */
  SMR_ERROR_LIMIT_BELOW_WINDOW = 11,
  /**
   * A number of the configuration lies outside the range that is stated beside it.
   */
  SMR_ERROR_CONFIG_OUT_OF_RANGE = 12,
  /**
   * Width or height of a part of the frame is 0.
   */
  SMR_ERROR_FRAME_EMPTY = 13,
  /**
   * The stride is smaller than the width.
   */
  SMR_ERROR_STRIDE_TOO_SMALL = 14,
  /**
   * `size` ends before the last pixel of the last row.
   */
  SMR_ERROR_FRAME_TOO_SHORT = 15,
  /**
   * `size` is more than any object can have (PTRDIFF_MAX).
   */
  SMR_ERROR_MEMORY_TOO_LARGE = 16,
  /**
   * The pixels, or the bytes, lie in the tracker's own storage, or in its workspace.
   */
  SMR_ERROR_OVERLAPS_TRACKER = 17,
  /**
   * A part in memory reaches beyond the edge of the frame.
   */
  SMR_ERROR_OUTSIDE_FRAME = 18,
  /**
   * The box has no pixels.
   */
  SMR_ERROR_BOX_EMPTY = 19,
  /**
   * A part of the box lies outside the frame.
   */
  SMR_ERROR_BOX_OUTSIDE_FRAME = 20,
  /**
   * The box has more than #SMR_PIXELS pixels. The robust tracker has room for every box.
   */
  SMR_ERROR_BOX_TOO_LARGE = 21,
  /**
   * The window could grow to more than #SMR_SPAN offsets on an axis. The robust tracker always has room.
   */
  SMR_ERROR_WINDOW_TOO_LARGE = 22,
  /**
   * What is in memory does not cover #smr_lock_window.
   */
  SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY = 23,
  /**
   * There is no target yet: #smr_lock comes first.
   */
  SMR_ERROR_NOT_LOCKED = 24,
  /**
   * The frame is not of the size of the one that was locked on, or by which the lock was begun.
   */
  SMR_ERROR_FRAME_SIZE_CHANGED = 25,
  /**
   * What is in memory does not cover #smr_window, or #smr_sweep_window where there is one.
   */
  SMR_ERROR_WINDOW_NOT_IN_MEMORY = 26,
  /**
   * No update, or no lock, of this tracker is under way in its workspace: none was begun, it was finished, the tracker has changed
   * since, or another one has used the workspace. #smr_begin or #smr_begin_lock comes first.
   */
  SMR_ERROR_NOT_BEGUN = 27,
  /**
   * The memory is too small for what goes there.
   */
  SMR_ERROR_BUFFER_TOO_SMALL = 28,
  /**
   * These are not the bytes of a saved target.
   */
  SMR_ERROR_NOT_SAVED = 29,
  /**
   * The target was saved by another version of the library.
   */
  SMR_ERROR_OTHER_VERSION = 30,
  /**
   * The saved target ends too early.
   */
  SMR_ERROR_TRUNCATED = 31,
  /**
   * The saved target has changed since it was written: its checksum is wrong.
   */
  SMR_ERROR_DAMAGED = 32,
  /**
   * The target was saved with another configuration: answers would differ.
   */
  SMR_ERROR_OTHER_CONFIG = 33,
  /**
   * The saved target is too large for this tracker.
   */
  SMR_ERROR_SAVED_TOO_LARGE = 34,
  /**
   * A reason that has no number yet.
   */
  SMR_ERROR_UNKNOWN = 35,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_status smr_status;
#else
typedef int32_t smr_status;
#endif
#endif


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
 * What the tracker holds of its target after a frame.
 */
enum smr_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * The target is where the box is. The paper's: it was found inside the picture. The robust tracker's: its early template
   * agrees, part by part.
   */
  SMR_TRACKING = 0,
  /**
   * The target is where the box is, partly outside the picture; the template is kept. Never from the robust tracker.
   */
  SMR_LEAVING = 1,
  /**
   * The target is partly hidden or changes quickly, or something else is followed: the early template hardly agrees. Never
   * from the paper's.
   */
  SMR_UNCERTAIN = 2,
  /**
   * The target is not seen. The box of the paper's tracker is the last one that was believed; that of the robust one is what
   * it follows meanwhile. Nothing is learned, and the search goes on.
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
 * The code of a tracker.
 */
typedef struct smr_method smr_method;

/**
 * Follows one target. Lives in storage that the caller gives to #smr_init; needs no clean-up.
 *
 * Several targets are several trackers. Calls on one tracker must not overlap in time, and neither must calls on trackers that
 * share a workspace; others may.
 */
typedef struct smr_tracker smr_tracker;

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
   * The least similarity matching ratio of the peak, in units of 1/65535; below it no frame is believed. Where it is not 0, a box inside
   * the frame must also show a quarter of the template's contrast (mean absolute deviation), and no more pixels cut off at 0 or 255 than
   * the template has and half of all: what a covered lens shows is no target. 0 demands nothing, neither of the ratio nor of the contrast,
   * which is the paper's.
   */
  uint16_t least_ratio;
} smr_gate;

/**
 * The numbers of the paper's tracker.
 */
typedef struct smr_paper_config {
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
   * 0: the runner-up is looked for when the gate's decision depends on it. Else: in every frame, which multiplies the
   * time.
   */
  uint8_t runner_up_always;
} smr_paper_config;

/**
 * The numbers of the robust tracker.
 */
typedef struct smr_robust_config {
  /**
   * How far the target is looked for to each side, in cells: 4 to 8. A cell is a tenth of the root of the target's area. The
   * work of an update grows with the square of 2 `reach` + 1.
   */
  uint8_t reach;
  /**
   * 0 if the box keeps its size; else it follows the target's.
   */
  uint8_t size;
  /**
   * 0 if a lost target is looked for only where it was lost; else all over the frame.
   */
  uint8_t sweep;
  /**
   * How slowly the confidence follows what speaks for the target: it keeps so many 256ths of itself in each frame. More
   * holds on for longer, through short occlusions and through errors alike.
   */
  uint8_t patience;
  /**
   * The target is lost while the confidence is below this, in units of 1/65535.
   */
  uint16_t lost_below;
  /**
   * It is uncertain while the confidence is below this; at least `lost_below`.
   */
  uint16_t uncertain_below;
  /**
   * How far the filter goes towards what is best for the present frame, in units of 1/256: 0 to 256. 0 keeps what was learned
   * in the first frame.
   */
  uint16_t learning_rate;
  /**
   * How far the early template goes towards the present frame, in units of 1/1024: 0 to 1024.
   */
  uint16_t early_rate;
} smr_robust_config;

/**
 * Which tracker, and its numbers. Fill it with #smr_config_camera, #smr_config_paper or #smr_config_robust first, then change
 * what is to be changed.
 */
typedef struct smr_config {
  /**
   * The tracker's code: leave it as it was filled in. A program links only the trackers whose configurations it fills.
   */
  const struct smr_method *method;
  /**
   * 0: the fastest way that the processor has. Else: the plain loop, which loads single bytes; a frame in Device memory
   * (external RAM before the MPU makes it Normal) needs it, as unaligned loads of words fault there. It changes no answer.
   */
  uint8_t plain_loop;
  /**
   * Read by the paper's tracker alone, and 0 from #smr_config_robust.
   */
  struct smr_paper_config paper;
  /**
   * Read by the robust tracker alone, and 0 from the other two.
   */
  struct smr_robust_config robust;
} smr_config;

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
 * A part of a frame that is in memory: 8-bit gray pixels, and where in the frame they are.
 */
typedef struct smr_part {
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
   * Pixels of a row; at least 1.
   */
  uint16_t width;
  /**
   * Rows; at least 1.
   */
  uint16_t height;
  /**
   * Where the part begins: column of the frame.
   */
  uint16_t x;
  /**
   * Where the part begins: row of the frame.
   */
  uint16_t y;
} smr_part;

/**
 * One frame of the camera: its size, and what of it is in memory. Pixels are only read, and only during the call.
 *
 * A whole frame is one part of the frame's own size at x = y = 0. Firmware that reads out only what the tracker asks for gives
 * #smr_window as the first part and, where there is one, #smr_sweep_window as the second.
 */
typedef struct smr_frame {
  /**
   * Width of the whole frame.
   */
  uint16_t width;
  /**
   * Height of the whole frame.
   */
  uint16_t height;
  /**
   * What is in memory. There is no second part where its `pixels` are NULL.
   */
  struct smr_part parts[2];
} smr_frame;

/**
 * A rectangle in units of 1/256 pixel of the frame. It may reach outside the frame.
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
 * The answer of #smr_update. Ratios and the confidence are in units of 1/65535, so 65535 is 1.0.
 */
typedef struct smr_answer {
  /**
   * The target's box in whole pixels.
   */
  struct smr_rect bbox;
  /**
   * The same in units of 1/256 pixel. That of the paper's tracker is always whole.
   */
  struct smr_fine_rect fine;
  /**
   * Whether the box is to be believed.
   */
  smr_state state;
  /**
   * The target's size against that of the box that was locked on, in units of 1/65536. Always 65536 from the paper's tracker.
   */
  uint32_t scale;
  /**
   * How much speaks for the box. The paper's: `ratio`, and 0 when lost. The robust tracker's: a running mean of the early
   * template's agreement, two thirds, and of the filter's response, one third.
   */
  uint16_t confidence;
  /**
   * How similar what was found is to the template. The paper's: the similarity matching ratio, rounded down. The robust
   * tracker's: the fourth least ratio of the 16 parts of the early template.
   */
  uint16_t ratio;
  /**
   * The ratio of the runner-up; 0 if there is none.
   */
  uint16_t runner_up_ratio;
  /**
   * The threshold that this frame was scored with, in gray levels (1..256): alpha, rounded up. A pixel counted if it differed
   * by less. 0 from the robust tracker, which has one for each place.
   */
  uint16_t alpha;
  /**
   * 1 if the runner-up was looked for; 0 if nothing depended on it (see `runner_up_always` in #smr_paper_config), and from the
   * robust tracker.
   */
  uint8_t has_runner_up;
  /**
   * 1 if the target was lost before this frame and is not any more; else 0.
   */
  uint8_t found_again;
} smr_answer;

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

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Fills a configuration of the paper's tracker with the values for cameras: the paper's with a bounded window, so that time and
 * memory are, too.
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
 * Fills a configuration of the paper's tracker with the values of the paper and its authors' program, for frames of about
 * 320x240.
 *
 * The window of a lost target grows until it is the padded frame: #SMR_SPAN must be at least frame + 40 - box + 1 on each
 * axis, or #smr_lock answers #SMR_ERROR_WINDOW_TOO_LARGE. For firmware see #smr_config_camera.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_paper(struct smr_config *config);

/**
 * Fills a configuration of the robust tracker. It goes beyond the paper: it holds when light, size and view change, says when
 * the target is not seen, and looks for it then; it takes more memory and time.
 *
 * @param config  Memory for the configuration.
 * @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
 */
smr_status smr_config_robust(struct smr_config *config);

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
 * The size that the storage of a tracker must have: #SMR_PAPER_TARGET_SIZE or #SMR_ROBUST_TARGET_SIZE of the library as it was
 * built.
 *
 * @param config  Made by one of the calls smr_config_...
 * @return        Bytes; 0 if `config` is NULL or was not made so. Differs from the macro if this program defines other
 *                capacities than the library was built with.
 */
size_t smr_target_size(const struct smr_config *config);

/**
 * The size that the workspace of a tracker must have: #SMR_PAPER_WORKSPACE_SIZE or #SMR_ROBUST_WORKSPACE_SIZE of the library as
 * it was built.
 *
 * @param config  Made by one of the calls smr_config_...
 * @return        As #smr_target_size.
 */
size_t smr_workspace_size(const struct smr_config *config);

/**
 * Makes a tracker without a target.
 *
 * @param storage         Memory for what the tracker remembers, such as an #smr_paper_target or an #smr_robust_target; aligned to
 *                        #SMR_ALIGNMENT. It must stay where it is, untouched, as long as the tracker is used; then it may be used
 *                        for anything.
 * @param storage_size    Bytes at `storage`; at least #smr_target_size.
 * @param workspace       Scratch memory for updates, such as an #smr_paper_workspace or an #smr_robust_workspace; aligned to
 *                        #SMR_ALIGNMENT. As `storage`, but trackers of the same kind may share one: an update that another
 *                        tracker has begun in it is then given up.
 * @param workspace_size  Bytes at `workspace`; at least #smr_workspace_size.
 * @param config          Says which tracker it is. Is copied, except for a table of its own: see #smr_paper_config.
 * @param tracker         Is set to the tracker, or to NULL if there is none.
 * @return                #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
 *                        #SMR_ERROR_WORKSPACE_TOO_SMALL, #SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE, #SMR_ERROR_NOT_INITIALISED (the
 *                        configuration, or its table) or what is wrong with the configuration (#SMR_ERROR_ZERO_DENOMINATOR to
 *                        #SMR_ERROR_CONFIG_OUT_OF_RANGE).
 */
smr_status smr_init(void *storage,
                    size_t storage_size,
                    void *workspace,
                    size_t workspace_size,
                    const struct smr_config *config,
                    struct smr_tracker **tracker);

/**
 * The pixels of a frame that #smr_lock reads for a target. Firmware may read out just these.
 *
 * @param tracker  Made by #smr_init.
 * @param width    Width of the frame.
 * @param height   Height of the frame.
 * @param target   The box, wholly inside the frame.
 * @param window   Is set to the rectangle, always inside the frame: for the paper's tracker the box, for the robust one its
 *                 surroundings, too. Left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_BOX_EMPTY or
 *                 #SMR_ERROR_BOX_OUTSIDE_FRAME.
 */
smr_status smr_lock_window(const struct smr_tracker *tracker,
                           uint16_t width,
                           uint16_t height,
                           const struct smr_rect *target,
                           struct smr_rect *window);

/**
 * Starts on the target in a box, at any time; whatever was followed before is forgotten. Only the pixels in #smr_lock_window are
 * read.
 *
 * Cost: for the paper's tracker a copy of the box and two comparisons for each of its pixels, for the robust one as much as 25
 * updates. #smr_begin_lock, #smr_step and #smr_finish_lock do the same in parts.
 *
 * @param tracker  Made by #smr_init.
 * @param frame    The frame; what is in memory covers #smr_lock_window.
 * @param target   The box, wholly inside the frame; of at most #SMR_PIXELS pixels for the paper's tracker.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
 *                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME) or with the box (#SMR_ERROR_BOX_EMPTY to
 *                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY). After an error the tracker goes on with what it had, and so does an
 *                 update that is under way.
 */
smr_status smr_lock(struct smr_tracker *tracker,
                    const struct smr_frame *frame,
                    const struct smr_rect *target);

/**
 * Begins a lock that is made in steps of a bounded amount of work, for those who have a deadline: #smr_step as often as it takes,
 * then #smr_finish_lock. From now on there is no target, until the lock is finished.
 *
 * @param tracker  Made by #smr_init.
 * @param frame    As for #smr_lock. Its pixels must stay as they are until #smr_finish_lock.
 * @param target   As for #smr_lock.
 * @return         As #smr_lock.
 */
smr_status smr_begin_lock(struct smr_tracker *tracker,
                          const struct smr_frame *frame,
                          const struct smr_rect *target);

/**
 * Does what is left of the lock that #smr_begin_lock has begun. From now on there is a target.
 *
 * @param tracker  As for #smr_begin_lock.
 * @param frame    The same frame, with the same pixels.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the frame
 *                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_BEGUN, #SMR_ERROR_FRAME_SIZE_CHANGED or
 *                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY. After an error the lock is still under way.
 */
smr_status smr_finish_lock(struct smr_tracker *tracker,
                           const struct smr_frame *frame);

/**
 * How well the target could be told from what lies beside it when it was locked. A flat target, an edge and a single pixel look the
 * same beside their place: the tracker follows such a target, but may slip along it without noticing.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param quality  Is set to the quality in units of 1/65535, poor below #SMR_POOR_QUALITY; left alone after an error.
 * @return         As #smr_window.
 */
smr_status smr_quality(const struct smr_tracker *tracker,
                       uint16_t *quality);

/**
 * Looks for the target in the next frame.
 *
 * Of the frame only the pixels in #smr_window and #smr_sweep_window are read; the rest need not be in memory. Cost of the paper's
 * tracker: for boxes of 8x8 pixels and windows of +-4 or more at most 1.25 times (offsets in the window) x (pixels of the template)
 * comparisons, far fewer where the target is seen clearly. In the frame in which a tracked target begins to leave the picture, at
 * most twice that. Cost of the robust tracker: about the same in every frame, at most 894 products for each of at most 2000
 * weights. #smr_begin, #smr_step and #smr_finish do the same in parts.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param frame    The frame; what is in memory covers #smr_window, and #smr_sweep_window where there is one.
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
 * #smr_update, however it is cut. An update that was begun before in this workspace, and not finished, is given up.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param frame    As for #smr_update. Its pixels must stay as they are until #smr_finish.
 * @return         As #smr_update.
 */
smr_status smr_begin(struct smr_tracker *tracker,
                     const struct smr_frame *frame);

/**
 * Goes on with the update that #smr_begin has begun, or with the lock that #smr_begin_lock has.
 *
 * @param tracker  As for #smr_begin or #smr_begin_lock.
 * @param frame    The same frame, with the same pixels.
 * @param work     Units of work to be done; 0 is taken for 1. For the paper's tracker a unit is a comparison of two bytes; a few
 *                 more are made, to come to a stop: at most the template's pixels or twice the pixels of a row of #smr_window,
 *                 whichever is more, and seven for each of #SMR_SPAN offsets. For the robust tracker it is about an instruction
 *                 of a Cortex-M4: an update takes at most 6.5 million, a lock 50.5 million, and a step at most 128,000 more than
 *                 it was asked for.
 * @param done     Is set to 1 if nothing is left to do but #smr_finish or #smr_finish_lock, else to 0; left alone after an error.
 * @return         As #smr_update or #smr_finish_lock, or #SMR_ERROR_NOT_BEGUN.
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
 * The pixels of the frame that the next #smr_update may read. Firmware may read out just these, and those of #smr_sweep_window.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param window   Is set to the rectangle, always inside the frame and never empty; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
 */
smr_status smr_window(const struct smr_tracker *tracker,
                      struct smr_rect *window);

/**
 * The pixels of a second place that the next #smr_update may read, where it looks for a lost target: only the robust tracker
 * does, and not in every frame.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param window   Is set to the rectangle, always inside the frame; its width and height are 0 if there is none. Left alone
 *                 after an error.
 * @return         As #smr_window.
 */
smr_status smr_sweep_window(const struct smr_tracker *tracker,
                            struct smr_rect *window);

/**
 * The box and the state of the last answer: after #smr_lock and #smr_restore, too.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param bbox     Is set to the box; left alone after an error.
 * @param state    Is set to the state; left alone after an error.
 * @return         As #smr_window.
 */
smr_status smr_last(const struct smr_tracker *tracker,
                    struct smr_fine_rect *bbox,
                    smr_state *state);

/**
 * Says that the picture has moved since the last frame because the camera turned: what was at (x, y) is expected at
 * (x + right, y + down). An update that is under way is given up.
 *
 * The search window moves along, so that a turn of the camera does not take the target out of it. The box is kept within reach
 * of the frame. The paper's tracker rounds to whole pixels. Before the first lock it does nothing.
 *
 * @param tracker  Made by #smr_init.
 * @param right    In units of 1/256 pixel.
 * @param down     In units of 1/256 pixel.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
 */
smr_status smr_moved(struct smr_tracker *tracker,
                     int32_t right,
                     int32_t down);

/**
 * The most bytes that #smr_save writes: #SMR_PAPER_SAVED_SIZE or #SMR_ROBUST_SAVED_SIZE of the library as it was built.
 *
 * @param tracker  Made by #smr_init.
 * @param size     Is set to the bytes; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
 */
smr_status smr_saved_size(const struct smr_tracker *tracker,
                          size_t *size);

/**
 * Writes the target to memory: template and track, and of the configuration a checksum. The bytes are the same on every
 * platform.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param bytes    Memory outside of the tracker's own; left alone after an error.
 * @param size     Bytes there; #smr_saved_size are always enough.
 * @param written  Is set to how many were written; left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
 *                 #SMR_ERROR_OVERLAPS_TRACKER,
 *                 #SMR_ERROR_NOT_LOCKED or #SMR_ERROR_BUFFER_TOO_SMALL.
 */
smr_status smr_save(const struct smr_tracker *tracker,
                    uint8_t *bytes,
                    size_t size,
                    size_t *written);

/**
 * Goes on with a target that #smr_save wrote: with identical answers, or not at all.
 *
 * @param tracker  Made by #smr_init with the same configuration.
 * @param bytes    What #smr_save wrote, on any platform, outside of the tracker's own memory.
 * @param size     Bytes there; more than were written do no harm.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
 *                 #SMR_ERROR_OVERLAPS_TRACKER,
 *                 #SMR_ERROR_OTHER_METHOD or what is wrong with the bytes (#SMR_ERROR_NOT_SAVED to #SMR_ERROR_SAVED_TOO_LARGE).
 *                 After an error the tracker goes on with what it had.
 */
smr_status smr_restore(struct smr_tracker *tracker,
                       const uint8_t *bytes,
                       size_t size);

/**
 * The template of the paper's tracker: the target's last believed appearance.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param image    Is set to the pixels, in the tracker's storage: they are good until the next call on this tracker that changes
 *                 it, and may only be read. Left alone after an error.
 * @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_NOT_LOCKED or
 *                 #SMR_ERROR_OTHER_METHOD.
 */
smr_status smr_template(const struct smr_tracker *tracker,
                        struct smr_image *image);

/**
 * alpha of the next #smr_update of the paper's tracker.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param alpha    Is set to alpha in gray levels, rounded up (1..256); left alone after an error.
 * @return         As #smr_template.
 */
smr_status smr_alpha(const struct smr_tracker *tracker, uint16_t *alpha);

/**
 * The early template of the robust tracker, by which the track is verified.
 *
 * @param tracker  Made by #smr_init, locked by #smr_lock.
 * @param pixels   Memory for its pixels, outside of the tracker's own: they are copied there, row by row, without gaps.
 * @param size     Bytes at `pixels`; #SMR_ROBUST_PIXELS are always enough.
 * @param image    Is set to the pixels and their shape. After an error it is left alone, and so are the pixels.
 * @return         As #smr_template, or #SMR_ERROR_BUFFER_TOO_SMALL.
 */
smr_status smr_early_template(const struct smr_tracker *tracker,
                              uint8_t *pixels,
                              size_t size,
                              struct smr_image *image);

/**
 * The version of the library that is linked, as "major.minor.patch".
 *
 * @return  A string that is always there, never NULL.
 */
const char *smr_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SMR_H */
