/* Stands in for the camera driver of Espressif: its camera sees the square of square.h, and answers to the second esp_camera_init. Checks
 * that pictures are given back, and PSRAM for two or for color. */
#pragma once
#include <Arduino.h>
#include <stdlib.h>
#include "square.h"

typedef int esp_err_t;
enum { ESP_OK = 0, ESP_FAIL = -1, ESP_ERR_NOT_FOUND = 0x105 };
enum pixformat_t { PIXFORMAT_RGB565, PIXFORMAT_YUV422, PIXFORMAT_YUV420, PIXFORMAT_GRAYSCALE };
enum framesize_t { FRAMESIZE_QQVGA = 1, FRAMESIZE_QVGA = 6 };
enum camera_fb_location_t { CAMERA_FB_IN_PSRAM, CAMERA_FB_IN_DRAM };
enum camera_grab_mode_t { CAMERA_GRAB_WHEN_EMPTY, CAMERA_GRAB_LATEST };
enum ledc_timer_t { LEDC_TIMER_0 };
enum ledc_channel_t { LEDC_CHANNEL_0 };

struct camera_config_t {
  int pin_pwdn, pin_reset, pin_xclk, pin_sccb_sda, pin_sccb_scl;
  int pin_d7, pin_d6, pin_d5, pin_d4, pin_d3, pin_d2, pin_d1, pin_d0, pin_vsync, pin_href, pin_pclk;
  int xclk_freq_hz;
  ledc_timer_t ledc_timer;
  ledc_channel_t ledc_channel;
  pixformat_t pixel_format;
  framesize_t frame_size;
  int jpeg_quality;
  size_t fb_count;
  camera_fb_location_t fb_location;
  camera_grab_mode_t grab_mode;
};

struct camera_fb_t {
  uint8_t *buf;
  size_t len, width, height;
  pixformat_t format;
};

#ifndef PSRAM
#define PSRAM 0
#endif
inline bool psramFound() { return PSRAM; }

static camera_fb_t esp_picture;
static pixformat_t esp_format;
static int esp_scale, esp_inits = 0;  // pixels of square.h to a pixel
static int esp_taken = 0;
static bool esp_is_out = false;

inline esp_err_t esp_camera_init(const camera_config_t *config)
{
  if (esp_inits++ == 0) return ESP_ERR_NOT_FOUND;
  bool large = config->fb_count > 1 || config->pixel_format != PIXFORMAT_GRAYSCALE || config->fb_location == CAMERA_FB_IN_PSRAM;
  if ((config->frame_size != FRAMESIZE_QVGA && config->frame_size != FRAMESIZE_QQVGA) || config->pin_pclk == 0 || (large && !PSRAM)) return ESP_FAIL;
  esp_format = config->pixel_format;
  esp_scale = config->frame_size == FRAMESIZE_QVGA ? 1 : 2;
  return ESP_OK;
}

inline camera_fb_t *esp_camera_fb_get()
{
  static uint8_t pixels[320 * 240 * 2];
  int bytes = esp_format == PIXFORMAT_GRAYSCALE ? 1 : 2, width = 320 / esp_scale, height = 240 / esp_scale;
  if (esp_is_out) abort();
  esp_is_out = true;
  for (int i = 0; i < width * height; i++) {
    int level = square_level(i % width * esp_scale, i / width * esp_scale, esp_taken);
    int pixel = bytes == 1 ? level << 3 : level << 11 | level << 6 | level;
    if (bytes == 2) pixels[2 * i] = static_cast<uint8_t>(pixel >> 8);
    pixels[bytes * i + bytes - 1] = static_cast<uint8_t>(pixel);
  }
  esp_taken++;
  esp_picture.buf = pixels;
  esp_picture.len = static_cast<size_t>(width * height * bytes);
  esp_picture.width = static_cast<size_t>(width);
  esp_picture.height = static_cast<size_t>(height);
  esp_picture.format = esp_format;
  return &esp_picture;
}

inline void esp_camera_fb_return(camera_fb_t *picture)
{
  if (!esp_is_out || picture != &esp_picture) abort();
  esp_is_out = false;
}
