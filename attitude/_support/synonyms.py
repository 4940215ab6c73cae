"""Names that other packages use, answered with the name that stands here.

`ATTRIBUTES` and `MODULES` hold a hint for each name that an object or a module does not have, and
`ARGUMENTS` for each argument that a call does not have.  A class holds those of its names; modules
and calls are answered after the usual search has failed: no hint costs time where a name exists.
"""

from __future__ import annotations

import sys
from abc import ABCMeta
from collections.abc import Callable, Mapping
from functools import wraps
from importlib import import_module
from typing import Any, ParamSpec, TypeVar

from attitude.errors import AttitudeError

P = ParamSpec("P")
R = TypeVar("R")
Class = TypeVar("Class", bound=type)

_WXYZ = "use .at(t).wxyz, scalar first, or .xyzw, scalar last"
_AT = "use .at(t), which has wxyz, xyzw, matrix, dcm and angular_velocity"
_PERIODS = (
    "use period_psi and period_phi, in s, or published('L') and published('S'), which have P_psi, "
    "P_phi, pole, phi0 and psi0 as papers print them"
)
_ROTATION = "use as_rotation(), a scipy Rotation, matrix (body to ICRF) or dcm (ICRF to body)"
_FILE = "use write(file), whose format follows from the ending, such as m.toml, m.aem or m.csv"
_TABLE = 'use table().write("x.ecsv") or table().write("x.csv")'
_RATES = "use angular_velocity, rad/s over the body axes"

# Hints by the name of a class, which hold for its subclasses too, and by absent names.
_OF_CLASSES = {
    "Motion": {
        "quaternion quaternions quat q wxyz xyzw": _WXYZ,
        "rotation rotations as_rotation matrix rotation_matrix dcm": (
            "use .at(t).as_rotation(), a scipy Rotation, .at(t).matrix (body to ICRF) or "
            ".at(t).dcm (ICRF to body)"
        ),
        "euler euler_angles eulers": 'use .at(t).euler("ZXZ"), rad',
        "omega angular_velocity rates rate w": (
            "use .at(t).angular_velocity, rad/s over the body axes"
        ),
        "propagate evaluate attitude attitude_at state states history integrate solve": _AT,
        "interpolate orientation get_attitude get_state state_at predict": _AT,
        "to_aem to_file to_toml to_csv to_ck to_apm to_acm save export dump to_stk to_spice": _FILE,
        "to_bc to_dict": _FILE,
        "lightcurve light_curve brightness magnitude": (
            "use attitude.Scene(motion, ..., shape=mesh).at(times).magnitude"
        ),
        "animate animation movie": (
            'use attitude.viewer.animate(motion, "m.mp4"), or view(output="m.html")'
        ),
        "show display render": 'use view(output="m.html"), or plot()',
        "table to_table to_pandas": "use .at(t).table(), an astropy QTable",
    },
    "FreeRotation": {
        "period periods P_psi P_phi rotation_period P precession_period nutation_period": _PERIODS,
        "spin_period frequency frequencies precession_rate": _PERIODS,
        "spin_rate rpm angular_speed mean_rate": (
            "use at(t).angular_velocity; str(motion) has its least, greatest and mean length"
        ),
        "pole spin_axis spin_pole rotation_axis axis momentum_direction": (
            "use momentum / |momentum|, the direction of the angular momentum in ICRF, or "
            "published('L').pole"
        ),
        "angular_momentum L H h": "use momentum, kg m2/s in ICRF",
        "kinetic_energy E T": "use energy, J",
        "nutation nutation_angle theta wobble wobble_angle": (
            "use angles(t), phi, theta and psi about the momentum, rad: theta is the nutation"
        ),
        "is_tumbling tumbles is_lam is_sam lam sam": "use mode, a Mode such as SHORT_AXIS",
        "describe summary info": "print the motion: str(motion) describes it",
        "separatrix is_near_separatrix": "use separatrix_distance or mode",
        "flips flip_times flip_period": (
            "use period_psi / 2, the time between flips, regime.flip_time and regime.dwell_time"
        ),
        "moments inertia principal_moments": "use body.moments, kg m2",
        "tensor inertia_tensor": "use body.tensor, kg m2",
        "covariance sigma errors": "use at(t).covariance, or at(t).sigma in rad",
        "jacobian stm derivatives": "use at(t).sensitivity or sensitivity_at(t)",
    },
    "AttitudeHistory": {
        "quaternion quaternions quat q as_quat": "use wxyz, scalar first, or xyzw, scalar last",
        "rotation rotations as_matrix rotation_matrix matrices R A C": _ROTATION,
        "euler_angles as_euler angles": 'use euler("ZXZ"), rad',
        "omega rates rate w angular_rate omegas": _RATES,
        "times t epochs": "use time, an astropy Time, or seconds since epoch",
        "write save to_csv to_ecsv to_file export": _TABLE,
        "to_table to_frame to_dataframe dataframe df": (
            "use table(), an astropy QTable, or to_pandas()"
        ),
        "rpy ypr roll_pitch_yaw roll pitch yaw": 'use euler("zyx"), rad',
        "interpolate resample interp": (
            "use the motion's .at(t): every epoch costs the same, and AttitudeTable.from_history "
            "interpolates"
        ),
        "plot show": "use motion.plot(), or attitude.plots",
        "apply rotate to_inertial": "use body_to_inertial(v)",
        "to_body apply_inverse": "use inertial_to_body(v)",
        "errors error std": "use sigma (rad), sigma_deg or covariance",
    },
    "AttitudeTable": {"time times t epochs": "use history.time, or seconds since epoch"},
    "AveragedHistory": {"branches events": "use branches() and events of the AveragedMotion"},
    "Body": {
        "inertia inertia_tensor I": "use tensor (body axes) or moments, kg m2",
        "principal_moments Ixx Iyy Izz A B C": "use moments, kg m2",
        "axes principal_frame": "use principal_axes, the columns are unit vectors",
        "com centre_of_mass center": "use center_of_mass, m",
        "from_moments from_principal_moments": "use Body(moments=(3 numbers))",
        "from_tensor from_inertia from_matrix": "use Body(tensor=(3 x 3))",
        "from_mesh from_obj from_file from_box from_cuboid box cuboid": (
            "use Body.from_shape(mesh, density=), where mesh is attitude.shape.read(file) or "
            "attitude.shape.box((a, b, c))"
        ),
        "sphere ellipsoid from_sphere": "use Body.from_ellipsoid((a, b, c), mass=)",
        "from_masses from_particles": "use Body.from_points(masses, positions)",
        "from_catalog from_name": "use attitude.catalog.load(name).body",
        "shape mesh facets": (
            "a Body has its inertia alone: give the shape to Scene(shape=), or make the body by "
            "Body.from_shape(mesh, density=)"
        ),
    },
    "Spin": {
        "quaternion q quat attitude orientation": "use wxyz, scalar first",
        "xyzw": "use np.roll(spin.wxyz, -1)",
        "omega rates rate w": _RATES,
        "time date t t0": "use epoch",
        "rotation matrix dcm": (
            "use FreeRotation(body, spin).at(spin.epoch).matrix (body to ICRF) or .dcm"
        ),
        "period periods P_psi P_phi pole from_period": (
            "periods follow from the body too: use FreeRotation(body, spin).period_psi"
        ),
        "from_quaternion from_quat": "use Spin(epoch=, wxyz=, angular_velocity=)",
        "from_dcm": "use Spin(epoch=, dcm=, angular_velocity=)",
        "from_rotvec from_axis_angle from_axis from_mrp": (
            "use Spin.from_rotation with scipy's Rotation.from_rotvec(axis * angle)"
        ),
        "from_rpm from_rate from_spin_rate about_axis": (
            'use Spin.from_periods(body, P="6 s", pole=...), or angular_velocity="0, 0, 10 rpm"'
        ),
        "from_catalog from_name from_file read": (
            "use attitude.catalog.load(name).spin, or attitude.formats.detect.read(file)"
        ),
    },
    "Scene": {
        "magnitude magnitudes light_curve lightcurve magnitude_at mag mags": (
            "use at(times).magnitude"
        ),
        "brightness flux": "use at(times).brightness",
        "phase_angle phase": "use at(times).phase_angle, rad",
        "observe evaluate propagate geometry": "use at(times)",
        "plot show render": "use view(output=file)",
        "animate": "use attitude.viewer.animate(scene, file)",
        "passes glints events": "use attitude.events.passes(scene, ...) or glints",
        "visible is_visible": "use at(times).elevation, .in_umbra or .lit_fraction",
    },
    "View": {
        "mag magnitudes mags V": "use magnitude or reduced_magnitude",
        "phase alpha phase_angles": "use phase_angle, rad",
        "distance range delta": "use observer_distance, m",
        "flux fluxes light_curve": "use brightness",
        "to_table write save to_csv": "use table(), an astropy QTable",
        "sun sun_vector": "use sun_direction, over the body axes",
        "observer observer_vector": "use observer_direction, over the body axes",
    },
    "LightCurve": {
        "mag mags magnitudes": "use magnitude",
        "error errors err uncertainty": "use sigma",
        "time t jd epochs": "use times",
        "periodogram period periods": "use attitude.photometry.periods(curve)",
        "fold folded": "use attitude.photometry.fold(curve, period)",
        "from_file load open": "use the class's read(file)",
        "invert solve": "use attitude.inversion.spin_states(curve, ...)",
    },
    "CurveFit": {
        "period periods": "use P_psi and P_phi, s, or published('L')",
        "spin body": "use motion.spin and motion.body",
        "mesh model": "use shape, a Mesh",
        "save to_file export": "use write(file.toml), and shape.write(file.obj)",
        "chi2 chisq residual": "use residuals, rms or chi_squared",
    },
    "SpinStates": {
        "best first solution": "use found[0]",
        "solutions candidates results": "iterate over it, or use table()",
        "motion": "use found[0].motion",
        "write save": "use found[0].write(file)",
        "period periods P_psi P_phi": "use found[0].P_psi and found[0].P_phi, s",
        "pole": "use found[0].pole",
        "predict": "use found[0].predict(times)",
    },
    "Ensemble": {
        "propagate evaluate": "use at(t)",
        "quaternion quaternions q": _WXYZ,
        "period periods P_psi P_phi": "use period_psi and period_phi, s",
        "size count n": "use len(ensemble)",
        "from_motions from_list": "use Ensemble.of(motions)",
        "random from_samples monte_carlo from_covariance": (
            "use Ensemble.sample(motion, ...), of errors, or Ensemble.from_periods"
        ),
    },
    "Entry": {
        "spin state": "use body and motion(), whose spin is motion().spin",
        "period periods pole": "use motion().published('L') and .published('S')",
        "source reference": "use sources, the publication of each number",
    },
    "Mesh": {
        "faces triangles": "use facets",
        "points verts": "use vertices, m",
        "save export to_obj": "use write(file)",
        "read load from_file": "use attitude.shape.read(file)",
        "scale resize": "use scaled(factor)",
        "move translate shift": "use moved(offset)",
        "rotate rotated turn apply_transform": "use turned(matrix)",
        "inertia moments moment_inertia centroid center_of_mass mass": (
            "use mass_properties(density=), with mass, center_of_mass and inertia, or "
            "Body.from_shape(mesh)"
        ),
        "plot show": "give it to a scene, Scene(motion, ..., shape=mesh).view(output=file)",
    },
}
# Hints by the name of a module, and by absent names.
_OF_MODULES = {
    "attitude": {
        "read open read_aem load_file from_file read_file": (
            "use attitude.formats.detect.read(file)"
        ),
        "load get toutatis": "use attitude.catalog.load(name)",
        "plot draw": "use attitude.plots.overview(motion), or motion.plot()",
        "view show": "use attitude.viewer.view(motion, output=file), or motion.view()",
        "animate": "use attitude.viewer.animate(motion, file)",
        "invert spin_states": "use attitude.inversion.spin_states(curve, ...)",
        "LightCurve": "use attitude.photometry.LightCurve or attitude.inversion.LightCurve",
        "periodogram LombScargle": "use attitude.photometry.periods(curve)",
        "spectrum": "use attitude.photometry: lines, fit_series, periods",
        "Ellipsoid": "use attitude.shape.Ellipsoid",
        "Mesh read_shape": "use attitude.shape.Mesh, or attitude.shape.read(file)",
        "Motion": "use attitude.motions.Motion",
        "TLE tle": "use attitude.paths.tle(file)",
        "Site Observer Location": "use attitude.paths.site(longitude, latitude)",
        "GravityGradient": "use attitude.torques.GravityGradient",
        "Torque": "use attitude.torques, such as torques.ConstantTorque",
        "RigidBody Asteroid Satellite": "use Body(moments=) with FreeRotation(body, spin)",
        "Rotation FreeMotion Tumbler Rotator": "use FreeRotation(body, spin)",
        "Trajectory rotation dcm euler integrate simulate solve Simulation": (
            "use FreeRotation(body, spin).at(t)"
        ),
        "Quaternion quaternions": "use plain arrays (..., 4), attitude.frames.quaternion",
        "lightcurve": "use attitude.light_curve, or Scene(motion, ..., shape=mesh).at(times)",
        "State Attitude SpinState": "use Spin(epoch=, wxyz=, angular_velocity=)",
        "Maneuver Manoeuvre Burn Thruster": "use Arcs with Impulse",
        "glints Glint find_glints": "use attitude.events.glints(scene, ...)",
        "passes Pass find_passes": "use attitude.events.passes(scene, ...)",
        "Orbit Kepler": "use attitude.paths.kepler(...), .tle(file) or .oem(file)",
        "read_photometry Photometry": "use attitude.photometry.read(file)",
        "version VERSION": "use attitude.__version__",
        "write save": "use motion.write(file), whose format follows from the ending",
        "Time Epoch Instant": 'use text such as "2026-01-01", or attitude.epochs',
    },
    "attitude.catalog": {
        "list all keys search bodies objects": "use catalog.names()",
        "get read body spin": "use catalog.load(name) or catalog.entry(name)",
        "toutatis apophis oumuamua envisat halley": "use catalog.entry(name)",
    },
    "attitude.formats": {
        "read load open": "use attitude.formats.detect.read(file)",
        "write save": "use motion.write(file), or attitude.formats.detect.write",
    },
    "attitude.paths": {
        "planet sun earth moon mars": 'use paths.body("mars barycenter")',
        "mpc mpcorb elements": "use paths.mpc_orbit(line) or paths.kepler(...)",
        "horizons asteroid": "use paths.mpc_orbit(line), or paths.spk(file) of Horizons",
        "satellite sgp4 from_tle TLE": "use paths.tle(file)",
        "from_spk SPK kernel": "use paths.spk(file, target)",
        "ground topos Site": "use paths.site(longitude, latitude) or paths.observatory(code)",
    },
    "attitude.plots": {
        "plot summary show": "use plots.overview(motion)",
        "animate": "use attitude.viewer.animate(motion, file)",
    },
    "attitude.inversion": {
        "periods Periods Pair": "use photometry.periods(curve, count=2, min_period=...)",
        "invert solve run fit": "use inversion.spin_states(curve, ...)",
        "read load": "use inversion.LightCurve.read(file)",
    },
    "attitude.photometry": {
        "lomb_scargle LombScargle": "use photometry.periods(curve)",
        "load from_file": "use photometry.read(file)",
        "Lightcurve": "use photometry.LightCurve",
    },
    "attitude.viewer": {
        "show plot render": "use viewer.view(motion, output=file)",
    },
    "attitude.shape": {
        "load read_obj from_file": "use shape.read(file)",
        "ellipsoid Sphere sphere": "use shape.Ellipsoid((a, b, c))",
        "cube Box Cuboid cuboid brick": "use shape.box((a, b, c))",
    },
    "attitude.events": {
        "find_glints flashes": "use events.glints(scene, ...)",
        "find_passes rise_set": "use events.passes(scene, ...)",
        "extrema find_extrema find_peaks": "use events.find_maxima or find_minima",
    },
    "attitude.light_curve": {
        "magnitude magnitudes light_curve lightcurve flux compute": (
            "use Scene(motion, ..., shape=mesh).at(times).magnitude, or light_curve.brightness"
        ),
    },
    "attitude.scattering": {
        "lambert Lambertian": "use scattering.Lambert()",
        "hapke": "use scattering.Hapke(...)",
        "lommel_seeliger LS lunar": "use scattering.LommelSeeliger()",
    },
    "attitude.torques": {
        "SolarPressure SRP YORP": "use torques.SolarRadiation(mesh, path)",
        "Drag Aerodynamic AirDrag": "use torques.AerodynamicTorque",
        "ThrusterTorque Thruster ControlTorque": (
            "use torques.ConstantTorque, or attitude.arcs.Impulse for a pulse"
        ),
        "Dissipation Friction": "use torques.InternalDissipation or torques.Rheology",
    },
}


def _by_name(table: dict[str, dict[str, str]]) -> dict[str, dict[str, str]]:
    """The table with an entry for each of the names that stand in one key."""
    return {
        owner: {name: hint for names, hint in hints.items() for name in names.split()}
        for owner, hints in table.items()
    }


ATTRIBUTES: dict[str, dict[str, str]] = _by_name(_OF_CLASSES)
MODULES: dict[str, dict[str, str]] = _by_name(_OF_MODULES)


def absent(owner: str, name: str) -> AttributeError:
    """The AttributeError for a name that a module does not have, with the hint of `MODULES`."""
    hint = MODULES.get(owner, {}).get(name)
    sentence = f"module {owner!r} has no attribute {name!r}"
    if hint is not None:
        sentence += f"; {hint}."
    return AttributeError(sentence, name=name)


def of_module(owner: str, where: Mapping[str, str] | None = None) -> Callable[[str], Any]:
    """A ``__getattr__`` of a module: it imports names, when they are first used, from the modules
    that `where` gives for them, and public modules in it, and answers each absent name.
    """

    def __getattr__(name: str) -> Any:
        if f"{owner}.{name}" in sys.modules["attitude"].PUBLIC_MODULES:
            return import_module(f"{owner}.{name}")
        if where is None or name not in where:
            raise absent(owner, name)
        value = getattr(import_module(where[name]), name)
        setattr(sys.modules[owner], name, value)
        return value

    return __getattr__


class _Absent:
    """A name that a class does not have: asking for it is an AttributeError with a hint.

    It stands in the class, because a ``__getattr__`` of the class would slow each lookup of an
    attribute that exists.
    """

    def __init__(self, name: str, hint: str) -> None:
        self.name = name
        self.hint = hint

    def __get__(self, obj: object, cls: type) -> Any:
        for base in cls.__mro__:  # another base of the class may have the name
            value = vars(base).get(self.name, self)
            if type(value) is not _Absent:
                return value.__get__(obj, cls) if hasattr(value, "__get__") else value
        sentence = f"{cls.__name__} has no attribute {self.name!r}; {self.hint}."
        raise AttributeError(sentence, name=self.name, obj=cls if obj is None else obj)


def is_absent(cls: type, name: str) -> bool:
    """Whether a hint stands in the class in place of the name."""
    return {type(vars(base)[name]) for base in cls.__mro__ if name in vars(base)} == {_Absent}


class _AnsweringClass(ABCMeta):
    """The class of such classes: `dir` does not list their absent names."""

    def __dir__(cls) -> list[str]:
        return [name for name in super().__dir__() if not is_absent(cls, name)]


class Answering(metaclass=_AnsweringClass):
    """Base of classes whose absent attributes are answered with a hint of `ATTRIBUTES`."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        for name, hint in ATTRIBUTES.get(cls.__name__, {}).items():
            if not hasattr(cls, name):  # a class of a user may have the same name
                setattr(cls, name, _Absent(name, hint))

    def __dir__(self) -> list[str]:
        names, stored = super().__dir__(), vars(self)
        return [name for name in names if name in stored or not is_absent(type(self), name)]


# ---- Calls with arguments that do not exist


def arguments(hints: Mapping[str, str], example: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator of a function or ``__init__``: a wrong call is an AttitudeError.

    It has the hint for an argument that does not exist, and an example of a call that is right.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def called(*positional: P.args, **named: P.kwargs) -> R:
            try:
                return function(*positional, **named)
            except TypeError:
                refusal = _refusal(function, positional, named, hints, example)
                if refusal is None:
                    raise
            raise AttitudeError(refusal)

        return called

    return decorated


def checks_arguments(hints: Mapping[str, str], example: str) -> Callable[[Class], Class]:
    """The decorator of `arguments` for a class whose ``__init__`` is made by dataclass."""

    def decorated(cls: Class) -> Class:
        constructor = vars(cls)["__init__"]
        constructor.__qualname__ = f"{cls.__name__}.__init__"
        setattr(cls, "__init__", arguments(hints, example)(constructor))  # noqa: B010
        return cls

    return decorated


def _refusal(
    function: Callable[..., Any],
    positional: tuple[Any, ...],
    named: Mapping[str, Any],
    hints: Mapping[str, str],
    example: str,
) -> str | None:
    """What is wrong with a call, as a sentence; None if its arguments fit the function."""
    import inspect  # 15 ms, of wrong calls only

    signature = inspect.signature(function)
    try:
        signature.bind(*positional, **named)
    except TypeError as err:
        reason = str(err)
    else:
        return None
    name = function.__qualname__.removesuffix(".__init__")
    known = [parameter for parameter in signature.parameters if parameter not in ("self", "cls")]
    wrong = next((argument for argument in named if argument not in known), None)
    if wrong is not None:
        return (
            f"{name} has no argument {wrong}; {hints.get(wrong, _takes(known))}, as in {example}."
        )
    return f"{name}: {reason}; {_takes(known)}, as in {example}."


def _takes(known: list[str]) -> str:
    return f"it takes {', '.join(known)}"


# ---- Methods that functions of higher folders implement


def named(address: str) -> Any:
    """The function of an address such as "attitude.plots:overview", imported when it is called.

    A motion answers verbs such as ``plot()`` by functions of folders that import motions.
    """
    module, _, name = address.partition(":")
    return getattr(import_module(module), name)
