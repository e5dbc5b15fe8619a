# SPDX-License-Identifier: GPL-3.0-or-later
"""Models rough metal: the GGX surface of microscopic mirrors, how much light it returns, and what it loses between
them.
"""
