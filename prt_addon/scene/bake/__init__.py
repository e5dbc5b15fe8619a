# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a scene: reads it as a whole, checks it, writes the result, and judges later whether that still holds."""
