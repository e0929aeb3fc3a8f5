/*
 * Follows the object in the middle of the camera's first picture, and prints its box. Uses the video interface of Zephyr 4.2.
 *
 * The camera must send 320x240 pixels as YUYV. The program needs 440 KB of RAM: two pictures of the camera, one of gray pixels, and
 * 53 KB for the tracker.
 */
#include <smr.h>
#include <zephyr/device.h>
#include <zephyr/drivers/video.h>
#include <zephyr/kernel.h>

#define WIDTH 320
#define HEIGHT 240
#define SIDE 48

static smr_robust_target storage;
static smr_robust_workspace workspace;
static uint8_t gray[WIDTH * HEIGHT];

/* Copies the gray levels (Y) of the whole picture to `gray`. */
static smr_status to_gray(const uint8_t *yuyv, size_t stride)
{
	const smr_rect all[2] = {{0, 0, WIDTH, HEIGHT}};
	smr_readout readout;
	smr_status status = smr_readout_begin(&readout, &SMR_YUYV, WIDTH, HEIGHT, all, gray, sizeof(gray));

	return status == SMR_OK ? smr_readout_lines(&readout, yuyv, stride * HEIGHT, stride) : status;
}

/* Locks on the middle of the first picture; updates the tracker with any later one. */
static smr_status follow(smr_tracker *tracker, bool first)
{
	static const char *const names[] = {"tracking", "leaving", "uncertain", "lost"};
	const smr_frame frame = {WIDTH, HEIGHT, {{gray, sizeof(gray), WIDTH, WIDTH, HEIGHT, 0, 0}}};
	const smr_rect middle = {(WIDTH - SIDE) / 2, (HEIGHT - SIDE) / 2, SIDE, SIDE};
	smr_answer answer;
	smr_status status;

	if (first) {
		return smr_lock(tracker, &frame, &middle);
	}
	status = smr_update(tracker, &frame, &answer);
	if (status == SMR_OK) {
		printk("%s box %d %d\n", names[answer.state], (int)answer.bbox.x, (int)answer.bbox.y);
	}
	return status;
}

/* Starts the camera. Returns 0 or an error of the video interface. */
static int start(const struct device *camera, struct video_format *format)
{
	int error = device_is_ready(camera) ? video_get_format(camera, format) : -ENODEV;

	format->pixelformat = VIDEO_PIX_FMT_YUYV;
	format->width = WIDTH;
	format->height = HEIGHT;
	format->pitch = WIDTH * 2;
	error = error != 0 ? error : video_set_format(camera, format);
	for (int i = 0; error == 0 && i < CONFIG_VIDEO_BUFFER_POOL_NUM_MAX; i++) {
		struct video_buffer *buffer = video_buffer_alloc(format->pitch * HEIGHT, K_FOREVER);

		if (buffer == NULL) {
			return -ENOMEM;
		}
		buffer->type = VIDEO_BUF_TYPE_OUTPUT;
		error = video_enqueue(camera, buffer);
	}
	return error != 0 ? error : video_stream_start(camera, VIDEO_BUF_TYPE_OUTPUT);
}

int main(void)
{
	const struct device *const camera = DEVICE_DT_GET(DT_CHOSEN(zephyr_camera));
	struct video_format format = {.type = VIDEO_BUF_TYPE_OUTPUT};
	struct video_buffer *buffer = &(struct video_buffer){.type = VIDEO_BUF_TYPE_OUTPUT};
	smr_config config;
	smr_tracker *tracker = NULL;
	smr_status status = smr_config_robust(&config);
	int error = start(camera, &format);

	if (status == SMR_OK) {
		status = smr_init(&storage, sizeof(storage), &workspace, sizeof(workspace), &config, &tracker);
	}
	for (bool first = true; error == 0 && status == SMR_OK; first = false) {
		error = video_dequeue(camera, &buffer, K_FOREVER);
		if (error == 0) {
			status = to_gray(buffer->buffer, format.pitch);
			error = video_enqueue(camera, buffer);
		}
		if (error == 0 && status == SMR_OK) {
			status = follow(tracker, first);
		}
	}
	printk("stopped: camera %d, tracker %s\n", error, smr_status_name(status));
	return 0;
}
