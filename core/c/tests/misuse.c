/*
 * Checks, with both trackers, that every wrong call that the library can detect returns its own status and changes nothing, also
 * between the steps of a lock or an update. The calls on a locked tracker are in wrong_calls.h.
 *
 * misuse [RUNS [SEED]]
 */

#include "between_steps.h"
#include "wrong_calls.h"

/* ---- calls without a tracker ---- */

static void names(void)
{
    HOLD(strcmp(smr_status_name(SMR_OK), "SMR_OK") == 0);
    HOLD(strcmp(smr_status_name(SMR_ERROR_WINDOW_NOT_IN_MEMORY), "SMR_ERROR_WINDOW_NOT_IN_MEMORY") == 0);
    HOLD(strcmp(smr_status_name(-1), "SMR_ERROR_UNKNOWN") == 0);
    HOLD(strcmp(smr_status_name(SMR_ERROR_UNCERTAIN_BELOW_LOST + 1), "SMR_ERROR_UNKNOWN") == 0);
}

static void version(void)
{
    char stated[32];
    sprintf(stated, "%d.%d.%d", SMR_VERSION_MAJOR, SMR_VERSION_MINOR, SMR_VERSION_PATCH);
    HOLD(strcmp(stated, smr_version()) == 0);
}

static void fillings(void)
{
    static smr_config several[2];
    EXPECT(smr_config_camera(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_paper(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_robust(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_refined(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_small(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_small_refined(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_camera((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_config_paper((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_config_robust((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_config_refined((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_config_small((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_config_small_refined((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    HOLD(smr_target_size(several) == 0 && smr_workspace_size(several) == 0); /* not filled */
    HOLD(smr_target_size(NULL) == 0 && smr_workspace_size(NULL) == 0);
}

/* ---- calls on each tracker ---- */

static void sizes(void)
{
    smr_config config = good_config();
    smr_tracker *tracker = good_tracker();
    size_t saved[2] = {0, 0};
    HOLD(smr_target_size(&config) == target_size());
    HOLD(smr_workspace_size(&config) == workspace_size());
    EXPECT(smr_saved_size(tracker, saved), SMR_OK);
    HOLD(saved[0] == (robust ? SMR_ROBUST_SAVED_SIZE : SMR_PAPER_SAVED_SIZE) && saved[1] == 0);
    EXPECT(smr_saved_size(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_saved_size(tracker, (size_t *)askew(saved)), SMR_ERROR_MISALIGNED);
}

static void configurations(void)
{
    smr_config config;
    smr_tracker *tracker = NULL;
#define REFUSED(change, wanted) \
    config = good_config(); \
    change; \
    tracker = (smr_tracker *)(void *)&storage; \
    EXPECT(smr_init(&storage, sizeof storage, &scratch, sizeof scratch, &config, &tracker), wanted); \
    HOLD(tracker == NULL)
    REFUSED(config.method = NULL, SMR_ERROR_NOT_INITIALISED);
    REFUSED(memset(&config, 0, sizeof config), SMR_ERROR_NOT_INITIALISED);
    if (robust) {
        HOLD(good_config().robust.size == 1 && good_config().robust.sweep == 4);
        REFUSED(config.robust.reach = 3, SMR_ERROR_CONFIG_OUT_OF_RANGE);
        REFUSED(config.robust.reach = 9, SMR_ERROR_CONFIG_OUT_OF_RANGE);
        REFUSED(config.robust.lost_below = 65535, SMR_ERROR_UNCERTAIN_BELOW_LOST);
        REFUSED(config.robust.learning_rate = 257, SMR_ERROR_CONFIG_OUT_OF_RANGE);
        REFUSED(config.robust.early_rate = 1025, SMR_ERROR_CONFIG_OUT_OF_RANGE);
        return;
    }
    REFUSED(config.paper.k.denominator = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.gate_tracking.denominator = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.gate_leaving.denominator = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.gate_returning.denominator = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.gate_lost.denominator = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.k.numerator = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.first_threshold = 0, SMR_ERROR_CONFIG_OUT_OF_RANGE);
    REFUSED(config.paper.window_limit.x = 4, SMR_ERROR_LIMIT_BELOW_WINDOW);
    REFUSED(config.paper.window_limit.y = 4, SMR_ERROR_LIMIT_BELOW_WINDOW);
}

/* Sets every setting by its name: values in its range are accepted, others are refused. */
static void settings(void)
{
    static smr_config several[2];
    static smr_setting room[2];
    smr_config config = good_config(), before = config;
    smr_setting setting;
    uint16_t few[5] = {1, 1, 1, 1, 1};
    size_t count;
    for (count = 0; smr_setting_at(&config, count, &setting) == SMR_OK; count++) {
        EXPECT(smr_set(&config, setting.name, setting.values, setting.count), SMR_OK);
        EXPECT(smr_set(&config, setting.name, setting.values, 5), SMR_ERROR_SETTING_COUNT);
        EXPECT(smr_set(&config, setting.name, few, setting.count % 2 + 1 + (setting.count == 4)), SMR_ERROR_SETTING_COUNT);
        if (setting.highest < 65535) {
            few[0] = (uint16_t)(setting.highest + 1);
            EXPECT(smr_set(&config, setting.name, few, setting.count), SMR_ERROR_CONFIG_OUT_OF_RANGE);
        }
        few[0] = 1;
    }
    HOLD(count == (robust ? 9 : 16));
    while (count-- > 0) {
        smr_setting old;
        EXPECT(smr_setting_at(&config, count, &setting), SMR_OK);
        EXPECT(smr_setting_at(&before, count, &old), SMR_OK);
        HOLD(memcmp(setting.values, old.values, sizeof old.values) == 0);
    }
    EXPECT(smr_set(&config, robust ? "patience" : "growth", few, 1), SMR_OK);
    HOLD(robust ? config.robust.patience == 1 : config.paper.growth == 1);
    EXPECT(smr_set(&config, robust ? "window" : "reach", few, 1), SMR_ERROR_SETTING_UNKNOWN);
    EXPECT(smr_set(&config, "", few, 1), SMR_ERROR_SETTING_UNKNOWN);
    EXPECT(smr_set(NULL, "padding", few, 1), SMR_ERROR_NULL);
    EXPECT(smr_set(&config, NULL, few, 1), SMR_ERROR_NULL);
    EXPECT(smr_set(&config, "padding", NULL, 1), SMR_ERROR_NULL);
    EXPECT(smr_set(&config, "padding", (uint16_t *)askew(few), 1), SMR_ERROR_MISALIGNED);
    EXPECT(smr_set(several, "padding", few, 1), SMR_ERROR_NOT_INITIALISED);
    EXPECT(smr_setting_at(several, 0, &setting), SMR_ERROR_NOT_INITIALISED);
    EXPECT(smr_setting_at((smr_config *)askew(several), 0, &setting), SMR_ERROR_MISALIGNED);
    EXPECT(smr_setting_at(&config, count, &setting), SMR_ERROR_SETTING_UNKNOWN);
    EXPECT(smr_setting_at(&config, 0, NULL), SMR_ERROR_NULL);
    EXPECT(smr_setting_at(&config, 0, (smr_setting *)askew(room)), SMR_ERROR_MISALIGNED);
}

static int is_zero(const void *memory, size_t size)
{
    const unsigned char *byte = (const unsigned char *)memory;
    while (size > 0 && byte[size - 1] == 0) {
        size--;
    }
    return size == 0;
}

static void storages(void)
{
    static target targets[2];
    static workspace workspaces[2];
    smr_config several[2];
    smr_tracker *trackers[2] = {NULL, NULL}, **tracker = trackers;
    size_t size = target_size(), work = workspace_size();
    memset(targets, 0, sizeof targets);
    memset(workspaces, 0, sizeof workspaces);
    several[0] = good_config();
    EXPECT(smr_init(NULL, size, workspaces, work, several, tracker), SMR_ERROR_NULL);
    EXPECT(smr_init(targets, size, NULL, work, several, tracker), SMR_ERROR_NULL);
    EXPECT(smr_init(targets, size, workspaces, work, NULL, tracker), SMR_ERROR_NULL);
    EXPECT(smr_init(targets, size, workspaces, work, several, NULL), SMR_ERROR_NULL);
    EXPECT(smr_init(askew(targets), size, workspaces, work, several, tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(targets, size, askew(workspaces), work, several, tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(targets[0].bytes + SMR_ALIGNMENT / 2, size, workspaces, work, several, tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(targets, size, workspaces[0].bytes + SMR_ALIGNMENT / 2, work, several, tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(targets, size, workspaces, work, (smr_config *)askew(several), tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(targets, size, workspaces, work, several, (smr_tracker **)askew(trackers)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(targets, 0, workspaces, work, several, tracker), SMR_ERROR_STORAGE_TOO_SMALL);
    EXPECT(smr_init(targets, size - 1, workspaces, work, several, tracker), SMR_ERROR_STORAGE_TOO_SMALL);
    EXPECT(smr_init(targets, size, workspaces, 0, several, tracker), SMR_ERROR_WORKSPACE_TOO_SMALL);
    EXPECT(smr_init(targets, size, workspaces, work - 1, several, tracker), SMR_ERROR_WORKSPACE_TOO_SMALL);
    EXPECT(smr_init(workspaces, size, workspaces, work, several, tracker), SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE);
    EXPECT(smr_init(workspaces[0].bytes + work - 8, size, workspaces, work, several, tracker),
           SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE);
    HOLD(is_zero(targets, sizeof targets) && is_zero(workspaces, sizeof workspaces));
    HOLD(trackers[0] == NULL);

    /* smr_init writes nothing after the stated end of the memory. */
    EXPECT(smr_init(targets, size, workspaces, work, several, tracker), SMR_OK);
    HOLD(trackers[0] != NULL && trackers[1] == NULL);
    HOLD(is_zero(targets[0].bytes + size, sizeof targets - size));
    HOLD(is_zero(workspaces[0].bytes + work, sizeof workspaces - work));
}

/* Locks and updates fail on memory without a tracker, and on a tracker whose workspace was overwritten. */
static void no_updates(smr_tracker *tracker, smr_status wanted)
{
    smr_frame frame = good_frame();
    smr_rect box = rect(10, 10, 12, 12);
    smr_answer answer;
    EXPECT(smr_lock(tracker, &frame, &box), wanted);
    EXPECT(smr_lock_step(tracker, &frame, &box, 1), wanted);
    EXPECT(smr_update(tracker, &frame, &answer), wanted);
    EXPECT(smr_update_step(tracker, &frame, 1, &answer), wanted);
}

static void no_tracker(smr_tracker *tracker, smr_status wanted)
{
    smr_rect box = rect(10, 10, 12, 12), windows[2];
    smr_fine_rect fine;
    smr_state state;
    smr_image image;
    size_t size;
    no_updates(tracker, wanted);
    EXPECT(smr_lock_window(tracker, WIDTH, HEIGHT, &box, windows), wanted);
    EXPECT(smr_windows(tracker, windows), wanted);
    EXPECT(smr_last(tracker, &fine, &state), wanted);
    EXPECT(smr_moved(tracker, 256, 256), wanted);
    EXPECT(smr_saved_size(tracker, &size), wanted);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &size), wanted);
    EXPECT(smr_restore(tracker, bytes, sizeof bytes), wanted);
    EXPECT(smr_template(tracker, bytes, sizeof bytes, &image), wanted);
}

static void no_trackers(void)
{
    static target zeroes, moved;
    smr_tracker *tracker = good_tracker();
    no_tracker(NULL, SMR_ERROR_NULL);
    no_tracker((smr_tracker *)askew(tracker), SMR_ERROR_MISALIGNED);
    no_tracker((smr_tracker *)(void *)&zeroes, SMR_ERROR_NOT_INITIALISED);
    memcpy(&moved, &storage, sizeof storage);
    no_tracker((smr_tracker *)(void *)&moved, SMR_ERROR_NOT_INITIALISED);
    memset(&storage, 0xFF, sizeof storage);
    no_tracker(tracker, SMR_ERROR_NOT_INITIALISED);
    tracker = locked_tracker();
    memset(&scratch, 0xFF, sizeof scratch);
    no_updates(tracker, SMR_ERROR_NOT_INITIALISED);
}

/* Trackers of the same kind can share a workspace, one update at a time. A tracker of the other kind overwrites it. */
static void shared_workspaces(void)
{
    static target second, other;
    smr_config config = good_config();
    smr_tracker *one = locked_tracker(), *two = tracker_in(&second, &config);
    smr_frame frame = good_frame();
    smr_rect elsewhere = rect(12, 10, 8, 8);
    smr_answer answer;
    /* Steps of the two trackers do not mix: each tracker follows its own box. */
    EXPECT(smr_lock(two, &frame, &elsewhere), SMR_OK);
    EXPECT(smr_update_step(one, &frame, 50, &answer), SMR_UNDER_WAY);
    EXPECT(smr_update_step(two, &frame, 50, &answer), SMR_UNDER_WAY);
    EXPECT(smr_update_step(one, &frame, UINT32_MAX, &answer), SMR_OK);
    HOLD(answer.bbox.x == 26 && answer.bbox.y == 22);
    EXPECT(smr_update_step(one, &frame, 50, &answer), SMR_UNDER_WAY);
    EXPECT(smr_update_step(two, &frame, UINT32_MAX, &answer), SMR_OK);
    HOLD(answer.bbox.x == 12 && answer.bbox.y == 10);
    robust = !robust;
    config = good_config();
    tracker_in(&other, &config);
    robust = !robust;
    no_updates(one, SMR_ERROR_NOT_INITIALISED);
}

/* A tracker refuses a target that the other kind of tracker has saved. */
static void other_methods(void)
{
    static target other;
    smr_tracker *tracker = locked_tracker();
    smr_config config;
    size_t written;
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &written), SMR_OK);
    robust = !robust;
    config = good_config();
    EXPECT(smr_restore(tracker_in(&other, &config), bytes, written), SMR_ERROR_OTHER_METHOD);
    robust = !robust;
}

/* A second part whose `pixels` are NULL is ignored, whatever its other fields. The window may lie in either part. */
static void parts(void)
{
    smr_tracker *tracker = locked_tracker();
    smr_frame frame = good_frame();
    smr_answer answer;
    frame.parts[1].x = UINT16_MAX;
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
    frame.parts[1] = frame.parts[0];
    frame.parts[0].width = frame.parts[0].height = 1;
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
}

static void boxes(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect box, window;
#define REFUSED_BOX(left, top, across, down, wanted) \
    box = rect(left, top, across, down); \
    window = rect(-7, -7, 7, 7); \
    EXPECT(smr_lock_window(tracker, WIDTH, HEIGHT, &box, &window), wanted); \
    HOLD((window.x == -7) == ((wanted) != SMR_OK)); \
    EXPECT(smr_lock(tracker, &frame, &box), wanted)
    REFUSED_BOX(5, 5, 0, 6, SMR_ERROR_BOX_EMPTY);
    REFUSED_BOX(5, 5, 6, 0, SMR_ERROR_BOX_EMPTY);
    REFUSED_BOX(-1, 5, 6, 6, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(WIDTH - 5, 5, 6, 6, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(INT32_MAX, INT32_MIN, UINT16_MAX, UINT16_MAX, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(0, 0, 1, 1, SMR_OK);
}

/* Only the paper tracker refuses a box or window as too large. */
static void capacities(void)
{
    static uint8_t wide[SMR_PIXELS + 1 > 2 * SMR_SPAN + 4 ? SMR_PIXELS + 1 : 2 * SMR_SPAN + 4];
    smr_config config = good_config();
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect box = rect(0, 0, SMR_PIXELS + 1, 1);
    frame.parts[0].pixels = wide;
    frame.parts[0].size = frame.parts[0].stride = sizeof wide;
    frame.width = frame.parts[0].width = sizeof wide;
    frame.height = frame.parts[0].height = 1;
    EXPECT(smr_lock(tracker, &frame, &box), SMR_ERROR_BOX_TOO_LARGE);
    box.width = SMR_PIXELS;
    EXPECT(smr_lock(tracker, &frame, &box), SMR_OK);
    box.width = 1;
    config.paper.window_limit.x = SMR_SPAN / 2 + 1;
    EXPECT(smr_lock(tracker_in(&storage, &config), &frame, &box), SMR_ERROR_WINDOW_TOO_LARGE);
    config.paper.window_limit.x = (SMR_SPAN - 1) / 2;
    EXPECT(smr_lock(tracker_in(&storage, &config), &frame, &box), SMR_OK);
}

/* A lock and an update refuse a frame if one column or row of the window that they read is not in memory. */
static void windows(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frame;
    smr_rect box = rect(26, 22, 8, 8), window, less, both[2];
    smr_answer answer;
    EXPECT(smr_lock_window(tracker, WIDTH, HEIGHT, &box, &window), SMR_OK);
    HOLD(window.x > 0 && window.y > 0 && window.x + window.width < WIDTH && window.y + window.height < HEIGHT);
    less = window;
    less.width--;
    frame = part_of_frame(&less);
    EXPECT(smr_lock(tracker, &frame, &box), SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY);
    less = window;
    less.y++;
    less.height--;
    frame = part_of_frame(&less);
    EXPECT(smr_lock(tracker, &frame, &box), SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY);
    frame = part_of_frame(&window);
    EXPECT(smr_lock(tracker, &frame, &box), SMR_OK);

    memset(both, 0x5A, sizeof both);
    EXPECT(smr_windows(tracker, both), SMR_OK);
    window = both[0];
    HOLD(robust || (window.x == 21 && window.y == 17 && window.width == 18 && window.height == 18));
    HOLD(both[1].x == 0 && both[1].y == 0 && both[1].width == 0 && both[1].height == 0);
    memset(&answer, 0x5A, sizeof answer);
    less = window;
    less.width--;
    frame = part_of_frame(&less);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_ERROR_WINDOW_NOT_IN_MEMORY);
    less = window;
    less.y++;
    less.height--;
    frame = part_of_frame(&less);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_ERROR_WINDOW_NOT_IN_MEMORY);
    HOLD(answer.bbox.x == 0x5A5A5A5A);
    frame = part_of_frame(&window);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
    HOLD(answer.bbox.x == 26 && answer.bbox.y == 22 && answer.bbox.width == 8 && answer.bbox.height == 8);
    HOLD(answer.fine.x == 26 * 256 || robust);
    HOLD(answer.state == SMR_TRACKING && answer.ratio > 65000 && answer.found_again == 0);
}

static void order(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame(), other = good_frame();
    smr_rect box = rect(26, 22, 8, 8), windows[2];
    smr_fine_rect fine = {-7, -7, 7, 7};
    smr_state state = SMR_LOST;
    smr_answer answer;
    size_t written = 777;
    memset(&answer, 0x5A, sizeof answer);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_update_step(tracker, &frame, 1, &answer), SMR_ERROR_NOT_LOCKED);
    memset(windows, 0x5A, sizeof windows);
    EXPECT(smr_windows(tracker, windows), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_last(tracker, &fine, &state), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &written), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_moved(tracker, 1, 1), SMR_OK);
    HOLD(answer.bbox.x == 0x5A5A5A5A && windows[0].x == 0x5A5A5A5A && windows[1].x == 0x5A5A5A5A && fine.x == -7 && state == SMR_LOST && written == 777);

    EXPECT(smr_lock(tracker, &frame, &box), SMR_OK);
    EXPECT(smr_last(tracker, &fine, &state), SMR_OK);
    HOLD(fine.x == 26 * 256 && fine.y == 22 * 256 && fine.width == 8 * 256 && state == SMR_TRACKING);
    other.height = other.parts[0].height = HEIGHT - 1;
    EXPECT(smr_update(tracker, &other, &answer), SMR_ERROR_FRAME_SIZE_CHANGED);

    EXPECT(smr_update_step(tracker, &frame, 1, &answer), SMR_UNDER_WAY);
    EXPECT(smr_update_step(tracker, &other, 1, &answer), SMR_ERROR_FRAME_SIZE_CHANGED);
    EXPECT(smr_update_step(tracker, &frame, UINT32_MAX, &answer), SMR_OK);
    EXPECT(smr_update_step(tracker, &frame, 1, &answer), SMR_UNDER_WAY);
    EXPECT(smr_moved(tracker, 2 * 256, -3 * 256), SMR_OK);
    EXPECT(smr_last(tracker, &fine, &state), SMR_OK);
    HOLD(fine.x == 28 * 256 && fine.y == 19 * 256);
    EXPECT(smr_moved(tracker, INT32_MAX, INT32_MIN), SMR_OK);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
}

/* A call that fails does not change the caller's memory. */
static void failures(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect none = rect(26, 22, 0, 8), outside = rect(-1, 22, 8, 8), box = rect(26, 22, 8, 8);
    smr_answer answer;
    uint16_t quality = 777;
    size_t written = 777, at;
    memset(bytes, 0xA5, sizeof bytes);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &written), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_quality(tracker, &quality), SMR_ERROR_NOT_LOCKED);
    HOLD(quality == 777);
    EXPECT(smr_lock(tracker, &frame, &box), SMR_OK);
    EXPECT(smr_quality(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_save(tracker, bytes, 40, &written), SMR_ERROR_BUFFER_TOO_SMALL);
    for (at = 0; at < sizeof bytes; at++) {
        HOLD(bytes[at] == 0xA5);
    }
    HOLD(written == 777);

    EXPECT(smr_lock(tracker, &frame, &none), SMR_ERROR_BOX_EMPTY);
    EXPECT(smr_lock(tracker, &frame, &outside), SMR_ERROR_BOX_OUTSIDE_FRAME);
    EXPECT(smr_lock_step(tracker, &frame, &none, 1), SMR_ERROR_BOX_EMPTY);
    EXPECT(smr_restore(tracker, bytes, sizeof bytes), SMR_ERROR_NOT_SAVED);
    EXPECT(smr_update_step(tracker, &frame, 1, &answer), SMR_UNDER_WAY);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &written), SMR_OK);
    EXPECT(smr_update_step(tracker, &frame, UINT32_MAX, &answer), SMR_OK);
    EXPECT(smr_restore(tracker, bytes, written), SMR_OK);
}

/* A lock in steps gives the same result as a lock at once. */
static void locks_in_steps(void)
{
    static uint8_t at_once[sizeof bytes], flat[sizeof pixels];
    smr_tracker *tracker = locked_tracker();
    smr_frame frame = good_frame();
    smr_rect box = rect(26, 22, 8, 8), windows[2];
    smr_fine_rect fine;
    smr_state state;
    smr_answer answer;
    uint16_t first = 777, quality = 777;
    size_t size, written;
    smr_status status;
    unsigned steps = 1;
    EXPECT(smr_quality(tracker, &first), SMR_OK);
    HOLD(first >= SMR_POOR_QUALITY);
    EXPECT(smr_save(tracker, at_once, sizeof at_once, &size), SMR_OK);

    while ((status = smr_lock_step(tracker, &frame, &box, 100000)) == SMR_UNDER_WAY) {
        steps++;
        EXPECT(smr_last(tracker, &fine, &state), SMR_ERROR_NOT_LOCKED);
        EXPECT(smr_windows(tracker, windows), SMR_ERROR_NOT_LOCKED);
        EXPECT(smr_quality(tracker, &quality), SMR_ERROR_NOT_LOCKED);
        EXPECT(smr_update_step(tracker, &frame, 1, &answer), SMR_ERROR_NOT_LOCKED);
    }
    EXPECT(status, SMR_OK);
    HOLD(robust ? steps > 20 : steps == 1);
    EXPECT(smr_quality(tracker, &quality), SMR_OK);
    HOLD(quality == first);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &written), SMR_OK);
    HOLD(written == size && memcmp(bytes, at_once, size) == 0);

    /* A frame without texture: the lock succeeds, but the quality is poor. */
    memset(flat, 90, sizeof flat);
    frame.parts[0].pixels = flat;
    EXPECT(smr_lock(tracker, &frame, &box), SMR_OK);
    EXPECT(smr_quality(tracker, &quality), SMR_OK);
    HOLD(quality == 0);
}

static void saved(void)
{
    static uint8_t again[sizeof bytes];
    smr_tracker *tracker = locked_tracker();
    smr_config config = good_config();
    size_t written = 777, second;
    memset(bytes, 0xA5, sizeof bytes);
    EXPECT(smr_save(tracker, NULL, sizeof bytes, &written), SMR_ERROR_NULL);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, NULL), SMR_ERROR_NULL);
    EXPECT(smr_save(tracker, bytes, SIZE_MAX, &written), SMR_ERROR_MEMORY_TOO_LARGE);
    EXPECT(smr_save(tracker, storage.bytes + target_size() - 1, 1, &written), SMR_ERROR_OVERLAPS_TRACKER);
    EXPECT(smr_save(tracker, scratch.bytes, 1, &written), SMR_ERROR_OVERLAPS_TRACKER);
    HOLD(written == 777 && bytes[0] == 0xA5);
    EXPECT(smr_save(tracker, bytes, 0, &written), SMR_ERROR_BUFFER_TOO_SMALL);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &written), SMR_OK);
    HOLD(written <= (robust ? SMR_ROBUST_SAVED_SIZE : SMR_PAPER_SAVED_SIZE));
    EXPECT(smr_save(tracker, again, written - 1, &second), SMR_ERROR_BUFFER_TOO_SMALL);
    EXPECT(smr_save(tracker, again, written, &second), SMR_OK);
    HOLD(second == written && memcmp(bytes, again, written) == 0);

    EXPECT(smr_restore(tracker, NULL, written), SMR_ERROR_NULL);
    EXPECT(smr_restore(tracker, bytes, SIZE_MAX), SMR_ERROR_MEMORY_TOO_LARGE);
    EXPECT(smr_restore(tracker, storage.bytes, 1), SMR_ERROR_OVERLAPS_TRACKER);
    EXPECT(smr_restore(tracker, pixels, sizeof pixels), SMR_ERROR_NOT_SAVED);
    EXPECT(smr_restore(tracker, bytes, 0), SMR_ERROR_NOT_SAVED);
    EXPECT(smr_restore(tracker, bytes, written - 1), SMR_ERROR_TRUNCATED);
    bytes[written - 5] ^= 1;
    EXPECT(smr_restore(tracker, bytes, written), SMR_ERROR_DAMAGED);
    bytes[4] ^= 0x55;
    EXPECT(smr_restore(tracker, bytes, written), SMR_ERROR_OTHER_VERSION);
    if (robust) {
        config.robust.patience++;
    } else {
        config.paper.padding++;
    }
    smr_tracker *other = tracker_in(&storage, &config);
    EXPECT(smr_restore(other, again, written), SMR_ERROR_OTHER_CONFIG);
    const char *name = "unchanged";
    EXPECT(smr_other_setting(other, again, written - 1, &name), SMR_ERROR_TRUNCATED);
    EXPECT(smr_other_setting(other, again, written, NULL), SMR_ERROR_NULL);
    EXPECT(smr_other_setting(other, NULL, written, &name), SMR_ERROR_NULL);
    HOLD(strcmp(name, "unchanged") == 0);
    EXPECT(smr_other_setting(other, again, written, &name), SMR_OK);
    HOLD(strcmp(name, robust ? "patience" : "padding") == 0);
    EXPECT(smr_other_setting(good_tracker(), again, written, &name), SMR_OK);
    HOLD(name == NULL);
    EXPECT(smr_restore(good_tracker(), again, written), SMR_OK);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &second), SMR_OK);
    HOLD(second == written && memcmp(bytes, again, written) == 0);
}

/* A power failure while a newer saved target overwrites an older one: a mixture of their bytes is refused. */
static void power(void)
{
    static uint8_t older[sizeof bytes], newer[sizeof bytes];
    smr_tracker *tracker = locked_tracker();
    smr_frame frame = good_frame();
    smr_answer answer;
    size_t size, second, cut;
    EXPECT(smr_save(tracker, older, sizeof older, &size), SMR_OK);
    EXPECT(smr_update_step(tracker, &frame, 1, &answer), SMR_UNDER_WAY);
    EXPECT(smr_save(tracker, newer, sizeof newer, &second), SMR_OK);
    HOLD(second == size && memcmp(older, newer, size) == 0); /* the update under way has changed nothing */
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
    EXPECT(smr_moved(tracker, 512, 256), SMR_OK);
    EXPECT(smr_save(tracker, newer, sizeof newer, &second), SMR_OK);
    HOLD(second == size && memcmp(older, newer, size) != 0);
    for (cut = 0; cut <= size; cut += cut < 40 || cut + 40 > size ? 1 : 13) {
        memcpy(bytes, newer, cut);
        memcpy(bytes + cut, older + cut, size - cut);
        if (memcmp(bytes, older, size) != 0 && memcmp(bytes, newer, size) != 0) {
            HOLD(smr_restore(tracker, bytes, size) == SMR_ERROR_DAMAGED);
        }
    }
    EXPECT(smr_restore(tracker, older, size), SMR_OK);
    EXPECT(smr_restore(tracker, newer, size), SMR_OK);
}

/* smr_template copies the template into a buffer that is large enough, and writes nothing beyond the template. */
static void templates(void)
{
    const uint16_t side = robust ? 16 : 8; /* robust: a grid of half the target's width and height */
    const size_t area = (size_t)side * side;
    smr_tracker *tracker = good_tracker();
    smr_image image;
    memset(bytes, 0x5A, sizeof bytes);
    memset(&image, 0x5A, sizeof image);
    EXPECT(smr_template(tracker, bytes, sizeof bytes, &image), SMR_ERROR_NOT_LOCKED);
    tracker = locked_tracker();
    EXPECT(smr_template(tracker, bytes, area - 1, &image), SMR_ERROR_BUFFER_TOO_SMALL);
    HOLD(bytes[0] == 0x5A && image.width == 0x5A5A);
    EXPECT(smr_template(tracker, bytes, area, &image), SMR_OK);
    HOLD(image.pixels == bytes && image.width == side && image.height == side);
    HOLD(bytes[area] == 0x5A && memchr(bytes, 0x5A, area) != bytes);
    HOLD(robust || bytes[8] == pixels[23 * WIDTH + 26]);
}

/* Wrong calls of the read-out, which begin with one on no memory and end with an unfinished frame. */
static void readouts(void)
{
    enum { ACROSS = 96, DOWN = 72 };
    static uint8_t line[ACROSS], first[32 + 6];
    const smr_rect windows[2] = {{4, 2, 8, 4}, {1, 1, 3, 2}}, one[2] = {{4, 2, 8, 4}, {0, 0, 0, 0}};
    const smr_rect outside[2] = {{90, 2, 8, 4}, {0, 0, 0, 0}}, second_outside[2] = {{4, 2, 8, 4}, {90, 2, 8, 4}};
    const smr_rect none[2] = {{0, 0, 0, 0}, {4, 2, 8, 4}};
    smr_readout readout, kept;
    smr_frame frame;
    EXPECT(smr_readout_begin(NULL, &SMR_GRAY8, ACROSS, DOWN, one, first, sizeof first), SMR_ERROR_NULL);
    EXPECT(smr_readout_begin(&readout, NULL, ACROSS, DOWN, one, first, sizeof first), SMR_ERROR_FORMAT_UNKNOWN);
    EXPECT(smr_readout_begin_shrunk(&readout, &SMR_GRAY8, ACROSS, DOWN, 0, one, first, sizeof first), SMR_ERROR_FORMAT_UNKNOWN);
    EXPECT(smr_readout_begin_shrunk(&readout, &SMR_GRAY8, ACROSS, DOWN, 5, one, first, sizeof first), SMR_ERROR_FORMAT_UNKNOWN);
    EXPECT(smr_readout_begin_shrunk(&readout, &SMR_GRAY8, ACROSS, DOWN, 4, outside, first, sizeof first), SMR_ERROR_OUTSIDE_FRAME);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, NULL, first, sizeof first), SMR_ERROR_NULL);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, one, NULL, 99), SMR_ERROR_NULL);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, one, first, 31), SMR_ERROR_BUFFER_TOO_SMALL);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, windows, first, 37), SMR_ERROR_BUFFER_TOO_SMALL);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, windows, first, 38), SMR_OK);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, outside, first, sizeof first), SMR_ERROR_OUTSIDE_FRAME);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, second_outside, first, sizeof first), SMR_ERROR_OUTSIDE_FRAME);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, none, first, sizeof first), SMR_ERROR_OUTSIDE_FRAME);
    EXPECT(smr_readout_begin(&readout, &SMR_BAYER8, ACROSS, DOWN, outside, first, sizeof first), SMR_ERROR_OUTSIDE_FRAME);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, one, first, (size_t)-1), SMR_ERROR_MEMORY_TOO_LARGE);
    EXPECT(smr_readout_begin(&readout, &SMR_GRAY8, ACROSS, DOWN, one, first, 32), SMR_OK);
    kept = readout;
    EXPECT(smr_readout_frame(&readout, &frame), SMR_ERROR_LINE_MISSING);
    HOLD(memcmp(&readout, &kept, sizeof kept) == 0);
    EXPECT(smr_readout_line(&readout, 3, line, sizeof line), SMR_ERROR_LINE_MISSING);
    HOLD(readout.line == 2);
    EXPECT(smr_readout_line(&readout, 2, line, sizeof line - 1), SMR_ERROR_LINE_TOO_SHORT);
    HOLD(readout.line == 2);
    EXPECT(smr_readout_line(&readout, 2, NULL, sizeof line), SMR_ERROR_NULL);
    EXPECT(smr_readout_line(&readout, 2, first + 1, sizeof line), SMR_ERROR_OVERLAPS_TRACKER);
    EXPECT(smr_readout_line(&readout, 2, line, sizeof line), SMR_OK);
    EXPECT(smr_readout_line(&readout, 2, line, sizeof line), SMR_ERROR_LINE_OUT_OF_ORDER);
    HOLD(readout.line == 2);
    EXPECT(smr_readout_line(&readout, DOWN, line, sizeof line), SMR_ERROR_LINE_OUTSIDE_FRAME);
    HOLD(readout.line == DOWN);
    EXPECT(smr_readout_lines(&readout, pixels, 5 * ACROSS, ACROSS), SMR_ERROR_LINE_TOO_SHORT);
    HOLD(readout.line == 5);
    EXPECT(smr_readout_frame(&readout, NULL), SMR_ERROR_NULL);
    kept = readout;
    kept.format = NULL;
    EXPECT(smr_readout_frame(&kept, &frame), SMR_ERROR_FORMAT_UNKNOWN);
    EXPECT(smr_readout_frame(&readout, &frame), SMR_ERROR_LINE_MISSING);
    HOLD(readout.line == 5);
}

/* The calls of the table on a locked tracker at rest. */
static void at_rest(void)
{
    smr_tracker *tracker = locked_tracker();
    smr_frame frame = good_frame();
    smr_answer answer;
    size_t size = 0;
    EXPECT(smr_save(tracker, former, sizeof former, &former_size), SMR_OK);
    wrong_calls(tracker, &frame, 1, ALL);
    EXPECT(smr_save(tracker, bytes, sizeof bytes, &size), SMR_OK);
    HOLD(size == former_size && memcmp(bytes, former, size) == 0);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
}

int main(int count, char **words)
{
    unsigned long runs = count > 1 ? strtoul(words[1], NULL, 10) : 8;
    unsigned i;
    seed = count > 2 ? (uint32_t)strtoul(words[2], NULL, 10) | 1 : 1;
    draw();
    for (i = 0; i < sizeof pixels; i++) {
        pixels[i] = (uint8_t)((i * i * 7919u) >> 5);
    }
    names();
    version();
    fillings();
    readouts();
    for (robust = 0; robust < 2; robust++) {
        sizes();
        configurations();
        settings();
        storages();
        no_trackers();
        shared_workspaces();
        other_methods();
        at_rest();
        parts();
        boxes();
        windows();
        order();
        failures();
        locks_in_steps();
        saved();
        power();
        templates();
        between_steps(runs);
    }
    robust = 0;
    capacities();
    printf("misuse: %u checks of both trackers, %u failed\n", tried, failed);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
