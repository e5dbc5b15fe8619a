# SPDX-License-Identifier: GPL-3.0-or-later
"""Records the calls of a real function, which then does its work."""


def recording(function, calls, of=lambda *arguments: arguments):
    """The function, adding what `of` makes of its arguments to a list of calls before each."""

    def recorded(*arguments, **named):
        calls.append(of(*arguments))
        return function(*arguments, **named)

    return recorded
