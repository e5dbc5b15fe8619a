# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the exceptions whose message is one sentence for the user: what is wrong, and what to do."""


class PRTError(Exception):
    """Base of every error that is the input's, not the program's; the message says what to do."""


class MeshError(PRTError):
    """A mesh that cannot be baked as it is."""


class LightError(PRTError):
    """A world that cannot become an SH light as it is."""


class PictureError(PRTError):
    """An image that cannot be read as it is."""


class VersionError(PRTError):
    """Stored data of a version that is not known yet."""


class RenderError(PRTError):
    """A scene whose picture cannot be rendered as it is."""


class RayCasterMissing(PRTError):
    """embreex, the ray caster, is not installed for this Python or platform."""


class ShardError(PRTError):
    """Shards of a bake that are missing, or do not belong together."""


class EngineError(PRTError):
    """The engine's process could not be started, or came to an end of its own."""


class Interrupted(PRTError):
    """Ctrl-C; nothing was written."""


class NoRoom(PRTError):
    """What a bake must keep fits neither in memory nor in the temporary folder."""


class Cancelled(PRTError):
    """The user has cancelled; nothing was written."""


CANCELLED = "Cancelled; nothing was changed."
"""What a `Cancelled` says."""
