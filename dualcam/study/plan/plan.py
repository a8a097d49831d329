"""Which values the runs of a study have."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from dualcam.common.arrays import Array
from dualcam.common.mistakes import refuse
from dualcam.study.plan import tables
from dualcam.study.plan.fields import PlanFields, problems_of_plan
from dualcam.study.plan.salib import problem_of, vary_of
from dualcam.study.plan.sampler import Sampler


@dataclass(frozen=True)
class Plan(PlanFields):
    """Which values each run has: rows by the number of the run, made when they are asked for.

    Parameters
    ----------
    kind : {"grid", "random", "latin", "sobol", "indices", "saltelli", "morris", "fast", "table"}
        "grid": every combination of the values, the last variable fastest. "random": `runs` independent runs.
        "latin": `runs` runs of a Latin hypercube. "sobol": `runs` runs of a scrambled Sobol sequence.
        "indices": the runs for Sobol's indices, see Notes. "saltelli", "morris", "fast": the runs that
        SALib's analysers take. "table": the rows of `table`.
    vary : Values by the name: of a variable of the FMU, or of a number for the scenario, a formula or a law.
    runs : int
        Number of runs of "random", "latin" and "sobol"; a power of 2 for "indices" and "saltelli";
        trajectories of "morris"; runs of each variable of "fast".
    seed : Start of the random numbers, 0 or more.
    table : array_like, shape (runs, variables), optional
        Of "table": values, columns in the order of `vary`. Of texts: their places.
    same_as : Variables that get the value of another one in every run.
    derived : Formulas, by the name of what gets their value, over the other names.
    constraints : Formulas that must be true in every run, by a name of theirs.
    on_violation : {"redraw", "mark"}
        What becomes of a run that violates a constraint: it is drawn again, up to 1000 times, or it is not
        made and its message names the constraint. Only runs of "random", "latin" and "sobol" can be drawn
        again.
    correlations : Correlations of "random", "latin" and "sobol", by a Gaussian copula.
    second_order : Of "saltelli": whether the runs are there for second-order indices.
    levels : Of "morris": levels of each variable, an even number.

    Raises
    ------
    StudyError
        All that is wrong at once: an unknown kind, a number or a range outside of what is allowed, a table of
        another shape, formulas that are none, or no runs.

    Notes
    -----
    "indices" makes `runs` times (variables + 2) runs, as Saltelli puts them: all of A, all of B, then for
    each variable all of A with B's column of that variable.

    `rows(start, stop)` has one column for each of `names`, in the FMU's units. The column of a String has
    places in `texts[name]`. `dualcam.study.plan.rows` says what a row means for its run.

    Examples
    --------
    >>> from dualcam.study import Plan, Vary
    >>> preload = Vary(50.0, 70.0, count=3)  # N
    >>> plan = Plan("grid", {"cam1.friction": Vary(values=[0.1, 0.2]), "spring.preload": preload})
    >>> plan.count
    6
    >>> plan.rows(0, 2).tolist()
    [[0.1, 50.0], [0.1, 60.0]]
    """

    def __post_init__(self) -> None:
        refuse(problems_of_plan(self))

    # ---- tables and other packages ----

    @classmethod
    def from_csv(cls, path: str | Path, texts: Collection[str] = ()) -> Plan:
        """A plan of kind "table" from a CSV file.

        Parameters
        ----------
        path : str or Path
            File whose first line names the variables. Each other line has the values of a run, in the FMU's
            units.
        texts : collection of str
            Variables whose column has texts, such as groove tables. Relative paths start in the file's
            folder.

        Returns
        -------
        Plan
            One run for each line.

        Raises
        ------
        StudyError
            The file is no table of numbers, or names a variable twice.
        """
        return cls.from_columns(tables.read_csv(Path(path), texts), Path(path).parent)

    @classmethod
    def from_parquet(cls, path: str | Path) -> Plan:
        """A plan of kind "table" from a Parquet file.

        Parameters
        ----------
        path : File with a column for each variable, in the FMU's units.

        Returns
        -------
        Plan
            One run for each row of the file.

        Raises
        ------
        StudyError
            The file is no table of numbers and texts, or pyarrow is not installed.
        """
        return cls.from_columns(tables.read_parquet(Path(path)), Path(path).parent)

    @classmethod
    def from_columns(cls, columns: Mapping[str, Sequence[Any] | Array], folder: Path | None = None) -> Plan:
        """A plan of kind "table" from columns.

        Parameters
        ----------
        columns : Numbers in the FMU's units, or texts, shape (runs,), by the name of the variable.
        folder : Where relative paths among the texts start; None: the current folder.

        Returns
        -------
        Plan
            One run for each row.

        Raises
        ------
        StudyError
            Columns of different lengths, or numbers that are not finite.

        Examples
        --------
        >>> from dualcam.study import Plan
        >>> plan = Plan.from_columns({"spring.preload": [50.0, 60.0], "cam1.table": ["a.csv", "b.csv"]})
        >>> plan.rows(0, 2).tolist(), plan.texts["cam1.table"][1]
        ([[50.0, 0.0], [60.0, 1.0]], 'b.csv')
        """
        vary, table = tables.places(columns, folder)
        return cls("table", vary, table=table)

    @classmethod
    def from_salib(
        cls,
        problem: Mapping[str, Any],
        kind: str,
        runs: int,
        seed: int = 0,
        **options: Any,  # noqa: ANN401
    ) -> Plan:
        """A plan over what a SALib problem describes.

        Parameters
        ----------
        problem : `names`, `bounds`, and `dists` if not all are uniform, as SALib has them.
        kind : Kind of the plan, such as "saltelli", "morris" or "fast".
        runs, seed
            As in `Plan`.
        **options
            Other parameters of `Plan`, such as `second_order`.

        Returns
        -------
        Plan
            Whose runs SALib's analysers take, with `salib_problem`.

        Raises
        ------
        StudyError
            A distribution or bounds that SALib does not have, or groups.

        Examples
        --------
        >>> from dualcam.study import Plan
        >>> problem = {"num_vars": 1, "names": ["cam1.friction"], "bounds": [[0.14, 0.02]], "dists": ["norm"]}
        >>> Plan.from_salib(problem, "latin", runs=8).vary["cam1.friction"].distribution
        'norm'
        """
        return cls(kind, vary_of(problem), runs, seed, **options)

    def salib_problem(self) -> dict[str, Any]:
        """The problem that SALib's analysers take together with the results of the runs: `num_vars`, `names`,
        `bounds` and `dists`. A list of values, and a distribution that SALib does not have, is described by
        its share in [0, 1]."""
        return problem_of(self.vary)

    # ---- what the runs get ----

    def limits(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of each variable that is not derived, in the FMU's units."""
        if self.kind == "table":
            ends = [(float(column.min()), float(column.max())) for column in self.table_rows.T if len(column)]
            found = dict(zip(self.vary, ends, strict=False))
        else:
            found = {name: vary.limits() for name, vary in self.vary.items()}
        return found | {name: found[other] for name, other in self.same_as.items()}

    def share_outside(self, name: str, least: float, most: float) -> float:
        """Share of the values of a variable that lie outside of a range.

        Parameters
        ----------
        name : One of `names`. Of a derived one the share is that of the first runs, 10,000 at most.
        least, most : Ends of the range, which are allowed.

        Returns
        -------
        float
            Share in [0, 1].
        """
        source = self.same_as.get(name, name)
        if source in self.vary and self.kind != "table":
            return self.vary[source].share_outside(least, most)
        values = self.rows(0, 10_000)[:, self.names.index(name)]
        return float(np.mean(~((values >= least) & (values <= most))))

    def rows(self, start: int, stop: int) -> Array:
        """The values of some runs.

        Parameters
        ----------
        start, stop : First run, and the run after the last one.

        Returns
        -------
        ndarray, shape (stop - start, names)
            A row for each run, columns in the order of `names`.
        """
        return self.sampler.rows(np.arange(start, min(stop, self.count)))

    @cached_property
    def sampler(self) -> Sampler:
        """What makes the rows."""
        return Sampler(self)

    def for_workers(self) -> Plan:
        """The plan as another process gets it: with the random numbers where they are few. A process that
        makes them by itself imports scipy.stats, which takes 0.7 s."""
        plan = replace(self)
        plan.sampler.take_few_numbers(self.sampler)
        return plan

    def facts(self) -> dict[str, Any]:
        """What the plan is, as plain data, to be compared with that of a study begun earlier."""
        is_table = self.kind == "table"
        facts = {
            "kind": self.kind,
            "vary": {
                name: (vary.texts.facts() if vary.texts else []) if is_table else vary.facts()
                for name, vary in self.vary.items()
            },
            "runs": self.runs,
            "seed": self.seed,
            "table": hashlib.sha256(self.table_rows.tobytes()).hexdigest() if is_table else "",
            "same_as": dict(self.same_as),
        }
        more = {
            "derived": dict(self.derived),
            "constraints": dict(self.constraints) and [dict(self.constraints), self.on_violation],
            "correlations": [[each.first, each.second, each.value, each.kind] for each in self.correlations],
            "second_order": self.kind == "saltelli" and [self.second_order],
            "levels": self.kind == "morris" and [self.levels],
        }
        return facts | {name: fact for name, fact in more.items() if fact}  # as versions before wrote them
