"""The experiments of Wong and Baciu (2005) again, over the files of Tulle's program.

Runs the scenes of the paper by `tulle run`, judges every frame by `tulle check`, asks the detector by
paper_measure, takes stills by `tulle render`, and writes tables, plots and one page that shows all of it.
lab/paper.md describes every file.
"""
