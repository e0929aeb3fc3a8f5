"""`python -m smr.mavlink SOURCE CONNECTION`: a MAVLink camera that follows what a ground station or an autopilot asks for.

It speaks MAVLink's camera protocol (`pip install smr-tracker[mavlink]`): a heartbeat each second, CAMERA_INFORMATION on request,
MAV_CMD_CAMERA_TRACK_RECTANGLE, MAV_CMD_CAMERA_TRACK_POINT and MAV_CMD_CAMERA_STOP_TRACKING in, CAMERA_TRACKING_IMAGE_STATUS out.
MAVLINK.md says how to connect a vehicle.
"""

import argparse
import itertools
import math
import os
import sys
import time

from . import Paper, Recording, Robust, State, __version__
from ._benchmark import inside

os.environ.setdefault("MAVLINK20", "1")  # Read by pymavlink when it is imported. CAMERA_TRACKING_IMAGE_STATUS needs MAVLink 2.
try:
    from pymavlink import mavutil
    from pymavlink.dialects.v20 import common as mavlink
except ImportError:
    if __name__ != "__main__":
        raise
    print("error: there is no module pymavlink: pip install smr-tracker[mavlink]", file=sys.stderr)
    sys.exit(2)

PRESETS = {"refined": Robust, "robust": Robust, "camera": Paper, "paper": Paper}
RADIUS = 0.05  # What a point gets that comes without one, as a part of the frame's width.
LEAST_SIDE = 16  # The least side of the box around a point, in pixels: a smaller one shows too little of the target.
MOST_MESSAGES = 1000  # Taken between two frames, so that a flood of them does not stop the tracker.
HEARTBEAT = 1.0  # In seconds, as MAVLink wants it.


def say(text):
    print(text, file=sys.stderr, flush=True)


class Camera:
    """A camera component on a MAVLink connection. `tracker` follows the target; one frame after the other goes into `show`.

    Places and sizes in messages are parts of the frame, 0 to 1.
    """

    def __init__(self, connection, tracker):
        self.connection, self.tracker = connection, tracker
        self.frame, self.number, self.mode = None, 0, mavlink.CAMERA_TRACKING_MODE_NONE
        self.state = None  # The target's in the last frame; None without a target.
        self.interval = 0.0  # Seconds between two messages of the status; infinite for none.
        self.sent = self.beaten = -math.inf  # When the last one was sent, and the last heartbeat.
        self.begun = time.monotonic()
        self.commands = {
            mavlink.MAV_CMD_CAMERA_TRACK_RECTANGLE: self.track_rectangle,
            mavlink.MAV_CMD_CAMERA_TRACK_POINT: self.track_point,
            mavlink.MAV_CMD_CAMERA_STOP_TRACKING: self.stop,
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self.set_interval,
            mavlink.MAV_CMD_REQUEST_MESSAGE: self.request,
            mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION: lambda *_: self.request(mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION),
        }

    def show(self, frame):
        """Follows the target in the next frame, and sends where it is."""
        self.frame, self.number = frame, self.number + 1
        if self.state is not None:
            answer = self.tracker.follow(frame)
            changed = (answer.state == State.LOST) != (self.state == State.LOST)
            if changed:
                say(f"frame {self.number}: " + ("lost" if answer.state == State.LOST else f"found again at {place(answer.box)}"))
            self.state = answer.state
            self.send_status(answer.fine_box, at_once=changed)
        self.poll()

    def wait(self, until):
        """Takes messages until this time of `time.monotonic`."""
        while (left := until - time.monotonic()) > 0:
            if self.connection.select(min(left, HEARTBEAT)):
                self.poll()

    def poll(self):
        """Sends the heartbeat if it is due, and answers all commands that have come."""
        if time.monotonic() - self.beaten >= HEARTBEAT:
            self.beaten = time.monotonic()
            self.connection.mav.heartbeat_send(mavlink.MAV_TYPE_CAMERA, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE)
        for _ in range(MOST_MESSAGES):
            message = self.connection.recv_msg()
            if message and message.get_type() in ("COMMAND_LONG", "COMMAND_INT"):
                self.command(message)
            # A packet of nonsense is no message, and others may wait behind it.
            if not message and not self.connection.select(0):
                return

    def command(self, message):
        own = self.connection.mav
        if (message.target_system, message.target_component) != (own.srcSystem, own.srcComponent):
            return
        act, parameters = self.commands.get(message.command), (message.param1, message.param2, message.param3, message.param4)
        sender = message.get_srcSystem(), message.get_srcComponent()
        result, after = mavlink.MAV_RESULT_UNSUPPORTED, None
        if act:
            try:
                result, after = mavlink.MAV_RESULT_ACCEPTED, act(*parameters)
            except NotImplementedError:
                result = mavlink.MAV_RESULT_UNSUPPORTED
            except ValueError as error:
                result = mavlink.MAV_RESULT_DENIED
                say(f"denied to {sender[0]}/{sender[1]}: {error}")
        own.command_ack_send(message.command, result, 0, 0, *sender)
        if after:  # The answer comes after its acknowledgement.
            after()

    def track_rectangle(self, left, top, right, bottom):
        corners = (left, top, right, bottom)
        if not all(0 <= side <= 1 for side in corners) or left >= right or top >= bottom:  # NaN is not, either.
            raise ValueError(f"expected a rectangle with corners of 0 to 1, found {listed(corners)}")
        height, width = self.frame.shape[:2]
        box = (left * width, top * height, (right - left) * width, (bottom - top) * height)
        return self.lock(box, mavlink.CAMERA_TRACKING_MODE_RECTANGLE)

    def track_point(self, x, y, radius, _):
        if not (0 <= x <= 1 and 0 <= y <= 1) or radius > 1 or radius < 0:
            raise ValueError(f"expected a point and a radius of 0 to 1, found {listed((x, y, radius))}")
        height, width = self.frame.shape[:2]
        side = max(LEAST_SIDE, 2 * width * (radius if radius > 0 else RADIUS))  # NaN is no radius.
        return self.lock((x * width - side / 2, y * height - side / 2, side, side), mavlink.CAMERA_TRACKING_MODE_POINT)

    def lock(self, box, mode):
        box = inside(box, self.frame)
        self.tracker.init(self.frame, box)
        self.state, self.mode = State.TRACKING, mode
        say(f"frame {self.number}: following {place(box)}")
        return lambda: self.send_status(box, at_once=True)

    def stop(self, *_):
        if self.state is not None:
            say(f"frame {self.number}: stopped")
        self.state, self.mode = None, mavlink.CAMERA_TRACKING_MODE_NONE
        return lambda: self.send_status(None, at_once=True)

    def set_interval(self, message, interval, *_):
        """`interval` is in microseconds; 0 is each frame, -1 is never."""
        if message != mavlink.MAVLINK_MSG_ID_CAMERA_TRACKING_IMAGE_STATUS:
            raise NotImplementedError
        if not (interval == -1 or 0 <= interval < math.inf):
            raise ValueError(f"expected an interval of microseconds, 0 or -1, found {interval:g}")
        self.interval = math.inf if interval == -1 else interval / 1e6

    def request(self, message, *_):
        if message == mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION:
            return self.send_information
        raise NotImplementedError

    def send_information(self):
        height, width = self.frame.shape[:2]
        major, minor, patch = map(int, __version__.split("-")[0].split("."))
        vendor, model = (list(name.encode().ljust(32, b"\0")) for name in ("smr", type(self.tracker).__name__))
        flags = mavlink.CAMERA_CAP_FLAGS_HAS_TRACKING_POINT | mavlink.CAMERA_CAP_FLAGS_HAS_TRACKING_RECTANGLE
        milliseconds, version = int(1000 * (time.monotonic() - self.begun)), patch << 16 | minor << 8 | major
        optics = [math.nan] * 3
        self.connection.mav.camera_information_send(milliseconds, vendor, model, version, *optics, width, height, 0, flags, 0, b"")

    def send_status(self, box, at_once=False):
        """Sends where the target is. A lost target has no place: an autopilot must not steer by an old one."""
        now = time.monotonic()
        if math.isinf(self.interval) or (now - self.sent < self.interval and not at_once):
            return
        self.sent = now
        status, data, numbers = mavlink.CAMERA_TRACKING_STATUS_FLAGS_IDLE, 0, [math.nan] * 7
        if self.state == State.LOST:
            status = mavlink.CAMERA_TRACKING_STATUS_FLAGS_ERROR
        elif self.state is not None:
            status, data = mavlink.CAMERA_TRACKING_STATUS_FLAGS_ACTIVE, mavlink.CAMERA_TRACKING_TARGET_DATA_IN_STATUS
            height, width = self.frame.shape[:2]
            left, top, right, bottom = (
                min(max(edge / side, 0), 1)
                for edge, side in zip((box.x, box.y, box.x + box.width, box.y + box.height), (width, height, width, height))
            )
            numbers = [(left + right) / 2, (top + bottom) / 2, (right - left) / 2, left, top, right, bottom]
        self.connection.mav.camera_tracking_image_status_send(status, self.mode, data, *numbers)


def place(box):
    return ",".join(f"{round(number)}" for number in box)


def listed(numbers):
    return ",".join(f"{number:g}" for number in numbers)


def connected(options):
    """The connection. Errors are those of pymavlink, of sockets and of serial ports."""
    try:
        return mavutil.mavlink_connection(
            options.connection,
            baud=options.baud,
            source_system=options.system_id,
            source_component=options.component,
            dialect="common",
        )
    except ImportError as error:
        raise ValueError(f"{options.connection}: there is no module {error.name}: pip install smr-tracker[mavlink]") from None
    except (OSError, ValueError) as error:
        expected = "expected udpout:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or a serial device"
        raise ValueError(f"cannot connect to {options.connection}: {error}: {expected}") from None


def serve(recording, camera, rate, repeat):
    """Shows the camera all frames: those of a recording at `rate` frames a second, those of a live source as they come."""
    for _ in itertools.count() if repeat and not recording.is_live else range(1):
        due = time.monotonic()
        for frame in recording:
            camera.show(frame)
            if not recording.is_live:
                due = max(due + 1 / rate, time.monotonic() - 1)  # After a pause it does not catch up for long.
                camera.wait(due)
    if camera.frame is None:
        raise ValueError("there are no frames")


def number(low, high, kind=int):
    def parse(text):
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"expected a number of {low} to {high}, found {text}")
        return value

    return parse


def arguments():
    parser = argparse.ArgumentParser(prog="python -m smr.mavlink", description="A MAVLink camera that follows what it is asked to.")
    parser.add_argument("source", metavar="SOURCE", help="a camera such as /dev/video0, an address such as rtsp://HOST/PATH, or a recording")
    parser.add_argument("connection", metavar="CONNECTION", help="as pymavlink takes it: udpout:HOST:PORT, udpin:HOST:PORT, or a serial device")
    parser.add_argument("--preset", choices=PRESETS, default="refined", help="the tracker (%(default)s)")
    parser.add_argument("--system-id", metavar="N", type=number(1, 255), default=1, help="of the vehicle (%(default)s)")
    parser.add_argument("--component", metavar="N", type=number(1, 255), default=100, help="of this camera (%(default)s, the first camera)")
    parser.add_argument("--baud", metavar="N", type=number(1, 10_000_000), default=57600, help="of a serial device (%(default)s)")
    parser.add_argument("--rate", metavar="N", type=number(0.1, 1000, float), default=30.0, help="frames a second of a recording (%(default)g)")
    parser.add_argument("--repeat", action="store_true", help="begin a recording again when it ends")
    return parser.parse_args()


def main():
    options = arguments()
    recording = Recording(options.source)
    camera = Camera(connected(options), PRESETS[options.preset](options.preset))
    say(f"{recording.name}: camera {options.system_id}/{options.component} at {options.connection}; Ctrl-C ends it")
    serve(recording, camera, options.rate, options.repeat)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
