"""A host at a real pty that is set to another rate than the robot's UART."""

from __future__ import annotations

import asyncio
import contextlib
import math
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.links.stream import StreamLink, open_port
from turtlewire.links.uart import image
from turtlewire.simulator import server
from turtlewire.simulator.car import CarSettings, SimulatedCar

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine

BAUD = 9600


def run(main: Coroutine[Any, Any, None]) -> None:
    asyncio.run(asyncio.wait_for(main, 60.0), debug=True)


class Heard(SimulatedCar):
    """A car that keeps what it has heard."""

    def __init__(self) -> None:
        super().__init__(CarSettings(baud=BAUD))
        self.bytes = bytearray()
        self._heard = asyncio.Event()

    def write(self, data: bytes) -> None:
        self.bytes += data
        super().write(data)
        self._heard.set()

    async def has_heard(self, size: int) -> None:
        while len(self.bytes) < size:
            self._heard.clear()
            await self._heard.wait()


@contextlib.asynccontextmanager
async def connected(car: SimulatedCar, baud: int, *, insists: bool = True) -> AsyncIterator[StreamLink]:
    stopped, urls = asyncio.Event(), asyncio.get_running_loop().create_future()
    bauds = [BAUD] if insists else []
    task = asyncio.create_task(
        server.serve_all([car], "pty", speed=100.0, bauds=bauds, ready=urls.set_result, stopped=stopped)
    )
    await asyncio.wait([task, urls], return_when=asyncio.FIRST_COMPLETED)
    link = await open_port((await urls)[0], baud=baud)
    try:
        yield link
    finally:
        await link.close()
        stopped.set()
        await task


async def read(link: StreamLink, size: int) -> bytes:
    data = b""
    while len(data) < size:
        data += await link.read(math.inf)
    return data


def test_at_the_robots_rate_all_is_as_sent() -> None:
    async def main() -> None:
        car = Heard()
        async with connected(car, BAUD) as link:
            link.write(b"F100000")
            assert await read(link, 1) == b"K"
        assert (car.drive, bytes(car.bytes)) == (100, b"F100000")

    run(main())


def test_who_does_not_insist_hears_any_rate() -> None:
    async def main() -> None:
        car = Heard()
        async with connected(car, 115200, insists=False) as link:
            link.write(b"F100000")
            assert await read(link, 1) == b"K"
        assert car.drive == 100

    run(main())


@pytest.mark.parametrize("baud", [4800, 19200, 38400])
def test_at_another_rate_both_ends_hear_images(baud: int) -> None:
    async def main() -> None:
        car = Heard()
        async with connected(car, baud) as link:
            # A zero is heard as one byte at each of these rates; seven of them are answered.
            for number in range(1, 8):
                link.write(b"\x00")
                await car.has_heard(number)
            assert car.bytes == image(b"\x00", BAUD / baud) * 7
            answer = image(b"F", baud / BAUD)
            assert answer != b"F"
            assert await read(link, len(answer)) == answer

    run(main())


def test_bytes_one_behind_the_other_are_one_image() -> None:
    async def main() -> None:
        car = Heard()
        async with connected(car, 19200) as link:
            link.write(b"S000000")
            expected = image(b"S000000", BAUD / 19200)
            await car.has_heard(len(expected))
            assert (
                car.bytes == expected != b"".join(image(bytes([byte]), BAUD / 19200) for byte in b"S000000")
            )

    run(main())


def test_the_rate_may_change_while_the_port_is_open() -> None:
    async def main() -> None:
        car = Heard()
        async with connected(car, 19200) as link:
            link.write(b"\x00")
            await car.has_heard(1)
            await link.set_baud(BAUD)
            link.write(b"F10000")
            assert await read(link, 1) == b"F"
            link.write(b"F100000")
            assert await read(link, 1) == b"K"
        assert car.drive == 100

    run(main())
