"""The tools of all benchmarks: building C loops, stepping FMUs, timing, instruction counts, results on disk.

Only benchmarks and their tests import this package. `core` holds all that the benchmarks know about fmu_src,
`oracles` all that they take from tests/. `slave` and `replay` import nothing but the standard library,
because they run under callgrind.
"""
