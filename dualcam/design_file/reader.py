"""Reads a design file: all errors at once, values in SI units."""

import json
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from dualcam.common.groove_laws import LAWS, PARAMETERS, TABLE, laws_with
from dualcam.common.paths import path_of
from dualcam.common.unit_guards import table_warnings, unit_warning, units_checked_before
from dualcam.design_file.design import DesignFile, SpringLimits, sample_times
from dualcam.design_file.findings import ERROR, WARNING, Finding
from dualcam.design_file.fmu_tables import fmu_friction, fmu_groove
from dualcam.design_file.friction_tables import ANALYTIC_FRICTION
from dualcam.design_file.keys import unknown_key
from dualcam.design_file.toml_text import line_of, lines_of_keys, parse, read_text
from dualcam.errors import DesignError, DesignFileError, DualcamError, DualcamWarning
from dualcam.fmi.variables import all_parameters, inputs_of

STUDY = "dualcam.study.section"  # checks the section [study]: a room above, loaded for such a file alone
ANY_INPUT = ("F_ext",)  # inputs of both models

DesignSource = DesignFile | str | Path


def read_design(path: str | Path) -> DesignFile:
    """The design that a TOML file describes.

    Parameters
    ----------
    path : str or Path
        The file. Its keys are the names of the FMU's parameters. Relative paths of tables, of grooves and
        friction, count from the folder of the file.

    Returns
    -------
    DesignFile
        Values in SI units; `warnings` has values that look as if they were in another unit.

    Raises
    ------
    DesignFileError
        With all errors: line, key, value, what is allowed and what would work.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design_file import read_design, write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     design = read_design(write_template("minimal", Path(folder) / "my.toml"))
    >>> design.parameters["cam1.radius"]
    0.015
    """
    path = path_of(path, "the design file")
    text = read_text(path)
    content = parse(path, text)
    reading = _Reading(path, lines_of_keys(text))
    design = reading.design(content)
    if reading.errors:
        raise DesignFileError(path, reading.errors)
    return design


def as_design(design: DesignSource, shows_findings: bool = False) -> DesignFile:
    """The design of an argument.

    Parameters
    ----------
    design : A design from `read_design`, or the path of a design file.
    shows_findings : bool
        Whether the result of the caller has the warnings of the design. Else the warnings of a file that is
        read here become Python warnings.

    Returns
    -------
    DesignFile
        `design` itself, or the design of the file.

    Raises
    ------
    DesignError
        `design` is something else.
    DesignFileError
        The file is refused.

    Warns
    -----
    DualcamWarning
        For each warning about a file that is read here.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     as_design(write_template("minimal", Path(folder) / "my.toml")).name
    'my'
    """
    if isinstance(design, DesignFile):
        return design
    if not isinstance(design, str | Path):
        raise DesignError(
            f"design {design!r}: allowed is a design from read_design, or the path of a design file"
            " (str or Path)"
        )
    read = read_design(design)
    for finding in () if shows_findings else read.warnings:
        warnings.warn(f"{read.path}: {finding}", DualcamWarning, stacklevel=3)
    return read


class _Reading:
    """One reading of a file, with the errors and warnings so far."""

    def __init__(self, path: Path, lines: Mapping[tuple[str, ...], int]) -> None:
        self.path, self.lines = path, lines
        self.errors: list[Finding] = []
        self.warnings: list[Finding] = []
        self.notes: list[str] = []
        self.refused_keys: set[str] = set()  # keys that the schema refuses; the rest of the file is read on

    # ---- findings ----

    def refuse(self, key: str, value: object, text: str) -> None:
        """Note an error at a key."""
        self.errors.append(self._finding(ERROR, key, value, text))

    def warn(self, key: str, value: object, text: str, kind: str) -> None:
        """Note a warning at a key."""
        self.warnings.append(self._finding(WARNING, key, value, text, kind))

    def _finding(self, severity: str, key: str, value: object, text: str, kind: str = "") -> Finding:
        return Finding(severity, key, value, text, line=line_of(self.lines, tuple(key.split("."))), kind=kind)

    def attempt(self, key: str, make: Callable[[], Any]) -> Any:  # noqa: ANN401
        """What `make` gives; None, and an error at the key, if it is refused."""
        try:
            with units_checked_before():  # the findings of the file have these warnings, with their lines
                return make()
        except DualcamError as error:
            self.refuse(key, None, f"[{key}] {error}")
            return None

    # ---- the whole ----

    def design(self, content: dict[str, Any]) -> DesignFile:
        """The design, without the keys that are refused."""
        from dualcam.design import Limits

        values = self._validated(content)
        parameters = self._parameters(values)
        spring_limits = self._spring_limits(values.get("spring", {}))
        self._check_units(values, _keys_with_unit("", content))
        self._warn_of_other_laws(parameters)
        self._read_tables(parameters)
        scenario_table = values.get("scenario")
        model = self._model(scenario_table or {})
        scenario = interval = None
        if scenario_table is not None and not self._is_refused("scenario"):
            scenario = self.attempt("scenario", lambda: _scenario(scenario_table, model))
            interval = scenario_table.get("output_interval")
        if scenario is not None:
            try:
                sample_times(scenario.stop, interval)
            except DualcamError as error:
                self.refuse("scenario.output_interval", interval, str(error))
        pin = self._pin(values["pin"]) if "pin" in values and not self._is_refused("pin") else None
        roller = self._roller(values["roller"], pin) if "roller" in values else None
        wire = values.get("helical_spring")
        helical_spring = None if wire is None else self._helical_spring(wire)
        limits = self.attempt("limits", lambda: Limits(**values["limits"])) if "limits" in values else None
        design = DesignFile(
            path=self.path,
            parameters=parameters,
            model=model,
            scenario=scenario,
            output_interval=interval,
            pin=pin,
            roller=roller,
            helical_spring=helical_spring,
            spring_limits=spring_limits,
            limits=limits,
            study=values.get("study"),
            title=values.get("title", ""),
            description=values.get("description", ""),
            warnings=tuple(sorted(self.warnings, key=lambda warning: warning.line or 0)),
            notes=tuple(self.notes),
            lines=self.lines,
        )
        if design.study is not None:
            self.attempt("study", lambda: import_module(STUDY).check_section(design))
        return design

    def _is_refused(self, prefix: str) -> bool:
        """Whether the schema refuses this key or one in this table."""
        return any(key == prefix or key.startswith(f"{prefix}.") for key in self.refused_keys)

    def _validated(self, content: dict[str, Any]) -> dict[str, Any]:
        """The content with numbers in SI units, without what the schema refuses."""
        from pydantic import ValidationError

        from dualcam.design_file.schema import design_model

        try:
            return design_model().model_validate(content).model_dump(exclude_unset=True)
        except ValidationError as error:
            for problem in error.errors(include_url=False):
                self._refuse_schema(problem)
                content = _without(content, problem["loc"])
        return design_model().model_validate(content).model_dump(exclude_unset=True)

    def _refuse_schema(self, problem: Mapping[str, Any]) -> None:
        from dualcam.design_file.schema import known_keys

        key, value = ".".join(map(str, problem["loc"])), problem["input"]
        shown, kind = _shown(value), problem["type"]
        if kind == "extra_forbidden":
            text = unknown_key(key, known_keys(), value)
            if key == "scenario.controller":
                text = "scenario.controller is no key: a controller belongs to a study plan"
        elif kind in ("model_type", "model_attributes_type", "dict_type"):
            within = [name.removeprefix(f"{key}.") for name in known_keys() if name.startswith(f"{key}.")]
            text = f"{key} = {shown}: allowed is a table [{key}]"
            text += f" with {', '.join(within)}" if within else ""
        elif kind in ("value", "range"):
            text = f"{key} = {shown}: {problem['msg']}"
            with_unit = kind != "range" or isinstance(value, str)
            if not with_unit and (hint := unit_warning(key, problem["ctx"]["number"])):
                text += f"; {hint.partition(': ')[2]}"
            if key.endswith(".friction_peak") and kind == "range":
                friction = key.replace("friction_peak", "friction")
                text += f"; the value is the ratio of the static to the kinetic coefficient {friction}"
        elif kind == "bool_type":
            text = f"{key} = {shown}: allowed is true or false, without quotes"
        elif kind == "string_type":
            text = f"{key} = {shown}: allowed is text in quotes"
        else:
            text = f"{key} = {shown}: {problem['msg']}"
        self.refused_keys.add(key)
        self.refuse(key, value, text)

    # ---- parameters ----

    def _parameters(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The FMU's parameters that the file gives, in the FMU's order."""
        found = {}
        for name in all_parameters():
            group, _, last = name.rpartition(".")
            table = values.get(group, {}) if group else values
            if last in table:
                found[name] = table[last]
        return found

    def _spring_limits(self, spring: Mapping[str, Any]) -> SpringLimits | None:
        free, solid = spring.get("free_length"), spring.get("solid_length")
        if (free is None and solid is None) or self._is_refused("spring"):
            return None
        if free is None or solid is None:
            given, lacking = ("free_length", "solid_length")[:: 1 if solid is None else -1]
            text = f"spring.{given} is given, spring.{lacking} is not: allowed are both or none"
            self.refuse(f"spring.{given}", spring[given], text)
            return None
        if not 0.0 <= solid < free:
            text = f"spring.solid_length = {solid:g} m: allowed is less than spring.free_length = {free:g} m"
            self.refuse("spring.solid_length", solid, text)
            return None
        return SpringLimits(free, solid)

    def _check_units(self, values: Mapping[str, Any], with_unit: set[str]) -> None:
        """Warnings for all numbers of the file, but for values with a written unit: their unit is known."""
        for key, value in _leaves("", values):
            if key not in with_unit and (text := unit_warning(key, value)):
                self.warn(key, value, text, "unit")
        histories = values.get("scenario", {}).get("inputs", {})
        for name, history in histories.items():
            far = max(history.get("value", ()), key=abs, default=0.0)
            if with_unit.isdisjoint(f"scenario.inputs.{name}{part}" for part in ("", ".value", ".unit")) and (
                text := unit_warning(f"scenario.inputs.{name}", far)
            ):
                self.warn(f"scenario.inputs.{name}", far, text, "unit")

    def _warn_of_other_laws(self, parameters: Mapping[str, Any]) -> None:
        """Warnings for keys of another groove law than that of the cam."""
        for cam in ("cam1", "cam2"):
            profile = f"{cam}.profile"
            if self._is_refused(profile):
                continue
            law = LAWS[parameters.get(profile, all_parameters()[profile].start)]
            groove = f"the groove of {cam} is {'an' if law.word[0] in 'aeiou' else 'a'} {law.word}"
            for name in PARAMETERS:
                key = f"{cam}.{name}"
                if (
                    parameters.get(key, "") != "" and name not in law.parameters
                ):  # an empty path names no table
                    words = " or ".join(f'"{other.word}"' for other in laws_with(name))
                    text = f"{key} is not used: {groove}. {key} belongs to {profile} = {words}"
                    self.warn(key, parameters[key], text, "unused")

    # ---- tables ----

    def _read_tables(self, parameters: dict[str, Any]) -> None:
        """Replaces the paths of tables by absolute paths of files that the FMU reads."""
        for cam in ("cam1", "cam2"):
            name, profile = f"{cam}.table", parameters.get(f"{cam}.profile", 1)
            if self._is_refused(f"{cam}.profile") or self._is_refused(name):
                continue
            if profile == TABLE.number and not parameters.get(name):
                text = f'{cam}.profile = 3 (table) without {name}: give its path, {name} = "groove.csv"'
                other = "cam2" if cam == "cam1" else "cam1"
                if parameters.get(f"{other}.table") and parameters.get(f"{other}.profile", 1) != TABLE.number:
                    text += f"; {other} has a table without profile = 3: are cam1 and cam2 swapped?"
                self.refuse(f"{cam}.profile", profile, text)
            elif parameters.get(name):
                self._read_table(parameters, cam)
        for cam in ("cam1", "cam2"):
            if parameters.get(f"{cam}.friction_table") and not self._is_refused(f"{cam}.friction_table"):
                self._read_friction_table(parameters, cam)

    def _replace_path(
        self,
        parameters: dict[str, Any],
        name: str,
        read: Callable[[Path], tuple[Any, Path]],
        warnings_of: Callable[[Any], Iterable[str]],
    ) -> bool:
        """Put the path of what the FMU reads in the place of a table's path; False if it cannot be read."""
        written = parameters[name]
        try:
            table, readable = read((self.path.parent / written).absolute())
        except (DualcamError, OSError, ValueError) as error:
            self.refuse(name, written, f"{name} = {written!r}: {error}")
            return False
        parameters[name] = str(readable)
        if table.notes:
            self.notes.append(f"{name} = {written!r} was read so: {', '.join(table.notes)}")
        for text in warnings_of(table):
            self.warn(name, written, f"{name} = {written!r}: {text}", "unit")
        return True

    def _read_table(self, parameters: dict[str, Any], cam: str) -> None:
        radius = parameters.get(f"{cam}.radius", all_parameters()[f"{cam}.radius"].start)
        self._replace_path(
            parameters,
            f"{cam}.table",
            fmu_groove,
            lambda groove: table_warnings(groove.psi, groove.z, radius),
        )

    def _read_friction_table(self, parameters: dict[str, Any], cam: str) -> None:
        name = f"{cam}.friction_table"
        if not self._replace_path(parameters, name, fmu_friction, lambda table: table.warnings):
            return
        for key in ANALYTIC_FRICTION:
            if f"{cam}.{key}" in parameters:
                text = f"{cam}.{key} is not used with {name}, which gives the friction coefficient itself"
                self.warn(f"{cam}.{key}", parameters[f"{cam}.{key}"], text, "unused")

    # ---- other tables ----

    def _model(self, scenario: Mapping[str, Any]) -> str:
        """The model that the inputs of the scenario belong to."""
        inputs = [name for name in scenario.get("inputs", {}) if name not in ANY_INPUT]
        by_model = {model: [n for n in inputs if n in inputs_of(model)] for model in ("forward", "inverse")}
        if by_model["forward"] and by_model["inverse"]:
            given = " and ".join([by_model["forward"][0], by_model["inverse"][0]])
            allowed = (
                "allowed is tau (the torque is given, the motion is found), or theta (the motion is given,"
                " the torque is found)"
            )
            self.refuse("scenario.inputs", None, f"[scenario] has {given}: {allowed}")
        if by_model["inverse"] and "theta" not in by_model["inverse"]:
            found = f"[scenario] has {by_model['inverse'][0]} without theta"
            allowed = "allowed is theta over time; omega and alpha then follow from theta"
            self.refuse("scenario.inputs", None, f"{found}: {allowed}")
        return "inverse" if by_model["inverse"] else "forward"

    def _pin(self, table: Mapping[str, Any]) -> Any:  # noqa: ANN401
        from dualcam.design import Pin

        lacking = [name for name in ("radius", "width") if name not in table]
        if lacking:
            self.refuse("pin", None, f"[pin] lacks {' and '.join(lacking)}: give both radius and width in m")
            return None
        return self.attempt("pin", lambda: Pin(**table))

    def _roller(self, table: Mapping[str, Any], pin: Any) -> Any:  # noqa: ANN401
        from dualcam.design import Roller

        if self._is_refused("roller") or self._lacks("roller", table, ("bearing_friction", "bearing_radius")):
            return None
        if pin is None:
            if not any(error.key.startswith("pin") for error in self.errors):
                text = "[roller] without [pin]: give pin.radius, the radius of the roller, and pin.width"
                self.refuse("roller", None, text)
            return None
        return self.attempt("roller", lambda: Roller(pin.radius, **table))

    def _helical_spring(self, table: Mapping[str, Any]) -> Any:  # noqa: ANN401
        from dualcam.design import HelicalSpring

        needed = ("wire_diameter", "coil_diameter", "active_coils")
        if self._is_refused("helical_spring") or self._lacks("helical_spring", table, needed):
            return None
        return self.attempt("helical_spring", lambda: HelicalSpring(**table))

    def _lacks(self, name: str, table: Mapping[str, Any], needed: Sequence[str]) -> bool:
        """Whether a key is missing, which is then an error."""
        lacking = [key for key in needed if key not in table]
        if lacking:
            self.refuse(name, None, f"[{name}] lacks {', '.join(lacking)}: give {', '.join(needed)}")
        return bool(lacking)


# ---- sections ----


def _scenario(table: Mapping[str, Any], model: str) -> Any:  # noqa: ANN401
    """The Scenario of a validated table; omega and alpha follow from theta where they are not given."""
    from dualcam.scenario.scenario import History, Scenario

    if "stop" not in table:
        raise DesignError("lacks stop: give the end of the simulation in s, such as stop = 2.0")
    inputs = {name: History(**history) for name, history in table.get("inputs", {}).items()}
    if model == "inverse":
        for name, of in (("omega", "theta"), ("alpha", "omega")):
            inputs.setdefault(name, History(derivative_of=of))
    return Scenario(table["stop"], inputs, table.get("step"), table.get("tolerance"))


# ---- values ----


def _leaves(prefix: str, table: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Keys, dotted, and numbers of all tables but the study; of a pair of numbers the larger one."""
    found: list[tuple[str, Any]] = []
    for name, value in table.items():
        if isinstance(value, Mapping) and name not in ("study", "inputs"):
            found += _leaves(f"{prefix}{name}.", value)
        elif isinstance(value, tuple) and value:
            found.append((f"{prefix}{name}", max(value)))
        elif not isinstance(value, Mapping):
            found.append((f"{prefix}{name}", value))
    return found


def _keys_with_unit(prefix: str, table: Mapping[str, Any]) -> set[str]:
    """Keys, dotted, whose value is text, or a list of texts: a number in quotes has its unit."""
    found: set[str] = set()
    for name, value in table.items():
        key = f"{prefix}{name}"
        if isinstance(value, Mapping):
            found |= _keys_with_unit(f"{key}.", value)
        elif all(isinstance(part, str) for part in (value if isinstance(value, list) else [value])):
            found.add(key)
    return found


def _without(content: dict[str, Any], place: tuple[int | str, ...]) -> dict[str, Any]:
    """The content without the entry at the place, or without the entry around the place."""
    first, *rest = place
    left = {name: value for name, value in content.items() if name != first}
    if rest and isinstance(content.get(str(first)), dict):
        return left | {str(first): _without(content[str(first)], tuple(rest))}
    return left


def _shown(value: object) -> str:
    """A value as it stands in the file, short."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{...}"
    if isinstance(value, list) and len(str(value)) > 40:
        return f"a list of {len(value)}"
    text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
