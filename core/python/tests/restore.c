/* Restores, with the C library, a target that Python saved: restore FRAME SAVED NEW. Restores SAVED with the preset robust, and prints the names
 * of the resulting status and of the first setting that differs ("-" if none does). Then locks on a box in FRAME,
 * 160x120 gray pixels, and writes that target to NEW. */
#include <stdio.h>
#include "smr.h"

static smr_robust_target storage;
static smr_robust_workspace workspace;
static unsigned char pixels[160 * 120], bytes[SMR_ROBUST_SAVED_SIZE];

static size_t contents(const char *name, unsigned char *to, size_t room)
{
    FILE *file = fopen(name, "rb");
    return file == NULL ? 0 : fread(to, 1, room, file);
}

int main(int count, char **names)
{
    smr_config config;
    smr_tracker *tracker;
    smr_frame frame = {160, 120, {{pixels, sizeof pixels, 160, 160, 120, 0, 0}}};
    smr_rect box = {40, 30, 40, 40};
    const char *setting = NULL;
    size_t size;
    if (count != 4 || contents(names[1], pixels, sizeof pixels) != sizeof pixels) {
        return 2;
    }
    if (smr_config_robust(&config) != SMR_OK || smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker) != SMR_OK) {
        return 1;
    }
    size = contents(names[2], bytes, sizeof bytes);
    smr_status status = smr_restore(tracker, bytes, size);
    smr_other_setting(tracker, bytes, size, &setting);
    printf("%s %s\n", smr_status_name(status), setting == NULL ? "-" : setting);
    if (smr_lock(tracker, &frame, &box) != SMR_OK || smr_save(tracker, bytes, sizeof bytes, &size) != SMR_OK) {
        return 1;
    }
    FILE *file = fopen(names[3], "wb");
    return file == NULL || fwrite(bytes, 1, size, file) != size || fclose(file) != 0;
}
