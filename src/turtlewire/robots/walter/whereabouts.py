"""Where a WALTER is, as far as its host can know: what was confirmed, what got lost, what the robot says (W11, W15).

No I/O: the connection tells what was done, lost and answered; this keeps account.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from turtlewire.protocols.walter.messages import (
    HeadingReply,
    LocationReply,
    PenReply,
    RobotMessage,
    XReply,
    YReply,
)
from turtlewire.robots.exact_pose import ExactPose
from turtlewire.robots.frame import Frame
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose, wrapped

UNIT_MM = 0.5  # W5
# A robot may round its pose to units and whole degrees; what is further off than this is corrected.
TOLERANCE_MM = 1.0
TOLERANCE_DEG = 1.0
# No number: no heading that a robot reports is off from this one.
ANY_HEADING = math.nan
# What is further off than this, people should know of.
NOTABLE_MM = 5.0
# Coordinates beyond what a reply can carry are not compared (W5).
LARGEST_MM = 16383.0
# A robot that tells its pen wrong so often cannot tell it.
MAX_PEN_DISAGREEMENTS = 3

ALL_DONE = "an answer of the robot got lost; its pose shows that every motion was done"


class Target(NamedTuple):
    """Where the robot is, and its pen, when a command is done. The heading is nan where it is not promised (C 0).

    ``frame``: the turtle's coordinates in the robot's, from then on; None: they stay as they are.
    """

    pose: Pose
    pen_down: bool
    frame: Frame | None = None


class Whereabouts:
    """The account of one robot.

    A robot that turns by other angles than it believes has other coordinates after each turn: it turned about where it
    stood, by more or less than it knows.

    Args:
        distance_scale, turn_scale: how far it truly goes, and turns, for what it is told, and believes.

    Attributes:
        position: the exact turtle, and the robot when everything submitted is done.
        frame: the turtle's coordinates in the robot's when everything submitted is done.
        confirmed: where the robot is known to be, or to have been last.
        trace, distance_mm: the way it is known to have gone.
        in_doubt: something got lost, or the robot is not where it should be: its pose has to be asked.
        corrections: how often that was done.
    """

    def __init__(self, distance_scale: float = 1.0, turn_scale: float = 1.0) -> None:
        self.distance_scale, self.turn_scale = distance_scale, turn_scale
        self.position = ExactPose(UNIT_MM * distance_scale, turn_scale)
        self.frame = Frame(HOME, distance_scale)
        self._confirmed_frame: Frame | None = None
        self.confirmed = Target(HOME, pen_down=True)
        self.trace = Trace()
        self.distance_mm = 0.0
        self.in_doubt = False
        self.corrections = 0
        # What was done or lost since a fence got lost, in order; None while nothing is uncertain.
        self._uncertain: list[Target] | None = None
        self._pen_disagreements = 0

    def done(self, tag: object) -> None:
        """A command is done; its tag is its ``Target``, if it has one."""
        if not isinstance(tag, Target):
            return
        if self._uncertain is not None:
            self._uncertain.append(tag)
            return
        self._confirmed_frame = tag.frame or self._confirmed_frame
        self.distance_mm += self.confirmed.pose.distance_to(tag.pose.x_mm, tag.pose.y_mm)
        self.confirmed = tag
        heading = self.trace.pose.heading_deg if math.isnan(tag.pose.heading_deg) else tag.pose.heading_deg
        self.trace.move(tag.pose._replace(heading_deg=heading), pen_down=tag.pen_down)

    def lost(self, tags: tuple[object, ...]) -> None:
        """A fence got lost, and perhaps commands before it (W15)."""
        self.in_doubt = True
        self._uncertain = self._uncertain or []
        for tag in tags:
            self.done(tag)

    def compare(self, reply: RobotMessage) -> None:
        """A fence's answer also tells where the robot is: is it elsewhere than it should be?"""
        if self._uncertain is None and self._is_off(reply):
            self.in_doubt = True

    def _is_off(self, reply: RobotMessage) -> bool:
        pose = self._frame_now.to_robot(self.confirmed.pose)
        if isinstance(reply, HeadingReply):
            return abs(wrapped(reply.heading_deg - pose.heading_deg)) > TOLERANCE_DEG
        if isinstance(reply, XReply):
            return _differs(reply.x_half_mm, pose.x_mm)
        if isinstance(reply, YReply):
            return _differs(reply.y_half_mm, pose.y_mm)
        if isinstance(reply, LocationReply):
            return _differs(reply.x_half_mm, pose.x_mm) or _differs(reply.y_half_mm, pose.y_mm)
        return self.trusts_pen and isinstance(reply, PenReply) and bool(reply.down) != self.confirmed.pen_down

    # ------------------------------------------------------------------ the turtle's coordinates in the robot's

    def target(self, pose: Pose, *, pen_down: bool) -> Target:
        """What a command leads to that ends at a pose, when everything before it is done."""
        return Target(pose, pen_down, None if self.turn_scale == 1.0 else self.frame)

    def turning(self, pose: Pose, angle_deg: float) -> None:
        """It is told to turn by so much, and will stand at a pose then; it believes that it turned as it was told."""
        if self.turn_scale != 1.0:
            believed = self.frame.to_robot(pose).turned(angle_deg * (1.0 - self.turn_scale))
            self.frame = Frame.matching(pose, believed, self.distance_scale)

    @property
    def _frame_now(self) -> Frame:
        """As far as the robot is known to have come."""
        return self._confirmed_frame or self.frame

    def found(self, tags: tuple[object, ...], reported: Pose, turned_deg: float = 0.0) -> Pose:
        """The robot was cut off on its way through these, and says where it is: that pose, for the turtle.

        ``turned_deg``: about how far it has turned meanwhile, for one that was driven by hand.
        """
        if self.turn_scale == 1.0:
            return self.frame.from_robot(reported)
        before, frame = self.confirmed.pose, self._frame_now
        pose = first = self._turned_from(before, frame, reported, turned_deg)
        for target in (tag for tag in tags if isinstance(tag, Target)):
            pose = self._turned_from(before, frame, reported, turned_deg)
            if _is_on_way(before, target.pose, pose):
                break
            before, frame = target.pose, target.frame or frame
        else:
            pose = first
        self.frame = Frame.matching(pose, reported, self.distance_scale)
        return pose

    def _turned_from(self, before: Pose, frame: Frame, reported: Pose, turned_deg: float) -> Pose:
        """Where it is, and looks, that has turned from a pose to what it reports, believing other angles."""
        place = frame.from_robot(reported)
        believed = wrapped(reported.heading_deg - frame.to_robot(before).heading_deg)
        believed += 360.0 * round((turned_deg / self.turn_scale - believed) / 360.0) if turned_deg else 0.0
        return place._replace(heading_deg=(before.heading_deg + believed * self.turn_scale) % 360.0)

    # ------------------------------------------------------------------ after a stop

    def forget(self) -> None:
        """Everything under way was abandoned: what is uncertain does not matter any more."""
        self._uncertain = None
        self.in_doubt = False

    @property
    def last_known(self) -> Pose:
        """Where the robot was last known to be."""
        pose = self.confirmed.pose
        return (
            pose._replace(heading_deg=self.trace.pose.heading_deg) if math.isnan(pose.heading_deg) else pose
        )

    def reckoned(self, interrupted: tuple[object, float] | None) -> Pose:
        """Where a robot that answers nothing was when it was cut off, its last command and the part done of it."""
        before = self.last_known
        if interrupted is None or not isinstance(interrupted[0], Target):
            return before
        after, part = interrupted[0].pose, interrupted[1]
        turn = 0.0 if math.isnan(after.heading_deg) else wrapped(after.heading_deg - before.heading_deg)
        return Pose(
            before.x_mm + part * (after.x_mm - before.x_mm),
            before.y_mm + part * (after.y_mm - before.y_mm),
            round(before.heading_deg + part * turn) % 360.0,
        )

    def cut_off(self, tags: tuple[object, ...], pose: Pose) -> None:
        """The robot was stopped here, on its way through these: those before are done, if it is on that way at all."""
        before = self.confirmed.pose
        targets = [tag for tag in tags if isinstance(tag, Target)]
        for i, target in enumerate(targets):
            if _is_on_way(before, target.pose, pose):
                for done in targets[:i]:
                    self.done(done)
                self.done(self.target(pose, pen_down=target.pen_down))
                return
            before = target.pose

    def may_be_at(self, tags: tuple[object, ...], pose: Pose) -> bool:
        """Whether the robot may be there, or may have been stopped there on its way through these."""
        before = self.confirmed.pose
        targets = [before, *(tag.pose for tag in tags if isinstance(tag, Target))]
        ways = zip([before, *targets], targets, strict=False)
        return any(_is_on_way(start, end, pose) for start, end in ways)

    def place(self, pose: Pose) -> None:
        """The robot is here, and so is the turtle; what is finer than the robot can tell is kept."""
        exact, near = self.position.exact, pose
        if exact.distance_to(pose.x_mm, pose.y_mm) <= UNIT_MM:
            near = Pose(exact.x_mm, exact.y_mm, pose.heading_deg)
        if abs(wrapped(exact.heading_deg - pose.heading_deg)) <= 0.5:
            near = Pose(near.x_mm, near.y_mm, exact.heading_deg)
        self.position.exact = near
        self.arrived(pose, pen_down=self.confirmed.pen_down)

    def arrived(self, pose: Pose, *, pen_down: bool) -> None:
        """The robot is known to be here, whatever was reckoned; the turtle is where it was."""
        self.position.robot = pose
        self.done(self.target(pose, pen_down=pen_down))

    # ------------------------------------------------------------------ in doubt

    def resolve(self, reported: Pose) -> tuple[list[Target], str]:
        """The robot says where it is, in its own coordinates, everything sent being done or lost.

        Returns what got lost and has to be done again (not blindly: the pose shows it), and what people should know.
        """
        self.corrections += 1
        uncertain, expected = self._uncertain or [], self.position.robot
        pose = self.frame.from_robot(reported)
        self.forget()
        if matches(pose, expected):
            for target in uncertain:
                self.done(target)
            if pose.distance_to(expected.x_mm, expected.y_mm) > TOLERANCE_MM:
                self.arrived(pose, pen_down=self.confirmed.pen_down)
            return [], ALL_DONE if uncertain else ""
        targets = [self.confirmed._replace(frame=self._frame_now), *uncertain]
        frames = [target.frame or self.frame for target in targets]
        last_done = max(
            (i for i, frame in enumerate(frames) if matches(frame.from_robot(reported), targets[i].pose)),
            default=None,
        )
        if last_done is None:
            # What it did instead is not known. It believes that it turned as far as it did.
            pose = self.found((), reported)
            last_done = len(uncertain)
        else:
            # Turns that got lost have changed nothing of what it believes.
            self.frame = frames[last_done]
            pose = self.frame.from_robot(reported)
        for target in uncertain[:last_done]:
            self.done(target)
        again = uncertain[last_done:]
        self.arrived(pose, pen_down=self.confirmed.pen_down)
        if again:
            return (
                again,
                f"{len(again)} commands got lost on the way; the pose shows which, they are sent again",
            )
        off_mm = pose.distance_to(expected.x_mm, expected.y_mm)
        if off_mm <= NOTABLE_MM:
            return [], ""
        return [], (
            f"the robot is {off_mm:.1f} mm from where it should be: a command got lost or damaged on the way, or its "
            "wheels were held; it goes on from where it is"
        )

    @property
    def trusts_pen(self) -> bool:
        """Whether the robot's answers about its pen mean anything."""
        return self._pen_disagreements < MAX_PEN_DISAGREEMENTS

    def pen_disagrees(self) -> str:
        """The pen is not as it was told, though nothing got lost. Returns what people should know."""
        self._pen_disagreements += 1
        if self.trusts_pen:
            return ""
        return "the robot's answers about its pen contradict what it was told; from now on they are ignored"


def _differs(units: int, mm: float) -> bool:
    """Whether a coordinate is another one than it should be, as far as the wire can tell."""
    return abs(mm) < LARGEST_MM and abs(units * UNIT_MM - mm) > TOLERANCE_MM


def matches(pose: Pose, other: Pose) -> bool:
    """Whether two poses may be the same one, given how robots round."""
    return (
        pose.distance_to(other.x_mm, other.y_mm) <= 2 * TOLERANCE_MM
        and abs(wrapped(pose.heading_deg - other.heading_deg)) <= TOLERANCE_DEG
    )


def _is_on_way(start: Pose, end: Pose, pose: Pose) -> bool:
    """Whether a robot that went (or turned) from one pose to another came through a third."""
    way_mm = start.distance_to(end.x_mm, end.y_mm)
    if way_mm == 0.0:
        turn, turned = (
            wrapped(end.heading_deg - start.heading_deg),
            wrapped(pose.heading_deg - start.heading_deg),
        )
        is_between = min(0.0, turn) - TOLERANCE_DEG <= turned <= max(0.0, turn) + TOLERANCE_DEG
        return is_between and pose.distance_to(end.x_mm, end.y_mm) <= TOLERANCE_MM
    dx, dy = (end.x_mm - start.x_mm) / way_mm, (end.y_mm - start.y_mm) / way_mm
    x, y = pose.x_mm - start.x_mm, pose.y_mm - start.y_mm
    return (
        -TOLERANCE_MM <= x * dx + y * dy <= way_mm + TOLERANCE_MM
        and abs(x * dy - y * dx) <= TOLERANCE_MM
        and abs(wrapped(pose.heading_deg - end.heading_deg)) <= TOLERANCE_DEG
    )
