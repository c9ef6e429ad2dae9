from __future__ import annotations

import math

import pytest

from turtlewire.errors import LinkClosedError, PortNotFoundError, UsageError
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.runner import InlineRunner

RUNNER = InlineRunner()


class Echo:
    """A far end in virtual time that sends back what it gets, 1 s later."""

    def __init__(self) -> None:
        self.now = 0.0
        self.opened = 0
        self.got: list[tuple[float, bytes]] = []
        self._back: list[tuple[float, bytes]] = []

    def write(self, data: bytes) -> None:
        self.got.append((self.now, data))
        self._back.append((self.now + 1.0, data))

    def discard_output(self) -> None:
        self.got.append((self.now, b"discard"))

    def awaits_host(self) -> bool:
        return False

    def port_opened(self) -> None:
        self.opened += 1

    def read(self, until: float) -> bytes:
        if self._back and self._back[0][0] <= until:
            self.now, data = self._back.pop(0)
            return data
        self.now = max(self.now, min(until, 1e6))
        return b""


def link(text: str) -> tuple[FaultyLink, Echo]:
    end = Echo()
    return FaultyLink(MemoryLink(end), Faults.parse(text)), end


def read(faulty: FaultyLink, until: float) -> bytes:
    return RUNNER.run(faulty.read(until))


def read_all(faulty: FaultyLink, until: float) -> list[bytes]:
    pieces = []
    while faulty.now() < until:
        if piece := read(faulty, until):
            pieces.append(piece)
    return pieces


def test_without_faults_everything_gets_through_as_it_is() -> None:
    faulty, end = link("")
    faulty.write(b"abc")
    assert end.got == [(0.0, b"abc")]
    assert read(faulty, 5.0) == b"abc"
    assert faulty.now() == 1.0
    assert read(faulty, 5.0) == b""
    assert faulty.now() == 5.0


@pytest.mark.parametrize(
    ("text", "expected"),
    [("lose:1", b""), ("duplicate:1", b"aabbcc"), ("to:robot,lose:1", b""), ("to:host,lose:1", b"abc")],
)
def test_certain_faults_towards_the_robot(text: str, expected: bytes) -> None:
    faulty, end = link(text)
    faulty.write(b"abc")
    assert b"".join(data for _, data in end.got) == expected


def test_added_bytes_come_before_the_others() -> None:
    faulty, end = link("add:1,to:robot")
    faulty.write(b"abc")
    (_, data), *_ = end.got
    assert data[1::2] == b"abc"
    assert faulty.added == 3


def test_a_flip_turns_one_bit() -> None:
    faulty, end = link("flip:1,to:robot")
    faulty.write(b"\x00\xff")
    (_, data), *_ = end.got
    assert [(a ^ b).bit_count() for a, b in zip(data, b"\x00\xff", strict=True)] == [1, 1]
    assert faulty.flipped == 2


def test_rates_are_rates_in_both_directions_and_the_seed_decides() -> None:
    results = []
    for seed in (1, 1, 2):
        faulty, end = link(f"lose:0.1,seed:{seed}")
        faulty.write(bytes(10_000))
        received = sum(map(len, read_all(faulty, 5.0)))
        sent = sum(len(data) for _, data in end.got)
        assert 8_500 < sent < 9_500
        assert 0.85 * sent < received < 0.95 * sent
        assert faulty.lost == 10_000 - received
        results.append((sent, received))
    assert results[0] == results[1] != results[2]


def test_split_cuts_into_pieces() -> None:
    faulty, end = link("split:2")
    faulty.write(b"abcde")
    assert [data for _, data in end.got] == [b"ab", b"cd", b"e"]


def test_a_delay_keeps_the_order() -> None:
    faulty, end = link("delay:0.5,seed:3")
    for byte in b"abcdefgh":
        faulty.write(bytes([byte]))
    back = read_all(faulty, 9.0)
    assert b"".join(data for _, data in end.got) == b"abcdefgh" == b"".join(back)
    times = [at for at, _ in end.got]
    assert times == sorted(times)
    assert 0.0 < times[-1] <= 0.5


def test_a_stall_holds_everything_back_and_then_lets_it_through() -> None:
    faulty, end = link("stall:2+3,to:robot")
    assert read(faulty, 2.5) == b""
    faulty.write(b"late")
    assert end.got == []
    assert read(faulty, 10.0) == b"late"
    assert end.got == [(5.0, b"late")]


def test_a_close_ends_the_link_on_time() -> None:
    faulty, _ = link("close:4")
    assert read(faulty, 3.0) == b""
    with pytest.raises(LinkClosedError, match="asked for"):
        read(faulty, math.inf)
    assert faulty.now() == 4.0
    with pytest.raises(LinkClosedError):
        faulty.write(b"x")
    with pytest.raises(LinkClosedError):
        faulty.write_urgent(b"x")


def test_a_link_that_ended_can_be_opened_again_when_it_is_there_again() -> None:
    faulty, end = link("close:4+2")
    with pytest.raises(LinkClosedError):
        read(faulty, math.inf)
    RUNNER.run(faulty.close())
    for at in (4.0, 5.0, 5.99):
        RUNNER.run(faulty.sleep(at))
        with pytest.raises(PortNotFoundError, match="asked for"):
            RUNNER.run(faulty.reopen())
        assert end.opened == 0
    RUNNER.run(faulty.sleep(6.0))
    RUNNER.run(faulty.reopen())
    assert end.opened == 1
    faulty.write(b"on")
    assert read(faulty, 100.0) == b"on"  # and it does not end once more
    assert read(faulty, 100.0) == b""


def test_what_was_on_its_way_when_the_link_ended_is_lost_and_the_faults_go_on() -> None:
    faulty, end = link("close:1,stall:0+0.9,stall:8+1,to:robot")
    faulty.write(b"late")
    assert read(faulty, 0.95) == b""
    with pytest.raises(LinkClosedError):
        read(faulty, math.inf)
    end.got.clear()
    RUNNER.run(faulty.close())
    RUNNER.run(faulty.reopen())
    RUNNER.run(faulty.sleep(8.5))
    faulty.write(b"stalled")
    assert end.got == []
    assert read(faulty, 20.0) == b"stalled"
    assert end.got == [(9.0, b"stalled")]


def test_chance_does_not_begin_anew() -> None:
    def damage(*, reopened: bool) -> list[bytes]:
        faulty, end = link("lose:0.5,to:robot,seed:3")
        faulty.write(bytes(range(100)))
        if reopened:
            RUNNER.run(faulty.close())
            RUNNER.run(faulty.reopen())
        faulty.write(bytes(range(100)))
        return [data for _, data in end.got]

    assert damage(reopened=True) == damage(reopened=False)


def test_an_urgent_write_takes_back_what_is_late() -> None:
    faulty, end = link("stall:0+3,to:robot")
    faulty.write(b"move")
    faulty.write_urgent(b"stop")
    read_all(faulty, 3.5)
    assert end.got == [(3.0, b"stop")]


@pytest.mark.parametrize("seed", range(10))
def test_nothing_overtakes_an_urgent_write(seed: int) -> None:
    faulty, end = link(f"delay:1,seed:{seed}")
    faulty.write_urgent(b"stop")
    for byte in b"12345":
        faulty.write(bytes([byte]))
    read_all(faulty, 2.0)
    assert b"".join(data for _, data in end.got if data != b"discard") == b"stop12345"


def test_an_urgent_write_is_passed_on_as_urgent() -> None:
    faulty, end = link("")
    faulty.write_urgent(b"stop")
    assert end.got == [(0.0, b"discard"), (0.0, b"stop")]


# ------------------------------------------------------------------ changed while it is open


def test_adjusted_faults_begin_at_once_and_end_without_a_trace() -> None:
    faulty, end = link("")
    assert faulty.faults == Faults()
    faulty.write(b"abc")
    faulty.adjust(Faults(lose=1.0))
    assert faulty.faults.lose == 1.0
    faulty.write(b"def")
    faulty.adjust(Faults())
    for byte in range(256):
        faulty.write(bytes([byte]))
    assert b"".join(data for _, data in end.got) == b"abc" + bytes(range(256))
    assert b"".join(read_all(faulty, 5.0)) == b"abc" + bytes(range(256))
    assert (faulty.lost, faulty.added, faulty.flipped, faulty.duplicated) == (3, 0, 0, 0)


def test_what_is_late_stays_late_when_the_delay_ends_and_the_order_is_kept() -> None:
    faulty, end = link("delay:2,to:robot,seed:1")
    faulty.write(b"late")
    assert end.got == []
    faulty.adjust(Faults())
    faulty.write(b"new")
    assert end.got == []
    assert b"".join(read_all(faulty, 9.0)) == b"latenew"
    assert [data for _, data in end.got] == [b"late", b"new"]
    assert 0.0 < end.got[0][0] == end.got[1][0] < 2.0
    faulty.write(b"at once")
    assert end.got[-1] == (faulty.now(), b"at once")


def test_chance_goes_on_where_the_seed_stays_and_begins_anew_with_another() -> None:
    def damage(*seeds: int) -> list[bytes]:
        faulty, end = link("lose:0.5,to:robot,seed:3")
        faulty.write(bytes(range(100)))
        for seed in seeds:
            faulty.adjust(Faults(lose=0.5, to="robot", seed=seed))
        faulty.write(bytes(range(100)))
        return [data for _, data in end.got]

    assert damage() == damage(3)
    first, again = damage(4, 3)
    assert first == again == damage()[0] != damage()[1]


def test_a_stall_by_hand_holds_back_what_is_late_and_what_is_new() -> None:
    faulty, end = link("delay:1,seed:1")
    faulty.write(b"late")
    assert read(faulty, 0.01) == b""
    faulty.stall(3.0)
    faulty.write(b"new")
    faulty.adjust(Faults())  # which does not end it
    assert read(faulty, 3.0) == b""
    assert end.got == []
    assert b"".join(read_all(faulty, 9.0)) == b"latenew"
    assert [at for at, _ in end.got] == [3.01, 3.01]


@pytest.mark.parametrize(
    ("to", "heard_at", "answer_at"), [("robot", 2.0, 3.0), ("host", 0.0, 2.0), ("", 2.0, 3.0)]
)
def test_a_stall_by_hand_keeps_to_the_direction(to: str, heard_at: float, answer_at: float) -> None:
    faulty, end = link(f"to:{to}" if to else "")
    faulty.stall(2.0)
    faulty.write(b"x")
    assert read(faulty, 9.0) == b"x"
    assert faulty.now() == answer_at
    assert end.got == [(heard_at, b"x")]


def test_an_urgent_write_waits_for_the_end_of_a_stall_and_nothing_overtakes_it() -> None:
    faulty, end = link("")
    faulty.stall(2.0)
    faulty.write(b"move")
    faulty.write_urgent(b"stop")
    faulty.write(b"on")
    read_all(faulty, 9.0)
    assert end.got == [(2.0, b"stop"), (2.0, b"on")]


def test_while_the_link_is_closed_a_stall_ends_no_sleep() -> None:
    faulty, _ = link("")
    faulty.write(b"x")
    faulty.stall(1.0)
    RUNNER.run(faulty.sleep(4.0))
    assert faulty.now() == 4.0


def test_who_waits_for_bytes_hears_of_the_plug_at_once() -> None:
    class Woken(MemoryLink):
        times = 0

        def wake(self) -> None:
            self.times += 1

    within = Woken(Echo())
    faulty = FaultyLink(within, Faults())
    faulty.adjust(Faults())
    assert within.times == 1
    faulty.stall(1.0)
    assert within.times == 2
    faulty.unplug(1.0)
    assert within.times == 3


def test_the_plug_is_pulled_and_put_back() -> None:
    faulty, end = link("lose:0")
    assert read(faulty, 2.0) == b""
    faulty.unplug(3.0)
    with pytest.raises(LinkClosedError, match="asked for"):
        faulty.write(b"x")
    with pytest.raises(LinkClosedError):
        read(faulty, 9.0)
    RUNNER.run(faulty.close())
    faulty.adjust(Faults(delay_s=0.1))  # which does not put it back
    for at in (2.0, 4.9):
        RUNNER.run(faulty.sleep(at))
        with pytest.raises(PortNotFoundError):
            RUNNER.run(faulty.reopen())
    RUNNER.run(faulty.sleep(5.0))
    RUNNER.run(faulty.reopen())
    assert end.opened == 1
    faulty.write(b"on")
    assert read(faulty, 20.0) == b"on"


def test_an_end_by_schedule_can_be_put_off() -> None:
    faulty, _ = link("close:4")
    assert read(faulty, 3.0) == b""
    faulty.adjust(Faults(close_at_s=6.0))
    assert read(faulty, 5.0) == b""
    with pytest.raises(LinkClosedError):
        read(faulty, math.inf)
    assert faulty.now() == 6.0


def test_closing_closes_the_link_within() -> None:
    faulty, _ = link("")
    faulty.wake()
    RUNNER.run(faulty.close())
    with pytest.raises(LinkClosedError):
        faulty.write(b"x")


@pytest.mark.parametrize(
    "text",
    [
        "lose",
        "lose:2",
        "lose:-1",
        "lose:x",
        "lose:nan",
        "to:moon",
        "stall:3",
        "melt:1",
        "split:-1",
        "close:-3",
    ],
)
def test_what_means_nothing_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=f"{text}.*lose:RATE"):
        Faults.parse(text)


def test_the_form_is_read_completely() -> None:
    text = "lose:0.1,add:0.2,flip:0.3,duplicate:0.4,delay:0.5,split:6,stall:7+8,stall:9+1,close:10,seed:-11,to:host"
    assert Faults.parse(text) == Faults(
        0.1, 0.2, 0.3, 0.4, 0.5, 6, ((7.0, 8.0), (9.0, 1.0)), 10.0, -11, "host"
    )
