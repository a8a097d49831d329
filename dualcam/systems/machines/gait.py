"""Measured gait: two walkers' shank, stride, and thigh and knee motion as Fourier series with 7 harmonics.

7 harmonics reach 5.9 Hz; the sources filter at 6 Hz. The coefficients are a least-squares fit to measured
markers. Derivatives are those of the series.
"""

import math
from dataclasses import dataclass

from dualcam.systems.blocks.pendulum import HingedPendulum

# Segment fractions from D. A. Winter, Biomechanics and Motor Control of Human Movement, the table of
# anthropometric data: mass over body mass; centre and radius of gyration over the segment's length.
SHANK_MASS, SHANK_CENTRE, SHANK_GYRATION = 0.0465, 0.433, 0.302
FOOT_MASS, FOOT_GYRATION = 0.0145, 0.475
# The foot's length (heel to fifth metatarsal) and its centre (halfway), along the shank's axis and ahead of
# it, over the shank's length: means of the first subject's markers over the swing.
FOOT_LENGTH, FOOT_ALONG, FOOT_AHEAD = 0.394, 1.090, 0.094


@dataclass(frozen=True)
class Walker:
    """A measured walker.

    Fourier coefficients are over one stride from heel strike: mean, then cosine and sine of each harmonic.
    The knee's path is seen from beside the walker, at constant speed of walking.

    Parameters
    ----------
    name : Name of the walker.
    mass : Mass of the body [kg].
    shank : Length from knee to ankle [m].
    stride : Duration of a stride at the self-selected cadence [s].
    thigh : Series of the thigh's inclination [rad], + knee ahead of the hip.
    knee : Series of the knee's flexion [rad].
    forward, upward : Series of the knee's path [m].
    published
        Published figures: percent of the stride, knee flexion [deg], knee extension moment [N.m per kg of
        body mass].
    """

    name: str
    mass: float
    shank: float
    stride: float
    thigh: tuple[float, ...]
    knee: tuple[float, ...]
    forward: tuple[float, ...]
    upward: tuple[float, ...]
    published: tuple[tuple[float, float, float], ...]

    @property
    def pendulum(self) -> HingedPendulum:
        """Shank and foot about the knee, the foot rigid on the shank."""
        shank, foot, length = SHANK_MASS * self.mass, FOOT_MASS * self.mass, self.shank
        along = length * (shank * SHANK_CENTRE + foot * FOOT_ALONG)
        ahead = length * foot * FOOT_AHEAD
        radii = shank * (SHANK_CENTRE**2 + SHANK_GYRATION**2) + foot * (
            FOOT_ALONG**2 + FOOT_AHEAD**2 + (FOOT_GYRATION * FOOT_LENGTH) ** 2
        )
        return HingedPendulum(radii * length**2, math.hypot(along, ahead), math.atan2(ahead, along))


# Source: csu-hmc/GaitAnalysisToolKit, gaitanalysis/octave/2d_inverse_dynamics/test/rawdata.txt (treadmill,
# markers at 100 Hz, two and a half strides), Apache-2.0. Coefficients fitted for this example; RMS of the
# fit 0.9 deg (knee; strides differ) and 0.6 deg (thigh). Published: mean of two strides through the
# authors' leg2d.m.
# fmt: off
DESIGN_WALKER = Walker(
    name="first subject",
    mass=67.2,
    shank=0.4416,
    stride=1.195,
    thigh=(0.17487, 0.26883, -0.06238, -0.06527, -0.00508, -0.00154, 0.03453, -0.00018, 0.00201, -0.00010,
        0.00703, 0.00348, 0.00478, 0.00265, -0.00057),
    knee=(0.49658, -0.08187, -0.29967, -0.23949, 0.12868, -0.00312, 0.09298, -0.00535, 0.01892, 0.00091,
        0.02322, 0.00833, 0.01305, 0.00833, 0.00171),
    forward=(0.0, 0.11229, -0.02136, -0.03388, 0.00752, -0.00136, 0.01384, -0.00215, 0.00109, -0.00016,
        0.00389, 0.00066, 0.00129, 0.00062, 0.00002),
    upward=(0.0, 0.01527, -0.00178, -0.00882, -0.00863, -0.00680, 0.00421, -0.00030, 0.00345, -0.00006,
        0.00078, -0.00017, 0.00081, 0.00056, 0.00027),
    published=((65, 54.9, 0.177), (70, 63.7, 0.090), (75, 62.8, 0.061), (80, 53.2, 0.032), (85, 37.4,
        -0.004), (90, 18.6, -0.093), (95, 7.3, -0.195), (100, 10.3, -0.139)),
)
# fmt: on

# Source: opensim-org/opensim-core, OpenSim/Examples/Moco/example3DWalking, Apache-2.0: coordinates.sto
# (right leg, overground at 1.24 m/s) with the lengths of subject_walk_scaled.osim; inclination is pelvis
# tilt plus hip flexion, list and rotation of the pelvis left out. Coefficients fitted for this example; RMS
# of the fit 0.3 deg. Published: id_walk.sto there.
# fmt: off
CHECK_WALKER = Walker(
    name="second subject",
    mass=85.27,
    shank=0.4652,
    stride=1.145,
    thigh=(0.17964, 0.38041, -0.05155, -0.10061, -0.02117, -0.01552, 0.02983, 0.00507, -0.00307, -0.00067,
        0.00266, 0.00382, 0.00257, -0.00087, 0.00084),
    knee=(0.44873, -0.01828, -0.39966, -0.34581, 0.09373, -0.03275, 0.08435, -0.00662, 0.00742, -0.00941,
        0.01771, 0.00588, 0.01244, -0.00039, 0.00314),
    forward=(0.0, 0.14363, -0.02259, -0.05411, 0.00466, -0.00469, 0.01140, -0.00028, -0.00094, -0.00078,
        0.00100, 0.00105, 0.00074, -0.00017, 0.00016),
    upward=(0.0, 0.02191, -0.00157, -0.00670, -0.01837, -0.00802, 0.00167, -0.00123, 0.00377, 0.00083,
        -0.00063, -0.00019, 0.00027, 0.00040, 0.00021),
    published=((65, 53.7, 0.175), (70, 69.0, 0.134), (75, 71.7, 0.065), (80, 63.5, -0.001), (85, 47.1,
        -0.009), (90, 24.0, -0.195), (95, 5.1, -0.395), (100, 2.4, -0.322)),
)
# fmt: on
