"""Whoever drives a robot by hand: wishes and orders in, what is to be seen of the robot out.

::

    wishes  what somebody wants: a wish, which holds for a time, and orders, which are carried out once
    helm    carries them out, in the robot's own thread
    sight   looks at the robot; view: what is to be seen of it. wire: what passes between the two, decoded

The terminal dashboard and the web console both drive by this.
"""
