# SPDX-License-Identifier: GPL-3.0-or-later
"""Relights the surfaces of materials in EEVEE."""
