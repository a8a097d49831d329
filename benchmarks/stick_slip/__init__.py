"""Stick-slip of the cam behind a soft shaft: the FMU against closed solutions and the phase plane."""
