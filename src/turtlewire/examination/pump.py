"""Carries out the plan of an examination on a link. Whatever ends it, the robot is stopped if that is known how to."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, TypeVar

from turtlewire.errors import LinkClosedError, LinkError
from turtlewire.examination.probes import BITS, SOCKET_BAUD
from turtlewire.examination.steps import Exchange, Heard, Tell, Tune, WayOut

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from turtlewire.examination.steps import Plan, Step
    from turtlewire.links.link import Link

T = TypeVar("T")
# What was handed over last may take a moment more than its own time: an adapter gathers bytes.
GRACE_S = 0.05


async def carry_out(
    plan: Plan[T],
    link: Link,
    tune: Callable[[int], Awaitable[None]] | None = None,
    tell: Callable[[Tell], object] = lambda _: None,
) -> T:
    """Do what a plan wants, up to its end; close the link in any case.

    Args:
        plan: the plan.
        link: open, and nobody else's.
        tune: changes the port's rate in place; raises ``LinkError`` for one that it does not have. None: it has none.
        tell: told what people want to know meanwhile.

    Raises ``LinkError`` when the link ends.
    """
    pump = _Pump(link, tune, tell)
    try:
        with contextlib.closing(plan):
            heard: Heard | None = None
            while True:
                try:
                    step = plan.send(heard)  # type: ignore[arg-type] # None starts it
                except StopIteration as end:
                    result: T = end.value
                    return result
                heard = await pump.do(step)
    finally:
        await pump.close()


class _Pump:
    """A link, and what was promised to be sent on it last."""

    def __init__(
        self, link: Link, tune: Callable[[int], Awaitable[None]] | None, tell: Callable[[Tell], object]
    ) -> None:
        self._link = link
        self._tune = tune
        self._tell = tell
        self._opened_s = link.now()
        self._baud = SOCKET_BAUD
        self._way_out = b""

    async def do(self, step: Step) -> Heard:
        """One step."""
        if isinstance(step, Exchange):
            return await self._exchange(step)
        refusal = ""
        if isinstance(step, Tune):
            refusal = await self._tuned(step.baud)
        elif isinstance(step, WayOut):
            self._way_out = step.data
        else:
            self._tell(step)
        return Heard(self._link.now() - self._opened_s, refusal=refusal)

    async def _tuned(self, baud: int) -> str:
        assert self._tune is not None, "a link without a rate is not tuned"
        try:
            await self._tune(baud)
        except LinkClosedError:
            raise
        except LinkError as error:
            return str(error)
        self._baud = baud
        return ""

    async def _exchange(self, step: Exchange) -> Heard:
        link = self._link
        begun_s = link.now()
        if step.data:
            link.write(step.data)
        until_s = begun_s + step.within_s
        data, first_s = b"", math.inf
        while (now_s := link.now()) < until_s and not (data and step.is_enough(data)):
            data += await link.read(until_s)
            if data and first_s == math.inf:
                first_s = link.now() - begun_s
        return Heard(now_s - self._opened_s, data, first_s, now_s - begun_s)

    async def close(self) -> None:
        """Stop the robot, and let go of it."""
        link = self._link
        try:
            if self._way_out:
                with contextlib.suppress(LinkClosedError):
                    link.write_urgent(self._way_out)
                    until_s = link.now() + len(self._way_out) * BITS / self._baud + GRACE_S
                    while link.now() < until_s:
                        await link.read(until_s)
        finally:
            await link.close()
