/* Stands in for the Camera library of the mbed core: its camera sees the square of square.h in RGB565. */
#pragma once
#include <Arduino.h>
#include "square.h"

enum { CAMERA_GRAYSCALE = 0, CAMERA_BAYER = 1, CAMERA_RGB565 = 2 };
enum { CAMERA_R320x240 = 1 };

class ImageSensor {};

class FrameBuffer {
public:
  uint8_t *getBuffer() { return pixels; }
private:
  uint8_t pixels[320 * 240 * 2];
};

class Camera {
public:
  Camera(ImageSensor &) {}
  bool begin(int32_t resolution, int32_t format, int32_t) { return resolution == CAMERA_R320x240 && format == CAMERA_RGB565; }
  int grabFrame(FrameBuffer &buffer, uint32_t)
  {
    for (int y = 0; y < 240; y++) {
      for (int x = 0; x < 320; x++) {
        // A gray pixel in RGB565: red, blue, and the upper five of green's six bits are all `level`.
        int level = square_level(x, y, taken);
        int pixel = level << 11 | level << 6 | level;
        buffer.getBuffer()[(y * 320 + x) * 2] = static_cast<uint8_t>(pixel >> 8);
        buffer.getBuffer()[(y * 320 + x) * 2 + 1] = static_cast<uint8_t>(pixel);
      }
    }
    taken++;
    return 0;
  }
private:
  int taken = 0;
};
