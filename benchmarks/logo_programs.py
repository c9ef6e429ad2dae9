"""Logo programs, start to end: ours, Debian's UCBLogo (in C) and py3logo, by the processor's time that each takes.

UCBLogo opens a window, so it runs under Xvfb; py3logo runs what it can. What each prints is compared first.

Ratios are given twice. *Whole*: of whole processes, from starting to the end, as somebody has who runs the program.
*Net*: without what an empty program takes of each, which is the language alone; the short programs of the workload
(queens, fib ...) are over before either of the two has started properly. Programs of our own take UCBLogo seconds, so
that it makes no difference. Ours have been run before: what is compiled comes from the disk.

Then what compiling costs: a program of 2,000 lines, beside Python's own compiler with a program of that length; and
starting.
"""

from __future__ import annotations

import math
import os
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from turtlewire.logo import Interpreter, ScreenTurtle

PROGRAMS = Path(__file__).with_name("logo")
RUNS = 3
PATIENCE_S = 120.0
AIM, LEAST, AIM_FIB, AIM_TURTLE = 15.0, 4.0, 40.0, 15.0
LEAST_NET_S = 0.001  # less cannot be measured
ROUTINE = """\
to routine.{0} :n :list
  local "sum
  make "sum 0
  repeat :n [make "sum :sum + repcount * {0}]
  if :sum > 100 [output fput :sum :list]
  foreach :list [make "sum :sum + ?]
  output map [? + :n] sentence :sum :list
end
"""


class Result(NamedTuple):
    """What a program printed, and the processor's time that it took, in seconds."""

    printed: str
    cpu_s: float


def timed(command: list[str]) -> Result | None:
    """Run a command; ``None`` if it failed, or did not end."""
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.DEVNULL,
            env={name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"},
        )
        deadline = time.monotonic() + PATIENCE_S
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                process.kill()
                os.wait4(process.pid, 0)
                return None
            time.sleep(0.005)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            return None
        output.seek(0)
        return Result(output.read(), usage.ru_utime + usage.ru_stime)


def ours(program: Path) -> Result | None:
    """``turtlewire logo PROGRAM``."""
    return timed([str(Path(sys.executable).with_name("turtlewire")), "logo", str(program)])


def ucblogo(program: Path) -> Result | None:
    """Debian's UCBLogo, from starting to BYE."""
    with tempfile.TemporaryDirectory() as folder:
        main, printed = Path(folder, "main.lg"), Path(folder, "printed")
        lines = [
            f'openwrite "{printed}',
            f'setwrite "{printed}',
            f'load "{program}',
            "setwrite []",
            f'close "{printed}',
        ]
        main.write_text("\n".join([*lines, "bye", ""]))
        result = timed(["ucblogo", str(main)])
        return Result(printed.read_text(), result.cpu_s) if result is not None and printed.exists() else None


def py3logo(program: Path) -> Result | None:
    """PyPI's py3logo."""
    result = timed([sys.executable, "-m", "py3logo.script", "-c", "-q", str(program)])
    # It says what it loads, on the standard output.
    return result._replace(printed=result.printed.partition("\n")[2]) if result is not None else None


def best(run: list[Result | None]) -> Result | None:
    """The quickest of several runs."""
    found = [each for each in run if each is not None]
    return min(found, key=lambda each: each.cpu_s) if found else None


class Ratios(NamedTuple):
    """How many times as long as ours another Logo takes: whole processes, and without their starting."""

    whole: float
    net: float


def compare() -> None:
    """The table of programs."""
    has_py3logo = shutil.which("py3logo") is not None or _has_module("py3logo")
    ratios: dict[str, Ratios] = {}
    mine_empty, theirs_empty = empty()
    print(f"starting and ending: turtlewire {mine_empty:.3f} s, UCBLogo {theirs_empty:.3f} s")
    print(
        f"{'program':14} {'turtlewire':>10} {'UCBLogo':>9} {'whole':>7} {'net':>7} {'py3logo':>9}   CPU seconds"
    )
    for program in sorted(PROGRAMS.glob("*.logo")):
        mine = best([ours(program) for _ in range(RUNS + 1)])
        theirs = best([ucblogo(program) for _ in range(RUNS)]) if program.stem != "depth" else None
        slow = best([py3logo(program)]) if has_py3logo else None
        assert mine is not None, f"{program.stem} does not run"
        other = f"{slow.cpu_s:9.2f}" if slow is not None and slow.printed == mine.printed else f"{'-':>9}"
        if theirs is None:
            print(f"{program.stem:14} {mine.cpu_s:10.3f} {'-':>9} {'-':>7} {'-':>7} {other}")
            continue
        assert theirs.printed == mine.printed, f"{program.stem}: {mine.printed!r}, UCBLogo {theirs.printed!r}"
        net = (theirs.cpu_s - theirs_empty) / max(mine.cpu_s - mine_empty, LEAST_NET_S)
        ratios[program.stem] = found = Ratios(theirs.cpu_s / mine.cpu_s, net)
        print(
            f"{program.stem:14} {mine.cpu_s:10.3f} {theirs.cpu_s:9.2f} {found.whole:7.1f} {found.net:7.1f} {other}",
            flush=True,
        )
    for title in Ratios._fields:
        each = [getattr(found, title) for found in ratios.values()]
        mean = math.exp(statistics.fmean(math.log(ratio) for ratio in each))
        print(f"{title}: geometric mean {mean:.1f} (the aim is {AIM:g}), least {min(each):.1f} ({LEAST:g})")
    fib, turtle = ratios["fib"], ratios["turtle"]
    print(f"fib 24: whole {fib.whole:.1f}, net {fib.net:.1f} ({AIM_FIB:g})")
    print(f"REPEAT 100000 [FD 1 RT 1]: whole {turtle.whole:.1f}, net {turtle.net:.1f} ({AIM_TURTLE:g})")


def empty() -> tuple[float, float]:
    """What an empty program takes of us and of UCBLogo, in seconds of the processor."""
    with tempfile.NamedTemporaryFile(suffix=".logo") as nothing:
        mine = best([ours(Path(nothing.name)) for _ in range(3 * RUNS)])
        theirs = best([ucblogo(Path(nothing.name)) for _ in range(2 * RUNS)])
    assert mine is not None
    assert theirs is not None
    return mine.cpu_s, theirs.cpu_s


def _has_module(name: str) -> bool:
    from importlib.util import find_spec

    return find_spec(name) is not None


def compiling() -> None:
    """What compiling 2,000 lines takes, beside Python with as many of its own."""
    count = 2000 // len(ROUTINE.splitlines())
    source = "".join(ROUTINE.format(index) for index in range(count))
    calls = "".join(f"ignore routine.{index} 1 [1 2]\n" for index in range(count))
    times = []
    logo = Interpreter(ScreenTurtle(), lambda _: None, random.Random(0))
    for _ in range(RUNS):
        logo = Interpreter(ScreenTurtle(), lambda _: None, random.Random(0))
        begun = time.process_time()
        logo.run(source + calls, "long.logo")
        times.append(time.process_time() - begun)
    sources = [logo.compiler.source(logo.procedures[f"routine.{index}"]) for index in range(count)]  # type: ignore[arg-type]
    python = "\n".join(text for text in sources if text is not None)
    python_times = []
    for _ in range(RUNS):
        begun = time.process_time()
        compile(python, "long.py", "exec")
        python_times.append(time.process_time() - begun)
    print(
        f"a program of {len(source.splitlines()):,} lines, read, compiled and run once: {min(times):.3f} s, "
        f"{min(times) / min(python_times):.1f} times Python's compile of the {len(python.splitlines()):,} lines made"
    )


def starting() -> None:
    """What starting takes, beside Python's."""
    with tempfile.NamedTemporaryFile(suffix=".logo") as empty:
        mine = best([ours(Path(empty.name)) for _ in range(3 * RUNS)])
    python = best([timed([sys.executable, "-c", "pass"]) for _ in range(3 * RUNS)])
    assert mine is not None
    assert python is not None
    print(f"an empty program: {mine.cpu_s / python.cpu_s:.1f} times `python -c pass` ({python.cpu_s:.3f} s)")


def main() -> None:
    """Print it all."""
    if shutil.which("ucblogo") is None or shutil.which("Xvfb") is None:
        raise SystemExit("UCBLogo is measured under Xvfb: on Debian, apt install ucblogo xvfb")
    display = ":93"
    with subprocess.Popen(["Xvfb", display], stderr=subprocess.DEVNULL) as server:
        os.environ["DISPLAY"] = display
        time.sleep(1.0)
        try:
            compare()
        finally:
            server.terminate()
    compiling()
    starting()


if __name__ == "__main__":
    main()
