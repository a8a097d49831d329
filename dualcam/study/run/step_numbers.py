"""The steps of the runs of a scenario, for the rows of a plan: runs of one arrangement differ in numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array
from dualcam.scenario.formula import formula
from dualcam.scenario.history import Number, names_in, numbers_in
from dualcam.scenario.scenario import Scenario, Step, instants
from dualcam.study.plan.rows import values_of
from dualcam.study.plan.texts import Texts
from dualcam.study.run.step_times import (
    AT_ONE_INSTANT,
    FIRST,
    Arrangement,
    Group,
    Key,
    groups_of_rows,
    has_points,
    numbers_of,
)


class StepNumbers:
    """The steps of the runs of a scenario, for rows with columns of these names, whose texts are places.

    `interpolates`: whether the FMU takes derivatives of inputs. `fixed`: whether it needs steps of one
    length."""

    def __init__(
        self,
        scenario: Scenario,
        results: Sequence[str],
        names: Sequence[str],
        texts: Mapping[str, Texts],
        interpolates: bool,
        fixed: bool,
    ) -> None:
        self.scenario, self.results, self.names, self.texts = scenario, results, names, texts
        self._interpolates, self._fixed = interpolates, fixed

    def arrangement(self, scenario: Scenario) -> Arrangement:
        """The steps of a scenario without formulas."""
        return Arrangement(*self._steps(scenario))

    def _steps(self, scenario: Scenario) -> tuple[tuple[Step, ...], tuple[int, ...]]:
        wanted = [time for _, time in instants(self.results, scenario.stop)]
        steps = scenario.steps(sorted(set(wanted)), self._interpolates, self._fixed)
        ends = np.array([step.time + step.size for step in steps])
        margins = AT_ONE_INSTANT * np.array([step.size for step in steps])
        read_after = []
        for time in wanted:
            near = np.flatnonzero(np.abs(ends - time) <= margins)
            read_after.append(FIRST if time == 0.0 else int(near[0]))
        return tuple(steps), tuple(read_after)

    def groups(self, rows: Array) -> tuple[list[Group], dict[int, str]]:
        """The runs of rows by their arrangements; by their places those that are no scenario: why."""
        if self._is_linear:
            return self._linear_group(rows)
        if has_points(self.scenario, self._interpolates, self._fixed):
            return self._groups_by_points(rows)
        columns = [self.names.index(name) for name in self.scenario.names]
        different, first, which = np.unique(rows[:, columns], axis=0, return_index=True, return_inverse=True)
        by_key: dict[Key, tuple[Arrangement, list[int], list[list[float]]]] = {}
        failed: dict[int, str] = {}
        for place, line in enumerate(first):
            try:
                arrangement = self.arrangement(self._scenario_of(rows[line]))
            except StudyError as error:
                failed |= dict.fromkeys(np.flatnonzero(which == place).tolist(), "; ".join(error.problems))
                continue
            _, members, numbers = by_key.setdefault(arrangement.key, (arrangement, [], []))
            members.append(place)
            numbers.append(numbers_of(arrangement.steps))
        groups = []
        for arrangement, members, numbers in by_key.values():
            order = np.full(len(different), -1)
            order[members] = np.arange(len(members))
            places = np.flatnonzero(order[which] >= 0)
            groups.append(Group(arrangement, places, np.array(numbers)[order[which[places]]]))
        return groups, failed

    def _scenario_of(self, row: Array) -> Scenario:
        return self.scenario.at(values_of(self.names, row, self.texts))

    def law_arguments(self, rows: Array) -> Array:
        """The numbers of the controller's arguments for each row, in their order; of texts their places."""
        control = self.scenario.controller
        assert control is not None
        columns = dict(zip(self.names, rows.T, strict=True))
        found = [numbers_in(each, columns, len(rows)) for each in control.arguments.values()]
        return np.column_stack(found) if found else np.empty((len(rows), 0))

    # ---- many runs at once ----

    @cached_property
    def _is_linear(self) -> bool:
        """Whether the steps are at the same times in all runs: values of inputs alone are formulas. All
        numbers are then linear in those values, so that one matrix gives the numbers of all runs."""
        scenario = self.scenario
        fixed = [each for each in (scenario.stop, scenario.step) if each is not None]
        fixed += [scenario.controller.period] if scenario.controller else []
        for history in scenario.inputs.values():
            fixed += [*history.time, history.frequency, history.phase]
        return not names_in(fixed)

    @cached_property
    def _formulas(self) -> list[str]:
        """Of the values of inputs, each once: equal ones keep a step without a slope."""
        inputs = self.scenario.inputs.values()
        numbers = [number for each in inputs for number in (*each.value, each.mean, each.amplitude)]
        return list(dict.fromkeys(number for number in numbers if isinstance(number, str)))

    @cached_property
    def _line_and_matrix(self) -> tuple[Arrangement, Array, Array]:
        """The arrangement, the numbers where all formulas are 0, and what each formula adds for 1."""
        zeros = dict.fromkeys(self._formulas, 0.0)
        samples = [self._sample(zeros, keeps_numbers=True)]
        samples += [self._sample(zeros | {text: 1.0}, keeps_numbers=False) for text in self._formulas]
        rates = [
            list(dict.fromkeys(key for sample in samples for key in sample[0][k].rates))
            for k in range(len(samples[0][0]))
        ]
        whole = [
            [
                replace(step, rates={key: step.rates.get(key, 0.0) for key in keys})
                for step, keys in zip(steps, rates, strict=True)
            ]
            for steps, _ in samples
        ]
        line = np.array(numbers_of(whole[0]))
        added = [[replace(step, time=0.0, size=0.0) for step in steps] for steps in whole[1:]]
        matrix = np.array([numbers_of(steps) for steps in added]).reshape(len(added), len(line))
        return Arrangement(tuple(whole[0]), samples[0][1]), line, matrix

    def _sample(
        self, values: Mapping[str, float], keeps_numbers: bool
    ) -> tuple[tuple[Step, ...], tuple[int, ...]]:
        """The steps where formulas have these values; other numbers stay, or are 0."""

        def other(number: Number) -> float:
            return values[number] if isinstance(number, str) else float(number) * keeps_numbers

        inputs = {
            name: replace(
                history,
                value=[other(number) for number in history.value],
                mean=other(history.mean),
                amplitude=other(history.amplitude),
            )
            for name, history in self.scenario.inputs.items()
        }
        control = self.scenario.controller
        still = replace(control, arguments={}) if control else None
        return self._steps(replace(self.scenario, inputs=inputs, controller=still))

    def _linear_group(self, rows: Array) -> tuple[list[Group], dict[int, str]]:
        arrangement, line, matrix = self._line_and_matrix
        columns = dict(zip(self.names, rows.T, strict=True))
        values = [formula(text).numbers(columns, len(rows)) for text in self._formulas]
        numbers = np.tile(line, (len(rows), 1))
        if values:
            numbers += np.column_stack(values) @ matrix
        finite = np.all(np.isfinite(numbers), axis=1)
        failed = {int(place): self._why_not(rows[place]) for place in np.flatnonzero(~finite)}
        places = np.flatnonzero(finite)
        return [Group(arrangement, places, numbers[places])], failed

    def _groups_by_points(self, rows: Array) -> tuple[list[Group], dict[int, str]]:
        columns = dict(zip(self.names, rows.T, strict=True))

        def evaluate(number: Number) -> Array:
            return numbers_in(number, columns, len(rows))

        groups, refused = groups_of_rows(self.scenario, self.results, evaluate, len(rows))
        return groups, {int(place): self._why_not(rows[place]) for place in refused}

    def _why_not(self, row: Array) -> str:
        try:
            self._steps(self._scenario_of(row))
        except StudyError as error:
            return "; ".join(error.problems)
        return "scenario: a number of an input is not finite"
