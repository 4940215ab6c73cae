"""The names of `_MODULES` and `_WHERE`, for editors and type checkers."""

from attitude import arcs as arcs
from attitude import averaged as averaged
from attitude import catalog as catalog
from attitude import conditions as conditions
from attitude import ensemble as ensemble
from attitude import epochs as epochs
from attitude import errors as errors
from attitude import events as events
from attitude import fitting as fitting
from attitude import formats as formats
from attitude import frames as frames
from attitude import inversion as inversion
from attitude import jacobi as jacobi
from attitude import jax as jax
from attitude import light_curve as light_curve
from attitude import motions as motions
from attitude import paths as paths
from attitude import photometry as photometry
from attitude import plots as plots
from attitude import proof as proof
from attitude import published as published
from attitude import quaternion as quaternion
from attitude import referee as referee
from attitude import representations as representations
from attitude import scattering as scattering
from attitude import scene as scene
from attitude import shape as shape
from attitude import splitting as splitting
from attitude import survey as survey
from attitude import torch as torch
from attitude import torques as torques
from attitude import viewer as viewer
from attitude._compilation.decorators import compilation_status as compilation_status
from attitude._solver.regime import Mode as Mode
from attitude.ensemble._ensemble import Ensemble as Ensemble
from attitude.errors import AttitudeError as AttitudeError
from attitude.fitting._attitudes import fit as fit
from attitude.fitting._attitudes import fit_directions as fit_directions
from attitude.fitting._attitudes import fit_rates as fit_rates
from attitude.motions._body import Body as Body
from attitude.motions._free_rotation import FreeRotation as FreeRotation
from attitude.motions._free_rotation import certify as certify
from attitude.motions._history import AttitudeHistory as AttitudeHistory
from attitude.motions._propagation import propagate as propagate
from attitude.motions._spin import Spin as Spin
from attitude.motions._table import AttitudeTable as AttitudeTable
from attitude.referee._referee import compare as compare
from attitude.scene._scene import Scene as Scene
from attitude.torques._arcs import Arcs as Arcs
from attitude.torques._arcs import Impulse as Impulse
from attitude.torques._arcs import InertiaChange as InertiaChange
from attitude.torques._torqued import TorquedRotation as TorquedRotation

__version__: str
__all__: list[str]
FORMAT_MODULES: tuple[str, ...]
PUBLIC_MODULES: tuple[str, ...]
