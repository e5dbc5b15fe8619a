# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: read once, to what light takes on where it bounces and to what is shown."""
