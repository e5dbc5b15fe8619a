# SPDX-License-Identifier: GPL-3.0-or-later
"""The SH light on the world: stored, driven, keyframed, looked at."""
