"""Finding out what is at the other end of a wire, by bytes that cannot make it move.

What is sent when is decided by a plan without clock or wire (``plan.py``, and ``of_simple.py``, ``of_walter.py``,
``of_frame.py`` for what follows when a protocol has shown itself); ``pump.py`` carries it out on a link. Why none of it
moves a robot, whatever its protocol, its rate and its state: docs/doctor.md, and tests/unit/examination/test_safety.py.
"""

from turtlewire.examination.findings import Findings
from turtlewire.examination.listening import Listening
from turtlewire.examination.plan import Wanted, examination
from turtlewire.examination.probes import BAUDS
from turtlewire.examination.pump import carry_out

__all__ = ["BAUDS", "Findings", "Listening", "Wanted", "carry_out", "examination"]
