# SPDX-License-Identifier: GPL-3.0-or-later
"""Rough metal: the GGX surface of microscopic mirrors, how much light it returns, and what it loses between them."""
