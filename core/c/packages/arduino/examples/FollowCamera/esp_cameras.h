/*
 * Cameras of ESP32 boards: ESP32-CAM (AI Thinker) and XIAO ESP32S3 Sense. For another board, add its name and its maker's pins below. The
 * board selected in the IDE selects the pins, and the sketch prints whose they are. ARDUINO_ESP32_DEV is "AI Thinker ESP32-CAM", but also
 * "ESP32 Dev Module" and "ESP32 Wrover Module": if yours is not an ESP32-CAM, replace the pins.
 *
 * With gray pictures the sketch needs 52 KB of RAM for the tracker, 77 KB for the picture, and the driver's own buffers: no PSRAM. COLOR 1
 * takes color pictures and converts them, for a sensor that sends no gray ones: 77 KB more, and PSRAM for the picture (154 KB).
 */
#pragma once
#include <esp_camera.h>

#ifndef COLOR
#define COLOR 0
#endif
#if COLOR
#include "gray.h"
#endif

static_assert((WIDTH == 320 && HEIGHT == 240) || (WIDTH == 160 && HEIGHT == 120), "esp_cameras.h takes pictures of 320x240 or 160x120");

static camera_config_t pins()
{
  camera_config_t config = camera_config_t();
#ifdef ARDUINO_XIAO_ESP32S3
#define CAMERA_BOARD "XIAO ESP32S3 Sense"
  config.pin_pwdn = -1;
  config.pin_xclk = 10;
  config.pin_sccb_sda = 40;
  config.pin_sccb_scl = 39;
  config.pin_d7 = 48;
  config.pin_d6 = 11;
  config.pin_d5 = 12;
  config.pin_d4 = 14;
  config.pin_d3 = 16;
  config.pin_d2 = 18;
  config.pin_d1 = 17;
  config.pin_d0 = 15;
  config.pin_vsync = 38;
  config.pin_href = 47;
  config.pin_pclk = 13;
#elif defined(ARDUINO_ESP32_DEV)
#define CAMERA_BOARD "ESP32-CAM (AI Thinker)"
  config.pin_pwdn = 32;
  config.pin_xclk = 0;
  config.pin_sccb_sda = 26;
  config.pin_sccb_scl = 27;
  config.pin_d7 = 35;
  config.pin_d6 = 34;
  config.pin_d5 = 39;
  config.pin_d4 = 36;
  config.pin_d3 = 21;
  config.pin_d2 = 19;
  config.pin_d1 = 18;
  config.pin_d0 = 5;
  config.pin_vsync = 25;
  config.pin_href = 23;
  config.pin_pclk = 22;
#else
#error "FollowCamera has the pins of ESP32-CAM (AI Thinker) and XIAO ESP32S3 Sense: select one in the IDE, or add this board's pins"
#endif
  config.pin_reset = -1;
  return config;
}

// Returns 0, or the error of esp_camera_init.
static int beginCamera()
{
  camera_config_t config = pins();
  config.xclk_freq_hz = 20000000;
  config.ledc_timer = LEDC_TIMER_0;
  config.ledc_channel = LEDC_CHANNEL_0;
  config.pixel_format = COLOR ? PIXFORMAT_RGB565 : PIXFORMAT_GRAYSCALE;
  config.frame_size = WIDTH == 320 ? FRAMESIZE_QVGA : FRAMESIZE_QQVGA;
  // In PSRAM a second picture is taken while the tracker works on the first.
  config.fb_count = psramFound() ? 2 : 1;
  config.fb_location = psramFound() ? CAMERA_FB_IN_PSRAM : CAMERA_FB_IN_DRAM;
  config.grab_mode = psramFound() ? CAMERA_GRAB_LATEST : CAMERA_GRAB_WHEN_EMPTY;
  return esp_camera_init(&config);
}

// The gray pixels of the next picture, until the next call; nullptr if there is none.
static const uint8_t *nextPicture()
{
  static camera_fb_t *picture = nullptr;
  if (picture != nullptr) esp_camera_fb_return(picture);
  picture = esp_camera_fb_get();
  if (picture == nullptr || picture->width != WIDTH || picture->height != HEIGHT) return nullptr;
#if COLOR
  return gray(picture->buf);
#else
  return picture->buf;
#endif
}
