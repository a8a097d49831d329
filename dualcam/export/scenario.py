"""The scenario of a design in its exported FMU: inputs over time as a file, and Python lines that play it."""

import json
import math
from collections.abc import Mapping, Sequence
from html import escape

from dualcam.export.description import Scalar, number_text
from dualcam.fmi.variables import inputs_of
from dualcam.scenario.scenario import Scenario, Step

FILE = "extra/scenario_in.csv"
SAMPLES = 1000  # rows of an input that is no straight line
ROUNDING = 1e-12  # of the largest value of a column
STEPS = 2000  # of the run that the page proposes
OUTPUTS = {"forward": ("tau", "theta", "omega"), "inverse": ("theta", "tau", "z")}
LINES = """\
import fmpy
fmu = {file}
inputs = fmpy.read_csv(f"{{fmpy.extract(fmu)}}/{table}")
names = {outputs}
result = fmpy.simulate_fmu(fmu, stop_time={stop}, output_interval={interval}, input=inputs, output=names)
print(result[-1])  # time and outputs at the end"""
TEXT = """\
<div id="scenario">
<p><b>Scenario.</b> <code>{table}</code> holds the inputs of the design's scenario over {stop} s. Between
two rows the inputs are straight lines. These lines of Python play the scenario with FMPy:</p>
<pre>{lines}</pre>
<p>FMPy holds the inputs over each step. So the result lags by up to <code>output_interval</code>; a
smaller one makes the lag smaller.</p>
</div>"""


def scenario_for(scenario: Scenario | None, model: str) -> Scenario | None:
    """The scenario, if histories of inputs of this model alone make it."""
    if scenario is None or scenario.controller is not None or not scenario.inputs:
        return None
    return scenario if set(scenario.inputs) <= set(inputs_of(model)) else None


def scenario_table(scenario: Scenario, model: str, start: Mapping[str, Scalar]) -> bytes:
    """All inputs over time [s] as CSV that FMPy reads, to 12 digits; two rows of one time are a jump."""
    known = inputs_of(model)
    constant = {name: float(start.get(name, variable.start)) for name, variable in known.items()}
    rows = []
    for step in _steps(scenario):
        for time, values in ((step.time, step.values), (step.time + step.size, _at_end(step))):
            given = constant | dict(values)
            rows.append([time, *(given[name] for name in known)])
    lines = [",".join(["time", *known])]
    for row in _without_rounding(rows):
        line = ",".join(number_text(float(f"{number:.12g}")) for number in row)
        if line != lines[-1]:
            lines.append(line)
    return ("\n".join(lines) + "\n").encode()


def _without_rounding(rows: list[list[float]]) -> list[list[float]]:
    """The rows with 0 for numbers that are rounding: a speed of 1e-16 would have a direction of motion."""
    sizes = [max(map(abs, column)) for column in zip(*rows, strict=True)]
    return [[x if abs(x) > ROUNDING * s else 0.0 for x, s in zip(row, sizes, strict=True)] for row in rows]


def _steps(scenario: Scenario) -> Sequence[Step]:
    """The pieces of the histories; short ones where an input is no straight line."""
    pieces = scenario.steps([], interpolates=True, fixed=False)
    if all(order == 1 for piece in pieces for _, order in piece.rates):
        return pieces
    times = [k * scenario.stop / SAMPLES for k in range(SAMPLES)]
    return scenario.steps(times, interpolates=True, fixed=False)


def _at_end(step: Step) -> dict[str, float]:
    """The inputs at the end of a step."""
    end = dict(step.values)
    for (name, order), rate in step.rates.items():
        end[name] += rate * step.size**order / math.factorial(order)
    return end


def python_lines(file: str, scenario: Scenario, model: str) -> str:
    """Six lines of Python that play the scenario of the FMU `file` in FMPy."""
    return LINES.format(
        file=json.dumps(file, ensure_ascii=False),
        table=FILE,
        stop=number_text(scenario.stop),
        interval=number_text(float(f"{scenario.stop / STEPS:.3g}")),
        outputs=json.dumps(OUTPUTS[model]),
    )


def scenario_text(file: str, scenario: Scenario, model: str) -> str:
    """The paragraph about the scenario for the page of the FMU."""
    lines = escape(python_lines(file, scenario, model), quote=False)
    return TEXT.format(table=FILE, stop=number_text(scenario.stop), lines=lines)
