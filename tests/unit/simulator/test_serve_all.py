"""Any number of robots behind real ports, in one process."""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import socket
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import PortBusyError, TurtlewireError, UsageError
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder
from turtlewire.protocols.frame.dialect import FROM_ROBOT, shipped
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import encode
from turtlewire.simulator import server
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.company import share_world
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.walter import Settings, SimulatedWalter
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine, Sequence

SOCKET = "socket://127.0.0.1:0"
TELEMETRY = shipped("telemetry")


def run(main: Coroutine[Any, Any, None]) -> None:
    asyncio.run(asyncio.wait_for(main, 60.0), debug=True)


@contextlib.asynccontextmanager
async def served(
    robots: Sequence[server.ServedRobot], listen: str | Sequence[str]
) -> AsyncIterator[list[str]]:
    """The URLs of robots that are served meanwhile."""
    stopped, urls = asyncio.Event(), asyncio.get_running_loop().create_future()
    task = asyncio.create_task(
        server.serve_all(robots, listen, speed=100.0, ready=urls.set_result, stopped=stopped)
    )
    await asyncio.wait([task, urls], return_when=asyncio.FIRST_COMPLETED)
    try:
        yield await urls
    finally:
        stopped.set()
        await task


async def connect(url: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    number = int(url.rpartition(":")[2])
    return await asyncio.open_connection("127.0.0.1", number)


def test_one_of_each_kind_in_one_world_each_on_its_own_line() -> None:
    async def main() -> None:
        walter = SimulatedWalter()
        car = SimulatedCar(CarSettings(start=Pose(1000.0, 0.0, 0.0)))
        frame = SimulatedFrameRobot(FrameRobotSettings(start=Pose(0.0, 1000.0, 0.0), dialect=TELEMETRY))
        robots = [walter, car, frame]
        share_world(robots)
        async with served(robots, SOCKET) as urls:
            assert len(set(urls)) == 3
            wires = [await connect(url) for url in urls]
            sent = [
                encode(m.Forward(200)) + encode(m.QueryLocation()),
                b"F140000",
                FrameEncoder(TELEMETRY).encode([TELEMETRY["SetWheelSpeeds"](50, 50)])[0],
            ]
            for (_, writer), data in zip(wires, sent, strict=True):
                writer.write(data)
            assert await wires[0][0].readexactly(7) == encode(m.LocationReply(0, 200))
            assert await wires[1][0].readexactly(1) == b"K"
            decoder = FrameDecoder(TELEMETRY, FROM_ROBOT)
            ticks: float = 0
            while not ticks:
                for item in decoder.receive_data(await wires[2][0].read(1000)):
                    assert isinstance(item, Frame)
                    ticks = item.messages[0].values()[1]
            for _, writer in wires:
                writer.close()
        assert walter.now == car.now == frame.now
        assert car.pose.y_mm > 100.0
        assert frame.pose.y_mm > 1000.0

    run(main())


def test_robots_of_different_ages_in_worlds_of_their_own() -> None:
    async def main() -> None:
        old, new = SimulatedWalter(), SimulatedWalter()
        old.read(500.0)
        async with served([old, new], SOCKET) as urls:
            for url in urls:
                reader, writer = await connect(url)
                writer.write(encode(m.QueryHeading()))
                assert await reader.readexactly(5) == encode(m.HeadingReply(0))
                writer.close()
        assert old.now == pytest.approx(500.0 + new.now)

    run(main())


def test_each_gets_a_pty_of_its_own() -> None:
    async def main() -> None:
        robots = [SimulatedWalter(Settings(baud=None)), SimulatedCar(CarSettings(baud=None))]
        async with served(robots, "pty") as urls:
            assert len(set(urls)) == 2
            descriptor = os.open(urls[1], os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            reader = asyncio.StreamReader()
            loop = asyncio.get_running_loop()
            loop.add_reader(descriptor, lambda: reader.feed_data(os.read(descriptor, 4096)))
            os.write(descriptor, b"S000000X000000")
            assert await reader.readexactly(2) == b"KF"
            loop.remove_reader(descriptor)
            os.close(descriptor)

    run(main())


def test_ports_follow_one_another_and_may_be_named_one_by_one() -> None:
    async def main() -> None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            number = free.getsockname()[1]
        robots = [SimulatedWalter(), SimulatedWalter()]
        names = [f"socket://127.0.0.1:{number}", "pty"]
        async with served(robots, names) as urls:
            assert urls[0] == names[0]
            assert urls[1].startswith("/dev/")

    run(main())
    assert server._ports_for(3, "socket://localhost:2000") == [
        f"socket://localhost:{n}" for n in (2000, 2001, 2002)
    ]
    assert server._ports_for(2, "socket://[::1]:0") == ["socket://[::1]:0"] * 2


def fails(count: int, listen: str | Sequence[str]) -> TurtlewireError:
    ready: list[list[str]] = []
    with pytest.raises(TurtlewireError) as caught:
        run(server.serve_all([SimulatedWalter() for _ in range(count)], listen, ready=ready.append))
    assert not ready
    return caught.value


def test_what_cannot_be_served() -> None:
    assert "there is no robot" in str(fails(0, "pty"))
    assert "there are 3 robots, but 2 ports" in str(fails(3, ["pty", "pty"]))
    assert "there are no 3 ports" in str(fails(3, "socket://127.0.0.1:65534"))
    assert isinstance(fails(2, "nowhere"), UsageError)


def test_when_one_port_is_taken_none_is_served() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other, socket.create_server(("127.0.0.1", 0)) as free:
        number = free.getsockname()[1]
        free.close()
        taken = f"socket://127.0.0.1:{other.getsockname()[1]}"
        assert isinstance(fails(2, [f"socket://127.0.0.1:{number}", taken]), PortBusyError)
        socket.create_server(("127.0.0.1", number)).close()  # the first is free again


def test_a_crowd_is_served() -> None:
    async def main() -> None:
        robots = [SimulatedCar(CarSettings(start=Pose(500.0 * n, 0.0, 0.0))) for n in range(30)]
        share_world(robots)
        async with served(robots, SOCKET) as urls:
            wires = [await connect(url) for url in urls]
            for _, writer in wires:
                writer.write(b"F140000")
            for reader, writer in wires:
                assert await reader.readexactly(1) == b"K"
                writer.close()
        assert all(robot.pose.y_mm > 0.0 for robot in robots)
        assert math.isfinite(robots[0].now)

    run(main())
