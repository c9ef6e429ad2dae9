"""A port that is kept from others while something else works at it."""

from __future__ import annotations

import asyncio
import os
import select
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LinkError, PortBusyError, PortNotFoundError
from turtlewire.links.held import held
from turtlewire.links.stream import open_port

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture
def ends() -> Iterator[tuple[int, str]]:
    near, far = os.openpty()
    yield near, os.ttyname(far)
    os.close(far)


async def opened(path: str) -> None:
    link = await open_port(path, baud=9600)
    await link.close()


def test_nobody_else_gets_it(ends: tuple[int, str]) -> None:
    near, path = ends
    with held(path):
        with pytest.raises(PortBusyError), held(path):
            pass
        with pytest.raises(PortBusyError):
            asyncio.run(opened(path))
    asyncio.run(opened(path))
    with held(path) as fileno:
        assert fileno is not None
        poll = select.poll()
        poll.register(fileno, 0)
        assert poll.poll(0) == []
        os.close(near)
        assert dict(poll.poll(0))[fileno] & select.POLLHUP


def test_what_cannot_be_held(tmp_path: Path) -> None:
    with pytest.raises(PortNotFoundError, match="there is no port"), held(str(tmp_path / "tty")):
        pass
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", Path("/dev/null")):
        with pytest.raises(LinkError, match="is no serial port"), held(str(path)):
            pass
