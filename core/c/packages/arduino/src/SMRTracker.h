/*
 * Follows one target through 8-bit gray frames: smr.h as a C++ class, for Arduino and any other C++11 compiler.
 *
 *     smr::Robust tracker;                                   // all memory is inside the object: make it global or static
 *     tracker.lock(pixels, 160, 120, smr::box(72, 52, 16, 16));
 *     smr::Answer answer = tracker.update(pixels);           // for each later frame
 *     if (answer.visible()) aim(answer.centerX(), answer.centerY());
 *
 * Every call returns an smr_status, and smr_status_name() its name. Nothing is allocated, nothing is thrown. For calls of smr.h that
 * the class lacks, pass tracker.handle().
 */
#ifndef SMR_TRACKER_H
#define SMR_TRACKER_H

#include "smr.h"

namespace smr {

typedef smr_rect Box;

/** Returns a box of the given left and top edge, width and height, in pixels. */
inline Box box(int32_t x, int32_t y, uint16_t width, uint16_t height)
{
    Box made = {x, y, width, height};
    return made;
}

/** The lower-case name of a state, to print it. */
inline const char *name(smr_state state)
{
    switch (state) {
    case SMR_TRACKING: return "tracking";
    case SMR_LEAVING: return "leaving";
    case SMR_UNCERTAIN: return "uncertain";
    case SMR_LOST: return "lost";
    }
    return "unknown";
}

/** The result of update(): the fields of smr_answer, and the status of the call. */
struct Answer : smr_answer {
    /** SMR_OK, or the reason why there is no answer. */
    smr_status status;

    /** True if there is an answer and the target is not lost. */
    bool visible() const { return status == SMR_OK && state != SMR_LOST; }
    /** The middle of the box, in pixels. */
    int32_t centerX() const { return bbox.x + bbox.width / 2; }
    int32_t centerY() const { return bbox.y + bbox.height / 2; }
};

/** A tracker of one target, with its memory and configuration. Use its types Paper, Robust, Refined, Small or SmallRefined. */
template <typename Target, typename Workspace, smr_status (*preset)(smr_config *)>
class Tracker {
public:
    /** The configuration, filled by the preset. Change it before the first lock. */
    smr_config config;

    Tracker() : tracker_(nullptr), width_(0), height_(0) { preset(&config); }
    // A tracker cannot be copied, because the library identifies it by its address.
    Tracker(const Tracker &) = delete;
    Tracker &operator=(const Tracker &) = delete;

    /** Learns the target in `box`. `pixels` are width * height bytes, row by row. */
    smr_status lock(const uint8_t *pixels, uint16_t width, uint16_t height, const Box &box)
    {
        const smr_frame frame = whole(pixels, width, height);
        return lock(frame, box);
    }

    /** Learns the target in `box` of a frame of which only parts are in memory: see smr_lock_window(). */
    smr_status lock(const smr_frame &frame, const Box &box)
    {
        smr_status status = begin();
        if (status == SMR_OK) status = smr_lock(tracker_, &frame, &box);
        if (status == SMR_OK) {
            width_ = frame.width;
            height_ = frame.height;
        }
        return status;
    }

    /** Finds the target in the next frame, which must have the size of the frame given to lock(). */
    Answer update(const uint8_t *pixels) { return update(whole(pixels, width_, height_)); }

    /** Finds the target in a frame of which only parts are in memory: see smr_windows(). */
    Answer update(const smr_frame &frame)
    {
        Answer answer = Answer();
        answer.state = SMR_LOST;
        answer.status = tracker_ == nullptr ? SMR_ERROR_NOT_LOCKED : smr_update(tracker_, &frame, &answer);
        return answer;
    }

    /** Initialises the tracker, as lock() also does. Call it only if you need handle() before the first lock. */
    smr_status begin()
    {
        return tracker_ != nullptr ? SMR_OK
                                   : smr_init(&target_, sizeof target_, &workspace_, sizeof workspace_, &config, &tracker_);
    }

    /** The tracker for calls of smr.h; NULL before begin() or lock(). */
    smr_tracker *handle() { return tracker_; }

private:
    static smr_frame whole(const uint8_t *pixels, uint16_t width, uint16_t height)
    {
        smr_frame frame = smr_frame();
        frame.width = width;
        frame.height = height;
        frame.parts[0].pixels = pixels;
        frame.parts[0].size = static_cast<size_t>(width) * height;
        frame.parts[0].stride = frame.parts[0].width = width;
        frame.parts[0].height = height;
        return frame;
    }

    Target target_;
    Workspace workspace_;
    smr_tracker *tracker_;
    uint16_t width_, height_;
};

/** The paper tracker with the camera preset: 13 KB of RAM. */
typedef Tracker<smr_paper_target, smr_paper_workspace, smr_config_camera> Paper;
/** The robust tracker: 52 KB of RAM. It follows changes of light, size and view, and searches for a lost target. */
typedef Tracker<smr_robust_target, smr_robust_workspace, smr_config_robust> Robust;
/** The robust tracker with the refiner, a small network that fits the box to the target. */
typedef Tracker<smr_robust_target, smr_robust_workspace, smr_config_refined> Refined;
/** The robust tracker of the small size: 45 KB of RAM and four fifths of the work. Its `reach` is at most 7. */
typedef Tracker<smr_robust_small_target, smr_robust_small_workspace, smr_config_small> Small;
/** The small tracker with the refiner. */
typedef Tracker<smr_robust_small_target, smr_robust_small_workspace, smr_config_small_refined> SmallRefined;

} // namespace smr

#endif
