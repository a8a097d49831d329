"""A bench with two helical grooves in closed form: the torque of a given motion, and recordings with noise.

Written from docs/mechanism.md, sections 3, 5 and 9, for two helices that never lock and a load F > 0.
Nothing here calls the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Bench:
    """Values in SI units; the index of a pair is the cam."""

    radius: tuple[float, float] = (0.02, 0.02)
    lead: tuple[float, float] = (np.pi / 4, np.pi / 4)
    friction: tuple[float, float] = (0.14, 0.14)
    peak: float = 1.0
    stribeck_velocity: float = 0.01
    viscous: float = 0.0
    load_exponent: float = 0.0
    load: float = 100.0  # of one of two contacts, N
    preload: float = 50.0
    stiffness: float = 50e3
    damping: float = 0.0  # of the damper in both directions, N.s/m
    shaft_damping: float = 0.0
    shaft: float = 0.002  # kg.m2
    mass: float = 0.0  # kg

    def torque(self, theta, omega, alpha, sigma=None, force=0.0):
        """Torque of slip in the direction sigma, by default that of omega."""
        sigma = np.sign(omega) if sigma is None else sigma
        slope = [r * np.tan(lead) for r, lead in zip(self.radius, self.lead, strict=True)]
        shares = [slope[1] / sum(slope), slope[0] / sum(slope)]  # of theta at cam 1 and cam 2
        ratio = slope[0] * slope[1] / sum(slope)
        z, v = ratio * theta, ratio * omega
        axial = self.preload + self.stiffness * z + force + self.damping * v
        kappa = 0.0
        for r, lead, mu, share in zip(self.radius, self.lead, self.friction, shares, strict=True):
            speed = np.abs(omega) * share * r / np.cos(lead)
            law = mu * (1 + (self.peak - 1) * np.exp(-((speed / self.stribeck_velocity) ** 2)))
            nominal = np.abs(axial) * share / np.cos(lead) / 2
            law = law * ((nominal / self.load) ** 2 + 0.01) ** (self.load_exponent / 2)
            kappa = kappa + 1.0 / (np.tan(lead + sigma * np.arctan(law + self.viscous * speed)) * r)
        return (axial + self.mass * ratio * alpha) / kappa + self.shaft_damping * omega + self.shaft * alpha

    def band(self, theta):
        """Edges of the stick band."""
        zero = np.zeros_like(theta)
        return self.torque(theta, zero, zero, -1.0), self.torque(theta, zero, zero, 1.0)


def sines(time, middle=0.7, amplitudes=(0.5,), frequencies=(0.2,)):
    """Angle, speed and acceleration of a sum of sines."""
    theta, omega, alpha = np.full_like(time, middle), np.zeros_like(time), np.zeros_like(time)
    for amplitude, frequency in zip(amplitudes, frequencies, strict=True):
        w = 2.0 * np.pi * frequency
        theta += amplitude * np.sin(w * time)
        omega += amplitude * w * np.cos(w * time)
        alpha -= amplitude * w**2 * np.sin(w * time)
    return theta, omega, alpha


def record(bench, time, motion, torque_noise, angle_noise, seed):
    """Columns of a recording: angle and torque with normal noise."""
    random = np.random.default_rng(seed)
    theta, omega, alpha = motion
    torque = bench.torque(theta, omega, alpha)
    noisy = [
        theta + angle_noise * random.standard_normal(len(time)),
        torque + torque_noise * random.standard_normal(len(time)),
    ]
    return time, *noisy


def triangle(time, least=0.15, range_=1.1, period=5.0):
    """Angle, speed and acceleration of turning to and fro at one speed."""
    phase = (time / period) % 1.0
    loading = phase < 0.5
    speed = 2.0 * range_ / period
    theta = least + 2.0 * range_ * np.where(loading, phase, 1.0 - phase)
    return theta, np.where(loading, speed, -speed), np.zeros_like(time)
