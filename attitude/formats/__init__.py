"""Files of attitudes and motions: one module or package for each format, imported on its own.

spin_file        spin files (TOML): a body and its spin; `spin_sections` reads their sections
mission          mission files (TOML): a scene, times and columns; `photometry` reads their
                 sections on shape, scattering and magnitudes
aem, apm, acm    CCSDS Attitude Ephemeris, Parameter and Comprehensive Messages
cic              attitude files of CIC, the dialect of CNES and VTS
stk              STK attitude files
ck               SPICE C-kernels
damit            spin files and light curves of DAMIT
quat             plain tables of quaternions
tables           astropy QTable, ECSV, FITS, CSV, parquet; with `csv_table`, `csv_rows`, `parquet`
detect           any of these by content or ending: `read`, `opened`, `write`, `write_motion`

ccsds            time codes, attitude types and axes of CCSDS messages
recipes          settings of writers for a tool that shall read the file
sampling         a motion to records within a tolerance
rows             records read from a file -> AttitudeTable; history -> columns
sources          what a writer is given -> segments, evaluated piece by piece
"""
