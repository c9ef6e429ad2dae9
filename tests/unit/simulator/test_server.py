"""A robot behind a real pty and a real socket. Robot time runs fast; nothing here looks at the clock on the wall."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import sys
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import LinkError, PortBusyError, TurtlewireError, UsageError
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import encode
from turtlewire.simulator import server
from turtlewire.simulator.walter import Settings, SimulatedWalter
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine

    from turtlewire.simulator.walter import Action

SOCKET = "socket://127.0.0.1:0"
FAST = 1000.0


def run(main: Coroutine[Any, Any, None]) -> None:
    asyncio.run(asyncio.wait_for(main, 60.0), debug=True)


def sent(*messages: m.WalterMessage) -> bytes:
    return b"".join(map(encode, messages))


@contextlib.asynccontextmanager
async def served(robot: SimulatedWalter, listen: str = SOCKET, speed: float = FAST) -> AsyncIterator[str]:
    """The URL of a robot that is served meanwhile."""
    stopped, url = asyncio.Event(), asyncio.get_running_loop().create_future()
    task = asyncio.create_task(
        server.serve(robot, listen, speed=speed, ready=url.set_result, stopped=stopped)
    )
    await asyncio.wait([task, url], return_when=asyncio.FIRST_COMPLETED)
    try:
        yield await url
    finally:
        stopped.set()
        await task


class Host:
    """The near end of either kind of port."""

    def __init__(self, reader: asyncio.StreamReader, close: Any, send: Any) -> None:
        self.reader = reader
        self.close = close
        self.send = send

    async def read(self, number: int) -> bytes:
        return await self.reader.readexactly(number)


async def connect(url: str) -> Host:
    if url.startswith("socket://"):
        name, _, number = url.removeprefix("socket://").rpartition(":")
        reader, writer = await asyncio.open_connection(name.strip("[]"), int(number))
        return Host(reader, writer.close, writer.write)
    loop = asyncio.get_running_loop()
    descriptor = os.open(url, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    reader = asyncio.StreamReader()
    loop.add_reader(descriptor, lambda: reader.feed_data(os.read(descriptor, 4096)))

    def close() -> None:
        loop.remove_reader(descriptor)
        os.close(descriptor)

    return Host(reader, close, lambda data: os.write(descriptor, data))


@pytest.mark.parametrize("listen", [SOCKET, "pty"])
def test_a_round_trip(listen: str) -> None:
    async def main() -> None:
        robot = SimulatedWalter()
        async with served(robot, listen) as url:
            host = await connect(url)
            # All 256 values pass unchanged, RET, flow control and end of file included.
            for speed in range(256):
                host.send(sent(m.SetSpeed(speed), m.QueryPen()))
                assert await host.read(4) == sent(m.PenReply(0))
                assert robot.speed == speed
            host.send(sent(m.Forward(200), m.Right(90), m.QueryLocation(), m.QueryHeading()))
            assert await host.read(12) == sent(m.LocationReply(0, 200), m.HeadingReply(90))
            host.close()
        assert robot.pose == Pose(0.0, 100.0, 90.0)

    run(main())


@pytest.mark.parametrize("listen", [SOCKET, "pty"])
def test_the_next_host_finds_the_robot_as_it_is(listen: str) -> None:
    async def main() -> None:
        robot = SimulatedWalter(Settings(baud=None))
        async with served(robot, listen) as url:
            host = await connect(url)
            host.send(sent(m.QueryPen(), m.Forward(2000), m.Right(90)))
            await host.read(4)
            host.close()
            while True:
                host = await connect(url)
                host.send(sent(m.QueryHeading()))
                reply = await host.reader.read(5)
                host.close()
                if reply:  # b"": the first host's leaving had not been noticed yet
                    break
            assert reply == sent(m.HeadingReply(90))  # what was queued went on
            assert robot.pose == Pose(0.0, 1000.0, 90.0)

    run(main())


def test_a_second_host_is_told_off_and_the_first_works_on() -> None:
    async def main() -> None:
        async with served(SimulatedWalter()) as url:
            first, second = await connect(url), await connect(url)
            with contextlib.suppress(ConnectionResetError):
                assert await second.reader.read() == b""
            first.send(sent(m.QueryPen()))
            assert await first.read(4) == sent(m.PenReply(0))
            second.close()
            first.send(sent(m.QueryPen()))
            assert await first.read(4) == sent(m.PenReply(0))
            first.close()

    run(main())


@pytest.mark.parametrize("listen", [SOCKET, "pty"])
def test_a_flood_reaches_the_robot_at_its_own_pace(listen: str) -> None:
    async def main() -> None:
        robot = SimulatedWalter()
        pieces: list[int] = []

        class Watched(SimulatedWalter):
            def write(self, data: bytes) -> None:
                super().write(data)
                pieces.append(self.bytes_on_line)

        robot = Watched()
        async with served(robot, listen, 20_000.0) as url:
            host = await connect(url)
            host.send(sent(m.SetSpeed(7)) * 500 + sent(m.QueryPen()))
            assert await host.read(4) == sent(m.PenReply(0))
            host.close()
        assert max(pieces) <= server.ADAPTER_BYTES
        assert robot.statistics.commands == 501

    run(main())


def test_a_pty_that_nobody_reads_holds_up_nothing() -> None:
    async def main() -> None:
        robot, ended = SimulatedWalter(Settings(baud=None)), asyncio.Event()

        def note(action: Action) -> None:
            if action.what.startswith("ended"):
                ended.set()

        robot.events = note
        async with served(robot, "pty") as url:
            descriptor = os.open(url, os.O_RDWR | os.O_NOCTTY)
            for _ in range(100):
                os.write(descriptor, sent(m.QueryLocation()) * 10 + sent(m.Forward(2)))
                await ended.wait()
                ended.clear()
            os.close(descriptor)
        assert robot.pose.y_mm == 100.0
        assert robot.statistics.bytes_out == 7000  # more than a pty holds

    run(main())


class Chatterbox:
    """A robot that sends a hundred megabytes as fast as it can, and then says so."""

    def __init__(self) -> None:
        self.now = 0.0
        self.bytes_on_line = 0
        self.sent_bytes = 0
        self.finished = asyncio.Event()

    def write(self, data: bytes) -> None:
        raise AssertionError("nobody writes to it")

    def read(self, until: float) -> bytes:
        self.now = until
        if self.sent_bytes == 100_000_000:
            self.finished.set()
            return b""
        self.sent_bytes += 1_000_000
        return bytes(1_000_000)

    def next_event(self) -> float:
        return self.now


def test_what_a_host_at_a_socket_does_not_read_is_dropped() -> None:
    async def main() -> None:
        robot, stopped = Chatterbox(), asyncio.Event()
        url = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(server.serve(robot, SOCKET, ready=url.set_result, stopped=stopped))
        number = int((await url).rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", number)) as host:
            await robot.finished.wait()
            stopped.set()
            await task
            came = 0
            with contextlib.suppress(ConnectionResetError):
                while data := host.recv(1 << 20):
                    came += len(data)
        assert came < 20_000_000

    run(main())


def test_nothing_runs_while_nothing_happens() -> None:
    async def main() -> None:
        reads = 0

        class Watched(SimulatedWalter):
            def read(self, until: float) -> bytes:
                nonlocal reads
                reads += 1
                return super().read(until)

        async with served(Watched(Settings(baud=None))) as url:
            host = await connect(url)
            host.send(sent(m.QueryPen()))
            assert await host.read(4) == sent(m.PenReply(0))
            before = reads
            for _ in range(1000):
                await asyncio.sleep(0)
            assert reads == before
            host.send(sent(m.Forward(2000), m.QueryPen()))
            assert await host.read(4) == sent(m.PenReply(0))
            assert reads - before < 20  # ten seconds of driving
            host.close()

    run(main())


def test_serving_ends_when_its_task_is_cancelled() -> None:
    async def main() -> None:
        url = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(server.serve(SimulatedWalter(), SOCKET, ready=url.set_result))
        host = await connect(await url)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        with contextlib.suppress(ConnectionResetError):
            assert await host.reader.read() == b""
        host.close()
        with pytest.raises(ConnectionRefusedError):
            await connect(await url)

    run(main())


def fails(listen: str, **options: Any) -> TurtlewireError:
    with pytest.raises(TurtlewireError) as caught:
        run(server.serve(SimulatedWalter(), listen, **options))
    return caught.value


@pytest.mark.parametrize(
    "listen",
    [
        "",
        "COM3",
        "/dev/ttyUSB0",
        "socket://",
        "socket://host",
        "socket://:80",
        "socket://host:",
        "socket://host:port",
        "socket://host:65536",
        "socket://host:80/path",
        "socket://[::1:80",
        "serial://host:80",
    ],
)
def test_what_is_no_port_is_wrong_usage(listen: str) -> None:
    error = fails(listen)
    assert isinstance(error, UsageError)
    assert repr(listen) in str(error)
    assert "socket://host:port" in str(error)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("inf"), float("nan")])
def test_a_speed_that_is_none_is_wrong_usage(speed: float) -> None:
    error = fails("pty", speed=speed)
    assert isinstance(error, UsageError)
    assert "above 0" in str(error)


def test_an_address_in_use_is_said_to_be() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        error = fails(f"socket://127.0.0.1:{other.getsockname()[1]}")
    assert isinstance(error, PortBusyError)
    assert "another program" in str(error)


@pytest.mark.parametrize("host", ["192.0.2.1", "no-such-host.invalid", "a" * 64])
def test_an_address_that_is_not_ours(host: str) -> None:
    error = fails(f"socket://{host}:0")
    assert isinstance(error, LinkError)
    assert f"cannot listen at socket://{host}:0: " in str(error)


def test_names_are_given_out_as_addresses() -> None:
    async def main() -> None:
        async with served(SimulatedWalter(), "socket://localhost:0") as url:
            assert url.startswith("socket://127.0.0.1:")
        async with served(SimulatedWalter(), "socket://0.0.0.0:0") as url:
            assert url.startswith("socket://127.0.0.1:")
            (await connect(url)).close()

    run(main())


def test_where_there_are_no_ptys_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_pty() -> tuple[int, int]:
        raise OSError(28, "out of pty devices")

    monkeypatch.setattr(os, "openpty", no_pty)
    assert "out of pty devices" in str(fails("pty"))
    monkeypatch.setitem(sys.modules, "tty", None)
    error = fails("pty")
    assert isinstance(error, UsageError)
    assert "no pseudo-terminals on this system" in str(error)
