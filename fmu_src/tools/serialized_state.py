"""A serialized state of an FMU, made by its library for this machine."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

INPUTS: dict[str, Mapping[str, float]] = {
    "DualCamForward": {"tau": 8.0},  # N.m
    "DualCamInverse": {"theta": 0.7, "omega": 2.0},  # rad, rad/s
}
STEP = 0.2  # s


def serialized_state(folder: Path, identifier: str) -> bytes:
    """The state after a step from the start values under constant inputs, of an FMU unpacked in `folder`."""
    from fmpy import fmi2, fmi3, read_model_description

    model = read_model_description(str(folder), validate=False)
    is_fmi3 = model.fmiVersion.startswith("3")
    kind = fmi3.FMU3Slave if is_fmi3 else fmi2.FMU2Slave
    slave = kind(
        guid=model.guid,
        unzipDirectory=str(folder),
        modelIdentifier=identifier,
        instanceName="state",
    )
    references = {variable.name: variable.valueReference for variable in model.modelVariables}
    slave.instantiate()
    if not is_fmi3:
        slave.setupExperiment()
    slave.enterInitializationMode()
    names = [references[name] for name in INPUTS[identifier]]
    values = list(INPUTS[identifier].values())
    (slave.setFloat64 if is_fmi3 else slave.setReal)(names, values)
    slave.exitInitializationMode()
    slave.doStep(0.0, STEP)
    state = slave.getFMUState()
    content: bytes = slave.serializeFMUState(state)
    slave.freeFMUState(state)
    slave.terminate()
    slave.freeInstance()
    return content
