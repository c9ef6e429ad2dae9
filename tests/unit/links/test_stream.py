"""Real pseudo-terminals and sockets at the far end; nothing here looks at the clock on the wall."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import math
import os
import pty
import select
import socket
import termios
import tty
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import LinkClosedError, LinkError, PortBusyError, PortNotFoundError, UsageError
from turtlewire.links import stream
from turtlewire.links.line_rate import baud_of
from turtlewire.links.port import Port
from turtlewire.links.stream import Connection, StreamLink, open_port

if TYPE_CHECKING:
    from collections.abc import Coroutine, Iterator


def descriptors() -> set[Path]:
    """What this process has open."""
    return set(Path("/proc/self/fd").iterdir())


def run(main: Coroutine[Any, Any, None]) -> None:
    """Run to the end; never for ever."""
    asyncio.run(asyncio.wait_for(main, 20.0))


@pytest.fixture
def device() -> Iterator[tuple[int, str]]:
    """A serial device, and the file descriptor at which its robot is."""
    near, far = pty.openpty()
    tty.setraw(far)
    os.set_blocking(near, False)
    yield near, os.ttyname(far)
    os.close(far)
    with contextlib.suppress(OSError):  # a test may have pulled the plug
        os.close(near)


async def heard(fd: int, size: int) -> bytes:
    """What arrives at the robot, up to so many bytes."""
    loop, data, more = asyncio.get_running_loop(), b"", asyncio.Event()
    loop.add_reader(fd, more.set)
    try:
        while len(data) < size:
            await more.wait()
            more.clear()
            with contextlib.suppress(BlockingIOError):
                data += os.read(fd, size - len(data))
    finally:
        loop.remove_reader(fd)
    return data


async def read_all(link: StreamLink, size: int) -> bytes:
    data = b""
    while len(data) < size:
        data += await link.read(math.inf)
    return data


# ---------------------------------------------------------------- serial devices


def test_bytes_go_both_ways_over_a_device(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        assert link.in_background
        link.write(b"F\x00\xc8\r")
        assert await heard(near, 4) == b"F\x00\xc8\r"
        os.write(near, b"QH\x00\x0a\r\x11\x13\x03")
        assert await read_all(link, 8) == b"QH\x00\x0a\r\x11\x13\x03"
        assert await link.read(link.now()) == b""
        link.wake()
        assert await link.read(link.now() - 1.0) == b""
        await link.close()
        for use in (link.write, link.write_urgent):
            with pytest.raises(LinkClosedError):
                use(b"x")
        with pytest.raises(LinkClosedError, match="closed"):
            await link.read(math.inf)
        await link.close()

    run(main())


def test_wake_ends_a_read_that_waits(device: tuple[int, str]) -> None:
    async def main() -> None:
        link = await open_port(f"serial://{device[1]}?baud=115200", baud=9600)
        reading = asyncio.create_task(link.read(math.inf))
        await asyncio.sleep(0)
        link.wake()
        assert await reading == b""
        await link.close()

    run(main())


def test_w8_an_urgent_write_flushes_what_the_system_holds(
    device: tuple[int, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    flushed: list[tuple[int, int]] = []
    real = termios.tcflush

    def spy(fd: int, queue: int) -> None:
        flushed.append((fd, queue))
        real(fd, queue)

    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        monkeypatch.setattr(termios, "tcflush", spy)
        link.write_urgent(b"2\r ")
        assert os.ttyname(flushed[0][0]) == path
        assert flushed[0][1] == termios.TCOFLUSH
        assert await heard(near, 3) == b"2\r "
        monkeypatch.setattr(termios, "tcflush", fail_to_flush)
        link.write_urgent(b"x")
        assert await heard(near, 1) == b"x"
        await link.close()

    def fail_to_flush(fd: int, queue: int) -> None:
        raise termios.error(errno.EIO, "gone")

    run(main())


def test_bytes_in_flight_at_close_arrive(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        link.write(bytes(range(200)))
        await link.close()
        assert await heard(near, 200) == bytes(range(200))

    run(main())


def test_a_device_that_is_not_read_never_blocks_and_loses_nothing(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        sent = bytes(range(251)) * 200
        for start in range(0, len(sent), 1000):  # more and more of it waits here
            link.write(sent[start : start + 1000])
        begun, fileno = b"", link._connection.fileno
        assert fileno is not None
        while not select.select([], [fileno], [], 0.0)[1]:
            assert select.select([near], [], [], 20.0)[0]
            begun += os.read(near, 1 << 16)
        link.write(b"last")  # there would be room for it now, but what waits comes first
        assert begun + await heard(near, len(sent) + 4 - len(begun)) == sent + b"last"
        for byte in sent[:100]:
            link.write(bytes([byte]))
        assert await heard(near, 100) == sent[:100]
        await link.close()

    run(main())


def test_whoever_listens_is_handed_what_comes(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        os.write(near, b"before")
        await link._connection.something.wait()
        got, more = bytearray(), asyncio.Event()

        def receive(data: bytes) -> None:
            got.extend(data)
            more.set()

        async def until(text: bytes) -> None:
            while got != text:
                await more.wait()
                more.clear()

        assert link.listen(receive)
        assert got == b"before"
        assert await link.read(link.now()) == b""
        reading = asyncio.create_task(link.read(math.inf))
        os.write(near, b", after")
        await until(b"before, after")
        assert not reading.done()
        link.wake()
        assert await reading == b""
        await link.close()
        await link.reopen()
        os.write(near, b", again")
        await until(b"before, after, again")
        await link.close()

    run(main())


def test_a_device_has_one_host_at_a_time(device: tuple[int, str]) -> None:
    async def main() -> None:
        link = await open_port(device[1], baud=9600)
        with pytest.raises(PortBusyError, match="in use by another program"):
            await open_port(device[1], baud=9600)
        await link.close()
        again = await open_port(device[1], baud=9600)
        await again.close()

    run(main())


def test_a_device_that_vanishes_ends_the_link(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        os.write(near, b"last words")
        assert await read_all(link, 10) == b"last words"
        os.close(near)
        with pytest.raises(LinkClosedError, match="still plugged in"):
            await read_all(link, 1)
        with pytest.raises(LinkClosedError):
            link.write_urgent(b"x")
        await link.close()

    run(main())


@pytest.mark.parametrize("path", ["/dev/null", "/etc/hostname", "/tmp"])
def test_what_is_no_tty_is_refused(path: str) -> None:
    async def main() -> None:
        with pytest.raises(LinkError):
            await open_port(path, baud=9600)

    run(main())


def test_a_port_that_is_not_there() -> None:
    async def main() -> None:
        with pytest.raises(PortNotFoundError, match="there is no port /dev/ttyNOWHERE"):
            await open_port("/dev/ttyNOWHERE", baud=9600)

    run(main())


@pytest.mark.parametrize(
    ("number", "kind", "text"),
    [
        (errno.EBUSY, PortBusyError, "in use"),
        (errno.EAGAIN, PortBusyError, "in use"),
        (errno.ENXIO, PortNotFoundError, "no port"),
        (errno.ENODEV, PortNotFoundError, "no port"),
        (errno.EACCES, LinkError, "dialout"),
        (errno.EPERM, LinkError, "dialout"),
        (errno.ENOTTY, LinkError, "no serial port"),
        (errno.EIO, LinkError, "cannot open"),
        (None, LinkError, "cannot open"),
    ],
)
def test_what_the_system_says_is_explained(number: int | None, kind: type[LinkError], text: str) -> None:
    error = OSError(number, os.strerror(number)) if number else OSError("strange")
    explained = stream.explained("/dev/x", Port("serial", "/dev/x"), error)
    assert type(explained) is kind
    assert text in str(explained)


def test_the_rate_changes_while_the_port_stays_open(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        assert baud_of(near) == 9600
        for baud in (115200, 250000, 12345):  # in the last two, no system has a name for it
            os.write(near, b"before")
            await link.set_baud(baud)
            assert baud_of(near) == baud
            os.write(near, b"after")
            data = await read_all(link, 5)
            assert data == b"after"
            link.write(b"host")
            assert await heard(near, 4) == b"host"
        await link.close()
        with pytest.raises(LinkClosedError):
            await link.set_baud(9600)

    run(main())


def test_a_rate_that_the_port_does_not_have(device: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        # What an adapter does that knows few rates: no pty does.
        monkeypatch.setattr(stream, "baud_of", lambda _: 256000)
        await link.set_baud(250000)
        with pytest.raises(
            LinkError, match="cannot be set to 500000 baud: the nearest that it has is 256000"
        ):
            await link.set_baud(500000)
        with pytest.raises(LinkError, match=r"cannot be set to 99999999999 baud"):
            await link.set_baud(99999999999)
        link.write(b"on")
        assert await heard(near, 2) == b"on"
        await link.close()

    run(main())


def test_the_rate_of_a_device_that_has_vanished(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        os.close(near)
        with pytest.raises(LinkClosedError):
            await link.set_baud(19200)
        await link.close()

    run(main())


def test_the_rate_of_what_has_none(tmp_path: Path) -> None:
    with (tmp_path / "file").open("wb") as file:
        assert baud_of(file.fileno()) is None


# ---------------------------------------------------------------- sockets


def test_bytes_go_both_ways_over_a_socket() -> None:
    async def main() -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(0.0)
            link = await open_port(f"socket://127.0.0.1:{server.getsockname()[1]}", baud=9600)
            loop = asyncio.get_running_loop()
            robot, _ = await loop.sock_accept(server)
            with robot:
                robot.settimeout(0.0)
                link.write(b"one")
                link.write_urgent(b"two")
                assert await loop.sock_recv(robot, 3) + await loop.sock_recv(robot, 9) == b"onetwo"
                await loop.sock_sendall(robot, b"reply")
                assert await read_all(link, 5) == b"reply"
            with pytest.raises(LinkClosedError):
                await read_all(link, 1)
            await link.close()

    run(main())


def test_a_robot_that_floods_a_host_that_does_not_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream, "MAX_UNREAD_BYTES", 1000)

    async def main() -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            link = await open_port(f"socket://127.0.0.1:{server.getsockname()[1]}", baud=9600)
        for _ in range(100):
            link._connection.data_received(bytes(100))
        assert len(await link.read(math.inf)) == 1000
        link._connection.data_received(b"again")
        assert await link.read(math.inf) == b"again"

    run(main())


def test_a_refused_connection_names_what_to_do() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]

    async def main() -> None:
        with pytest.raises(PortNotFoundError, match="start the robot or the simulator there first"):
            await open_port(f"socket://127.0.0.1:{number}", baud=9600)

    run(main())


def test_an_address_that_does_not_answer_or_does_not_exist() -> None:
    port = Port("socket", host="robot.invalid", number=1)
    late = stream.explained("socket://robot.invalid:1", port, TimeoutError())
    unknown = stream.explained("socket://robot.invalid:1", port, socket.gaierror(-2, "unknown"))
    assert (type(late), type(unknown)) == (PortNotFoundError, PortNotFoundError)
    assert "switched on" in str(late)
    assert "unknown" in str(unknown)


def test_what_is_no_port_is_a_usage_error() -> None:
    async def main() -> None:
        with pytest.raises(UsageError):
            await open_port("nonsense", baud=9600)

    run(main())


# ---------------------------------------------------------------- opened again


def test_a_device_that_is_opened_again_brings_nothing_of_before(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        os.write(near, b"before")
        await link.close()
        os.write(near, b"meanwhile")
        await link.reopen()
        assert await link.read(link.now()) == b""
        os.write(near, b"now")
        assert await read_all(link, 3) == b"now"
        link.write_urgent(b"!")
        assert await heard(near, 1) == b"!"
        with pytest.raises(PortBusyError):
            await open_port(path, baud=9600)
        await link.close()

    run(main())


def test_a_device_that_is_not_there_yet_can_be_tried_again(device: tuple[int, str], tmp_path: Path) -> None:
    async def main() -> None:
        near, path = device
        plug = tmp_path / "ttyUSB0"
        plug.symlink_to(path)
        link = await open_port(str(plug), baud=9600)
        plug.unlink()
        await link.close()
        before = descriptors()
        for _ in range(3):
            with pytest.raises(PortNotFoundError, match="no port"):
                await link.reopen()
            with pytest.raises(LinkClosedError, match="closed"):
                link.write(b"x")
        assert descriptors() == before
        plug.symlink_to(path)
        await link.reopen()
        link.write(b"here")
        assert await heard(near, 4) == b"here"
        await link.close()

    run(main())


def test_the_name_of_a_pseudo_terminal_whose_program_is_gone_is_another_s_soon(tmp_path: Path) -> None:
    async def main() -> None:
        near, far = pty.openpty()
        tty.setraw(far)
        path = os.ttyname(far)
        plug = tmp_path / "ttyUSB0"
        plug.symlink_to(path)
        for name, is_gone in ((path, True), (str(plug), False)):
            link = await open_port(name, baud=9600)
            if name == path:
                # It was closed, but is there yet.
                await link.close()
                await link.reopen()
            os.close(far)
            os.close(near)
            with pytest.raises(LinkClosedError):
                await read_all(link, 1)
            await link.close()
            near, far = pty.openpty()  # which may have the name again
            tty.setraw(far)
            plug.unlink()
            plug.symlink_to(os.ttyname(far))
            if is_gone:
                with pytest.raises(LinkClosedError, match="has gone, and does not come back"):
                    await link.reopen()
            else:
                await link.reopen()
                await link.close()
        os.close(near)
        os.close(far)

    run(main())


def test_an_opening_that_is_cancelled_leaves_nothing_behind(device: tuple[int, str]) -> None:
    async def main() -> None:
        link = await open_port(device[1], baud=9600)
        await link.close()
        before = descriptors()
        for rounds in range(12):
            opening = asyncio.create_task(link.reopen())
            for _ in range(rounds):
                await asyncio.sleep(0.0)
            opening.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await opening
                await link.close()
            assert descriptors() == before

    run(main())


def test_a_server_that_accepts_again_is_reached_again() -> None:
    async def main() -> None:
        loop = asyncio.get_running_loop()
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(0.0)
            link = await open_port(f"socket://127.0.0.1:{server.getsockname()[1]}", baud=9600)
            first, _ = await loop.sock_accept(server)
            with first:
                await loop.sock_sendall(first, b"old")
                assert await read_all(link, 3) == b"old"
            with pytest.raises(LinkClosedError):
                await read_all(link, 1)
            await link.close()
            await link.reopen()
            second, _ = await loop.sock_accept(server)
            with second:
                await loop.sock_sendall(second, b"new")
                assert await read_all(link, 3) == b"new"
            await link.close()

    run(main())


def test_bytes_that_an_old_connection_brings_late_do_not_mix_in(device: tuple[int, str]) -> None:
    async def main() -> None:
        near, path = device
        link = await open_port(path, baud=9600)
        old = link._connection
        await link.close()
        await link.reopen()
        old.data_received(b"late")
        old.connection_lost(OSError("late"))
        os.write(near, b"now")
        assert await read_all(link, 3) == b"now"
        await link.close()

    run(main())


def test_a_peer_that_takes_nothing_does_not_keep_a_link_from_being_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(stream, "CLOSE_TIMEOUT_S", 0.05)

    async def main() -> None:
        loop = asyncio.get_running_loop()
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(0.0)
            link = await open_port(f"socket://127.0.0.1:{server.getsockname()[1]}", baud=9600)
            robot, _ = await loop.sock_accept(server)
            with robot:
                link.write(bytes(1 << 24))
                before = descriptors()
                await link.close()
                assert len(descriptors()) == len(before) - 1

    run(main())


# ---------------------------------------------------------------- a new pty


class Comer:
    """Opens the far end as soon as it hears of it."""

    def __init__(self) -> None:
        self.path = ""
        self.robot = -1

    def __call__(self, path: str) -> None:
        self.path = path
        self.come()

    def come(self) -> None:
        self.robot = os.open(self.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def go(self) -> None:
        os.close(self.robot)


@pytest.fixture
def comer() -> Iterator[Comer]:
    made = Comer()
    yield made
    with contextlib.suppress(OSError):  # gone already
        made.go()


def test_a_robot_comes_to_a_new_pty_and_leaves_and_comes_again(comer: Comer) -> None:
    async def main() -> None:
        link = await open_port("pty", baud=9600, announce=comer)
        for number in range(2):
            if number:
                comer.come()
            robot = comer.robot
            link.write(b"F\r\n\x03")
            assert await heard(robot, 4) == b"F\r\n\x03"
            os.write(robot, b"QH\r")
            assert await read_all(link, 3) == b"QH\r"
            os.close(robot)
        await link.close()
        await link.close()
        with pytest.raises(LinkClosedError):
            link.write(b"x")

    run(main())


def test_a_new_pty_is_raw_and_waits_until_somebody_opens_it() -> None:
    async def main() -> None:
        announced: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        before = descriptors()
        opening = asyncio.create_task(open_port("pty", baud=9600, announce=announced.set_result))
        path = await announced
        # However often it looks, nobody is there.
        for _ in range(5):
            await asyncio.sleep(0.0)
        assert not opening.done()
        robot = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        os.write(robot, b"\r\n\x03")
        os.close(robot)  # at once: it is noticed by what it has left behind
        link = await opening
        assert await read_all(link, 3) == b"\r\n\x03"
        await link.close()
        assert descriptors() == before

    run(main())


def test_whoever_stops_waiting_at_a_new_pty_leaves_nothing_behind() -> None:
    async def main() -> None:
        announced: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        before = descriptors()
        opening = asyncio.create_task(open_port("pty", baud=9600, announce=announced.set_result))
        await announced
        opening.cancel()
        with pytest.raises(asyncio.CancelledError):
            await opening
        assert descriptors() == before

    run(main())


def test_a_pty_whose_robot_does_not_read_never_blocks_and_loses_nothing(comer: Comer) -> None:
    async def main() -> None:
        link = await open_port("pty:", baud=9600, announce=comer)
        robot = comer.robot
        sent = bytes(range(256)) * 1024
        link.write(sent)
        assert await heard(robot, len(sent)) == sent
        link.write(b"!")
        assert await heard(robot, 1) == b"!"
        os.close(robot)
        await link.close()

    run(main())


def test_a_pty_that_fails_ends_the_link(comer: Comer) -> None:
    async def main() -> None:
        for failing in ("_readable", "_writable"):
            link = await open_port("pty", baud=9600, announce=comer)
            transport: Any = link._connection.transport
            broken = os.open("/dev/null", os.O_RDONLY if failing == "_writable" else os.O_WRONLY)
            near, transport._near = transport._near, broken
            asyncio.get_running_loop().remove_reader(near)
            transport._unsent += b"x"
            getattr(transport, failing)()
            os.close(near)
            with pytest.raises(LinkClosedError):
                await link.read(math.inf)
            await link.close()
            comer.go()

    run(main())


def test_nothing_to_read_is_no_end(comer: Comer) -> None:
    async def main() -> None:
        link = await open_port("pty", baud=9600, announce=comer)
        transport: Any = link._connection.transport
        transport._readable()
        transport._unsent += bytes(1 << 17)
        for _ in range(9):
            transport._writable()  # until the system holds no more
        assert transport._unsent
        assert await link.read(link.now()) == b""
        await link.close()

    run(main())


def test_a_system_without_ptys_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pty", None)

    async def main() -> None:
        with pytest.raises(LinkError, match="no pty"):
            await open_port("pty", baud=9600)

    run(main())


def test_a_link_that_was_never_opened() -> None:
    async def main() -> None:
        async def never(_: Connection) -> None:
            raise AssertionError

        link = StreamLink("x", never)
        with pytest.raises(LinkClosedError, match="not open"):
            link.write(b"x")
        await link.close()

    run(main())
