# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects pictures of the sky and cube maps to SH light, finds lamps in them, draws directions by their brightness."""
