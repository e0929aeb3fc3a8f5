/*
 * Follows a target without a camera: the sketch draws a scene, the tracker follows the bright square in it, and the serial monitor
 * (115200 baud) shows where. The square hides for a moment in every round.
 *
 * It needs 20 KB of RAM. On a board with 128 KB or more, try smr::Robust.
 */
#include <SMRTracker.h>

const int WIDTH = 96, HEIGHT = 72, SIDE = 16, ROUND = 60;
static uint8_t pixels[WIDTH * HEIGHT];
static smr::Paper tracker;
static int frame = 0;

// A texture that does not repeat.
static uint8_t noise(uint32_t seed, int x, int y)
{
  uint32_t n = seed + (uint32_t)x * 374761393u + (uint32_t)y * 668265263u;
  n = (n ^ (n >> 13)) * 1274126177u;
  return (uint8_t)(n ^ (n >> 16));
}

// Where the square is: right for half a round, then left again.
static int left() { return 10 + (frame % ROUND < ROUND / 2 ? frame % ROUND : ROUND - frame % ROUND) * 2; }
static int top() { return 20 + left() / 4; }
static bool inView() { return frame % ROUND < 40 || frame % ROUND >= 48; }

static void draw()
{
  for (int y = 0; y < HEIGHT; y++) {
    for (int x = 0; x < WIDTH; x++) {
      int u = x - left(), v = y - top();
      bool inside = inView() && u >= 0 && u < SIDE && v >= 0 && v < SIDE;
      pixels[y * WIDTH + x] = inside ? 128 + noise(1, u / 3, v / 3) / 2 : noise(2, x / 4, y / 4) / 4 + noise(3 + frame, x, y) / 32;
    }
  }
}

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
  Serial.print(inView() ? " square " : " hidden ");
  Serial.print(left());
  Serial.print(" ");
  Serial.println(top());
  delay(50);
}
