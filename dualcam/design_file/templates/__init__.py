"""Commented designs to begin with."""

from dualcam.design_file.templates.template import TEMPLATES, write_template

__all__ = ["TEMPLATES", "write_template"]
