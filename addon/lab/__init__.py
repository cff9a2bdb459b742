# SPDX-License-Identifier: GPL-3.0-or-later
"""The laboratory: speed against accuracy of any scene, rendered by many settings and by Cycles.

plan (what is rendered), driver (one process that renders it all, by a budget), worker (that process), store (what is
kept in the folder), results (figures), pictures, figure and page (what is drawn), chart and compare (the commands).
Only the worker needs Blender; only `figure` needs matplotlib.
"""
