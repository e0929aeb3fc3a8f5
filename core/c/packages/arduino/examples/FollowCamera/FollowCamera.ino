/*
 * Follows the object in the middle of the camera's picture. To lock on it, send any character from the serial monitor (115200 baud).
 *
 * ESP32-CAM (AI Thinker) and XIAO ESP32S3 Sense (esp_cameras.h); boards whose core has the Camera library (mbed_cameras.h): Nicla Vision,
 * Portenta H7 with the Vision Shield, GIGA R1 with an OV7670. For another camera, give lock() and update() its gray pixels.
 */
#include <SMRTracker.h>

const int WIDTH = 320, HEIGHT = 240, SIDE = 48;
#ifdef ARDUINO_ARCH_ESP32
#include "esp_cameras.h"
#else
#include "mbed_cameras.h"
#endif

static smr::Robust tracker;
static bool locked = false;

void setup()
{
  Serial.begin(115200);
  while (!beginCamera()) {
    Serial.println("no camera");
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
