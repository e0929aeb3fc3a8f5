/*
 * Follows the object in the middle of the camera's picture. To lock on it, send any character from the serial monitor (115200 baud).
 *
 * Boards whose core has the Camera library: Nicla Vision (GC2145), Portenta H7 with the Vision Shield (HM0360 or HM01B0), GIGA R1 with
 * an OV7670. The sketch needs 290 KB of RAM, half of it for the camera's color picture.
 */
#include <camera.h>
#include <SMRTracker.h>

#ifdef ARDUINO_NICLA_VISION
#include <gc2145.h>
static GC2145 sensor;
#define COLOR 1
#elif defined(ARDUINO_PORTENTA_H7_M7)
#include <hm0360.h>  // the older shield has an HM01B0: himax.h, HM01B0
static HM0360 sensor;
#define COLOR 0
#elif defined(ARDUINO_GIGA)
#include <ov767x.h>
static OV7670 sensor;
#define COLOR 1
#else
#error "FollowCamera knows Nicla Vision, Portenta H7 and GIGA R1. For another camera, give update() its gray pixels."
#endif

const int WIDTH = 320, HEIGHT = 240, SIDE = 48;
static Camera camera(sensor);
static FrameBuffer buffer;
static smr::Robust tracker;
static bool locked = false;

// Returns the gray pixels of the picture in the buffer; nullptr if they cannot be converted.
static const uint8_t *gray()
{
#if COLOR
  // The sensor sends RGB565, the high byte first.
  static uint8_t pixels[WIDTH * HEIGHT];
  const smr::Box all[] = {smr::box(0, 0, WIDTH, HEIGHT), smr::box(0, 0, 0, 0)};
  smr_readout readout;
  smr_status status = smr_readout_begin(&readout, &SMR_RGB565_BE, WIDTH, HEIGHT, all, pixels, sizeof pixels);
  if (status == SMR_OK) status = smr_readout_lines(&readout, buffer.getBuffer(), WIDTH * HEIGHT * 2, WIDTH * 2);
  return status == SMR_OK ? pixels : nullptr;
#else
  return buffer.getBuffer();
#endif
}

void setup()
{
  Serial.begin(115200);
  while (!camera.begin(CAMERA_R320x240, COLOR ? CAMERA_RGB565 : CAMERA_GRAYSCALE, 30)) {
    Serial.println("no camera");
    delay(1000);
  }
}

void loop()
{
  if (camera.grabFrame(buffer, 3000) != 0) {
    Serial.println("no picture");
    return;
  }
  const uint8_t *pixels = gray();
  if (Serial.available() > 0) {
    Serial.read();
    smr_status status = tracker.lock(pixels, WIDTH, HEIGHT, smr::box((WIDTH - SIDE) / 2, (HEIGHT - SIDE) / 2, SIDE, SIDE));
    locked = status == SMR_OK;
    Serial.print("lock: ");
    Serial.println(smr_status_name(status));
  } else if (locked) {
    smr::Answer answer = tracker.update(pixels);
    if (answer.status != SMR_OK) {
      Serial.println(smr_status_name(answer.status));
      return;
    }
    Serial.print(smr::name(answer.state));
    Serial.print(" box ");
    Serial.print((int)answer.bbox.x);
    Serial.print(" ");
    Serial.println((int)answer.bbox.y);
  }
}
