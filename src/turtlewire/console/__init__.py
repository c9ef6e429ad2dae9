"""The web console: robots driven, watched and programmed from a browser, by several people.

::

    page/ --WebSocket, HTTP--> gate -> stream, routes -> stations -> helm -> the robot

    gate       who may come in: token, Host, Origin, sizes, rates
    stream     one page's WebSocket: set-points in, states out. setpoints: which of them count
    routes     the same for machines; models: what is said
    stations   the robots; each station has a helm, and a wheel: who drives
    server     makes the application, and serves it; page: what a browser is given first

``wheel``, ``setpoints`` and ``rates`` have no clock: time is an argument.
"""
