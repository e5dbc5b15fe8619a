# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: baked objects read again, engines compared."""
