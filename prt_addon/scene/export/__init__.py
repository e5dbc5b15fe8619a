# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other programs, out of the scene and into it."""
