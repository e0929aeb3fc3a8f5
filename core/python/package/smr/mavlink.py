"""`python -m smr.mavlink SOURCE CONNECTION`: a MAVLink camera that follows what a ground station or an autopilot asks for.

It speaks MAVLink's camera protocol (`pip install smr-tracker[mavlink]`). MAVLINK.md lists the messages, and says how to connect a vehicle.
"""

import argparse
import itertools
import math
import os
import socket
import struct
import sys
import threading
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

PRESETS = {"refined": Robust, "robust": Robust, "small": Robust, "small_refined": Robust, "camera": Paper, "paper": Paper}
COASTING = 8  # CAMERA_TRACKING_STATUS_FLAGS_COASTING, which older versions of pymavlink do not name.
STREAMS = {"rtsp": mavlink.VIDEO_STREAM_TYPE_RTSP, "udp": mavlink.VIDEO_STREAM_TYPE_RTPUDP, "tcp": mavlink.VIDEO_STREAM_TYPE_TCP_MPEG}
RADIUS = 0.05  # What a point gets that comes without one, as a part of the frame's width.
MIN_SIDE = 16  # The least side of the box around a point, in pixels: a smaller one shows too little of the target.
MAX_MESSAGES = 1000  # Taken between two frames, so that a flood of them does not stop the tracker.
MAX_RECEIVERS = 100  # Whose intervals and commands are kept.
MAX_COMMANDS = 8  # Of each receiver, whose results are kept for when it sends them again.
DOUBLED = 1.0  # Seconds in which the same packet is a copy: a sender counts its packets, in 8 bits.
HEARTBEAT = 1.0  # In seconds, as MAVLink wants it.
TICK = 0.01  # The longest wait for a frame, in seconds, before messages are taken.
PATIENCE = 1.0  # The age of a frame, in seconds, from which the place of its target is no place.
RECONNECT = 1.0  # Seconds between two attempts to connect again. An attempt takes half of it at most.


def say(text):
    print(text, file=sys.stderr, flush=True)


class Receiver:
    """A MAVLink system and component that has sent a command: its interval of status messages, and the results of its last commands."""

    def __init__(self):
        self.interval = 0.0  # Seconds between two messages of the status; infinite for none.
        self.sent = -math.inf
        self.results = {}  # (result, packet, time) by command and parameters, the newest last.

    def result(self, message):
        """The result of a command that is sent again because its acknowledgement was lost; None for a new command."""
        result, packet, came = self.results.get(identity(message), (None, None, -math.inf))
        is_copy = packet == message.get_msgbuf() and time.monotonic() - came < DOUBLED
        return result if is_copy or getattr(message, "confirmation", 0) > 0 else None

    def keep(self, message, result):
        key = identity(message)
        self.results.pop(key, None)
        self.results[key] = result, message.get_msgbuf(), time.monotonic()
        if len(self.results) > MAX_COMMANDS:
            del self.results[next(iter(self.results))]


def identity(message):
    """The command and the bits of its parameters: a NaN equals itself."""
    names = ("x", "y", "z") if message.get_type() == "COMMAND_INT" else ("param5", "param6", "param7")
    return message.command, struct.pack("<7d", *(getattr(message, name) for name in ("param1", "param2", "param3", "param4", *names)))


class Addresses(dict):
    """pymavlink's times of the last packet from each address of a server, and the address of the newest packet."""

    newest = None

    def __setitem__(self, address, time):
        self.newest = address
        super().__setitem__(address, time)


class Nobody:
    """A stand-in for a lost connection, with which the camera continues until it has another one."""

    def __init__(self, system, component):
        self.mav = mavlink.MAVLink(self, system, component)

    def write(self, _):
        pass

    def recv_msg(self):
        return None

    def select(self, seconds):
        time.sleep(seconds)
        return False


class Camera:
    """A camera component on a MAVLink connection. `tracker` follows the target; `show` takes each frame. `poll` sends what is due and answers
    commands; call it more often than frames arrive.

    Positions and sizes in messages are fractions of the frame, 0 to 1. A connection whose peer has gone raises OSError. `stream` is the optional
    address of the video for ground stations.
    """

    def __init__(self, connection, tracker, stream=None):
        self.tracker, self.stream = tracker, stream
        self.frame, self.number, self.mode = None, 0, mavlink.CAMERA_TRACKING_MODE_NONE
        self.state = self.box = None  # The target's in the last frame; None without a target.
        self.receivers, self.strangers = {}, Receiver()  # By address, system and component; and all others.
        self.beaten = -math.inf  # When the last heartbeat was sent,
        self.shown, self.period = -math.inf, 0.0  # and when the last frame came, and how many seconds after the one before.
        self.patience, self.is_stale = PATIENCE, False
        self.begun = time.monotonic()
        self.commands = {
            mavlink.MAV_CMD_CAMERA_TRACK_RECTANGLE: self.track_rectangle,
            mavlink.MAV_CMD_CAMERA_TRACK_POINT: self.track_point,
            mavlink.MAV_CMD_CAMERA_STOP_TRACKING: self.stop,
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self.set_interval,
            mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: lambda message, *_: self.request(mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL, message),
            mavlink.MAV_CMD_REQUEST_MESSAGE: self.request,
            mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION: lambda *_: self.request(mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION, 0),
            mavlink.MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION: lambda number, *_: self.request(mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION, number),
        }
        # These are performed once, however often they are sent again. A request is answered each time.
        self.once = (self.track_rectangle, self.track_point, self.stop, self.set_interval)
        self.connect(connection)

    def connect(self, connection):
        self.connection, self.addresses = connection, Addresses()
        if getattr(connection, "udp_server", False):
            connection.clients_last_alive = self.addresses

    def show(self, frame):
        """Follows the target in the next frame, and sends its status."""
        came_again, self.is_stale = self.is_stale, False
        now = time.monotonic()
        self.period = 0.0 if self.frame is None else now - self.shown
        self.frame, self.number, self.shown = frame, self.number + 1, now
        if self.state is not None:
            answer = self.tracker.follow(frame)
            changed = (answer.state == State.LOST) != (self.state == State.LOST)
            if changed:
                say(f"frame {self.number}: " + ("lost" if answer.state == State.LOST else f"found again at {place(answer.box)}"))
            self.state, self.box = answer.state, answer.fine_box
            self.send_status(self.box, at_once=changed or came_again)
        self.poll()

    def poll(self):
        """Sends the messages that are due, and answers all commands that have arrived."""
        now = time.monotonic()
        if now - self.beaten >= HEARTBEAT:
            self.beaten = now
            self.connection.mav.heartbeat_send(mavlink.MAV_TYPE_CAMERA, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE)
        was_stale, self.is_stale = self.is_stale, now - self.shown > self.patience
        if self.is_stale and self.state is not None:
            if not was_stale:
                say(f"frame {self.number}: no new frame for {self.patience:g} s")
            self.send_status(None, at_once=not was_stale)
        for _ in range(MAX_MESSAGES):
            message = self.connection.recv_msg()
            if message and message.get_type() in ("COMMAND_LONG", "COMMAND_INT"):
                self.command(message)
            # An invalid packet gives no message, but later packets may be waiting.
            if not message and not self.connection.select(0):
                return

    def command(self, message):
        own = self.connection.mav
        to = (message.target_system, message.target_component)
        if to[0] not in (0, own.srcSystem) or to[1] not in (0, own.srcComponent):  # 0 is for all.
            return
        sender = message.get_srcSystem(), message.get_srcComponent()
        key = (self.addresses.newest, *sender)
        self.receiver = self.receivers[key] = self.receivers.pop(key, None) or Receiver()  # The last one is the newest.
        if len(self.receivers) > MAX_RECEIVERS:
            del self.receivers[next(iter(self.receivers))]
        result, after = self.receiver.result(message), None
        if result is None:
            result, after = self.performed(message, sender)
            if self.commands.get(message.command) in self.once and result != mavlink.MAV_RESULT_TEMPORARILY_REJECTED:
                self.receiver.keep(message, result)
        if result == mavlink.MAV_RESULT_UNSUPPORTED and 0 in to:
            return  # Another component may do what was asked of all.
        own.command_ack_send(message.command, result, 0, 0, *sender)
        if after:  # The answer comes after its acknowledgement.
            after()

    def performed(self, message, sender):
        """Performs a command. Returns its result, and the function that sends the answer if there is one."""
        act = self.commands.get(message.command)
        if not act:
            return mavlink.MAV_RESULT_UNSUPPORTED, None
        if self.frame is None and act not in (self.stop, self.set_interval):
            return mavlink.MAV_RESULT_TEMPORARILY_REJECTED, None
        try:
            return mavlink.MAV_RESULT_ACCEPTED, act(message.param1, message.param2, message.param3, message.param4)
        except NotImplementedError:
            return mavlink.MAV_RESULT_UNSUPPORTED, None
        except ValueError as error:
            say(f"denied to {sender[0]}/{sender[1]}: {error}")
            return mavlink.MAV_RESULT_DENIED, None

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
        side = max(MIN_SIDE, 2 * width * (radius if radius > 0 else RADIUS))  # NaN is no radius.
        return self.lock((x * width - side / 2, y * height - side / 2, side, side), mavlink.CAMERA_TRACKING_MODE_POINT)

    def lock(self, box, mode):
        box = inside(box, self.frame)
        self.tracker.init(self.frame, box)
        self.state, self.mode, self.box = State.TRACKING, mode, box
        say(f"frame {self.number}: following {place(box)}")
        return lambda: self.send_status(box, at_once=True)

    def stop(self, *_):
        if self.state is not None:
            say(f"frame {self.number}: stopped")
        self.state, self.box, self.mode = None, None, mavlink.CAMERA_TRACKING_MODE_NONE
        return lambda: self.send_status(None, at_once=True)

    def set_interval(self, message, interval, *_):
        """Sets the receiver's interval of status messages in microseconds; 0 is every frame, -1 is never."""
        if message != mavlink.MAVLINK_MSG_ID_CAMERA_TRACKING_IMAGE_STATUS:
            raise NotImplementedError
        if not (interval == -1 or 0 <= interval < math.inf):
            raise ValueError(f"expected an interval of microseconds, 0 or -1, found {interval:g}")
        self.receiver.interval = math.inf if interval == -1 else interval / 1e6

    def request(self, message, about, *_):
        if message == mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION:
            return self.send_information
        if message == mavlink.MAVLINK_MSG_ID_CAMERA_TRACKING_IMAGE_STATUS:
            return lambda: self.send_status(self.box, to=self.receiver)
        if message == mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL and 0 <= about < 65536:
            return lambda: self.connection.mav.message_interval_send(int(about), self.interval(about))
        if message == mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION and self.stream and about in (0, 1):
            return self.send_stream
        raise NotImplementedError

    def interval(self, message):
        """Microseconds between two messages of this kind to the receiver: -1 is never, 0 is only on request."""
        status = max(self.receiver.interval, self.period)
        seconds = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: HEARTBEAT, mavlink.MAVLINK_MSG_ID_CAMERA_TRACKING_IMAGE_STATUS: status}.get(message, 0)
        return -1 if seconds == math.inf else round(1e6 * min(seconds, 2000))

    def send_stream(self):
        height, width = self.frame.shape[:2]
        kind, _, address = self.stream.partition("://")
        # The address of a UDP stream is only the port on which the ground station listens.
        address = (address.rpartition(":")[2] if kind == "udp" else self.stream).encode()
        about = STREAMS[kind], mavlink.VIDEO_STREAM_STATUS_FLAGS_RUNNING, 1 / self.period if self.period else 0, width, height
        self.connection.mav.video_stream_information_send(1, 1, *about, 0, 0, 0, b"smr", address)

    def send_information(self):
        height, width = self.frame.shape[:2]
        major, minor, patch = map(int, __version__.split("-")[0].split("."))
        vendor, model = (list(name.encode().ljust(32, b"\0")) for name in ("smr", type(self.tracker).__name__))
        flags = mavlink.CAMERA_CAP_FLAGS_HAS_TRACKING_POINT | mavlink.CAMERA_CAP_FLAGS_HAS_TRACKING_RECTANGLE
        flags |= mavlink.CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM if self.stream else 0
        version = (patch & 255) << 16 | (minor & 255) << 8 | major & 255
        milliseconds = int(1000 * (time.monotonic() - self.begun)) & 0xFFFFFFFF  # It wraps after 49.7 days.
        optics = [math.nan] * 3
        self.connection.mav.camera_information_send(milliseconds, vendor, model, version, *optics, width, height, 0, flags, 0, b"")

    def send_status(self, box, at_once=False, to=None):
        """Sends the status of the target to all receivers for whom it is due, or to one. A lost target, or one of an old frame, has no position."""
        now, least = time.monotonic(), HEARTBEAT if self.is_stale else 0
        # A UDP server sends to each address separately. On other connections, all receivers get every message.
        clients = self.connection.clients if getattr(self.connection, "udp_server", False) else None
        due = set()
        for address in [None] if clients is None else clients:
            # An address without a known receiver is treated as `strangers`, which set no minimum interval between messages.
            for one in [one for (at, *_), one in self.receivers.items() if at == address] or [self.strangers]:
                is_due = one.interval < math.inf and (at_once or now - one.sent >= max(one.interval, least))
                if is_due if to is None else one is to:
                    due.add((address, one))
        if not due:
            return
        for _, one in due:
            one.sent = now
        status, data, numbers = mavlink.CAMERA_TRACKING_STATUS_FLAGS_IDLE, 0, [math.nan] * 7
        if self.state == State.LOST or (self.state is not None and self.is_stale):
            status = mavlink.CAMERA_TRACKING_STATUS_FLAGS_ERROR
        elif self.state is not None:
            status, data = mavlink.CAMERA_TRACKING_STATUS_FLAGS_ACTIVE, mavlink.CAMERA_TRACKING_TARGET_DATA_IN_STATUS
            status |= COASTING if self.state == State.UNCERTAIN else 0
            height, width = self.frame.shape[:2]
            left, top, right, bottom = (
                min(max(edge / side, 0), 1)
                for edge, side in zip((box.x, box.y, box.x + box.width, box.y + box.height), (width, height, width, height))
            )
            numbers = [(left + right) / 2, (top + bottom) / 2, (right - left) / 2, left, top, right, bottom]
        if clients is not None:
            self.connection.clients = {address for address, _ in due}
        try:
            self.connection.mav.camera_tracking_image_status_send(status, self.mode, data, *numbers)
        finally:
            if clients is not None:
                self.connection.clients = clients


def place(box):
    return ",".join(f"{round(number)}" for number in box)


def listed(numbers):
    return ",".join(f"{number:g}" for number in numbers)


def gone():
    raise ConnectionError("the peer has gone")


def connected(options, seconds=None):
    """Opens the connection; raises ValueError if that fails. `seconds` is the longest wait for a peer."""
    try:
        kind, *address = options.connection.split(":")
        if kind in ("udp", "udpin", "udpout", "udpbcast", "tcp", "tcpin") and len(address) == 2:
            if not (address[1].isdecimal() and 0 < int(address[1]) < 65536):
                raise ValueError("the port must be 1 to 65535")
            try:
                socket.gethostbyname(address[0])
            except OSError as error:
                raise ValueError(f"there is no host {address[0]}: {error}") from None
        socket.setdefaulttimeout(seconds)
        try:
            connection = mavutil.mavlink_connection(
                options.connection,
                baud=options.baud,
                source_system=options.system_id,
                source_component=options.component,
                dialect="common",
                retries=1,
            )
        finally:
            socket.setdefaulttimeout(None)
    except ImportError as error:
        raise ValueError(f"{options.connection}: there is no module {error.name}: pip install smr-tracker[mavlink]") from None
    except (OSError, ValueError) as error:
        expected = "expected udpout:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or a serial device"
        raise ValueError(f"cannot connect to {options.connection}: {error}: {expected}") from None
    # When the peer has gone, pymavlink only prints that and reads on. `gone` raises an error instead.
    connection.handle_eof = connection.handle_disconnect = gone
    connection.portdead = True
    return connection


class Source(threading.Thread):
    """Reads frames in a thread of its own, so that a stalled source does not stall the camera."""

    def __init__(self, recording, repeat):
        super().__init__(daemon=True)
        self.recording, self.repeat = recording, repeat
        self.frame, self.error, self.has_ended, self.is_wanted = None, None, False, True
        self.frames = None
        self.changed = threading.Condition()
        self.start()

    def run(self):
        try:
            while self.read() and self.repeat and not self.recording.is_live:
                pass
        except Exception as error:
            self.error = error
        with self.changed:
            self.has_ended = True
            self.changed.notify_all()

    def read(self):
        """Reads the recording once, to its end. Returns False if it has no frame, or none is wanted."""
        self.frames, frame = iter(self.recording), None
        for frame in self.frames:
            with self.changed:
                # The newest frame of a live source replaces an older one.
                self.changed.wait_for(lambda: self.frame is None or self.recording.is_live or not self.is_wanted)
                if not self.is_wanted:
                    return False
                self.frame = frame
                self.changed.notify_all()
        return frame is not None

    def take(self, seconds):
        """Returns the next frame; None if none arrives within `seconds`. Raises the error of the recording."""
        with self.changed:
            self.changed.wait_for(lambda: self.frame is not None or self.has_ended, seconds)
            frame, self.frame = self.frame, None
            self.changed.notify_all()
        if frame is None and self.error is not None:
            raise self.error
        return frame

    def is_over(self):
        with self.changed:
            return self.has_ended and self.frame is None and self.error is None

    def end(self):
        """Ends the thread. Returns False if it is still waiting for a frame."""
        with self.changed:
            self.is_wanted = False
            self.changed.notify_all()
        if self.frames is not None:
            self.frames.close()
        self.join(1)
        return not self.is_alive()


def serve(source, camera, rate, connect):
    """Passes all frames to the camera: of a recording `rate` per second, of a live source as they arrive. `connect` reconnects a lost peer."""
    due, tried = time.monotonic(), -math.inf
    if not source.recording.is_live:
        camera.patience = max(PATIENCE, 2 / rate)
    while not source.is_over():
        now, frame = time.monotonic(), None
        if source.recording.is_live or now >= due:
            frame = source.take(TICK)
        if connect and isinstance(camera.connection, Nobody) and now - tried >= RECONNECT:
            tried = now
            try:
                camera.connect(connect(RECONNECT / 2))
                say("connected again")
            except ValueError:
                pass
        try:
            if frame is None:
                camera.connection.select(min(TICK, max(due - now, 0)))
                camera.poll()
            else:
                due = max(due + 1 / rate, now - 1)  # After a pause it does not catch up for long.
                camera.show(frame)
        except OSError as error:
            own = camera.connection.mav
            say(f"frame {camera.number}: no connection: {error}; trying again each {RECONNECT:g} s")
            camera.connection.close()
            camera.connect(Nobody(own.srcSystem, own.srcComponent))
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


def stream(text):
    kind, _, address = text.partition("://")
    port = address.rpartition(":")[2]
    if kind not in STREAMS or not 0 < len(text.encode()) <= 160 or not address or (kind == "udp" and not port.isdecimal()):
        raise argparse.ArgumentTypeError(f"expected rtsp://HOST/PATH, udp://HOST:PORT or tcp://HOST:PORT of at most 160 bytes, found {text}")
    return text


def arguments():
    parser = argparse.ArgumentParser(prog="python -m smr.mavlink", description="A MAVLink camera that follows what it is asked to.")
    parser.add_argument("source", metavar="SOURCE", help="a camera such as /dev/video0, an address such as rtsp://HOST/PATH, or a recording")
    parser.add_argument("connection", metavar="CONNECTION", help="as pymavlink takes it: udpout:HOST:PORT, udpin:HOST:PORT, or a serial device")
    parser.add_argument("--preset", choices=PRESETS, default="refined", help="the tracker (%(default)s)")
    parser.add_argument("--system-id", metavar="N", type=number(1, 255), default=1, help="of the vehicle (%(default)s)")
    parser.add_argument("--component", metavar="N", type=number(1, 255), default=100, help="of this camera (%(default)s, the first camera)")
    parser.add_argument("--baud", metavar="N", type=number(1, 10_000_000), default=57600, help="of a serial device (%(default)s)")
    parser.add_argument("--rate", metavar="N", type=number(0.1, 1000, float), default=30.0, help="frames a second of a recording (%(default)g)")
    parser.add_argument("--stream-uri", metavar="URI", type=stream, help="where ground stations find the video: rtsp://, udp:// or tcp://")
    parser.add_argument("--repeat", action="store_true", help="begin a recording again when it ends")
    return parser.parse_args()


def run():
    """Runs the program; returns its exit code."""
    source = None
    try:
        options = arguments()
        recording = Recording(options.source)
        camera = Camera(connected(options), PRESETS[options.preset](options.preset), options.stream_uri)
        say(f"{recording.name}: camera {options.system_id}/{options.component} at {options.connection}; Ctrl-C ends it")
        source = Source(recording, options.repeat)
        serve(source, camera, options.rate, lambda seconds: connected(options, seconds))
        code = 0
    except KeyboardInterrupt:
        code = 130
    except (ValueError, OSError) as error:
        say(f"error: {error}")
        code = 2
    if source is not None and not source.end():
        os._exit(code)  # Python's end would break off the thread inside of the extension.
    return code


if __name__ == "__main__":
    sys.exit(run())
