"""FMUs from Python: the calls of FMI 2.0 and 3.0, handles with names instead of value references, model
descriptions, and where this package's own FMUs are. Physics is in the FMU alone.

May import common.
"""
