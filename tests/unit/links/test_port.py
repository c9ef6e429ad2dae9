"""Ports as people write them."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire.errors import UsageError
from turtlewire.links.port import Port


@pytest.mark.parametrize(
    ("text", "port"),
    [
        ("/dev/ttyUSB0", Port("serial", "/dev/ttyUSB0")),
        ("COM3", Port("serial", "COM3")),
        ("com12", Port("serial", "com12")),
        (r"\\.\COM10", Port("serial", r"\\.\COM10")),
        ("serial:///dev/ttyUSB0", Port("serial", "/dev/ttyUSB0")),
        ("serial:///dev/ttyUSB0?baud=115200", Port("serial", "/dev/ttyUSB0", baud=115200)),
        ("serial://COM3", Port("serial", "COM3")),
        ("socket://127.0.0.1:4000", Port("socket", host="127.0.0.1", number=4000)),
        ("socket://[::1]:4000/", Port("socket", host="::1", number=4000)),
        ("pty", Port("pty")),
        ("pty:", Port("pty")),
    ],
)
def test_ports(text: str, port: Port) -> None:
    assert Port.parse(text) == port


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "no port"),
        ("ttyUSB0", "no port"),
        ("COM", "no port"),
        ("COM3x", "no port"),
        ("ftp://x", "'ftp'"),
        ("serial://", "names no device"),
        ("serial:///dev/x?baud=fast", "baud"),
        ("serial:///dev/x?baud=49", "baud"),
        ("serial:///dev/x?baud=4000001", "baud"),
        ("serial:///dev/x?baud=", "baud"),
        ("serial:///dev/x?baud=²", "baud"),
        ("serial:///dev/x?parity=odd", "'parity'"),
        ("socket://host", "port number"),
        ("socket://:4000", "port number"),
        ("socket://host:x", "port number"),
        ("socket://host:70000", "port number"),
        ("socket://host:1/path", "port number"),
        ("socket://host:1?x=1", "'x'"),
        ("socket://[::1", "socket"),
    ],
)
def test_what_is_no_port(text: str, complaint: str) -> None:
    with pytest.raises(UsageError, match=complaint.replace("(", r"\(")):
        Port.parse(text)


@given(st.one_of(st.text(), st.text().map("socket://".__add__), st.text().map("serial://".__add__)))
def test_any_text_is_a_port_or_a_usage_error(text: str) -> None:
    with contextlib.suppress(UsageError):
        assert Port.parse(text).kind in ("serial", "socket", "pty")
