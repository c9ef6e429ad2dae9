"""Robots at ports that come and go."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.unit.robots.reconnecting.ports import ROBOTS, Port

if TYPE_CHECKING:
    from pathlib import Path

MakePort = Callable[..., Port]


@pytest.fixture
def port(tmp_path: Path) -> Iterator[MakePort]:
    """A robot of a protocol at a port of a kind: ``port("walter", "pty", boot_s=1.0)``."""
    ports: list[Port] = []

    def make(protocol: str, kind: str = "socket", **settings: Any) -> Port:
        folder = tmp_path / str(len(ports))
        folder.mkdir()
        ports.append(Port(kind, ROBOTS[protocol](**settings), folder))
        return ports[-1]

    yield make
    for one in ports:
        one.unplug()
