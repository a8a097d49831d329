"""
The stick band
==============

Between the torque of releasing and the torque of loading, friction holds the cam.
"""

import matplotlib.pyplot as plt

plt.plot([0, 1], [0, 1])
