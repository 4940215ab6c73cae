"""Files of DAMIT, the database of asteroid models.

damit         spin files: `read`, `write`, `RelaxedRotator`
curve         `DamitLightCurve`: one light curve with its geometry
light_curve   files of light curves: `read_damit_light_curves`, `write_damit_light_curves`
"""

from attitude.formats.damit.damit import RelaxedRotator, read, write

__all__ = ["RelaxedRotator", "read", "write"]
