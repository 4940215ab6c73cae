"""What a mission file says of a body's looks: [shape], [scattering] and [magnitude].

==============  ====================================================================================
[shape]         One of ``ellipsoid`` (three semi-axes; or "moments", the homogeneous ellipsoid of
                the body's moments, with ``diameter``), ``box`` (three edges), ``cylinder`` and
                ``box_wing`` (tables of what `attitude.shape` takes), ``file`` (OBJ, DAMIT .txt,
                STL, PLY; with ``unit``, ``format``).  ``facets``: how many an ellipsoid gets
                where the law has no closed form (1000).  ``divided``: how often facets are cut in
                four, for finer shadows.  ``shadows = false`` leaves out those that a body casts on
                itself.
[scattering]    ``law``: a name of `scattering.laws` ("lommel-seeliger" unless given), with the
                fields of that law as keys; or ``materials``, a table for each group of facets with
                the fields of `scattering.Material`.
[magnitude]     ``kind``: "apparent" or "reduced" (apparent where both distances are known).
                ``sun_magnitude`` of the band (-26.76, Johnson V).  ``h`` with ``g``, or with ``g1``
                and ``g2``: the mean over all orientations follows that phase function, and shape
                and law tell the variation alone.  ``sun_distance``, ``observer_distance``: where
                they are directions.
==============  ====================================================================================

Numbers are SI and radians, or text with a unit.
"""

from dataclasses import dataclass

import numpy as np

from attitude import scattering, shape, validation
from attitude.errors import AttitudeError
from attitude.light_curve import magnitudes
from attitude.textfiles import quantities
from attitude.textfiles.toml import refuse_unknown, way_of

# What leads each way to give a shape, and what may go with it.
_SHAPES = {
    "ellipsoid": ("diameter", "facets"),
    "box": (),
    "cylinder": (),
    "box_wing": (),
    "file": ("unit", "format"),
}
_ANY_SHAPE = ("divided", "shadows")
# Units of the numbers that tables of parts hold; None for words and whole numbers.
_CYLINDER = {"radius": "m", "height": "m", "sides": None, "axis": None}
_BOX_WING = {
    "body": "m",
    "wing": "m",
    "gap": "m",
    "thickness": "m",
    "wing_axis": None,
    "wing_angle": "rad",
    "wings": None,
}
_FACETS = 1000


@dataclass(frozen=True)
class Magnitude:
    """Which magnitudes a light curve is in.

    Attributes
    ----------
    kind : str
        "apparent" or "reduced".
    sun_distance, observer_distance : float or None
        m; where the scene has directions.
    """

    kind: str
    sun_distance: float = None
    observer_distance: float = None

    def of(self, view):
        """The magnitudes of a View, (S,); inf where nothing of the body is both lit and seen."""
        if self.kind == "reduced":
            return view.reduced_magnitude
        if self.sun_distance is None and self.observer_distance is None:
            return view.magnitude
        far = [
            getattr(view, name) if getattr(self, name) is None else getattr(self, name)
            for name in ("sun_distance", "observer_distance")
        ]
        found = view.reduced_magnitude + magnitudes.distance_modulus(*far)
        return found + magnitudes.dimming(view.lit_fraction) if view.scene.shadow_of else found


def shape_of(given, body, opened):
    """The shape of a section [shape], and what else of it a Scene takes: a dict.

    Parameters
    ----------
    given : dict
    body : Body or None
    opened : callable
        Of a file name and what it is called, the path.
    """
    if not isinstance(given, dict):
        raise AttitudeError(f"shape is {given!r}; give a section that begins [shape].")
    known = {*_SHAPES, *_ANY_SHAPE, *(key for each in _SHAPES.values() for key in each)}
    refuse_unknown(given, sorted(known), "[shape]")
    way = way_of(given, _SHAPES, "[shape]")
    for key in given:
        if key not in (way, *_ANY_SHAPE, *_SHAPES[way]):
            raise AttitudeError(f"[shape] {key} does not go with {way}; leave it out.")
    found = {}
    if "shadows" in given:
        found["shadows"] = validation.one_of(given["shadows"], "[shape] shadows", (True, False))
    if way == "file":
        path = opened(given["file"], "[shape] file")
        rest = {key: given[key] for key in ("unit", "format") if key in given}
        found["shape"] = shape.read(path, **rest)
    elif way == "ellipsoid":
        found["shape"] = _ellipsoid(given, body)
    elif way == "box":
        found["shape"] = shape.box(_number(given["box"], "[shape] box", "m"))
    else:
        table = _table(given[way], f"[shape] {way}", _CYLINDER if way == "cylinder" else _BOX_WING)
        needed = ("radius", "height") if way == "cylinder" else ("body", "wing")
        for key in needed:
            if key not in table:
                raise AttitudeError(f"[shape] {way} has no {key}; give it, in m.")
        found["shape"] = getattr(shape, way)(**table)
    if "divided" in given:
        if way == "ellipsoid":
            raise AttitudeError("[shape] divided does not go with ellipsoid; give facets.")
        found["shape"] = found["shape"].divided(given["divided"])
    return found


def facets_for(given, found, law):
    """The shape itself, or the facets of an ellipsoid that a law has no closed form for."""
    if isinstance(found, shape.Ellipsoid) and not law.has_ellipsoid_form:
        return found.facets(given.get("facets", _FACETS))
    if "facets" in given and isinstance(found, shape.Ellipsoid):
        return found.facets(given["facets"])
    return found


def law_of(given, found):
    """The law of a section [scattering], for a shape."""
    if not isinstance(given, dict):
        raise AttitudeError(f"scattering is {given!r}; give a section that begins [scattering].")
    if "materials" in given:
        refuse_unknown(given, ("materials",), "[scattering] with materials")
        return _materials(given["materials"], found)
    name, known = given.get("law", "lommel-seeliger"), scattering.laws()
    if not isinstance(name, str) or name not in known:
        raise AttitudeError(
            f"[scattering] law is {name!r}; give one of {', '.join(map(repr, known))}, or a table "
            "of materials."
        )
    rest = {key: value for key, value in given.items() if key != "law"}
    return _law(known[name], rest, "[scattering]")


def scale_of(given):
    """Of a section [magnitude], what a Scene takes: sun_magnitude, phase_function; a dict."""
    if not isinstance(given, dict):
        raise AttitudeError(f"magnitude is {given!r}; give a section that begins [magnitude].")
    known = ("kind", "sun_magnitude", "h", "g", "g1", "g2", "sun_distance", "observer_distance")
    refuse_unknown(given, known, "[magnitude]")
    found = {"phase_function": _phase_function(given)}
    if "sun_magnitude" in given:
        band = given["sun_magnitude"]
        found["sun_magnitude"] = validation.number(band, "[magnitude] sun_magnitude", unit="mag")
    if found["phase_function"] is not None and "sun_magnitude" in given:
        raise AttitudeError(
            "[magnitude] has both h and sun_magnitude, but h tells the brightness by itself; leave "
            "one out."
        )
    return found


def magnitude_of(given, scene):
    """The `Magnitude` of a section [magnitude], of what is seen in a Scene."""
    distances = {}
    for key, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer)):
        if key in given:
            if not place.is_direction:
                raise AttitudeError(
                    f"[magnitude] {key} is given, but the {key.partition('_')[0]} is "
                    f"{place.name}, whose distance is known; leave it out."
                )
            value = _number(given[key], f"[magnitude] {key}", "m")
            distances[key] = validation.positive(value, f"[magnitude] {key}", unit="m")
    far = [
        key
        for key, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer))
        if place.is_direction and key not in distances
    ]
    kind = given.get("kind", "reduced" if far else "apparent")
    validation.one_of(kind, "[magnitude] kind", ("apparent", "reduced"))
    if kind == "apparent" and far:
        raise AttitudeError(
            f"an apparent magnitude needs {' and '.join(far)} where there is a direction; give it "
            'in [magnitude], or kind = "reduced".'
        )
    return Magnitude(kind, **distances)


def _ellipsoid(given, body):
    axes = given["ellipsoid"]
    if axes != "moments":
        if "diameter" in given:
            raise AttitudeError('[shape] diameter goes with ellipsoid = "moments"; leave it out.')
        return shape.Ellipsoid(_number(axes, "[shape] ellipsoid", "m"))
    if body is None:
        raise AttitudeError('[shape] ellipsoid is "moments", but there is no spin with a body.')
    if np.any(body.tensor != np.diag(np.diag(body.tensor))):
        raise AttitudeError(
            '[shape] ellipsoid is "moments", but the principal axes of the body are not its axes; '
            "give three semi-axes."
        )
    diameter = _number(given.get("diameter", 1.0), "[shape] diameter", "m")
    return shape.Ellipsoid.of_moments(np.diag(body.tensor), diameter=diameter)


def _law(made, given, where):
    """A law of a class by the keys of a table, which are the fields of the class."""
    parameters = made.parameters()
    refuse_unknown(given, list(parameters), f"{where} ({made.name})")
    rest = {}
    for key, value in given.items():
        each = parameters[key]
        rest[key] = value if each.words else _number(value, f"{where} {key}", each.unit)
    for key in made.required():
        if key not in rest:
            raise AttitudeError(f"{where} has no {key}; give {parameters[key]}.")
    try:
        return made(**rest)
    except AttitudeError as err:
        raise AttitudeError(f"{where} {err}") from err


def _materials(given, found):
    if not isinstance(given, dict) or not all(isinstance(each, dict) for each in given.values()):
        raise AttitudeError(
            "[scattering] materials is no table of tables; give a section for each group of "
            "facets, as in [scattering.materials.body]."
        )
    if isinstance(found, shape.Ellipsoid):
        raise AttitudeError(
            "[scattering] materials are those of groups of facets, and an ellipsoid has none; give "
            "a law."
        )
    carried = sorted(set(found.materials))
    for name in given:
        if name not in carried:
            raise AttitudeError(
                f"[scattering] materials has {name!r}, which no facet carries; the shape's facets "
                f"are of {', '.join(map(repr, carried))}."
            )
    for name in carried:
        if name not in given:
            raise AttitudeError(
                f"[scattering] materials has no {name!r}, of which the shape has facets; give it."
            )
    return scattering.Materials(
        {
            key: _law(scattering.Material, value, f"[scattering] {key}")
            for key, value in given.items()
        }
    )


def _phase_function(given):
    names = [key for key in ("g", "g1", "g2") if key in given]
    if "h" not in given:
        if names:
            raise AttitudeError(
                f"[magnitude] has {names[0]} but no h; give the absolute magnitude."
            )
        return None
    numbers = {
        key: validation.number(
            _number(given[key], f"[magnitude] {key}", None), f"[magnitude] {key}"
        )
        for key in ("h", *names)
    }
    if names in ([], ["g"]):
        made = scattering.hg
    elif names == ["g1", "g2"]:
        made = scattering.hg1g2
    else:
        raise AttitudeError(
            f"[magnitude] has h with {' and '.join(names)}; give h and g, or h, g1 and g2."
        )

    def function(alpha):
        return made(alpha, **numbers)

    function(np.zeros(1))  # parameters out of range are told now
    return function


def _table(given, where, units):
    if not isinstance(given, dict):
        keys = ", ".join(units)
        raise AttitudeError(f"{where} is {given!r}; give a table of {keys}, in braces.")
    refuse_unknown(given, tuple(units), where)
    return {
        key: value if units[key] is None else _number(value, f"{where} {key}", units[key])
        for key, value in given.items()
    }


def _number(value, name, unit):
    """A number or list of a file, or text with a unit, as floats in the unit."""
    if isinstance(value, str):
        return quantities.in_unit(value, name, unit)[()]
    return validation.real(value, name, unit=unit)[()]
