"""A connection to a WALTER at work: what is driven, and knowing where the robot is (W9..W15).

What to aim at is decided in ``robots.exact_pose``.
"""

from __future__ import annotations

import math

from turtlewire.protocols.walter.codec import Mode
from turtlewire.protocols.walter.messages import (
    Back,
    Forward,
    Left,
    PenDown,
    PenUp,
    QueryHeading,
    QueryLocation,
    QueryPen,
    Right,
)
from turtlewire.robots.exact_pose import Step, Turn, wire_parts, with_rest
from turtlewire.robots.walter.attention import PEN_S, Attention
from turtlewire.robots.walter.wire import MAX_ROUNDS

# The command for a positive amount, and its opposite for a negative one (W12).
TURNS = (Right, Left)
MOVES = (Forward, Back)


class Connection(Attention):
    """A WALTER at the other end of a link."""

    async def ready(self) -> None:
        """Before every operation: see to it that the robot is in Logo control, and where the host thinks it is."""
        self.check()
        self.stops.check()
        await self.raise_event()
        if self.host.mode is not Mode.LOGO:
            await self._attend(self.settings.reply_timeout_s)
        if self.where.in_doubt:
            await self._reconcile()

    def drive(self, steps: list[Step]) -> None:
        """Have the steps of the exact pose sent, in as many commands as the wire needs (W5, W12)."""
        position = self.where.position
        for step in steps:
            value = step.angle_deg if isinstance(step, Turn) else step.units
            commands = TURNS if isinstance(step, Turn) else MOVES
            for rest, part in with_rest(wire_parts(abs(value), gentle=self.settings.gentle)):
                left = math.copysign(rest, value)
                if isinstance(step, Turn):
                    at = step.pose.turned(-left * position.unit_deg)
                    self.where.turning(at, math.copysign(part, value))
                else:
                    at = step.pose.moved(-left * position.unit_mm)
                self.submit(commands[value < 0](part), self.duration_s(step, part), at)

    def duration_s(self, step: Step, amount: int) -> float:
        """How long a step of so many degrees or units should take (W14)."""
        position = self.where.position
        if isinstance(step, Turn):
            return amount * position.unit_deg / (self.speed * self.settings.deg_per_s_per_unit)
        return amount * position.unit_mm / (self.speed * self.settings.mm_per_s_per_unit)

    def set_pen(self, *, down: bool) -> None:
        """Raise or lower the pen, if it is not so already."""
        if self.pen_down != down:
            self.pen_down = down
            self.submit(PenDown() if down else PenUp(), PEN_S)

    async def finish(self, *, verify: bool = False) -> None:
        """Wait until everything that was submitted is done; then the robot is where the host thinks it is.

        A fence asks for one of four things; the others may be wrong, by a command that was damaged on the way.
        ``verify`` asks for all, unless nothing was sent since it was done last.
        """
        host = self.host
        for _ in range(MAX_ROUNDS):
            if verify and host.answers and self._verified != host.commands_sent + host.unsent:
                for query in (QueryPen(), QueryLocation(), QueryHeading()):
                    host.submit(query)
                self._verified = host.commands_sent + host.unsent
            host.fence()
            await self.until(lambda: host.idle)
            if not self.where.in_doubt:
                return
            await self._reconcile()
        raise self._out_of_control()

    # ------------------------------------------------------------------ lost or damaged on the way (W15)

    async def _reconcile(self) -> None:
        """Answers got lost, or the robot is not where it should be: ask where it is, and go on from there."""
        where, position, wanted = self.where, self.where.position, self.pen_down
        exact, expected = position.exact, position.robot
        reported = await self._ask_pose()
        pen = await self.ask(QueryPen())
        again, text = where.resolve(reported)
        if where.trusts_pen and pen.values() != (int(where.confirmed.pen_down),):
            self.pen_down = not where.confirmed.pen_down
            text = text or where.pen_disagrees()
        for target in again:
            self.set_pen(down=target.pen_down)
            self.drive(position.go_to(target.pose.x_mm, target.pose.y_mm))
        self.set_pen(down=wanted)
        position.exact = exact
        if position.robot != expected:
            self.drive(position.go_to(exact.x_mm, exact.y_mm) + position.align())
        if text:
            self.tell(text)
