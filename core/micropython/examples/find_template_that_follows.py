# Finds the picture /template.pgm once by OpenMV's find_template, then follows it by smr as it moves, turns and changes size. When smr has lost
# it, find_template searches again. Without the picture, the script follows the object in the centre.
#
# Tested with stand-ins for the camera's modules, but not yet on a camera.
import image
import sensor
import smr

sensor.reset()
sensor.set_pixformat(sensor.GRAYSCALE)
sensor.set_framesize(sensor.QVGA)
sensor.skip_frames(time=2000)

try:
    template = image.Image("/template.pgm")
except OSError:
    template = None


def look(frame):
    if template is not None:
        return frame.find_template(template, 0.7, step=4, search=image.SEARCH_EX)
    width, height = frame.width(), frame.height()
    return (width // 2 - 20, height // 2 - 20, 40, 40)


tracker = smr.Robust()
following = False
while True:
    frame = sensor.snapshot()
    if not following:
        box = look(frame)
        if box is not None:
            tracker.lock(frame, frame.width(), frame.height(), box)
            following = True
        continue
    answer = tracker.update(frame)
    if answer.state != smr.LOST:
        frame.draw_rectangle(answer.box)
        print(answer.box, answer.confidence * 100 // 65535, "%")
    elif template is not None:
        following = False
