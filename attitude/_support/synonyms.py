"""Names that other packages use, answered with the name that stands here.

`ATTRIBUTES` and `MODULES` hold a hint for each name that an object or a module does not have, and
`ARGUMENTS` for each argument that a call does not have.  A name is answered only after the usual
search has failed, so that the table costs nothing where a name exists.
"""

from __future__ import annotations

import sys
from abc import ABCMeta
from collections.abc import Callable, Mapping
from functools import wraps
from importlib import import_module
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from attitude.errors import AttitudeError

P = ParamSpec("P")
R = TypeVar("R")
Class = TypeVar("Class", bound=type)


def _each(hint: str, *names: str) -> dict[str, str]:
    """The same hint for several names."""
    return dict.fromkeys(names, hint)


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

# Hints by the name of a class, which hold for its subclasses too.
ATTRIBUTES: dict[str, dict[str, str]] = {
    "Motion": {
        **_each(_WXYZ, "quaternion", "quaternions", "quat", "q", "wxyz", "xyzw"),
        **_each(
            "use .at(t).as_rotation(), a scipy Rotation, .at(t).matrix (body to ICRF) or "
            ".at(t).dcm (ICRF to body)",
            *("rotation", "rotations", "as_rotation", "matrix", "rotation_matrix", "dcm"),
        ),
        **_each('use .at(t).euler("ZXZ"), rad', "euler", "euler_angles", "eulers"),
        **_each(
            "use .at(t).angular_velocity, rad/s over the body axes",
            *("omega", "angular_velocity", "rates", "rate", "w"),
        ),
        **_each(_AT, "propagate", "evaluate", "attitude", "attitude_at", "state", "states"),
        **_each(_AT, "history", "integrate", "solve", "interpolate", "orientation"),
        **_each(_AT, "get_attitude", "get_state", "state_at", "predict"),
        **_each(_FILE, "to_aem", "to_file", "to_toml", "to_csv", "to_ck", "to_apm", "to_acm"),
        **_each(_FILE, "save", "export", "dump", "to_stk", "to_spice", "to_bc", "to_dict"),
        **_each(
            "use attitude.Scene(motion, ..., shape=mesh).at(times).magnitude",
            *("lightcurve", "light_curve", "brightness", "magnitude"),
        ),
        **_each(
            'use attitude.viewer.animate(motion, "m.mp4"), or view(output="m.html")',
            *("animate", "animation", "movie"),
        ),
        **_each('use view(output="m.html"), or plot()', "show", "display", "render"),
        **_each("use .at(t).table(), an astropy QTable", "table", "to_table", "to_pandas"),
    },
    "FreeRotation": {
        **_each(_PERIODS, "period", "periods", "P_psi", "P_phi", "rotation_period", "P"),
        **_each(_PERIODS, "precession_period", "nutation_period", "spin_period"),
        **_each(_PERIODS, "frequency", "frequencies", "precession_rate"),
        **_each(
            "use at(t).angular_velocity; str(motion) has its least, greatest and mean length",
            *("spin_rate", "rpm", "angular_speed", "mean_rate"),
        ),
        **_each(
            "use momentum / |momentum|, the direction of the angular momentum in ICRF, or "
            "published('L').pole",
            *("pole", "spin_axis", "spin_pole", "rotation_axis", "axis", "momentum_direction"),
        ),
        **_each("use momentum, kg m2/s in ICRF", "angular_momentum", "L", "H", "h"),
        **_each("use energy, J", "kinetic_energy", "E", "T"),
        **_each(
            "use angles(t), phi, theta and psi about the momentum, rad: theta is the nutation",
            *("nutation", "nutation_angle", "theta", "wobble", "wobble_angle"),
        ),
        **_each(
            "use mode, a Mode such as SHORT_AXIS", *("is_tumbling", "tumbles", "is_lam", "is_sam")
        ),
        **_each("use mode, a Mode such as SHORT_AXIS", "lam", "sam"),
        **_each("print the motion: str(motion) describes it", "describe", "summary", "info"),
        **_each("use separatrix_distance or mode", "separatrix", "is_near_separatrix"),
        **_each(
            "use period_psi / 2, the time between flips, regime.flip_time and regime.dwell_time",
            *("flips", "flip_times", "flip_period"),
        ),
        **_each("use body.moments, kg m2", "moments", "inertia", "principal_moments"),
        **_each("use body.tensor, kg m2", "tensor", "inertia_tensor"),
        **_each("use at(t).covariance, or at(t).sigma in rad", "covariance", "sigma", "errors"),
        **_each("use at(t).sensitivity or sensitivity_at(t)", "jacobian", "stm", "derivatives"),
    },
    "AttitudeHistory": {
        **_each("use wxyz, scalar first, or xyzw, scalar last", "quaternion", "quaternions"),
        **_each("use wxyz, scalar first, or xyzw, scalar last", "quat", "q", "as_quat"),
        **_each(_ROTATION, "rotation", "rotations", "as_matrix", "rotation_matrix", "matrices"),
        **_each(_ROTATION, "R", "A", "C"),
        **_each('use euler("ZXZ"), rad', "euler_angles", "as_euler", "angles"),
        **_each(_RATES, "omega", "rates", "rate", "w", "angular_rate", "omegas"),
        **_each("use time, an astropy Time, or seconds since epoch", "times", "t", "epochs"),
        **_each(_TABLE, "write", "save", "to_csv", "to_ecsv", "to_file", "export"),
        **_each(
            "use table(), an astropy QTable, or to_pandas()",
            *("to_table", "to_frame", "to_dataframe", "dataframe", "df"),
        ),
        **_each('use euler("zyx"), rad', "rpy", "ypr", "roll_pitch_yaw", "roll", "pitch", "yaw"),
        **_each(
            "use the motion's .at(t): every epoch costs the same, and AttitudeTable.from_history "
            "interpolates",
            *("interpolate", "resample", "interp"),
        ),
        **_each("use motion.plot(), or attitude.plots", "plot", "show"),
        **_each("use body_to_inertial(v)", "apply", "rotate", "to_inertial"),
        **_each("use inertial_to_body(v)", "to_body", "apply_inverse"),
        **_each("use sigma (rad), sigma_deg or covariance", "errors", "error", "std"),
    },
    "Body": {
        **_each("use tensor (body axes) or moments, kg m2", "inertia", "inertia_tensor", "I"),
        **_each("use moments, kg m2", "principal_moments", "Ixx", "Iyy", "Izz", "A", "B", "C"),
        **_each("use principal_axes, the columns are unit vectors", "axes", "principal_frame"),
        **_each("use center_of_mass, m", "com", "centre_of_mass", "center"),
        **_each("use Body(moments=(3 numbers))", "from_moments", "from_principal_moments"),
        **_each("use Body(tensor=(3 x 3))", "from_tensor", "from_inertia", "from_matrix"),
        **_each(
            "use Body.from_shape(mesh, density=), where mesh is attitude.shape.read(file) or "
            "attitude.shape.box((a, b, c))",
            *("from_mesh", "from_obj", "from_file", "from_box", "from_cuboid", "box", "cuboid"),
        ),
        **_each("use Body.from_ellipsoid((a, b, c), mass=)", "sphere", "ellipsoid", "from_sphere"),
        **_each("use Body.from_points(masses, positions)", "from_masses", "from_particles"),
        **_each("use attitude.catalog.load(name).body", "from_catalog", "from_name"),
        **_each(
            "a Body has its inertia alone: give the shape to Scene(shape=), or make the body by "
            "Body.from_shape(mesh, density=)",
            *("shape", "mesh", "facets"),
        ),
    },
    "Spin": {
        **_each("use wxyz, scalar first", "quaternion", "q", "quat", "attitude", "orientation"),
        "xyzw": "use np.roll(spin.wxyz, -1)",
        **_each(_RATES, "omega", "rates", "rate", "w"),
        **_each("use epoch", "time", "date", "t", "t0"),
        **_each(
            "use FreeRotation(body, spin).at(spin.epoch).matrix (body to ICRF) or .dcm",
            *("rotation", "matrix", "dcm"),
        ),
        **_each(
            "periods follow from the body too: use FreeRotation(body, spin).period_psi",
            *("period", "periods", "P_psi", "P_phi", "pole", "from_period"),
        ),
        **_each("use Spin(epoch=, wxyz=, angular_velocity=)", "from_quaternion", "from_quat"),
        **_each("use Spin(epoch=, dcm=, angular_velocity=)", "from_dcm"),
        **_each(
            "use Spin.from_rotation with scipy's Rotation.from_rotvec(axis * angle)",
            *("from_rotvec", "from_axis_angle", "from_axis", "from_mrp"),
        ),
        **_each(
            'use Spin.from_periods(body, P="6 s", pole=...), or angular_velocity="0, 0, 10 rpm"',
            *("from_rpm", "from_rate", "from_spin_rate", "about_axis"),
        ),
        **_each(
            "use attitude.catalog.load(name).spin, or attitude.formats.detect.read(file)",
            *("from_catalog", "from_name", "from_file", "read"),
        ),
    },
    "Scene": {
        **_each("use at(times).magnitude", "magnitude", "magnitudes", "light_curve", "lightcurve"),
        **_each("use at(times).magnitude", "magnitude_at", "mag", "mags"),
        **_each("use at(times).brightness", "brightness", "flux"),
        **_each("use at(times).phase_angle, rad", "phase_angle", "phase"),
        **_each("use at(times)", "observe", "evaluate", "propagate", "geometry"),
        **_each("use view(output=file)", "plot", "show", "render"),
        **_each("use attitude.viewer.animate(scene, file)", "animate"),
        **_each("use attitude.events.passes(scene, ...) or glints", "passes", "glints", "events"),
        **_each("use at(times).elevation, .in_umbra or .lit_fraction", "visible", "is_visible"),
    },
    "View": {
        **_each("use magnitude or reduced_magnitude", "mag", "magnitudes", "mags", "V"),
        **_each("use phase_angle, rad", "phase", "alpha", "phase_angles"),
        **_each("use observer_distance, m", "distance", "range", "delta"),
        **_each("use brightness", "flux", "fluxes", "light_curve"),
        **_each("use table(), an astropy QTable", "to_table", "write", "save", "to_csv"),
        **_each("use sun_direction, over the body axes", "sun", "sun_vector"),
        **_each("use observer_direction, over the body axes", "observer", "observer_vector"),
    },
    "LightCurve": {
        **_each("use magnitude", "mag", "mags", "magnitudes"),
        **_each("use sigma", "error", "errors", "err", "uncertainty"),
        **_each("use times", "time", "t", "jd", "epochs"),
        **_each("use attitude.photometry.periods(curve)", "periodogram", "period", "periods"),
        **_each("use attitude.photometry.fold(curve, period)", "fold", "folded"),
        **_each("use the class's read(file)", "from_file", "load", "open"),
        **_each("use attitude.inversion.spin_states(curve, ...)", "invert", "solve"),
    },
    "CurveFit": {
        **_each("use P_psi and P_phi, s, or published('L')", "period", "periods"),
        **_each("use motion.spin and motion.body", "spin", "body"),
        **_each("use shape, a Mesh", "mesh", "model"),
        **_each("use write(file.toml), and shape.write(file.obj)", "save", "to_file", "export"),
        **_each("use residuals, rms or chi_squared", "chi2", "chisq", "residual"),
    },
    "SpinStates": {
        **_each("use found[0]", "best", "first", "solution"),
        **_each("iterate over it, or use table()", "solutions", "candidates", "results"),
        **_each("use found[0].motion", "motion"),
        **_each("use found[0].write(file)", "write", "save"),
        **_each("use found[0].P_psi and found[0].P_phi, s", "period", "periods", "P_psi", "P_phi"),
        **_each("use found[0].pole", "pole"),
        **_each("use found[0].predict(times)", "predict"),
    },
    "Ensemble": {
        **_each("use at(t)", "propagate", "evaluate"),
        **_each(_WXYZ, "quaternion", "quaternions", "q"),
        **_each("use period_psi and period_phi, s", "period", "periods", "P_psi", "P_phi"),
        **_each("use len(ensemble)", "size", "count", "n"),
        **_each("use Ensemble.of(motions)", "from_motions", "from_list"),
        **_each(
            "use Ensemble.sample(motion, ...), of errors, or Ensemble.from_periods",
            *("random", "from_samples", "monte_carlo", "from_covariance"),
        ),
    },
    "Entry": {
        **_each("use body and motion(), whose spin is motion().spin", "spin", "state"),
        **_each("use motion().published('L') and .published('S')", "period", "periods", "pole"),
        **_each("use sources, the publication of each number", "source", "reference"),
    },
    "Mesh": {
        **_each("use facets", "faces", "triangles"),
        **_each("use vertices, m", "points", "verts"),
        **_each("use write(file)", "save", "export", "to_obj"),
        **_each("use attitude.shape.read(file)", "read", "load", "from_file"),
        **_each("use scaled(factor)", "scale", "resize"),
        **_each("use moved(offset)", "move", "translate", "shift"),
        **_each("use turned(matrix)", "rotate", "rotated", "turn", "apply_transform"),
        **_each(
            "use mass_properties(density=), with mass, center_of_mass and inertia, or "
            "Body.from_shape(mesh)",
            *("inertia", "moments", "moment_inertia", "centroid", "center_of_mass", "mass"),
        ),
        **_each(
            "give it to a scene, Scene(motion, ..., shape=mesh).view(output=file)", "plot", "show"
        ),
    },
}

# Hints by the name of a module.
MODULES: dict[str, dict[str, str]] = {
    "attitude": {
        **_each("use attitude.formats.detect.read(file)", "read", "open", "read_aem", "load_file"),
        **_each("use attitude.formats.detect.read(file)", "from_file", "read_file"),
        **_each("use attitude.catalog.load(name)", "load", "get", "toutatis"),
        **_each("use attitude.plots.overview(motion), or motion.plot()", "plot", "draw"),
        **_each("use attitude.viewer.view(motion, output=file), or motion.view()", "view", "show"),
        **_each("use attitude.viewer.animate(motion, file)", "animate"),
        **_each("use attitude.inversion.spin_states(curve, ...)", "invert", "spin_states"),
        **_each(
            "use attitude.photometry.LightCurve or attitude.inversion.LightCurve", "LightCurve"
        ),
        **_each("use attitude.photometry.periods(curve)", "periodogram", "LombScargle"),
        **_each("use attitude.photometry: lines, fit_series, periods", "spectrum"),
        **_each("use attitude.shape.Ellipsoid", "Ellipsoid"),
        **_each("use attitude.shape.Mesh, or attitude.shape.read(file)", "Mesh", "read_shape"),
        **_each("use attitude.motions.Motion", "Motion"),
        **_each("use attitude.paths.tle(file)", "TLE", "tle"),
        **_each("use attitude.paths.site(longitude, latitude)", "Site", "Observer", "Location"),
        **_each("use attitude.torques.GravityGradient", "GravityGradient"),
        **_each("use attitude.torques, such as torques.ConstantTorque", "Torque"),
        **_each(
            "use Body(moments=) with FreeRotation(body, spin)", "RigidBody", "Asteroid", "Satellite"
        ),
        **_each("use FreeRotation(body, spin)", "Rotation", "FreeMotion", "Tumbler", "Rotator"),
        **_each("use FreeRotation(body, spin).at(t)", "Trajectory", "rotation", "dcm", "euler"),
        **_each("use plain arrays (..., 4), attitude.frames.quaternion", "Quaternion"),
        **_each(
            "use FreeRotation(body, spin).at(t)", "integrate", "simulate", "solve", "Simulation"
        ),
        **_each("use Spin(epoch=, wxyz=, angular_velocity=)", "State", "Attitude", "SpinState"),
        **_each("use Arcs with Impulse", "Maneuver", "Manoeuvre", "Burn", "Thruster"),
        **_each("use attitude.events.glints(scene, ...)", "glints", "Glint", "find_glints"),
        **_each("use attitude.events.passes(scene, ...)", "passes", "Pass", "find_passes"),
        **_each("use attitude.paths.kepler(...), .tle(file) or .oem(file)", "Orbit", "Kepler"),
        **_each("use attitude.photometry.read(file)", "read_photometry", "Photometry"),
        **_each("use attitude.__version__", "version", "VERSION"),
        **_each("use motion.write(file), whose format follows from the ending", "write", "save"),
        **_each('use text such as "2026-01-01", or attitude.epochs', "Time", "Epoch", "Instant"),
    },
    "attitude.catalog": {
        **_each("use catalog.names()", "list", "all", "keys", "search", "bodies", "objects"),
        **_each("use catalog.load(name) or catalog.entry(name)", "get", "read", "body", "spin"),
        **_each("use catalog.entry(name)", "toutatis", "apophis", "oumuamua", "envisat", "halley"),
    },
    "attitude.formats": {
        **_each("use attitude.formats.detect.read(file)", "read", "load", "open"),
        **_each("use motion.write(file), or attitude.formats.detect.write", "write", "save"),
    },
    "attitude.paths": {
        **_each('use paths.body("mars")', "planet", "sun", "earth", "moon", "mars"),
        **_each("use paths.mpc_orbit(line) or paths.kepler(...)", "mpc", "mpcorb", "elements"),
        **_each(
            "use paths.mpc_orbit(line), or paths.spk(file) of Horizons", "horizons", "asteroid"
        ),
        **_each("use paths.tle(file)", "satellite", "sgp4", "from_tle", "TLE"),
        **_each("use paths.spk(file, target)", "from_spk", "SPK", "kernel"),
        **_each(
            "use paths.site(longitude, latitude) or paths.observatory(code)",
            "ground",
            "topos",
            "Site",
        ),
    },
    "attitude.plots": {
        **_each("use plots.overview(motion)", "plot", "summary", "show"),
        **_each("use attitude.viewer.animate(motion, file)", "animate"),
    },
    "attitude.inversion": {
        **_each(
            "use photometry.periods(curve, count=2, min_period=...)", "periods", "Periods", "Pair"
        ),
        **_each("use inversion.spin_states(curve, ...)", "invert", "solve", "run", "fit"),
        **_each("use inversion.LightCurve.read(file)", "read", "load"),
    },
    "attitude.photometry": {
        **_each("use photometry.periods(curve)", "lomb_scargle", "LombScargle"),
        **_each("use photometry.read(file)", "load", "from_file"),
    },
    "attitude.viewer": {
        **_each("use viewer.view(motion, output=file)", "show", "plot", "render"),
    },
    "attitude.shape": {
        **_each("use shape.read(file)", "load", "read_obj", "from_file"),
        **_each("use shape.Ellipsoid((a, b, c))", "ellipsoid", "Sphere", "sphere"),
        **_each("use shape.box((a, b, c))", "cube", "Box", "Cuboid", "cuboid", "brick"),
    },
    "attitude.events": {
        **_each("use events.glints(scene, ...)", "find_glints", "flashes"),
        **_each("use events.passes(scene, ...)", "find_passes", "rise_set"),
        **_each("use events.find_maxima or find_minima", "extrema", "find_extrema", "find_peaks"),
    },
    "attitude.light_curve": {
        **_each(
            "use Scene(motion, ..., shape=mesh).at(times).magnitude, or light_curve.brightness",
            *("magnitude", "magnitudes", "light_curve", "lightcurve", "flux", "compute"),
        ),
    },
    "attitude.scattering": {
        **_each("use scattering.Lambert()", "lambert", "Lambertian"),
        **_each("use scattering.Hapke(...)", "hapke"),
        **_each("use scattering.LommelSeeliger()", "lommel_seeliger", "LS", "lunar"),
    },
    "attitude.torques": {
        **_each("use torques.SolarRadiation(mesh, path)", "SolarPressure", "SRP", "YORP"),
        **_each("use torques.AerodynamicTorque", "Drag", "Aerodynamic", "AirDrag"),
        **_each(
            "use torques.ConstantTorque, or attitude.arcs.Impulse for a pulse",
            *("ThrusterTorque", "Thruster", "ControlTorque"),
        ),
        **_each("use torques.InternalDissipation or torques.Rheology", "Dissipation", "Friction"),
    },
}


def absent(owner: str, name: str, *, obj: Any = None) -> AttributeError:
    """The AttributeError for a name that a module does not have, with the hint of `MODULES`."""
    hint = MODULES.get(owner, {}).get(name)
    sentence = f"module {owner!r} has no attribute {name!r}"
    if hint is not None:
        sentence += f"; {hint}."
    return AttributeError(sentence, name=name, obj=obj)


def of_module(owner: str, where: Mapping[str, str] | None = None) -> Callable[[str], Any]:
    """A ``__getattr__`` of a module: it imports names, when they are first used, from the modules
    that `where` gives for them, and answers each absent name.
    """

    def __getattr__(name: str) -> Any:
        if where is None or name not in where:
            raise absent(owner, name)
        value = getattr(import_module(where[name]), name)
        setattr(sys.modules[owner], name, value)
        return value

    return __getattr__


class _AnsweringClass(ABCMeta):
    """The class of such classes: constructors that do not exist (`Spin.from_quaternion`)."""

    if not TYPE_CHECKING:

        def __getattr__(cls, name: str) -> Any:
            raise _absent_attribute(cls, name, cls)


class Answering(metaclass=_AnsweringClass):
    """Base of classes whose absent attributes are answered with a hint of `ATTRIBUTES`."""

    if not TYPE_CHECKING:
        # Hidden from type checkers: a class with __getattr__ has every name, misspelt ones too.
        def __getattr__(self, name: str) -> Any:
            cls = type(self)
            if not name.startswith("_") and hasattr(cls, name):  # a property raised: its own error
                return object.__getattribute__(self, name)
            raise _absent_attribute(cls, name, self)


def _absent_attribute(cls: type, name: str, obj: Any) -> AttributeError:
    """The AttributeError for a name that a class does not have, with the hint of `ATTRIBUTES`."""
    hints = (ATTRIBUTES.get(base.__name__, {}).get(name) for base in cls.__mro__)
    hint = next((text for text in hints if text is not None), None)
    if hint is None and obj is cls:
        sentence = f"type object {cls.__name__!r} has no attribute {name!r}"
    elif hint is None:
        sentence = f"{cls.__name__!r} object has no attribute {name!r}"
    else:
        sentence = f"{cls.__name__} has no attribute {name!r}; {hint}."
    return AttributeError(sentence, name=name, obj=obj)


# ---- Calls with arguments that do not exist


def arguments(hints: Mapping[str, str], example: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator of a function or ``__init__``: a wrong call is an AttitudeError.

    hints: what to do in place of an argument that does not exist.
    example: a call that is right.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def called(*given: P.args, **named: P.kwargs) -> R:
            try:
                return function(*given, **named)
            except TypeError:
                refusal = _refusal(function, given, named, hints, example)
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
    given: tuple[Any, ...],
    named: Mapping[str, Any],
    hints: Mapping[str, str],
    example: str,
) -> str | None:
    """What is wrong with a call, as a sentence; None if its arguments fit the function."""
    import inspect  # 15 ms, of wrong calls only

    signature = inspect.signature(function)
    try:
        signature.bind(*given, **named)
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
