"""Sweeps: many runs of one scene with other values, on this machine, under Slurm or on a Dask cluster.

`python -m tulle.sweep SWEEP.yaml` reads what to run, makes one directory with a run for each row of values, and
collects a table, arrays and a page. The package needs PyYAML and the program `tulle`, numpy for the arrays, and nothing
else of the package `tulle`; so it works on a login node.

How the modules build on each other, from below:

- `problems`, `document`: errors with places; YAML with the places of its values.
- `values`, `definition`: the rows of values; what a sweep file says.
- `program`, `layout`: the program; the files of a sweep's directory, and its lock.
- `plan`: which run has which number, and what of an earlier start stays.
- `execute`: one run from start to picture, wherever it happens.
- `arrays`, `collect`, `page`: what the runs give.
- `local`, `slurm`, `dask_cluster`: where the runs happen.
- `progress`, `cli`: what people see.
"""
