"""The table of the Earth's orientation that is installed, for astropy in a test."""

from astropy.utils import iers


def installed():
    """A context in which astropy uses the table of astropy-iers-data.

    Without one astropy 6.1 requests a newer file.
    """
    table = iers.IERS_A.read(iers.IERS_A_FILE, readme=iers.IERS_A_README)
    return iers.earth_orientation_table.set(table)
