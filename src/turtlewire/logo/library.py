"""What a program may define anew without asking: the procedures of UCBLogo's library, and what UCBLogo does not have.

Programs written for UCBLogo do so, and mean their own procedures. ERASE brings ours back.
"""

from __future__ import annotations

LIBRARY = frozenset((
    "#", "?in", "?out", "?rest", "`", "backslashed?", "backslashedp", "buryall", "buryname", "cascade", "cascade.2",
    "case", "closeall", "combine", "cond", "crossmap", "dequeue", "do.until", "do.while", "ern", "erpl", "file?",
    "filep", "filter", "find", "for", "foreach", "gensym", "ignore", "invoke", "iseq", "localmake", "macroexpand",
    "map", "map.se", "mdarray", "mditem", "mdsetitem", "name", "namelist", "pick", "pllist", "poall", "pon", "pons",
    "pop", "popl", "popls", "pops", "pots", "push", "queue", "quoted", "reduce", "remdup", "remove", "reverse", "rseq",
    "savel", "transfer", "unburyall", "unburyname", "until", "while", "xcor", "ycor",
    # What UCBLogo does not have.
    "abs", "ask", "distance", "each", "eyesoff", "eyeson", "hornhi", "hornlo", "hornoff", "limitsensor", "onlimit",
    "onstop", "pi", "setspeed", "tan", "tell", "who",
))  # fmt: skip

# Variables that are there from the beginning, and buried.
VARIABLES: dict[str, str | float] = {
    "allowgetset": "true",
    "caseignoredp": "true",
    "logoplatform": "Unix-nographics",
    "logoversion": 6.2,
    "unburyonedit": "true",
}
