/*
 * Keeps a target in the middle of the picture with two servos: pan on pin 9, tilt on pin 10.
 *
 * look() simulates the camera on the head: the servos follow a square on a drawn wall. Replace it by your camera's gray pixels (see
 * FollowCamera), and set PIXELS_PER_DEGREE for your lens. The sketch needs 75 KB of RAM.
 */
#include <SMRTracker.h>
#include <Servo.h>

const int WIDTH = 160, HEIGHT = 120, SIDE = 20;
const int PIXELS_PER_DEGREE = 3;  // the width of the picture in pixels by the lens's angle of view
static uint8_t pixels[WIDTH * HEIGHT];
static smr::Robust tracker;
static Servo pan, tilt;
static int panAngle = 90, tiltAngle = 90, frame = 0;

// The gray level at (x, y) of a texture that does not repeat.
static uint8_t noise(uint32_t seed, int x, int y)
{
  uint32_t n = seed + (uint32_t)x * 374761393u + (uint32_t)y * 668265263u;
  n = (n ^ (n >> 13)) * 1274126177u;
  return (uint8_t)(n ^ (n >> 16));
}

// Draws the picture that a camera on the head would see: a wall, and a square that moves right and down.
static void look()
{
  int wallX = (panAngle - 90) * PIXELS_PER_DEGREE + 1000, wallY = (tiltAngle - 90) * PIXELS_PER_DEGREE + 1000;
  int squareX = 1000 + WIDTH / 2 - SIDE / 2 + frame, squareY = 1000 + HEIGHT / 2 - SIDE / 2 + frame / 2;
  for (int y = 0; y < HEIGHT; y++) {
    for (int x = 0; x < WIDTH; x++) {
      int u = wallX + x - squareX, v = wallY + y - squareY;
      bool inside = u >= 0 && u < SIDE && v >= 0 && v < SIDE;
      pixels[y * WIDTH + x] = inside ? 128 + noise(1, u / 3, v / 3) / 2 : noise(2, (wallX + x) / 4, (wallY + y) / 4) / 4;
    }
  }
}

// The new angle of a servo: it turns half of the way to the target, so that it does not oscillate.
static int turned(int angle, int offset)
{
  angle += offset / (2 * PIXELS_PER_DEGREE);
  return angle < 0 ? 0 : angle > 180 ? 180 : angle;
}

void setup()
{
  Serial.begin(115200);
  pan.attach(9);
  tilt.attach(10);
  pan.write(panAngle);
  tilt.write(tiltAngle);
  delay(2000);
  look();
  smr_status status = tracker.lock(pixels, WIDTH, HEIGHT, smr::box((WIDTH - SIDE) / 2, (HEIGHT - SIDE) / 2, SIDE, SIDE));
  Serial.print("lock: ");
  Serial.println(smr_status_name(status));
}

void loop()
{
  if (frame < 150) frame++;
  look();
  smr::Answer answer = tracker.update(pixels);
  if (answer.visible()) {
    panAngle = turned(panAngle, answer.centerX() - WIDTH / 2);
    tiltAngle = turned(tiltAngle, answer.centerY() - HEIGHT / 2);
    pan.write(panAngle);
    tilt.write(tiltAngle);
  }
  Serial.print(answer.status == SMR_OK ? smr::name(answer.state) : smr_status_name(answer.status));
  Serial.print(" off ");
  Serial.print((int)(answer.centerX() - WIDTH / 2));
  Serial.print(" ");
  Serial.print((int)(answer.centerY() - HEIGHT / 2));
  Serial.print(" pan ");
  Serial.print(panAngle);
  Serial.print(" tilt ");
  Serial.println(tiltAngle);
  delay(30);
}
