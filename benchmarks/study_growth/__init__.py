"""Growth of a parameter study with its workers, and where the growth ends.

    ./build.sh run studygrowth

The study is that of `./build.sh run rate`, with Parquet files in one folder that all workers see.

1. Throughput of one and of two workers, in turns: processes of this machine, and workers of a Dask cluster on
   this machine. Reported as the median over the rounds, with quartiles. Where other programs run, too, these
   numbers are small; the processors' time of a run then says what free processors would make.
2. What a file of 10,000 runs costs: values of the plan, runs, encoding, writing; and what the study itself
   does for the file, by pipe and by Dask.
3. Throughput of up to 1000 workers on paper, from these costs: which part is busy all the time first.
4. Runs over one groove table and over 100 tables.
"""
