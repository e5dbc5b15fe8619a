# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake of the scene: read as a whole, checked, written, judged later."""
