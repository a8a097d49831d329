"""How each master is made to play a scene, or to check an FMU."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZipFile

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv

from dualcam.ssp import Component, System
from verification.masters import install
from verification.masters.install import Failed, Words, attempt, complaint
from verification.masters.scenes import INVERSE, Array, Result, Scene, fmu, play

HOSTS = Path(__file__).with_name("hosts")
PATIENCE = 300.0  # s, for one run
CONTAINER_INPUTS = ("tau", "F_ext")
CONTAINER_OUTPUTS = ("theta", "omega", "z", "v", "tau")  # those with causality `output`


def insist(command: Words, folder: Path, **variables: str) -> str:
    """Runs it in this folder, where it also leaves what it would leave elsewhere; what it prints."""
    try:
        done = attempt(command, PATIENCE, folder, TMPDIR=str(folder), **variables)
    except subprocess.TimeoutExpired:
        raise Failed(f"not done after {PATIENCE:.0f} s") from None
    if done.returncode != 0:
        raise Failed(f"exit {done.returncode}: {complaint(done)}")
    return done.stdout


def read(path: Path) -> Result:
    """A CSV file with a header. Where a time comes twice (before and after an event), the last row counts."""
    try:
        with path.open(newline="") as file:
            header, *rows = csv.reader(file)
        table = np.array(rows, dtype=float)
    except (OSError, ValueError) as error:
        raise Failed(f"no result: {error}") from None
    names = [name.strip() for name in header]
    if "time" in names:
        last = np.append(np.diff(table[:, names.index("time")]) > 0.0, True)
        table = table[last]
    return dict(zip(names, table.T, strict=True))


def start_values(scene: Scene) -> list[str]:
    return [f"{name}={value}" for name, value in scene.start.items()]


def job(scene: Scene, path: Path, folder: Path) -> tuple[list[str | Path], Path]:
    """Arguments of a program in hosts/, and the file that it will write."""
    inputs, outputs = scene.write_inputs(folder / "inputs.csv"), folder / "outputs.csv"
    return [path, repr(scene.step), inputs, outputs, ",".join(scene.outputs), *start_values(scene)], outputs


def ecos(scene: Scene, path: Path, folder: Path) -> Result:
    venv = install.package("ecospy", "tbb")  # tbb: a library that ecospy needs and does not bring
    words, outputs = job(scene, path, folder)
    insist([venv / "bin/python", HOSTS / "ecos_host.py", *words], folder, LD_LIBRARY_PATH=str(venv / "lib"))
    return read(outputs)


def ecos_csv(scene: Scene, path: Path, folder: Path) -> Result:
    """The same from the file that ecos itself writes, whose columns are "cam::theta[REAL]" and the like."""
    ecos(scene, path, folder)
    columns = read(folder / "outputs.printed.csv")
    return {m[1]: column for name, column in columns.items() if (m := re.fullmatch(r"cam::(.*)\[.*\]", name))}


def libcosim(scene: Scene, path: Path, folder: Path) -> Result:
    venv = install.package("libcosimpy")
    words, outputs = job(scene, path, folder)
    insist([venv / "bin/python", HOSTS / "libcosim_host.py", *words], folder)
    return read(outputs)


def scratch(folder: Path) -> str:
    """Java does not look at TMPDIR."""
    return f"-Djava.io.tmpdir={folder}"


def fmi4j(scene: Scene, path: Path, folder: Path) -> Result:
    jars = ":".join(str(install.artifact(jar)) for jar in install.FMI4J)
    words, outputs = job(scene, path, folder)
    java = install.java(17, compiler=True)
    insist([java, scratch(folder), "-cp", jars, HOSTS / "Fmi4jHost.java", *words], folder)
    return read(outputs)


def without_units(path: Path, folder: Path) -> Path:
    """A copy whose variables have no unit and no nominal value, which fmi-sim does not read in FMI 3.0."""
    copy = folder / path.name
    with ZipFile(path) as old, ZipFile(copy, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                head, mark, variables = content.decode().partition("<ModelVariables>")
                content = (head + mark + re.sub(r' (unit|nominal)="[^"]*"', "", variables)).encode()
            new.writestr(name, content)
    return copy


def fmi_sim(scene: Scene, path: Path, folder: Path, kind: str = "co-simulation") -> Result:
    program = install.fmi_sim()
    outputs = folder / "outputs.csv"
    model = without_units(path, folder) if path.parent.name == "fmi3" else path
    command: list[str | Path] = [program, "--model", model, "--output-file", outputs]
    if scene.inputs:
        command += ["--input-file", scene.write_inputs(folder / "inputs.csv")]
    command += [kind, "--output-interval", repr(scene.step), "-f", repr(scene.duration)]
    for word in start_values(scene):
        command += ["--init-values", word]
    insist(command, folder)
    return read(outputs)


def fmi_sim_me(scene: Scene, path: Path, folder: Path) -> Result:
    return fmi_sim(scene, path, folder, "model-exchange")


def compiled(scene: Scene, path: Path, folder: Path) -> Result:
    """`fmpy compile`: FMPy with a binary that CMake and the system's C compiler make of the FMU's sources."""
    install.program("cc", "a C compiler")
    cmake = install.program("cmake", "which FMPy calls")
    copy = folder / path.name
    with ZipFile(path) as old, ZipFile(copy, "w") as new:
        for name in old.namelist():
            if not name.startswith("binaries/"):
                new.writestr(name, old.read(name))
    words: Words = [sys.executable, "-m", "fmpy", "compile", copy, "--generator", "Unix Makefiles"]
    insist(words, folder, PATH=f"{Path(cmake).parent}:{os.environ['PATH']}")
    return play(scene, copy)


def fmucontainer(scene: Scene, path: Path, folder: Path) -> Result:
    """FMPy with a container that holds the FMU, whose parameters have a prefix there."""
    venv = install.package("fmu-manipulation-toolbox")
    shutil.copy(path, folder)
    (folder / "box.csv").write_text(f"rule;from_fmu;from_port;to_fmu;to_port\nFMU;{path.name};;;\n")
    options: Words = ["-fmu-directory", folder, "-auto-parameter"]
    insist([venv / "bin/fmucontainer", "-container", f"box.csv:{scene.step!r}", *options], folder)
    prefix = f"{path.stem.lower()}."
    start = {
        name if name in CONTAINER_INPUTS else prefix + name: value for name, value in scene.start.items()
    }
    shown = tuple(name for name in scene.outputs if name in CONTAINER_OUTPUTS)
    return play(replace(scene, start=start, outputs=shown), folder / "box.fmu")


# ---- FMPy's `simulate_ssp`. Inputs of the system reach the FMU one step late, and are 0 in the first step


def fmpy_ssp(scene: Scene, path: Path, folder: Path) -> Result:
    """A package with the FMU alone, whose inputs and outputs are connectors of the system."""
    parameters = {
        k: v for k, v in scene.start.items() if k not in CONTAINER_INPUTS and not isinstance(v, str)
    }
    cam = Component("cam", path, parameters)
    ends = tuple(f"cam.{name}" for name, (kind, _) in cam.variables.items() if kind in ("input", "output"))
    system = System("scene", scene.text, (cam,), (), scene.step, scene.duration, ends)
    package = str(system.save(folder / "scene.ssp"))
    values = read_ssv(package, "resources/cam.ssv")
    for parameter in values.parameters:
        parameter.name = f"cam.{parameter.name}"
    signals = {name: held(column, scene.step) for name, column in inputs_of(scene).items()}
    times = {"stop_time": scene.duration - scene.step / 2, "step_size": scene.step}
    result = simulate_ssp(package, **times, parameter_set=values, input=signals)
    shown = [name for name in scene.outputs if f"cam.{name}" in result.dtype.names]
    return {name: result[f"cam.{name}"] for name in shown}


def inputs_of(scene: Scene) -> dict[str, Array]:
    """A value for each communication point."""
    ones = np.ones(len(scene.times))
    return {n: float(scene.start.get(n, 0.0)) * ones for n in CONTAINER_INPUTS} | dict(scene.inputs)


def held(column: Array, step: float) -> Callable[[float], float]:
    return lambda time: float(column[round(time / step)])


def fmpy_ssp_reference(scene: Scene, path: Path) -> Result:
    """FMPy with inputs one step late. The rows of `simulate_ssp` are those at the ends of the steps."""
    late = {name: np.append(0.0, column[:-1]) for name, column in inputs_of(scene).items()}
    parameters = {name: value for name, value in scene.start.items() if name not in CONTAINER_INPUTS}
    result = play(replace(scene, start=parameters, inputs=late), path)
    return {name: column[1:] for name, column in result.items()}


# ---- Maestro. Its parameters reach parameters alone, and it insists on connections. So an inverse FMU whose
# cam is not turned is the source of the constant torque (T_load at theta = 0 is in proportion to the
# preload), and another one takes the motion and says what torque that needs.

SOURCE = Scene("source", "", INVERSE, 1e-3, ("tau", "mode"), frozenset())
PRELOAD = 150.0  # N: 1.99 N.m


def maestro_scene(scene: Scene) -> Scene:
    """The scene with the torque of that source."""
    torque = play(replace(SOURCE, start={"spring.preload": PRELOAD}), fmu(INVERSE))["tau"]
    return replace(scene, start=dict(scene.start) | {"tau": float(torque[0])})


def needed(scene: Scene, motion: Result) -> Scene:
    """What the second inverse FMU sees: angle and speed of the communication point before."""
    still = np.zeros(len(scene.times))
    inputs = {"theta": motion["theta"], "omega": motion["omega"], "alpha": still, "F_ext": still}
    return replace(scene, model=INVERSE, start={}, inputs=inputs, outputs=("tau", "mode"), modes=frozenset())


def maestro_reference(scene: Scene, path: Path) -> Result:
    motion = play(maestro_scene(scene), path, tolerance=0.1)  # Maestro's, always
    torque = play(needed(scene, motion), fmu(INVERSE))
    return {**motion, "needed torque": torque["tau"]}


def maestro(scene: Scene, path: Path, folder: Path) -> Result:
    java, jar = install.java(11), install.artifact(install.MAESTRO)
    cam, source, inverse = "{forward}.cam", "{inverse}.source", "{inverse}.needed"
    start = {name: value for name, value in scene.start.items() if name != "tau"}
    system = {
        "fmus": {"{forward}": path.as_uri(), "{inverse}": fmu(INVERSE).as_uri()},
        "connections": {
            f"{source}.tau": [f"{cam}.tau"],
            f"{cam}.theta": [f"{inverse}.theta"],
            f"{cam}.omega": [f"{inverse}.omega"],
        },
        "parameters": {f"{source}.spring.preload": PRELOAD}
        | {f"{cam}.{name}": value for name, value in start.items()},
        "logVariables": {cam: list(scene.outputs), inverse: ["tau"]},
        "algorithm": {"type": "fixed-step", "size": scene.step},
    }
    # It adds up its time, with rounding: half a step more, so that the last one is not left out
    experiment = {"startTime": 0.0, "endTime": scene.duration + scene.step / 2}
    files = [folder / "system.json", folder / "experiment.json"]
    for file, content in zip(files, (system, experiment), strict=True):
        file.write_text(json.dumps(content))
    options: Words = ["-output", folder, "--interpret", "--inline-framework-config"]
    insist([java, scratch(folder), "-jar", jar, "import", "Sg1", *files, *options], folder)
    result = read(folder / "outputs.csv")
    names = {f"{cam}.{name}": name for name in scene.outputs} | {f"{inverse}.tau": "needed torque"}
    return {name: result[key] for key, name in names.items() if key in result}


# ---- Checkers: they fail if they find anything


def vdmcheck(path: Path) -> None:
    with TemporaryDirectory() as folder:
        printed = insist(["bash", install.vdmcheck(), path], Path(folder))
    if "No errors found." not in printed:  # its exit code is that of the last program in a pipe
        raise Failed("does not say that there are no errors")


def fmugym(path: Path) -> None:
    venv = install.package("fmugym", "fmpy")
    with TemporaryDirectory() as folder:
        insist([venv / "bin/python", HOSTS / "fmugym_host.py", path], Path(folder))


def notebook(path: Path) -> None:
    venv = install.package("fmpy", "nbclient", "ipykernel", "plotly")
    with TemporaryDirectory() as folder:
        insist([venv / "bin/python", HOSTS / "notebook_host.py", path], Path(folder))


def fmutool(path: Path) -> None:
    venv = install.package("fmu-manipulation-toolbox")
    with TemporaryDirectory() as folder:
        insist([venv / "bin/fmutool", "-input", path, "-check"], Path(folder))
