"""What every subject needs: checks of input, arrays, pairs, blocks, least squares, text.

annotations     types of public parameters and results
validation      checks of the numbers that callers give; arguments that do not exist
quantity_text   values in text: quoted, counted, numbers followed by a unit
synonyms        hints for names that other packages use; methods of higher folders
arrays          read-only arrays, immutable classes, memory for results
pairs           sums and products in two doubles, in numpy
least_squares   Levenberg and Marquardt's iteration, of many states side by side
blocks          division of work into blocks and threads, reports of progress
tables          astropy's tables, written with a column for each component
markup          HTML and SVG for notebooks
constants       physical constants
"""
