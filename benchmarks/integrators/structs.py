"""The structures of integrators.c and its headers."""

from __future__ import annotations

import ctypes


def doubles(*names: str) -> list[tuple[str, type]]:
    return [(name, ctypes.c_double) for name in names]


class EllipseStruct(ctypes.Structure):
    _fields_ = doubles("start", "rate", "steepness", "height")


class TransmissionStruct(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_double * 13) for name in ("a1", "a2", "z", "gamma")),
        *doubles("middle", "scale"),
    ]


class SceneStruct(ctypes.Structure):
    _fields_ = [
        *doubles("r1", "r2", "mu1", "mu2", "inertia", "mass", "spin", "preload", "k", "k2", "k3"),
        *doubles("c", "q", "b", "tau0", "tau1", "theta", "omega", "span"),
        ("parts", ctypes.c_int),
        ("groove1", EllipseStruct),
        ("groove2", EllipseStruct),
        ("transmission", TransmissionStruct),
        *doubles("theta_scale", "omega_scale"),
    ]


COUNTS = ("steps", "rejected", "values", "partials", "solves", "newton", "failed")


class OutcomeStruct(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_long) for name in COUNTS), *doubles("theta", "omega")]


class ControlStruct(ctypes.Structure):
    _fields_ = [
        ("matrix", ctypes.c_int),
        ("linear", ctypes.c_bool),
        ("slaved", ctypes.c_bool),
        *doubles("power", "order"),
    ]


class MethodStruct(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_int), ("stages", ctypes.c_int), ("control", ControlStruct)]
