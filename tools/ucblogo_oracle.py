"""Let UCBLogo supply, or check again, what the programs in tests/vectors/logo do.

Usage:
    python tools/ucblogo_oracle.py check           compare every case with the installed UCBLogo
    python tools/ucblogo_oracle.py record          write UCBLogo's answers into the cases

Needs Debian's packages ucblogo and xvfb. A case says what UCBLogo does (``output`` and ``error``, both null when it
does not come back); where turtlewire differs on purpose it also has ``differs`` (why) and ``ours`` (what turtlewire
does instead). One that is ``alone`` leaves a workspace behind in which nothing else can run.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

VECTORS = Path(__file__).resolve().parent.parent / "tests" / "vectors" / "logo"
ORIGIN = "ucblogo 6.2.2"
_MARK = "@@error"
_BEGINNING = 'make "..b [] buryname "..b make "..b buried'
_TIMEOUT_S = 6  # for one process
_PATIENCE_S = 60  # for a program by itself that is known to come back, on a busy computer
_BATCH = 50  # programs that one process runs at most


def _main_program(folder: Path, index: int, *, cleans: bool) -> str:
    """The lines that run one case and write what it printed, and its error if there was one, to a file.

    With ``cleans`` they leave the workspace as it was.
    """
    runs = [
        f'openwrite "{folder}/out{index}',
        f'setwrite "{folder}/out{index}',
        "cs",
        f'catch "error [load "{folder}/case{index}.lg]',
        'make "..e error',
        'make "fullprintp "false ern [printdepthlimit printwidthlimit]',  # for what is printed here
        f'if not emptyp :..e [print "{_MARK} print item 1 :..e print item 2 :..e show item 3 :..e]',
        "setwrite [] setread [] setprefix [] nodribble",
        "closeall",
    ]
    tidies = [
        "untrace traced unstep stepped",
        "unburyall",
        "bury :..b",  # what was buried when it began; the library is loaded again as it is needed
        "erall",
        'make "caseignoredp "true make "allowgetset "true make "unburyonedit "true',
    ]
    return "\n".join(runs + tidies if cleans else runs)


def ask(programs: list[str], timeout_s: int = _TIMEOUT_S) -> list[dict[str, Any] | None]:
    """What UCBLogo does with each program; ``None`` where it did not come back (an uncaught THROW ends it)."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for index, program in enumerate(programs):
            (folder / f"case{index}.lg").write_text(program + "\n", encoding="utf-8")
        lines = [_main_program(folder, index, cleans=len(programs) > 1) for index in range(len(programs))]
        (folder / "main.lg").write_text("\n".join([_BEGINNING, *lines, "bye", ""]), encoding="utf-8")
        command = ["xvfb-run", "-a", "timeout", str(timeout_s), "ucblogo", str(folder / "main.lg")]
        (folder / "work").mkdir()  # where the files are that programs write
        subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, check=False, cwd=folder / "work"
        )
        return [
            _read_answer(folder / f"out{index}", folder / f"out{index + 1}") for index in range(len(programs))
        ]


def _read_answer(path: Path, following: Path) -> dict[str, Any] | None:
    if not path.exists():
        return None
    # turtlewire always prints UCBLogo's "how  to" with one space.
    text = path.read_text(encoding="utf-8", errors="replace").replace("how  to", "how to")
    output, marked, error = text.rpartition(f"{_MARK}\n")
    if not marked:
        # Nothing tells an unfinished case from a silent one but whether UCBLogo went on to the next.
        return {"output": text, "error": None} if text or following.exists() else None
    number, sentence, procedure = (
        error.rstrip("\n").rsplit("\n", 2) if error.count("\n") > 2 else error.split("\n")[:3]
    )
    return {
        "output": output,
        "error": {
            "number": int(number),
            "text": " ".join(sentence.split()),
            "procedure": None if procedure == "[]" else procedure,
        },
    }


def ask_all(cases: list[dict[str, Any]]) -> list[dict[str, Any] | None]:
    """Ask in one process as far as it lives, and go on in a new one behind the program that ended it.

    A program that was known to come back, and did not, is asked again by itself, with patience.
    """
    answers: list[dict[str, Any] | None] = []
    while len(answers) < len(cases):
        rest = cases[len(answers) :]
        alone = next((i for i, case in enumerate(rest) if "alone" in case), len(rest))
        if alone == 0:
            answers += ask([rest[0]["program"]], _PATIENCE_S)
            continue
        batch = [case["program"] for case in rest[: min(alone, _BATCH)]]
        found = ask([*batch, "print 1"])[:-1]  # so that the last of them can be seen to have come back
        alive = next((i for i, answer in enumerate(found) if answer is None), len(found))
        answers += found[:alive]
        if alive < len(found):
            ended = rest[alive]
            is_known_to_return = ended["output"] is not None or "differs" not in ended
            again = ask([ended["program"], "print 1"], _PATIENCE_S) if is_known_to_return else [None]
            answers.append(again[0])
    return answers


def main(arguments: list[str]) -> int:
    """Check or record; the exit code is 1 when something differs."""
    if arguments not in (["check"], ["record"]):
        print(__doc__)
        return 2
    wrong = 0
    for path in sorted(VECTORS.glob("*.json")):
        document = json.loads(path.read_text(encoding="utf-8"))
        cases = document["cases"]
        answers = ask_all(cases)
        for case, answer in zip(cases, answers, strict=True):
            now = answer or {"output": None, "error": None}
            if arguments == ["record"]:
                case.update(now)
            elif {"output": case["output"], "error": case["error"]} != now:
                wrong += 1
                print(
                    f"{path.name} {case['id']}: recorded {case['output']!r} {case['error']}, now {now}",
                    flush=True,
                )
        if arguments == ["record"]:
            document["origin"] = ORIGIN
            path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(f"{path.name}: {len(cases)} cases", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
