"""Files of attitudes and motions: one module or package for each format, imported on its own.

spin_file        spin files (TOML): a body and its spin
mission          mission files (TOML): a scene, times and columns
aem, apm, acm    CCSDS Attitude Ephemeris, Parameter and Comprehensive Messages
cic              attitude files of CIC, the dialect of CNES and VTS
stk              STK attitude files
ck               SPICE C-kernels; `_ck_files`, clock and frame kernels, plans of segments
damit            spin files of DAMIT; `damit_light_curve`, its light curves
tables           astropy QTable, ECSV, FITS, CSV, parquet
detect           any of these by content or ending: `read`, `opened`, `write`, `write_motion`

_attitude_types  attitude types of CCSDS messages; `_ccsds_epochs`, time codes
_aem_message     the meaning of an AEM; `_aem_notations`, its KVN and XML
_recipes         settings of writers for a tool that shall read the file
_sampling        a motion to records within a tolerance; segments of what a writer is given
_records         records read from a file -> AttitudeTable; history -> columns
"""
