/*
 * Follows a target without a camera: scene.h draws a scene, the tracker follows the bright square in it, and the monitor shows its box.
 *
 * The program needs 20 KB of RAM. With a camera, replace `pixels` by its gray pixels (from color: smr_readout_begin), and use
 * smr_robust_target, smr_robust_workspace and smr_config_robust: 53 KB, and the tracker follows changes of light, size and view.
 */
#include <inttypes.h>
#include <stdio.h>

#include "freertos/FreeRTOS.h"
#include "freertos/task.h"
#include "scene.h"
#include "smr.h"

static smr_paper_target storage;
static smr_paper_workspace workspace;

static const char *name_of(smr_state state)
{
    static const char *const names[] = {"tracking", "leaving", "uncertain", "lost"};
    return names[state];
}

void app_main(void)
{
    const smr_frame picture = {WIDTH, HEIGHT, {{pixels, sizeof pixels, WIDTH, WIDTH, HEIGHT, 0, 0}}};
    const smr_rect target = {left(), top(), SIDE, SIDE};
    smr_config config;
    smr_tracker *tracker;
    smr_answer answer;
    smr_status status = smr_config_camera(&config);

    draw();
    if (status == SMR_OK) status = smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker);
    if (status == SMR_OK) status = smr_lock(tracker, &picture, &target);
    printf("lock: %s\n", smr_status_name(status));
    while (status == SMR_OK) {
        frame++;
        draw();
        status = smr_update(tracker, &picture, &answer);
        printf("%s box %" PRId32 " %" PRId32 " %s %d %d\n", status == SMR_OK ? name_of(answer.state) : smr_status_name(status),
               answer.bbox.x, answer.bbox.y, in_view() ? "square" : "hidden", left(), top());
        vTaskDelay(pdMS_TO_TICKS(50));
    }
}
