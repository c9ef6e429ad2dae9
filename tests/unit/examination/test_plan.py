"""Examinations of the project's own robots, in virtual time, at every rate, in every condition they may be in."""

from __future__ import annotations

import random
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.unit.examination.wires import Echo, Line, Talker
from turtlewire.errors import LinkClosedError
from turtlewire.examination import BAUDS, Findings, Listening, Wanted, examination
from turtlewire.examination.findings import CarFacts, FrameFacts, WalterFacts
from turtlewire.examination.listening import is_text
from turtlewire.examination.probes import FLUSH, LOGO_PROBE, MILD_PROBE, logo_probe, pause_s
from turtlewire.examination.steps import Exchange, Heard, Tell, Tune, WayOut
from turtlewire.links.uart import RECEIVERS, Receiver
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.dialect import SHIPPED, Dialect, read_dialect, shipped
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.walter import Settings, SimulatedWalter
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from turtlewire.examination.steps import Step

ALL = frozenset({"walter", "simple", "frame"})
DIALECTS = {name: shipped(name) for name in SHIPPED}
TELEMETRY = DIALECTS["telemetry"]
EVERYTHING = Wanted(BAUDS, ALL, DIALECTS)
STOP = b"S000000"
every_rate = pytest.mark.parametrize("baud", BAUDS)
every_receiver = pytest.mark.parametrize("receiver", RECEIVERS)


def examined(line: Line, wanted: Wanted = EVERYTHING) -> Findings:
    found = line.examine(examination(wanted))
    assert isinstance(found, Findings)
    return found


def watched(robot: Any) -> list[str]:
    """What a robot does, as it does it."""
    actions: list[str] = []
    robot.events = lambda action: actions.append(action.what)
    return actions


# ---------------------------------------------------------------- each robot, at each rate


@every_rate
@every_receiver
def test_a_car(baud: int, receiver: Receiver) -> None:
    car = SimulatedCar(CarSettings(baud=baud))
    actions = watched(car)
    line = Line(car, baud, receiver)
    found = examined(line)
    assert (found.protocol, found.baud, found.likelihood) == ("simple", baud, 1.0)
    assert found.facts == CarFacts(window=8)
    assert found.round_trip is not None
    assert found.round_trip.times == 20
    assert found.round_trip.median_s == pytest.approx(8 * 10 / baud)
    assert set(actions) == {"stop"}
    assert car.pose == HOME
    assert [at.baud for at in found.rates] == list(BAUDS[: BAUDS.index(baud) + 1])
    # It is left in step, and stopped last of all: 14 times S is two stops.
    assert line.sent[-1] == (baud, b"S" * 14)
    assert car._end.pending == b""


@every_rate
@every_receiver
def test_a_walter(baud: int, receiver: Receiver) -> None:
    robot = SimulatedWalter(Settings(baud=baud, start=Pose(10.0, 20.0, 90.0)))
    actions = watched(robot)
    line = Line(robot, baud, receiver)
    found = examined(line)
    assert (found.protocol, found.baud, found.likelihood) == ("walter", baud, 1.0)
    facts = found.facts
    assert isinstance(facts, WalterFacts)
    assert facts.answered == ("pen", "heading", "location", "x", "y", "towards")
    assert facts.unanswered == ()
    assert (facts.pose, facts.is_pen_down) == (HOME, False)  # by its odometer
    assert found.round_trip is not None
    # QP and QH by turns: 3 bytes there, 4 or 5 back.
    assert found.round_trip.median_s == pytest.approx(7.5 * 10 / baud)
    assert actions == []
    assert (baud, m.ATTENTION) in line.sent
    assert line.sent[-1] == (baud, m.EMERGENCY_STOP)
    assert (robot.mode, robot.is_moving) == (Mode.DIRECT, False)


@pytest.mark.parametrize("baud", [9600, 19200, 115200, 1000000])
def test_a_frame_robot_that_talks(baud: int) -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(baud=baud, dialect=TELEMETRY))
    line = Line(robot, baud)
    found = examined(line)
    assert (found.protocol, found.baud) == ("frame", baud)
    assert found.likelihood > 0.999
    facts = found.facts
    assert isinstance(facts, FrameFacts)
    assert (facts.crc, facts.coverage, facts.dialect) == ("CRC-8/SMBUS", "magic", "telemetry")
    assert set(facts.messages) == {"odometry", "status", "distance"}
    assert facts.is_dialects_crc
    assert not facts.ignored
    assert found.round_trip is None
    assert robot.pose == HOME
    # F13
    assert len(line.sent[-1][1]) >= 128
    assert robot._end.heard > 2


def test_at_the_first_rate_nothing_is_sent_to_what_talks() -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(baud=9600, dialect=TELEMETRY))
    assert examined(Line(robot, 9600)).bytes_sent == 0


# ---------------------------------------------------------------- in any condition


@pytest.mark.parametrize("groups", ["", "CQHE", "Q", "CHE"])
@pytest.mark.parametrize("mode", Mode)
def test_a_walter_in_either_mode_with_any_groups(groups: str, mode: Mode) -> None:
    robot = SimulatedWalter(Settings(groups=frozenset(groups), mode=mode))
    actions = watched(robot)
    found = examined(Line(robot, 9600))
    assert found.protocol == ("walter" if "Q" in groups else "")
    assert actions == []
    assert robot.odometer == HOME


def test_above_115200_a_walter_is_found_in_logo_control_only() -> None:
    robot = SimulatedWalter(Settings(baud=230400, mode=Mode.DIRECT))
    assert examined(Line(robot, 230400)).protocol == ""
    assert robot.mode is Mode.DIRECT


@pytest.mark.parametrize(
    "left",
    [b"F\xff\xff\r", b"F\xff\xff\rR\x03\xe8\r", b"2\rA", b"2\rZ", b"2\r,", b"2\r.", b"2\rAG", b"F\x00"],
    ids=repr,
)
def test_a_walter_that_an_earlier_host_has_left_moving_is_stopped(left: bytes) -> None:
    robot = SimulatedWalter()
    robot.write(left)
    while robot.now < 0.1:
        robot.read(0.1)
    actions = watched(robot)
    found = examined(Line(robot, 9600))
    assert found.protocol == "walter"
    assert not robot.is_moving
    assert all(action.startswith("stopped") for action in actions)


@pytest.mark.parametrize("pending", range(7))
def test_a_car_that_an_earlier_host_has_left_out_of_step_and_driving_is_stopped(pending: int) -> None:
    car = SimulatedCar()
    car.write(b"F200000" + b"B12x000"[:pending])
    while car.now < 0.1:
        car.read(0.1)
    assert car.drive == 200
    actions = watched(car)
    found = examined(Line(car, 9600))
    assert found.protocol == "simple"
    assert (car.drive, car.steer) == (0, 0)
    assert set(actions) == {"stop"}


def test_what_an_earlier_host_has_said_in_full_is_carried_out_and_stopped() -> None:
    # S7's own limit, and the only one: three positions are missing, at which anything will do.
    car = SimulatedCar()
    car.write(b"F200")
    while car.now < 0.1:
        car.read(0.1)
    actions = watched(car)
    found = examined(Line(car, 9600))
    assert found.protocol == "simple"
    assert actions[0] == "drive_forward speed=200"
    assert set(actions[1:]) == {"stop"}
    assert car.drive == 0


@pytest.mark.parametrize("boot_s", [0.3, 1.0, 1.7, 2.4])
@pytest.mark.parametrize("protocol", ["simple", "walter"])
def test_a_robot_that_boots_is_tried_again(protocol: str, boot_s: float) -> None:
    robot: Any = (
        SimulatedCar(CarSettings(boot_s=boot_s))
        if protocol == "simple"
        else SimulatedWalter(Settings(boot_s=boot_s))
    )
    actions = watched(robot)
    found = examined(Line(robot, 9600))
    assert (found.protocol, found.baud) == (protocol, 9600)
    assert found.first_answer_s is not None
    assert boot_s < found.first_answer_s < boot_s + 1.2
    assert len(found.rates) == 1
    assert set(actions) <= {"stop"}


def test_a_robot_that_boots_longer_is_found_if_one_says_so() -> None:
    def robot() -> Line:
        return Line(SimulatedCar(CarSettings(boot_s=7.0)), 9600)

    assert examined(robot()).protocol == ""
    patient = examined(robot(), EVERYTHING._replace(boot_s=8.0))
    assert patient.protocol == "simple"
    assert patient.attempts > 4


def test_what_talks_has_booted() -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(dialect=TELEMETRY))
    found = examined(Line(robot, 115200), EVERYTHING._replace(boot_s=60.0))
    assert (found.protocol, found.attempts) == ("frame", 2)


def test_the_boot_is_waited_for_once() -> None:
    found = examined(Line(Talker(), None))
    assert found.protocol == ""
    assert found.seconds < EVERYTHING.boot_s + 1.3 + 1.2 * (len(BAUDS) - 1)


def test_a_link_without_a_rate() -> None:
    wanted = EVERYTHING._replace(bauds=(None,))
    for robot, protocol in ((SimulatedCar(), "simple"), (SimulatedWalter(), "walter")):
        found = examined(Line(robot, None), wanted)
        assert (found.protocol, found.baud) == (protocol, None)
    telemetry = SimulatedFrameRobot(FrameRobotSettings(dialect=TELEMETRY))
    assert examined(Line(telemetry, None), wanted).protocol == "frame"
    assert examined(Line(Talker(), None), wanted).protocol == ""


# ---------------------------------------------------------------- what is no robot


def test_nothing_at_all() -> None:
    silent = Talker()
    found = examined(Line(silent, None))
    assert (found.protocol, found.strange, found.likelihood) == ("", "", 0.0)
    assert [at.baud for at in found.rates] == list(BAUDS)
    assert {at.what for at in found.rates} == {"silence"}


@every_rate
def test_text_tells_its_rate_and_ends_the_search(baud: int) -> None:
    found = examined(Line(Talker(b"temperature 21.5 degrees\r\n", every_s=0.2), baud))
    assert (found.protocol, found.baud) == ("", baud)
    assert found.strange == f"something writes text at {baud} baud: 'temperature 21.5 degrees'"
    # Whatever else is there has the same rate: that one is probed, and no other after it.
    assert found.rates[-1].baud == baud
    assert "text: 'temperature 21.5 degrees'" in [at.what for at in found.rates if at.baud == baud]


def test_a_robot_that_writes_text_at_its_boot_is_found() -> None:
    class Chatty(SimulatedCar):
        said = False

        def read(self, until: float) -> bytes:
            if self.now >= 0.1 and not self.said:
                self.said = True
                return b"Hello, this is car 7, ready when you are\r\n"
            return super().read(min(until, 0.1) if not self.said else until)

    found = examined(Line(Chatty(CarSettings(boot_s=0.5)), 9600))
    assert found.protocol == "simple"


def test_an_echo() -> None:
    found = examined(Line(Echo(), None))
    assert found.protocol == ""
    assert found.strange.startswith("what is sent comes back as it is")
    assert found.baud is None
    assert found.bytes_sent == len(FLUSH)


def test_a_host() -> None:
    says = b"".join(map(encode, (m.Forward(200), m.Right(90), m.QueryHeading(), m.Back(7), m.QueryX())))
    found = examined(Line(Talker(says), 9600))
    assert found.protocol == ""
    assert "what talks there at 9600 baud is a host that speaks walter" in found.strange


def test_a_host_of_frame() -> None:
    encoder = FrameEncoder(DIALECTS["0.1"])
    moves = [DIALECTS["0.1"].parse(f"engine_forward {n % 2} {n}") for n in range(40)]
    found = examined(Line(Talker(b"".join(encoder.encode([move])[0] for move in moves)), 115200))
    assert found.protocol == ""
    # At other rates it looks like other things.
    assert "what talks there at 115200 baud is a host that speaks frame" in found.strange


def test_noise_is_nothing() -> None:
    chance = random.Random(7)

    class Noise(Talker):
        def read(self, until: float) -> bytes:
            return chance.randbytes(len(super().read(until)))

    found = examined(Line(Noise(bytes(20)), None))
    assert (found.protocol, found.strange) == ("", "")
    assert all(at.what.startswith("something talks") for at in found.rates)


def test_a_rate_that_the_port_does_not_have_is_left_out() -> None:
    line = Line(SimulatedCar(CarSettings(baud=115200)), 115200)
    line.refused = {9600, 57600}
    found = examined(line)
    assert (found.protocol, found.baud) == ("simple", 115200)
    assert [(at.baud, at.what) for at in found.rates] == [(9600, "no 9600"), (115200, "simple")]
    line = Line(Talker(), 115200)
    line.refused = set(BAUDS)
    found = examined(line)
    assert found.protocol == ""
    assert found.bytes_sent == 0


# ---------------------------------------------------------------- only what is wanted


def test_frame_alone_is_only_listened_to() -> None:
    line = Line(SimulatedCar(), 9600)
    found = examined(line, EVERYTHING._replace(protocols=frozenset({"frame"})))
    assert found.protocol == ""
    assert line.sent == []


@pytest.mark.parametrize(("protocol", "other"), [("simple", "walter"), ("walter", "simple")])
def test_one_protocol_alone(protocol: str, other: str) -> None:
    robots: dict[str, Any] = {"simple": SimulatedCar, "walter": SimulatedWalter}
    wanted = EVERYTHING._replace(protocols=frozenset({protocol}), bauds=(9600, 19200))
    assert examined(Line(robots[protocol](), 9600), wanted).protocol == protocol
    line = Line(robots[other](), 9600)
    assert examined(line, wanted).protocol == ""
    if protocol == "simple":
        assert {byte for _, data in line.sent for byte in data} == {0x00, 0xFF}


# ---------------------------------------------------------------- dialects

OWN = (Path(__file__).parents[3] / "src/turtlewire/protocols/frame/dialects/telemetry.toml").read_text(
    "utf-8"
)


def own_dialect() -> Dialect:
    """As telemetry, with another CRC, and a status of another type."""
    text = OWN.replace('dialect = "telemetry"', 'dialect = "mine"').replace("CRC-8/SMBUS", "CRC-8/MAXIM-DOW")
    return read_dialect(text.replace('type = 0x11\ndirection = "from', 'type = 0x77\ndirection = "from'))


def test_a_dialect_of_ones_own() -> None:
    mine = own_dialect()
    robot = SimulatedFrameRobot(FrameRobotSettings(dialect=mine))
    wanted = EVERYTHING._replace(dialects={"mine.toml": mine, **DIALECTS}, bauds=(115200,))
    facts = examined(Line(robot, 115200), wanted).facts
    assert isinstance(facts, FrameFacts)
    assert (facts.dialect, facts.crc, facts.is_dialects_crc) == ("mine.toml", "CRC-8/MAXIM-DOW", True)
    assert "status" in facts.messages


def test_a_dialect_that_fits_in_part_and_another_crc_are_told() -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(dialect=own_dialect()))
    line = Line(robot, 115200)
    facts = examined(line, EVERYTHING._replace(bauds=(115200,))).facts
    assert isinstance(facts, FrameFacts)
    # Its status is unknown, and hides the whole frame it stands in (F3).
    assert (facts.crc, facts.dialect) == ("CRC-8/MAXIM-DOW", "")
    assert line.sent == []  # how to stop it, nobody knows


def test_another_crc_than_the_dialects() -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(dialect=TELEMETRY.configured(crc="ROHC", coverage="seq")))
    facts = examined(Line(robot, 115200), EVERYTHING._replace(bauds=(115200,))).facts
    assert isinstance(facts, FrameFacts)
    assert (facts.dialect, facts.crc, facts.coverage) == ("telemetry", "CRC-8/ROHC", "seq")
    assert not facts.is_dialects_crc
    assert robot._end.heard > 0  # it was stopped with that CRC


# ---------------------------------------------------------------- what is sent, whatever comes back

BEFORE_KNOWN = frozenset(FLUSH + LOGO_PROBE + MILD_PROBE)


def answered(seed: int) -> tuple[list[Step], int]:
    """The steps of an examination that gets answers by chance; and how many before it believed to know something."""
    chance = random.Random(seed)
    plan = examination(EVERYTHING)
    steps: list[Step] = []
    known = 0
    now_s, heard = 0.0, None
    likely = [b"", b"F", b"K", b"FF", b"QP\x01\r", b"\x00", b"abc", b"QP\r", b"\xa3\x00\x00"]
    try:
        while True:
            step = plan.send(heard)  # type: ignore[arg-type] # None starts it
            steps.append(step)
            if isinstance(step, WayOut) and not known:
                known = len(steps)
            data = b""
            if isinstance(step, Exchange):
                now_s += step.within_s
                data = chance.choice(likely) if chance.random() < 0.3 else b""
            heard = Heard(now_s, data, 0.0, 0.01)
    except StopIteration:
        return steps, known or len(steps)


@pytest.mark.parametrize("seed", range(100))
def test_before_it_knows_something_only_proven_bytes_are_sent_each_alone_with_its_pause(seed: int) -> None:
    steps, known = answered(seed)
    baud: int | None = None
    sent = b""
    for step in steps[:known]:
        if isinstance(step, Tune):
            baud, sent = step.baud, b""
        elif isinstance(step, Exchange) and step.data:
            assert step.data[0] in BEFORE_KNOWN
            assert len(step.data) == 1
            # A zero that is waited for longer may be answered earlier: then its pause is a step of its own.
            assert step.within_s >= 10 / (baud or 9600) + pause_s(baud)
            sent += step.data
    # What may start something (a RET, a mode) comes only behind all of FLUSH.
    assert sent.startswith(FLUSH) or FLUSH.startswith(sent)
    rest = sent[len(FLUSH) :].lstrip(b"\x00")
    assert logo_probe(baud).startswith(rest)


def test_chance_answers_lead_everywhere() -> None:
    told = {step.what for seed in range(100) for step in answered(seed)[0] if isinstance(step, Tell)}
    assert {"silence", "walter"} <= told


# ---------------------------------------------------------------- the way out


@pytest.mark.parametrize("protocol", ["simple", "walter", "frame"])
def test_a_link_that_ends_in_the_middle(protocol: str) -> None:
    robots: dict[str, Any] = {
        "simple": SimulatedCar(),
        "walter": SimulatedWalter(),
        "frame": SimulatedFrameRobot(FrameRobotSettings(baud=9600, dialect=TELEMETRY)),
    }

    class Cut(Line):
        left = 40

        def read(self, until: float) -> bytes:
            self.left -= 1
            if not self.left:
                raise LinkClosedError("unplugged")
            return super().read(until)

    with pytest.raises(LinkClosedError, match="unplugged"):
        examined(Cut(robots[protocol], 9600))


# ---------------------------------------------------------------- listening alone


@every_rate
def test_listening_finds_the_rate_of_what_talks(baud: int) -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(baud=baud, dialect=TELEMETRY, telemetry_s=0.2))
    line = Line(robot, baud)
    listening = Listening(BAUDS, 60.0)
    line.examine(listening.plan())
    assert listening.baud == baud
    assert len(listening.data) > 32
    assert line.sent == []


@every_rate
def test_what_is_repeated_is_not_mistaken_at_another_rate(baud: int) -> None:
    # At wrong rates this is a pattern that repeats itself: it looks like text, or like the keys of a WALTER.
    encoder = FrameEncoder(DIALECTS["0.1"])
    moves = [DIALECTS["0.1"].parse(f"engine_forward {n % 2} {n}") for n in range(40)]
    line = Line(Talker(b"".join(encoder.encode([move])[0] for move in moves), every_s=0.3), baud)
    listening = Listening(BAUDS, 60.0)
    line.examine(listening.plan())
    assert listening.baud == baud


@pytest.mark.parametrize(
    ("data", "is_so"),
    [
        (b"temperature 21.5 degrees\r\n", True),
        (b"a short line\r\n", False),
        (b'\t$"\t 1' * 10, False),
        (b"xxxxxxxxxx" * 10, False),
        (b"temperature 21.5 degrees\x00\r\n", False),
        (b"[+] {a:1} <b|c> (d;e) -- == ** ##", False),
    ],
)
def test_text(data: bytes, is_so: bool) -> None:
    assert is_text(data) == is_so


def test_listening_ends_when_the_time_is_up_and_prefers_text() -> None:
    says = b"one two three four five\r\n"
    line = Line(Talker(says, every_s=0.3), 57600)
    listening = Listening(BAUDS, 20.0)
    line.examine(listening.plan())
    assert (listening.baud, set(listening.data)) == (57600, set(says))
    assert line.now < 24.0
    silence = Listening(BAUDS, 5.0)
    line = Line(Talker(), None)
    line.examine(silence.plan())
    assert (silence.baud, silence.data) == (BAUDS[0], b"")
    assert line.now == pytest.approx(5.0)


def test_listening_at_a_port_that_refuses_every_rate_comes_to_its_end() -> None:
    line = Line(Talker(), None)
    line.refused = set(BAUDS)
    line.examine(Listening(BAUDS, 5.0).plan())
    assert line.now == pytest.approx(5.0)


def test_stop_bytes_of_the_frame_robot_are_those_of_its_dialect() -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(baud=9600, dialect=TELEMETRY))
    robot.write(FrameEncoder(TELEMETRY).encode([TELEMETRY.parse("set_wheel_speeds 100 100")])[0])
    examined(Line(robot, 9600))
    assert list(robot.engines) == [0, 0]
    assert not robot.is_moving
