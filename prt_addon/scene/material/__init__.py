# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads materials, each once: the colour that light takes on where it bounces, and the surface that is shown."""
