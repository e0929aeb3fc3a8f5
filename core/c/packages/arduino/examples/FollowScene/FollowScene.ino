/*
 * Follows a target without a camera: scene.h draws a scene, the tracker follows the bright square in it, and the serial monitor
 * (115200 baud) shows its box. The square hides for a moment in every round.
 *
 * The sketch needs 20 KB of RAM. With a camera and 52 KB more, smr::Robust also follows changes of light, size and view: see FollowCamera.
 */
#include <SMRTracker.h>
#include "scene.h"

static smr::Paper tracker;

void setup()
{
  Serial.begin(115200);
  delay(2000);  // time to open the serial monitor
  draw();
  smr_status status = tracker.lock(pixels, WIDTH, HEIGHT, smr::box(left(), top(), SIDE, SIDE));
  Serial.print("lock: ");
  Serial.println(smr_status_name(status));
}

void loop()
{
  frame++;
  draw();
  smr::Answer answer = tracker.update(pixels);
  if (answer.status != SMR_OK) {
    Serial.println(smr_status_name(answer.status));
    delay(1000);
    return;
  }
  Serial.print(smr::name(answer.state));
  Serial.print(" box ");
  Serial.print((int)answer.bbox.x);
  Serial.print(" ");
  Serial.print((int)answer.bbox.y);
  Serial.print(in_view() ? " square " : " hidden ");
  Serial.print(left());
  Serial.print(" ");
  Serial.println(top());
  delay(50);
}
