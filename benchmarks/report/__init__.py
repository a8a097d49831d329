"""docs/performance.md from the results of the benchmarks.

    .venv/bin/python -m benchmarks.report        (./build.sh run bench ends with it)

All numbers of the page are those of the CSV files.
"""
