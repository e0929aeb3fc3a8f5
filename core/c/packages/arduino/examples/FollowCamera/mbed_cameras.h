/*
 * Cameras of boards whose core has the Camera library. The sketch needs 290 KB of RAM with a color sensor, half of it for the color picture.
 */
#pragma once
#include <camera.h>

#ifdef ARDUINO_NICLA_VISION
#include <gc2145.h>
#include "gray.h"
static GC2145 sensor;
#define CAMERA_BOARD "Nicla Vision"
#define COLOR 1
#elif defined(ARDUINO_PORTENTA_H7_M7)
#include <hm0360.h>  // the older shield has an HM01B0: himax.h, HM01B0
static HM0360 sensor;
#define CAMERA_BOARD "Portenta H7"
#define COLOR 0
#elif defined(ARDUINO_GIGA)
#include <ov767x.h>
#include "gray.h"
static OV7670 sensor;
#define CAMERA_BOARD "GIGA R1"
#define COLOR 1
#else
#error "FollowCamera knows ESP32-CAM, XIAO ESP32S3 Sense, Nicla Vision, Portenta H7 and GIGA R1"
#endif

static_assert(WIDTH == 320 && HEIGHT == 240, "mbed_cameras.h takes pictures of 320x240");

static Camera camera(sensor);
static FrameBuffer buffer;

// Returns 0, or 1 if the camera does not answer.
static int beginCamera()
{
  return camera.begin(CAMERA_R320x240, COLOR ? CAMERA_RGB565 : CAMERA_GRAYSCALE, 30) ? 0 : 1;
}

// The gray pixels of the next picture, until the next call; nullptr if there is none.
static const uint8_t *nextPicture()
{
  if (camera.grabFrame(buffer, 3000) != 0) return nullptr;
#if COLOR
  return gray(buffer.getBuffer());
#else
  return buffer.getBuffer();
#endif
}
