/*
 * Follows the object in the middle of the camera's picture. To lock on it, send any character from the serial monitor (115200 baud).
 *
 * ESP32-CAM (AI Thinker) and XIAO ESP32S3 Sense (esp_cameras.h; the library's README.md has the steps); boards whose core has the Camera
 * library (mbed_cameras.h): Nicla Vision, Portenta H7 with the Vision Shield, GIGA R1 with an OV7670. For another camera, give lock() and
 * update() its gray pixels.
 */
#include <SMRTracker.h>

// The size of the camera's pictures: on an ESP32 320x240, or 160x120, which takes 58 KB of RAM less.
const int WIDTH = 320, HEIGHT = 240;
const int SIDE = HEIGHT / 5;
#ifdef ARDUINO_ARCH_ESP32
#include "esp_cameras.h"
#else
#include "mbed_cameras.h"
#endif

static smr::Robust tracker;  // or smr::Small: 7 KB of RAM less, and it follows equally well
static bool locked = false;

// Returns true if the serial monitor has sent something, and reads all of it: the monitor may add one or two characters that end a line.
static bool asked()
{
  bool any = false;
  while (Serial.available() > 0) {
    Serial.read();
    any = true;
  }
  return any;
}

// Each second, because a monitor that opens later misses what was sent before.
static void hint()
{
  static unsigned long said = 0;
  if (millis() - said < 1000) return;
  said = millis();
  Serial.println("camera of " CAMERA_BOARD ": send any character to lock");
}

void setup()
{
  Serial.begin(115200);
  for (int error = beginCamera(); error != 0; error = beginCamera()) {
    Serial.print("no camera on " CAMERA_BOARD ", error 0x");
    Serial.println(error, HEX);
    delay(1000);
  }
}

void loop()
{
  const uint8_t *pixels = nextPicture();
  if (pixels == nullptr) {
    Serial.println("no picture");
    return;
  }
  if (asked()) {
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
  } else {
    hint();
  }
}
