"""`python -m smr.mavlink` with pymavlink as the ground station, over the loopback address."""

import math
import random
import socket
import subprocess
import sys
import threading
import time

import pytest
import smr
from conftest import followed, interrupted, refuses, run

pytest.importorskip("pymavlink", reason="skipped: MAVLink: no pymavlink")
from smr import mavlink as program  # noqa: E402
from smr.mavlink import Camera, connected, mavlink, mavutil  # noqa: E402

STATUS = "CAMERA_TRACKING_IMAGE_STATUS"
RECORDING = smr.Recording("synthetic")
FRAMES = list(RECORDING)
HEIGHT, WIDTH = FRAMES[0].shape
TRACK = mavlink.MAV_CMD_CAMERA_TRACK_RECTANGLE
POINT = mavlink.MAV_CMD_CAMERA_TRACK_POINT
STOP = mavlink.MAV_CMD_CAMERA_STOP_TRACKING
INTERVAL = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
REQUEST, GET = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_GET_MESSAGE_INTERVAL
ACCEPTED, DENIED, UNSUPPORTED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_UNSUPPORTED
OWN = (1, 100)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as held:
        held.bind(("127.0.0.1", 0))
        return held.getsockname()[1]


def parts(box):
    """A box in pixels as a rectangle of MAVLink."""
    x, y, width, height = box
    return x / WIDTH, y / HEIGHT, (x + width) / WIDTH, (y + height) / HEIGHT


class Station:
    """A ground station beside a camera in the same process: what one sends, the other has."""

    def __init__(self, camera, port, system):
        self.camera = camera
        self.link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=system, source_component=190, dialect="common")
        self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        camera.poll()

    def heard(self, kind):
        """All messages of this kind that have come."""
        found = []
        while self.link.select(0):
            message = self.link.recv_msg()
            found += [message] if message and message.get_type() == kind else []
        return found

    def ask(self, command, *parameters, to=OWN, confirmation=0):
        """The result that the camera gives, None if it says nothing. What else it says is in `after`."""
        self.link.mav.command_long_send(*to, command, confirmation, *parameters, *[0] * (7 - len(parameters)))
        self.camera.poll()
        answers, self.after = [], []
        while self.link.select(0):
            message = self.link.recv_msg()
            (answers if message.get_type() == "COMMAND_ACK" else self.after).append(message)
        assert len(answers) <= 1 and all(answer.command == command for answer in answers)
        assert all((answer.target_system, answer.target_component) == (self.link.source_system, 190) for answer in answers)
        return answers[0].result if answers else None


@pytest.fixture
def world():
    """A camera that looks at the first frame, and makers of ground stations."""
    port, links = free_port(), []
    options = type("", (), {"connection": f"udpin:127.0.0.1:{port}", "baud": 57600, "system_id": OWN[0], "component": OWN[1]})
    camera = Camera(connected(options), smr.Robust())
    camera.show(FRAMES[0])

    def station(system):
        links.append(Station(camera, port, system))
        return links[-1]

    yield camera, station
    for link in (camera.connection, *(one.link for one in links)):
        link.close()


def test_a_box_is_followed_lost_and_asked_for_again(world, capsys):
    camera, station = world
    one, other = station(255), station(254)
    assert one.ask(TRACK, *parts(RECORDING.start)) == ACCEPTED
    assert [message.get_type() for message in one.after] == [STATUS]
    other.heard(STATUS)
    for frame, truth, answer in zip(FRAMES[1:], RECORDING.truth[1:], followed(smr.Robust(), FRAMES[:80], RECORDING.start)):
        camera.show(frame)
        # Both ground stations get each status, even the one that has requested nothing.
        (status,), (same,) = one.heard(STATUS), other.heard(STATUS)
        assert status.get_msgbuf() == same.get_msgbuf() and (status.get_srcSystem(), status.get_srcComponent()) == OWN
        assert status.tracking_status == mavlink.CAMERA_TRACKING_STATUS_FLAGS_ACTIVE
        assert status.tracking_mode == mavlink.CAMERA_TRACKING_MODE_RECTANGLE
        assert status.target_data == mavlink.CAMERA_TRACKING_TARGET_DATA_IN_STATUS
        found = (status.rec_top_x, status.rec_top_y, status.rec_bottom_x, status.rec_bottom_y)
        assert found == pytest.approx(parts(answer.fine_box), abs=1e-6)
        assert truth is None or found == pytest.approx(parts(truth), abs=0.05)
    for _ in range(20):
        camera.show(FRAMES[0] * 0)  # The lens is covered.
    status = one.heard(STATUS)[-1]
    assert (status.tracking_status, status.target_data) == (mavlink.CAMERA_TRACKING_STATUS_FLAGS_ERROR, 0)
    assert all(map(math.isnan, (status.rec_top_x, status.rec_bottom_y, status.point_x, status.radius)))
    for frame in FRAMES[80:100]:
        camera.show(frame)
    assert one.heard(STATUS)[-1].tracking_status == mavlink.CAMERA_TRACKING_STATUS_FLAGS_ACTIVE
    for _ in range(20):
        camera.show(FRAMES[0] * 0)
    # The other ground station selects the target again, by a point, and later sends the command to stop tracking.
    camera.show(FRAMES[0])
    x, y, width, height = RECORDING.start
    other.heard(STATUS)
    assert other.ask(POINT, (x + width / 2) / WIDTH, (y + height / 2) / HEIGHT, 0.07) == ACCEPTED
    camera.show(FRAMES[1])
    status = one.heard(STATUS)[-1]
    assert (status.tracking_status, status.tracking_mode) == (1, mavlink.CAMERA_TRACKING_MODE_POINT)
    assert (status.point_x * WIDTH, status.point_y * HEIGHT) == pytest.approx((x + width / 2, y + height / 2), abs=4)
    assert status.radius == pytest.approx(0.07, abs=0.02)
    assert other.ask(STOP) == ACCEPTED
    assert one.heard(STATUS)[-1].tracking_status == mavlink.CAMERA_TRACKING_STATUS_FLAGS_IDLE
    camera.show(FRAMES[2])
    assert one.heard(STATUS) == []
    said = capsys.readouterr().err.splitlines()
    assert [line.split(": ")[1].split(" ")[0] for line in said] == ["following", "lost", "found", "lost", "following", "stopped"]
    assert said[0] == f"frame 1: following {program.place(RECORDING.start)}"


def test_it_says_what_it_can(world):
    one = world[1](255)
    for command in [(REQUEST, 259), (mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION, 1)]:
        assert one.ask(*command) == ACCEPTED
        (information,) = one.after
        assert information.get_type() == "CAMERA_INFORMATION"
        assert (information.resolution_h, information.resolution_v) == (WIDTH, HEIGHT)
        assert information.flags == 512 | 1024
        assert bytes(information.vendor_name).rstrip(b"\0") == b"smr"
    camera = world[0]
    assert camera.connection.mav.srcComponent == mavlink.MAV_COMP_ID_CAMERA
    camera.beaten = -math.inf
    camera.poll()
    camera.poll()
    (heartbeat,) = one.heard("HEARTBEAT")
    assert (heartbeat.type, heartbeat.autopilot) == (mavlink.MAV_TYPE_CAMERA, mavlink.MAV_AUTOPILOT_INVALID)
    camera.begun -= 2**32 / 1000  # The time wraps.
    assert one.ask(REQUEST, 259) == ACCEPTED and one.after[0].time_boot_ms < 60_000
    # Before the first frame the camera rejects commands temporarily.
    camera.frame = None
    for command in [(TRACK, *parts(RECORDING.start)), (POINT, 0.5, 0.5), (REQUEST, 259)]:
        assert one.ask(*command) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    assert one.ask(STOP) == ACCEPTED


NAN, INF = float("nan"), float("inf")


def test_nonsense_is_refused_and_changes_nothing(world):
    camera, station = world
    one = station(255)
    assert one.ask(TRACK, *parts(RECORDING.start)) == ACCEPTED
    saved = camera.tracker.save()
    for result, commands in {
        DENIED: [
            (TRACK,), (TRACK, NAN, 0.1, 0.2, 0.2), (TRACK, 0.1, 0.1, INF, 0.2), (TRACK, 0.2, 0.1, 0.1, 0.2), (TRACK, -0.1, 0.1, 0.2, 0.2),
            (TRACK, 0.9, 0.9, 1.1, 1.1), (TRACK, 0.5, 0.5, 0.50001, 0.50001), (POINT, 1.5, 0.5), (POINT, NAN, 0.5), (POINT, 0.5, 0.5, -1),
            (INTERVAL, 275, NAN), (INTERVAL, 275, -2),
        ],
        # Message 269 (VIDEO_STREAM_INFORMATION) requires --stream-uri.
        UNSUPPORTED: [
            (INTERVAL, 30, 1000), (REQUEST, 30), (REQUEST, NAN), (REQUEST, 269), (REQUEST, 244, NAN), (GET, -1),
            (mavlink.MAV_CMD_IMAGE_START_CAPTURE,), (65535,),
        ],
    }.items():  # fmt: skip
        assert [one.ask(*command) for command in commands] == [result] * len(commands)
    for other in [(1, 101), (2, 100), (1, 1), (0, 101), (2, 0)]:
        assert one.ask(TRACK, 0.1, 0.1, 0.2, 0.2, to=other) is None
    pick = random.Random(46)
    for length in (1, 7, 60, 280, 280, 280):
        for first in (b"\xfd", b"\xfe", b""):
            one.link.write(first + pick.randbytes(length))
    camera.poll()
    assert camera.tracker.save() == saved
    assert one.ask(STOP) == ACCEPTED  # Also by the other message that commands come in:
    one.link.mav.command_int_send(*OWN, 0, TRACK, 0, 0, *parts(RECORDING.start), 0, 0, 0)
    camera.poll()
    assert [answer.result for answer in one.heard("COMMAND_ACK")] == [ACCEPTED] and camera.state == smr.State.TRACKING


def test_what_is_sent_again_is_answered_again_and_acts_once(world, capsys):
    camera, station = world
    one, other = station(255), station(254)
    box, second = parts(RECORDING.start), (0.1, 0.1, 0.3, 0.3)

    def acts(sender, command, *parameters, **more):
        """The result, and whether the camera has done something."""
        capsys.readouterr()
        sender.heard(None)
        result = sender.ask(command, *parameters, **more)
        return result, capsys.readouterr().err != ""

    # The acknowledgement is lost, and the target has moved on.
    assert acts(one, TRACK, *box) == (ACCEPTED, True)
    for frame in FRAMES[1:6]:
        camera.show(frame)
    followed = camera.tracker.save()
    one.heard(STATUS)
    for confirmation in (1, 2, 255):
        assert acts(one, TRACK, *box, confirmation=confirmation) == (ACCEPTED, False)
        assert one.after == [] and camera.tracker.save() == followed
    # Other commands were sent meanwhile, even a newer one of this kind.
    assert one.ask(REQUEST, 259) == ACCEPTED
    assert acts(one, TRACK, *second) == (ACCEPTED, True)
    assert acts(one, TRACK, *box, confirmation=1) == (ACCEPTED, False)
    assert acts(one, STOP) == (ACCEPTED, True)
    assert acts(one, TRACK, *second, confirmation=3) == (ACCEPTED, False) and camera.state is None
    # A first transmission acts, with equal and with other parameters; so does a confirmation of what never came.
    assert acts(one, TRACK, *second) == (ACCEPTED, True)
    assert acts(one, TRACK, *second) == (ACCEPTED, True)
    assert acts(one, TRACK, 0.2, 0.1, 0.4, 0.3, confirmation=1) == (ACCEPTED, True)
    assert acts(one, TRACK, 0.2, 0.1, 0.4, 0.3, confirmation=2) == (ACCEPTED, False)
    assert acts(one, POINT, 0.5, 0.5, 0.1) == (ACCEPTED, True)
    assert acts(one, POINT, 0.5, 0.5, NAN, confirmation=1) == (ACCEPTED, True)
    assert acts(one, POINT, 0.5, 0.5, NAN, confirmation=2) == (ACCEPTED, False)
    # Another sender is another one, also at the same address.
    assert acts(other, POINT, 0.5, 0.5, 0.1, confirmation=1) == (ACCEPTED, True)
    one.heard(None)
    one.link.mav.srcComponent = 191
    one.link.mav.command_long_send(*OWN, POINT, 1, 0.5, 0.5, 0.1, 0, 0, 0, 0)
    camera.poll()
    (answer,) = one.heard("COMMAND_ACK")
    assert (answer.target_system, answer.target_component, answer.result) == (255, 191, ACCEPTED)
    assert "following" in capsys.readouterr().err
    one.link.mav.srcComponent = 190
    # A refused command is refused again, and said once. A request is answered each time, since its answer may be lost.
    assert acts(one, TRACK, 0.2, 0.1, 0.1, 0.2) == (DENIED, True)
    assert acts(one, TRACK, 0.2, 0.1, 0.1, 0.2, confirmation=1) == (DENIED, False)
    assert one.ask(REQUEST, 259, confirmation=1) == ACCEPTED and one.after[0].get_type() == "CAMERA_INFORMATION"
    # A temporarily rejected command is tried again.
    frame, camera.frame = camera.frame, None
    assert acts(one, TRACK, 0.3, 0.1, 0.5, 0.3) == (mavlink.MAV_RESULT_TEMPORARILY_REJECTED, False)
    camera.frame = frame
    assert acts(one, TRACK, 0.3, 0.1, 0.5, 0.3, confirmation=1) == (ACCEPTED, True)
    # An interval that was set anew stays.
    assert one.ask(INTERVAL, 275, -1) == one.ask(INTERVAL, 275, 0) == one.ask(INTERVAL, 275, -1, confirmation=1) == ACCEPTED
    assert one.ask(GET, 275) == ACCEPTED and one.after[0].interval_us >= 0


def test_a_packet_that_comes_twice_acts_once(world, capsys):
    camera, station = world
    one = station(255)
    commands = (
        mavlink.MAVLink_command_long_message(*OWN, TRACK, 0, *parts(RECORDING.start), 0, 0, 0),
        mavlink.MAVLink_command_int_message(*OWN, 0, TRACK, 0, 0, *parts(RECORDING.start), 0, 0, 0),
    )
    for command in commands:
        packet = command.pack(one.link.mav)
        one.link.write(packet)
        one.link.write(packet)
        camera.poll()
        assert [answer.result for answer in one.heard("COMMAND_ACK")] == [ACCEPTED] * 2
        assert capsys.readouterr().err.count("following") == 1
        # Long after, a packet of this number is another one.
        (receiver,) = camera.receivers.values()
        receiver.results = {key: (result, packet, -math.inf) for key, (result, packet, _) in receiver.results.items()}
        one.link.write(packet)
        camera.poll()
        assert [answer.result for answer in one.heard("COMMAND_ACK")] == [ACCEPTED]
        assert capsys.readouterr().err.count("following") == 1


def test_the_memory_of_commands_is_bounded(world):
    camera, station = world
    one = station(255)
    for number in range(200):
        assert one.ask(TRACK, 0.1, 0.1, 0.3 + number / 1000, 0.3) == ACCEPTED
    (receiver,) = camera.receivers.values()
    assert len(receiver.results) == program.MAX_COMMANDS
    for number in range(150):
        one.link.mav.srcSystem = 1 + number
        one.link.mav.command_long_send(*OWN, STOP, 0, 0, 0, 0, 0, 0, 0, 0)
        one.link.mav.srcSystem = 255  # It stays among those that sent last.
        one.link.mav.command_long_send(*OWN, STOP, 0, 0, 0, 0, 0, 0, 0, 0)
        camera.poll()
    assert len(camera.receivers) == program.MAX_RECEIVERS and receiver in camera.receivers.values()


def test_the_interval_is_that_which_was_asked_for(world):
    camera, station = world
    one = station(255)
    assert one.ask(TRACK, *parts(RECORDING.start)) == ACCEPTED
    for microseconds, count in [(-1, 0), (1e9, 0), (0, 9)]:
        assert one.ask(INTERVAL, 275, microseconds) == ACCEPTED
        for frame in FRAMES[1:10]:
            camera.show(frame)
        assert len(one.heard(STATUS)) == count
        for command in [(GET, 275), (REQUEST, 244, 275)]:
            assert one.ask(*command) == ACCEPTED
            (told,) = one.after
            assert told.get_type() == "MESSAGE_INTERVAL" and told.message_id == 275
            assert told.interval_us == {-1: -1, 1e9: 1e9}.get(microseconds, round(1e6 * camera.period))
        assert one.ask(REQUEST, 275) == ACCEPTED and [message.get_type() for message in one.after] == [STATUS]
    for message, interval in [(0, 1e6), (33, 0)]:
        assert one.ask(GET, message) == ACCEPTED and one.after[0].interval_us == interval


@pytest.mark.parametrize("uri, kind, sent", [
    ("rtsp://10.0.0.2:8554/cam", 0, b"rtsp://10.0.0.2:8554/cam"), ("udp://10.0.0.1:5600", 1, b"5600"), ("tcp://10.0.0.2:7000", 2, b"tcp://10.0.0.2:7000"),
])  # fmt: skip
def test_it_says_where_the_video_is(world, uri, kind, sent):
    camera, station = world
    camera.stream = program.stream(uri)
    camera.show(FRAMES[1])
    one = station(255)
    for command in [(REQUEST, 269, 0), (REQUEST, 269, 1), (mavlink.MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION, 1)]:
        assert one.ask(*command) == ACCEPTED
        (about,) = one.after
        assert (about.stream_id, about.count, about.type, about.flags, about.uri.encode()) == (1, 1, kind, 1, sent)
        assert (about.resolution_h, about.resolution_v, about.framerate) == (WIDTH, HEIGHT, pytest.approx(1 / camera.period))
    assert one.ask(REQUEST, 269, 2) == UNSUPPORTED
    assert one.ask(REQUEST, 259) == ACCEPTED and one.after[0].flags == 256 | 512 | 1024


def test_an_uncertain_target_has_a_place_and_coasts(world):
    camera, station = world
    one, box = station(255), smr.Box(10, 10, 20, 20)
    assert one.ask(TRACK, *parts(box)) == ACCEPTED
    for state, flags in {smr.State.TRACKING: 1, smr.State.LEAVING: 1, smr.State.UNCERTAIN: 1 | 8, smr.State.LOST: 2}.items():
        answer = smr.Answer(box, smr.FineBox(*box), state, 0.5, 0.5, None, None, None, 1.0, False)
        camera.tracker = type("", (), {"follow": lambda _self, _frame: answer})()
        camera.show(FRAMES[1])
        (status,) = one.heard(STATUS)
        assert status.tracking_status == flags and math.isnan(status.rec_top_x) == (state == smr.State.LOST)


def test_what_is_asked_of_all_is_asked_of_the_camera(world):
    one = world[1](255)
    for to in [(1, 0), (0, 100), (0, 0)]:
        assert one.ask(TRACK, *parts(RECORDING.start), to=to) == ACCEPTED
        assert one.ask(REQUEST, 259, to=to) == ACCEPTED and one.after[0].get_type() == "CAMERA_INFORMATION"
        assert one.ask(TRACK, 0.2, 0.1, 0.1, 0.2, to=to) == DENIED
        # The camera does not answer an unknown command to all systems or all components: another component may know it.
        assert one.ask(mavlink.MAV_CMD_IMAGE_START_CAPTURE, to=to) is None
        assert one.ask(STOP, to=to) == ACCEPTED


def test_each_receiver_has_its_own_interval(world):
    camera, station = world
    never, some, silent = station(255), station(254), station(253)
    assert never.ask(TRACK, *parts(RECORDING.start)) == ACCEPTED
    assert never.ask(INTERVAL, 275, -1) == ACCEPTED
    some.heard(STATUS)
    assert some.ask(INTERVAL, 275, 1e9) == ACCEPTED
    for one in (never, some, silent):
        one.heard(STATUS)
    for frame in FRAMES[1:10]:
        camera.show(frame)
    assert [len(one.heard(STATUS)) for one in (never, some, silent)] == [0, 1, 9]
    # On a shared connection, the status is sent if it is due for any receiver.
    camera.receivers = {(None, number, 190): program.Receiver() for number in (1, 2)}
    for interval, count in [(math.inf, 0), (0, 3)]:
        camera.receivers[None, 1, 190].interval, camera.receivers[None, 2, 190].interval = interval, math.inf
        camera.connection, sent = program.Nobody(*OWN), []
        camera.connection.write = sent.append
        for frame in FRAMES[10:13]:
            camera.show(frame)
        assert len([message for message in sent if message[7] | message[8] << 8 == 275]) == count
    camera.connection = silent.link


class Stalled:
    """A live source that stops sending after two frames."""

    is_live = True

    def __init__(self):
        self.goes_on = threading.Event()

    def __iter__(self):
        yield from FRAMES[:2]
        self.goes_on.wait(60)


def test_without_frames_it_answers_and_has_no_place(world, capsys):
    camera, station = world
    one, recording = station(255), Stalled()
    source = program.Source(recording, False)
    serving = threading.Thread(target=program.serve, args=(source, camera, 30, None))
    serving.start()

    def heard(wanted):
        until = time.monotonic() + 10
        while time.monotonic() < until:
            message = one.link.recv_match(blocking=True, timeout=1)
            if message and wanted(message):
                return message
        raise AssertionError("not heard")

    one.link.mav.command_long_send(*OWN, TRACK, 0, *parts(RECORDING.start), 0, 0, 0)
    assert heard(lambda message: message.get_type() == "COMMAND_ACK").result == ACCEPTED
    for _ in range(2):
        status = heard(lambda message: message.get_type() == STATUS and message.tracking_status != 1)
        assert (status.tracking_status, status.target_data) == (mavlink.CAMERA_TRACKING_STATUS_FLAGS_ERROR, 0)
        heard(lambda message: message.get_type() == "HEARTBEAT")
    one.link.mav.command_long_send(*OWN, REQUEST, 0, 259, 0, 0, 0, 0, 0, 0)
    heard(lambda message: message.get_type() == "CAMERA_INFORMATION")
    # The status is also ERROR after a target is selected while no new frames arrive.
    one.link.mav.command_long_send(*OWN, TRACK, 0, *parts(RECORDING.start), 0, 0, 0)
    heard(lambda message: message.get_type() == "COMMAND_ACK" and message.command == TRACK)
    assert heard(lambda message: message.get_type() == STATUS).tracking_status == mavlink.CAMERA_TRACKING_STATUS_FLAGS_ERROR
    recording.goes_on.set()
    serving.join(10)
    assert not serving.is_alive() and source.end()
    assert capsys.readouterr().err.splitlines()[1:2] == [f"frame {camera.number}: no new frame for 1 s"]
    camera.show(FRAMES[2])
    assert one.heard(STATUS)[-1].tracking_status == mavlink.CAMERA_TRACKING_STATUS_FLAGS_ACTIVE


def test_a_peer_that_goes_is_connected_again():
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(30)
        command = [sys.executable, "-m", "smr.mavlink", "synthetic", f"tcp:127.0.0.1:{server.getsockname()[1]}", "--repeat"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            for end in (bool, bool, running.terminate):
                with server.accept()[0] as peer:
                    assert peer.recv(300)
                    end()
            assert running.stdout.read() == ""
            said = running.stderr.read().splitlines()
    assert len(said) <= 6 and "the peer has gone; trying again" in said[1] and said[2] == "connected again"


def test_the_program_sends_until_the_recording_ends():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground:
        ground.bind(("127.0.0.1", 0))
        port = ground.getsockname()[1]
        ran = run("smr.mavlink", "border", f"udpout:127.0.0.1:{port}", "--rate", "1000", "--preset", "camera", "--system-id", "7", "--component", "101")
        assert (ran.returncode, ran.stdout) == (0, "")
        assert ran.stderr == f"border: camera 7/101 at udpout:127.0.0.1:{port}; Ctrl-C ends it\n"
        assert mavlink.MAVLink(None).parse_char(ground.recv(300)).get_type() == "HEARTBEAT"


@pytest.mark.parametrize("arguments, reason", [
    (["/no/such.mp4", "udpout:127.0.0.1:1"], "cannot open /no/such.mp4: "),
    (["synthetic", "udpout:nowhere"], "cannot connect to udpout:nowhere: "),
    (["synthetic", "/dev/no-such-port"], "cannot connect to /dev/no-such-port: "),
    (["synthetic", "udpout:no-such-host.invalid:14550"], "cannot connect to udpout:no-such-host.invalid:14550: there is no host no-such-host.invalid: "),
    (["synthetic", "tcp:no-such-host.invalid:5760"], "cannot connect to tcp:no-such-host.invalid:5760: there is no host no-such-host.invalid: "),
    (["synthetic", "udpout:127.0.0.1:70000"], "cannot connect to udpout:127.0.0.1:70000: the port must be 1 to 65535"),
])  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_2(arguments, reason):
    refuses(["smr.mavlink", *arguments], reason)


def test_without_pymavlink_it_says_what_to_install(tmp_path):
    (tmp_path / "pymavlink.py").write_text("raise ImportError\n")
    command = ["smr.mavlink", "synthetic", "udpout:127.0.0.1:1"]
    refuses(command, "there is no module pymavlink: pip install smr-tracker[mavlink]\n", PYTHONPATH=str(tmp_path))


def test_an_interrupt_ends_it_quietly():
    def wait(running):
        assert "Ctrl-C ends it" in running.stderr.readline()

    assert interrupted(wait, "smr.mavlink", "synthetic", "udpout:127.0.0.1:1", "--repeat") == (130, "", "")
