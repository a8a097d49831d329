"""
A spring clamp that warms up
============================

The friction of the cam heats the grease, and the warm grease changes the friction. Page :doc:`/examples`
explains the result, page :doc:`/use-temperature` how to do the same; the whole script is
``system_examples/spring_clamp.py``.
"""

# %%
# Twenty minutes of clamping in a cold hall. The comparison is friction that stays as cold as at the start.

import matplotlib.pyplot as plt

import dualcam
from system_examples import spring_clamp

results = spring_clamp.run(dualcam.fmu_path("forward"), cycles=400)
figure, (temperature, torque) = plt.subplots(1, 2, figsize=(10.0, 4.4), layout="constrained")
spring_clamp.draw_temperature(temperature, results)
spring_clamp.draw_torque(torque, results)
for axes in (temperature, torque):
    axes.set_xlim(0.0, 20.0)
print("\n".join(spring_clamp.balance_table(results)))

# %%
# The friction of the grease, cold and warm: the viscosity stretches the curve over the sliding speed.

figure, law = plt.subplots(figsize=(8.0, 4.8), layout="constrained")
spring_clamp.draw_law(law, results[spring_clamp.WARMING])
plt.show()
