# SPDX-License-Identifier: GPL-3.0-or-later
"""Skies as arrays: pictures and cube maps to SH light, directions drawn by brightness, pictures of a light."""
