"""The cam as a plant of python-control: nonlinear and linear models, describing functions, limit cycles of
sampled loops. Users take these names from `dualcam`.

May import common, fmi.
"""
