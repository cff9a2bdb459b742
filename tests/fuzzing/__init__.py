# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes, valid and invalid, that a Blender in a process of its own renders: none may crash, hang or give pixels
that are not finite.
"""
