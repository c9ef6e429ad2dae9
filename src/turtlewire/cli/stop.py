"""``turtlewire stop``: stop a robot, or all of them, from any state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.errors import LinkClosedError, NoReplyError, RobotError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals
    from turtlewire.configuration import Target
    from turtlewire.connect import Stopped

EXAMPLES = """\
examples:
  turtlewire stop --port /dev/ttyUSB0
  turtlewire stop --port socket://robot.local:2000 --require-replies && echo "it stands"
  turtlewire stop --robot simple --port /dev/ttyUSB1
  turtlewire stop --robot elsie
      the robot that robots.toml calls elsie
  turtlewire stop --all
      every robot in robots.toml, all at the same time
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "stop",
        summary="stop a robot, whatever it is doing",
        description="Stop a robot, whatever it is doing; then ask where it is.",
        examples=EXAMPLES,
    )
    options.add_target(parser, options.PORTS)
    parser.add_argument("--all", action="store_true", help="every robot in robots.toml, at the same time")
    options.add_require_replies(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Send the stop first; then see whether the robot confirms it."""
    del signals  # one that comes before the stop is sent may end this, and later it does no harm
    if arguments.all:
        if arguments.robot or arguments.port or arguments.set:
            raise UsageError("--all means the robots in robots.toml, as they are there: leave out the others")
        return _stop_all(require_replies=arguments.require_replies)
    from turtlewire.configuration import PROTOCOLS
    from turtlewire.connect import stop

    if arguments.port is None and arguments.robot in (None, *PROTOCOLS):
        raise UsageError("the following arguments are required: --port, or --robot with a name, or --all")
    target = options.target(arguments)
    assert target is not None  # as one of both is given
    try:
        text = _confirmed(
            target, stop(_demanding(target, arguments.require_replies)), arguments.require_replies
        )
    except LinkClosedError as error:
        options.explain_refusal(error, target.port)
        error.add_note("Nothing confirms that the robot was stopped.")
        raise
    except RobotError as error:
        error.add_note(f"The stop was sent to {target.port} before that, but nothing confirms it.")
        raise
    if text:
        output.write(f"{text}\n")
    else:
        output.tell(f"the stop was sent to {target.port}; the robot answers nothing, so nothing confirms it")
    return 0


def _demanding(target: Target, require_replies: bool) -> Target:
    return options.with_replies(target) if require_replies and target.protocol == "walter" else target


def _confirmed(target: Target, stopped: Stopped, require_replies: bool) -> str:
    """What a robot has said about its stop; ``""`` if nothing. Raises ``NoReplyError`` if that is not enough."""
    if stopped.pose is not None:
        pose = stopped.pose
        return (
            f"stopped: the robot answers, at x {pose.x_mm:g} mm, y {pose.y_mm:g} mm, "
            f"heading {pose.heading_deg:g} degrees"
        )
    if stopped.is_confirmed:
        return "stopped: the robot answers"
    if require_replies:
        raise NoReplyError(f"the robot at {target.port} answers nothing")
    return ""


def _stop_all(*, require_replies: bool) -> int:
    """Stop every robot in ``robots.toml``; whatever is wrong with one keeps no other from being stopped."""
    from turtlewire.configuration import entries, path
    from turtlewire.connect import stop_all

    robots = entries()
    if not robots:
        raise UsageError(f"there are no robots in {path()}")
    failures: dict[str, TurtlewireError] = {}
    targets: dict[str, Target] = {}
    for name, entry in robots.items():
        try:
            targets[name] = _demanding(entry.target(), require_replies)
        except TurtlewireError as error:
            failures[name] = error
    real = [target for target in targets.values() if not target.is_simulated]
    results = dict(zip((target.name for target in real), stop_all(real), strict=True))
    for name, target in targets.items():
        result = results.get(name)
        if result is None:
            output.write(f"{name}: simulated, in each process a robot of its own: there is nothing to stop\n")
            continue
        try:
            if isinstance(result, TurtlewireError):
                raise result
            text = _confirmed(target, result, require_replies)
        except TurtlewireError as error:
            failures[name] = error
        else:
            output.write(
                f"{name}: {text or 'the stop was sent, but nothing confirms it: it never answers'}\n"
            )
    for name, failure in failures.items():
        output.tell(f"turtlewire: {name}: NOT STOPPED, as far as is known: {failure}")
    return RobotError.exit_code if failures else 0
