# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the scene as files of other programs, and reads them back."""
