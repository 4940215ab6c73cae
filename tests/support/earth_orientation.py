"""The table of the Earth's orientation that is installed, for astropy in a test."""

from astropy.utils import iers


class _WithFinalValues(iers.IERS_A):
    """The table IERS_A in which IERS_B replaces the past, as IERS_Auto, which asks the network."""

    _substitute_iers_b = iers.IERS_Auto.__dict__["_substitute_iers_b"]


def installed():
    """A context in which astropy uses the table of astropy-iers-data.

    Without one astropy 6.1 requests a newer file.
    """
    table = _WithFinalValues.read(iers.IERS_A_FILE, readme=iers.IERS_A_README)
    return iers.earth_orientation_table.set(table)
