/*
 * Follows one target through 8-bit gray frames: smr.h as a C++ class, for Arduino and any other C++11 compiler.
 *
 *     smr::Robust tracker;                                   // all memory is inside the object: make it global or static
 *     tracker.lock(pixels, 160, 120, smr::box(72, 52, 16, 16));
 *     smr::Answer answer = tracker.update(pixels);           // for each later frame
 *     if (answer.visible()) aim(answer.centerX(), answer.centerY());
 *
 * Every call gives an smr_status (smr_status_name() gives its name). Nothing is allocated, nothing is thrown. What the class does not
 * have, smr.h has: pass tracker.handle() to it.
 */
#ifndef SMR_TRACKER_H
#define SMR_TRACKER_H

#include "smr.h"

#ifdef __XTENSA__
#if !__has_include("esp32/libsmr.a") && !__has_include("esp32s2/libsmr.a") && !__has_include("esp32s3/libsmr.a")
#error "SMRTracker has no libsmr.a for Xtensa (ESP32, S2, S3): its README.md says how to build one"
#endif
#endif

namespace smr {

typedef smr_rect Box;

/** A box by its left and top edge, width and height, in pixels. */
inline Box box(int32_t x, int32_t y, uint16_t width, uint16_t height)
{
    Box made = {x, y, width, height};
    return made;
}

/** The name of a state, to print it. */
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

/** What update() answers: all of smr_answer, and how the call ended. */
struct Answer : smr_answer {
    /** SMR_OK, or why there is no answer. */
    smr_status status;

    /** Whether there is an answer and the target is not lost. */
    bool visible() const { return status == SMR_OK && state != SMR_LOST; }
    /** The middle of the box, in pixels. */
    int32_t centerX() const { return bbox.x + bbox.width / 2; }
    int32_t centerY() const { return bbox.y + bbox.height / 2; }
};

/** One target, its memory and its configuration. Use Paper, Robust or Refined. */
template <typename Target, typename Workspace, smr_status (*preset)(smr_config *)>
class Tracker {
public:
    /** The preset's numbers. Change them before the first lock. */
    smr_config config;

    Tracker() : tracker_(nullptr), width_(0), height_(0) { preset(&config); }
    // The library knows a tracker by its address.
    Tracker(const Tracker &) = delete;
    Tracker &operator=(const Tracker &) = delete;

    /** Learns the target in `box`. `pixels` are width * height bytes, row by row. */
    smr_status lock(const uint8_t *pixels, uint16_t width, uint16_t height, const Box &box)
    {
        const smr_frame frame = whole(pixels, width, height);
        return lock(frame, box);
    }

    /** The same for a frame of which only parts are in memory: see smr_lock_window(). */
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

    /** Finds the target in the next frame, which has the size of the one at the lock. */
    Answer update(const uint8_t *pixels) { return update(whole(pixels, width_, height_)); }

    /** The same for a frame of which only parts are in memory: see smr_windows(). */
    Answer update(const smr_frame &frame)
    {
        Answer answer = Answer();
        answer.state = SMR_LOST;
        answer.status = tracker_ == nullptr ? SMR_ERROR_NOT_LOCKED : smr_update(tracker_, &frame, &answer);
        return answer;
    }

    /** Initialises the tracker; lock() does so too. Call it first if you need handle() before the first lock. */
    smr_status begin()
    {
        return tracker_ != nullptr ? SMR_OK
                                   : smr_init(&target_, sizeof target_, &workspace_, sizeof workspace_, &config, &tracker_);
    }

    /** For the calls of smr.h; NULL before begin() or lock(). */
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

/** The paper's tracker with the preset for cameras: 13 KB of RAM. */
typedef Tracker<smr_paper_target, smr_paper_workspace, smr_config_camera> Paper;
/** The robust tracker: 53 KB of RAM. It follows changes of light, size and view, and searches for a lost target. */
typedef Tracker<smr_robust_target, smr_robust_workspace, smr_config_robust> Robust;
/** The robust tracker with the refiner, which keeps the box to the target. */
typedef Tracker<smr_robust_target, smr_robust_workspace, smr_config_refined> Refined;

} // namespace smr

#endif
