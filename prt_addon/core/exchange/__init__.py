# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes files of other programs."""
