/* Stands in for Zephyr's video interface: a camera that sends the square of square.h as YUYV, and stops after LOOPS pictures. Checks the
 * type of each queued buffer, and writes pictures only into queued buffers. */
#pragma once
#include <errno.h>
#include <stddef.h>
#include <stdint.h>
#include <zephyr/device.h>
#include "square.h"

#define CONFIG_VIDEO_BUFFER_POOL_NUM_MAX 2
#define VIDEO_PIX_FMT_YUYV 0x56595559u
enum video_buf_type { VIDEO_BUF_TYPE_INPUT, VIDEO_BUF_TYPE_OUTPUT };
struct video_format { enum video_buf_type type; uint32_t pixelformat, width, height, pitch; };
struct video_buffer { enum video_buf_type type; uint8_t *buffer; uint32_t size; };

static uint8_t pool[CONFIG_VIDEO_BUFFER_POOL_NUM_MAX][320 * 240 * 2];
static struct video_buffer buffers[CONFIG_VIDEO_BUFFER_POOL_NUM_MAX], *queued[CONFIG_VIDEO_BUFFER_POOL_NUM_MAX];
static int allocated, waiting, taken, streams;

static inline int video_get_format(const struct device *camera, struct video_format *format)
{
  (void)camera;
  return format->type == VIDEO_BUF_TYPE_OUTPUT ? 0 : -EINVAL;
}

static inline int video_set_format(const struct device *camera, struct video_format *format)
{
  (void)camera;
  return format->pixelformat == VIDEO_PIX_FMT_YUYV && format->width == 320 && format->height == 240 ? 0 : -ENOTSUP;
}

static inline struct video_buffer *video_buffer_alloc(size_t size, int timeout)
{
  (void)timeout;
  if (allocated == CONFIG_VIDEO_BUFFER_POOL_NUM_MAX || size > sizeof pool[0]) return NULL;
  buffers[allocated].buffer = pool[allocated];
  return &buffers[allocated++];
}

static inline int video_enqueue(const struct device *camera, struct video_buffer *buffer)
{
  (void)camera;
  if (buffer->type != VIDEO_BUF_TYPE_OUTPUT || waiting == CONFIG_VIDEO_BUFFER_POOL_NUM_MAX) return -EINVAL;
  queued[waiting++] = buffer;
  return 0;
}

static inline int video_stream_start(const struct device *camera, enum video_buf_type type)
{
  (void)camera;
  streams = 1;
  return type == VIDEO_BUF_TYPE_OUTPUT ? 0 : -EINVAL;
}

static inline int video_dequeue(const struct device *camera, struct video_buffer **buffer, int timeout)
{
  (void)camera, (void)timeout;
  if (!streams || waiting == 0 || taken == LOOPS) return -EAGAIN;
  *buffer = queued[0];
  queued[0] = queued[--waiting];
  for (int i = 0; i < 320 * 240; i++) {
    (*buffer)->buffer[2 * i] = (uint8_t)(square_level(i % 320, i / 320, taken) * 8);
    (*buffer)->buffer[2 * i + 1] = 128;
  }
  taken++;
  return 0;
}
