# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports on a scene: reads baked objects again, and compares EEVEE with Cycles."""
