"""The terminal dashboard of ``turtlewire drive``: any robot, driven by keyboard.

::

    keyboard   what a terminal sends -> keys, and their releases where it tells them
    holding    keys -> what is held, and for how long that counts: the dead-man's handle
    controls   -> a wish: how fast, where to; and orders: stop, pen, lamp. With layouts, the keys of each robot
    app        has them carried out by ``helm``, and shows what it sees: panels, chart (of braille dots), over terminal

The first three have no clock, no terminal and no robot.
"""
