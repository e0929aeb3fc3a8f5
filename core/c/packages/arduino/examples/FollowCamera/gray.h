/* The gray pixels of a color picture. */
#pragma once
#include <SMRTracker.h>

// Converts WIDTH * HEIGHT pixels of RGB565, the high byte first; returns nullptr if that fails. The result stays until the next call.
static const uint8_t *gray(const uint8_t *color)
{
  static uint8_t pixels[WIDTH * HEIGHT];
  const smr::Box all[] = {smr::box(0, 0, WIDTH, HEIGHT), smr::box(0, 0, 0, 0)};
  smr_readout readout;
  smr_status status = smr_readout_begin(&readout, &SMR_RGB565_BE, WIDTH, HEIGHT, all, pixels, sizeof pixels);
  if (status == SMR_OK) status = smr_readout_lines(&readout, color, WIDTH * HEIGHT * 2, WIDTH * 2);
  return status == SMR_OK ? pixels : nullptr;
}
