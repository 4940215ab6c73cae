"""Files of attitudes and motions: one module for each format, imported on its own.

spin_file           spin files (TOML): a body and its spin
mission             mission files (TOML): a scene, times and columns
aem, apm, acm       CCSDS Attitude Ephemeris, Parameter and Comprehensive Messages
cic                 attitude files of CIC, the dialect of CNES and VTS
stk                 STK attitude files
ck                  SPICE C-kernels
damit               spin files of DAMIT
damit_light_curve   light curves of DAMIT
quat                plain tables of quaternions
tables              astropy QTable, ECSV, FITS, CSV, parquet
detect              any of these by content or ending: `read`, `opened`, `write`, `write_motion`

_aem_message        an AEM or CIC file: keywords, records of segments, read and to be written
_messages           units, epochs, axes, sequences and inertia of CCSDS attitude messages
_ck_files           files, clock and records of C-kernels; SPICE's pool
_recipes            settings of writers for a tool that shall read the file
_format             `Format`, the contract of a format, and the registry of formats
_records            types of attitudes; rows of a file to an AttitudeTable, a history to rows
_surface            sections [shape], [scattering], [magnitude] of spin and mission files
_sampling           a motion to records within a tolerance; what a writer is given, as segments
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.formats._format import Format, OpenedFile, Option, forget, formats, register

__all__ = ["Format", "OpenedFile", "Option", "forget", "formats", "register"]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
