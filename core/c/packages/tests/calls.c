/* Calls the functions that every program needs. For each processor, .ci/release links this file with a package's libsmr.a, without a C library. */
#include "smr.h"

static smr_robust_target storage;
static smr_robust_workspace workspace;

int main(void)
{
  static const uint8_t pixels[64 * 64];
  const smr_frame frame = {64, 64, {{pixels, sizeof pixels, 64, 64, 64, 0, 0}}};
  const smr_rect box = {16, 16, 16, 16};
  smr_config config;
  smr_tracker *tracker;
  smr_answer answer;
  smr_status status = smr_config_refined(&config);
  if (status == SMR_OK) status = smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker);
  if (status == SMR_OK) status = smr_lock(tracker, &frame, &box);
  if (status == SMR_OK) status = smr_update(tracker, &frame, &answer);
  return (int)status;
}
