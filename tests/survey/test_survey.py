"""Light curves for simulations of surveys: against FreeRotation, and in a real run of sorcha."""

import math
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from attitude import AttitudeError, Body, Ensemble, FreeRotation, Spin, epochs, paths
from attitude.light_curve import brightness, mean_brightness
from attitude.motions._published import longest_P_phi
from attitude.shape import Ellipsoid
from attitude.survey._rotators import UNSEEN, Rotators, drawn, emission
from tests.support.places import ROOT

HOUR = 3600.0
needs_sorcha = pytest.mark.skipif(
    find_spec("sorcha") is None, reason="sorcha is not installed (the extra sorcha)"
)


def columns(count, seed=1):
    """Columns of rotators, every second of which is relaxed."""
    random = np.random.default_rng(seed)
    axes = np.stack(
        [np.ones(count), random.uniform(0.7, 0.9, count), random.uniform(0.4, 0.6, count)], axis=1
    )
    squares = axes**2
    moments = np.sort(squares.sum(axis=1, keepdims=True) - squares, axis=1)
    relaxed = np.arange(count) % 2 == 0
    P_psi = random.uniform(20.0, 40.0, count)
    mode = np.where(np.arange(count) % 4 == 1, "LAM", "SAM")
    longest = [
        longest_P_phi(row, each, "L" if each == "LAM" else "S", period)
        for row, each, period in zip(moments, mode, P_psi, strict=True)
    ]
    return {
        "axis_a": axes[:, 0], "axis_b": axes[:, 1], "axis_c": axes[:, 2],
        "pole_lon_deg": random.uniform(0.0, 360.0, count),
        "pole_lat_deg": random.uniform(-90.0, 90.0, count),
        "phi0_deg": random.uniform(0.0, 360.0, count),
        "psi0_deg": random.uniform(0.0, 360.0, count),
        "spin_epochMJD_TDB": random.uniform(60000.0, 60400.0, count),
        "period_h": np.where(relaxed, random.uniform(2.0, 20.0, count), math.nan),
        "P_psi_h": np.where(relaxed, math.nan, P_psi),
        "P_phi_h": np.where(relaxed, math.nan, np.array(longest) * 0.9),
        "mode": np.where(relaxed, "", mode).astype(object),
        "convention": np.where(mode == "LAM", "L", "S").astype(object),
    }  # fmt: skip


def shift_of(table, k, mjd, sun, observer, law="lommel-seeliger"):
    """The shift of one row by Spin.from_periods, FreeRotation and light_curve."""
    axes = [table[f"axis_{each}"][k] for each in "abc"]
    body = Body.from_ellipsoid(axes)
    pole = np.radians([table["pole_lon_deg"][k], table["pole_lat_deg"][k]])
    given = {"pole": pole, "phi0": math.radians(table["phi0_deg"][k])}
    if math.isnan(table["period_h"][k]):
        given |= {
            "mode": table["mode"][k], "convention": table["convention"][k],
            "P_psi": table["P_psi_h"][k] * HOUR, "P_phi": table["P_phi_h"][k] * HOUR,
            "psi0": math.radians(table["psi0_deg"][k]),
        }  # fmt: skip
    else:
        given["P"] = table["period_h"][k] * HOUR
    motion = FreeRotation(body, Spin.from_periods(body, epoch=epochs.Instant(0.0), **given))
    matrix = motion.at((mjd - table["spin_epochMJD_TDB"][k]) * 86400.0).matrix
    s, o = (matrix.T @ (each / np.linalg.norm(each)) for each in (sun, observer))
    phase = math.atan2(np.linalg.norm(np.cross(s, o)), s @ o)
    shape = Ellipsoid(axes)
    seen = brightness(shape, law, s, o)
    return -2.5 * math.log10(seen / mean_brightness(shape, law, phase))


def rows(count, of):
    random = np.random.default_rng(9)
    member = np.sort(random.integers(0, of, count))
    sun = random.normal(size=(count, 3))
    observer = sun + 0.3 * random.normal(size=(count, 3))
    return member, random.uniform(60500.0, 63000.0, count), sun, observer


@pytest.mark.parametrize("law", ["lommel-seeliger"])
def test_shifts_are_those_of_single_rotations(law):
    table = columns(20)
    found = Rotators(table, law=law)
    given = rows(60, 20)
    shifts = found.shifts(*given)
    for n, (k, *row) in enumerate(zip(*given, strict=True)):
        assert shifts[n] == pytest.approx(shift_of(table, k, *row, law), abs=1e-9)
    assert np.all(shifts >= found.brightest()[given[0]])


def test_the_mean_over_all_orientations_is_zero():
    """The mean brightness, over the directions of 4000 random frames at one phase angle."""
    table = {name: np.array(each)[[0]] for name, each in columns(2).items()}
    random = np.random.default_rng(4)
    frames = np.linalg.qr(random.normal(size=(4000, 3, 3)))[0]
    sun, observer = frames[:, 0], frames[:, 0] * math.cos(0.4) + frames[:, 1] * math.sin(0.4)
    shifts = Rotators(table).shifts(np.zeros(4000, int), np.full(4000, 60500.0), sun, observer)
    ratios = 10.0 ** (-0.4 * shifts)
    assert ratios.mean() == pytest.approx(1.0, abs=4.0 * ratios.std() / math.sqrt(4000))


def test_meshes_in_place_of_ellipsoids():
    table = columns(6)
    same = {**table, "axis_a": np.ones(6), "axis_b": np.full(6, 0.8), "axis_c": np.full(6, 0.5)}
    same["P_phi_h"] = table["P_phi_h"] * 0.5  # possible for these axes too
    mesh = Ellipsoid((1.0, 0.8, 0.5)).facets(2000)
    given = rows(30, 6)
    exact = Rotators(same).shifts(*given)
    one = Rotators(same, shape=mesh).shifts(*given)
    # 2000 facets instead of a smooth surface
    np.testing.assert_allclose(one, exact, atol=0.02)
    named = {**same, "shape": np.array(["round", "long"] * 3, dtype=object)}
    both = Rotators(named, shape={"long": mesh, "round": mesh})
    np.testing.assert_array_equal(both.shifts(*given), one)
    with pytest.raises(AttitudeError, match="Member 0: shape is 'flat'; it must be one of 'long'"):
        Rotators({**named, "shape": ["flat"] * 6}, shape={"long": mesh})


def test_the_columns_of_a_survey_make_an_ensemble(tmp_path):
    """Attitudes at dates, of columns and of a CSV file, against `Spin.from_periods` of each row."""
    table = {**columns(8), "ObjID": [f"S{k}" for k in range(8)]}
    rows = zip(*table.values(), strict=True)
    lines = [",".join(table), *(",".join(map(str, row)) for row in rows)]
    (tmp_path / "rotation.csv").write_text("\n".join(lines) + "\n")
    date = epochs.instant("2024-03-01T12:00:00")
    ensemble = Ensemble.from_table(table)
    assert ensemble.names.tolist() == table["ObjID"] and ensemble.frame == "ecliptic"
    found = ensemble.at(["2024-03-01T12:00:00"]).wxyz[:, 0]
    again = Ensemble.from_table(tmp_path / "rotation.csv").at(["2024-03-01T12:00:00"])
    np.testing.assert_array_equal(again.wxyz[:, 0], found)
    for k in range(8):
        body = Body.from_ellipsoid([table[f"axis_{each}"][k] for each in "abc"])
        pole = np.radians([table["pole_lon_deg"][k], table["pole_lat_deg"][k]])
        given = {"pole": pole, "phi0": math.radians(table["phi0_deg"][k])}
        if math.isnan(table["period_h"][k]):
            given |= {
                "mode": table["mode"][k], "convention": table["convention"][k],
                "P_psi": table["P_psi_h"][k] * HOUR, "P_phi": table["P_phi_h"][k] * HOUR,
                "psi0": math.radians(table["psi0_deg"][k]),
            }  # fmt: skip
        else:
            given["P"] = table["period_h"][k] * HOUR
        start = epochs.Instant((table["spin_epochMJD_TDB"][k] - 51544.5) * 86400.0)
        motion = FreeRotation(body, Spin.from_periods(body, epoch=start, frame="ecliptic", **given))
        # An epoch of 7e8 s in one double has 6e-8 s, of which a turn in 2 h makes 5e-11 rad.
        exact = motion.at(date).wxyz
        assert min(abs(found[k] - exact).max(), abs(found[k] + exact).max()) < 1e-10


@pytest.mark.parametrize("ending", ["csv", "ecsv", "fits"])
def test_empty_cells_of_files(ending, tmp_path):
    """Masked by astropy; with the states of NaN and empty text.  FITS has bytes as text."""
    from astropy.table import Table

    wanted = {**columns(8), "ObjID": [f"S{k}" for k in range(8)]}
    rows = [wanted, *zip(*wanted.values(), strict=True)]
    source = tmp_path / "rotation.csv"
    source.write_text("".join(",".join(map(str, row)) + "\n" for row in rows).replace("nan", ""))
    table = Table.read(source, format="ascii.csv")
    assert table["P_psi_h"].mask.any() and table["mode"].mask.any()
    if ending != "csv":
        table.write(tmp_path / f"rotation.{ending}")
    t = ["2024-03-01T12:00:00"]
    exact = Ensemble.from_table(wanted).at(t).wxyz
    for given in (table, tmp_path / f"rotation.{ending}"):
        found = Ensemble.from_table(given)
        np.testing.assert_array_equal(found.at(t).wxyz, exact)
        assert found.names.tolist() == wanted["ObjID"]
    Rotators({name: table[name] for name in table.colnames})


def test_columns_with_units_and_masks():
    from astropy import units
    from astropy.table import MaskedColumn, QTable

    plain = {name: each[[0, 2]] for name, each in columns(4).items()}
    exact = Ensemble.from_table(plain)
    t = exact.epoch_of(0).after(5e6)
    changed = {
        "period_h": plain["period_h"] * 60.0 * units.min,
        "pole_lon_deg": np.radians(plain["pole_lon_deg"]) * units.rad,
        "axis_a": plain["axis_a"] * units.km,
        "axis_b": plain["axis_b"] * 1e3 * units.m,
        "axis_c": list(plain["axis_c"] * 1e5 * units.cm),
    }
    found = Ensemble.from_table(QTable({**plain, **changed}))
    np.testing.assert_allclose(found.period_psi, exact.period_psi, rtol=1e-12)
    np.testing.assert_allclose(found.at(t).wxyz, exact.at(t).wxyz, atol=1e-8)
    with pytest.raises(AttitudeError, match="period_h is in m; give it in h"):
        Ensemble.from_table({**plain, "period_h": [1.0, 2.0] * units.m})
    for name, sentence in (("period_h", "P_psi, P_phi"), ("pole_lon_deg", "pole holds nan")):
        masked = MaskedColumn(plain[name], mask=[False, True])
        with pytest.raises(AttitudeError, match=f"Member 1: .*{sentence}"):
            Ensemble.from_table(QTable({**plain, name: masked}))


@pytest.mark.parametrize(
    ("changed", "options", "sentence"),
    [
        ({"period_h": [5.0, 0.0]}, {}, "the table: ObjID 'B': P is 0.0"),
        ({"spin_epochMJD_TDB": [60000.0, math.nan]}, {}, "ObjID 'B' has no spin_epochMJD_TDB"),
        ({}, {"frame": "icrf"}, "whose frame is 'ecliptic', not 'icrf'; leave frame out"),
        ({}, {"relative": False}, "whose relative is True, not False; leave relative out"),
    ],
)
def test_bad_columns_of_a_survey_in_an_ensemble(changed, options, sentence):
    table = {name: each[[0, 2]] for name, each in columns(4).items()} | {"ObjID": ["A", "B"]}
    with pytest.raises(AttitudeError, match=sentence):
        Ensemble.from_table({**table, **changed}, **options)
    kept = Ensemble.from_table({**table, "period_h": [5.0, 0.0]}, on_error="nan")
    assert np.isnan(kept.at(0.0).wxyz[1]).all() and np.isfinite(kept.at(0.0).wxyz[0]).all()


def test_dates_of_emission():
    """Against the conversion of astropy's Times, to a microsecond."""
    from astropy.time import Time

    received = np.linspace(60200.0, 60900.0, 301) + 0.123
    left = emission(received, np.full(301, 3e8))
    times = Time(received, format="mjd", scale="tai")
    seconds = (left - times.tdb.mjd) * 86400.0 + 3e11 / 299792458.0
    assert np.max(np.abs(seconds)) < 2e-6
    assert emission(received[:1], [3e8])[0] == pytest.approx(left[0], abs=1e-11)


def test_what_is_drawn_depends_on_the_name_alone():
    names = [f"S{k}" for k in range(2000)]
    both = drawn(names, "period_h", 7, (2.0, 4.0))
    np.testing.assert_array_equal(drawn(names[500:510], "period_h", 7, (2.0, 4.0)), both[500:510])
    assert both.min() >= 2.0 and both.max() <= 4.0 and both.mean() == pytest.approx(3.0, abs=0.06)
    assert np.abs(np.corrcoef(both, drawn(names, "phi0_deg", 7, (0, 1)))[0, 1]) < 0.1
    assert not np.array_equal(both, drawn(names, "period_h", 8, (2.0, 4.0)))
    squared = drawn(names, "period_h", 7, lambda u: u**2)
    np.testing.assert_allclose(squared, ((both - 2.0) / 2.0) ** 2, atol=1e-12)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"axis_b": [1.0, -1.0]}, "ObjID .b. has the semi-axes .*above zero"),
        ({"period_h": [5.0, 0.0]}, "ObjID 'b': P is 0.0"),
        ({"pole_lat_deg": None}, "the column pole_lat_deg is missing"),
        ({"phi0_deg": ["x", "y"]}, "ObjID 'a': phi0_deg is 'x'; give a number"),
        ({"period_h": [5.0]}, "the column period_h has shape .1,.; give one number"),
        ({"P_psi_h": [7.0, 7.0]}, "ObjID 'a': P is the one period of a relaxed rotator; leave out"),
        ({"spin_epochMJD_TDB": [6e4, math.nan]}, "ObjID 'b' has no spin_epochMJD_TDB; give"),
    ],
)
def test_bad_columns(changed, sentence):
    table = {name: each[[0, 2]] for name, each in columns(4).items()}
    table = {name: each for name, each in {**table, **changed}.items() if each is not None}
    with pytest.raises(AttitudeError, match=sentence):
        Rotators(table, names=["a", "b"])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"law": "hapke"}, "about a mean"),
        ({"law": "lambert"}, "ellipsoids need Lommel-Seeliger's law"),
        ({"shape": Ellipsoid((3.0, 2.0, 1.0))}, "shape is Ellipsoid.*; give a Mesh"),
    ],
)
def test_laws_and_shapes_without_a_mean_are_refused(options, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        Rotators(columns(2), **options)
    assert UNSEEN > 30.0


@pytest.mark.parametrize(
    ("member", "mjd", "sentence"),
    [
        ([0.0], [6e4], "member is .0.0.; give whole numbers"),
        ([5], [6e4], "member 5 of row 0 is out of range"),
        ([0, 1], [6e4], "member has shape .2,., mjd_tdb .1,.; give both as .R,."),
        ([0], ["now"], "mjd_tdb is 'now'"),
    ],
)
def test_bad_rows(member, mjd, sentence):
    vectors = [[1.0, 0.0, 0.0]] * len(member)
    rotators = Rotators(columns(2))
    with pytest.raises(AttitudeError, match=sentence):
        rotators.shifts(member, mjd, vectors, vectors)
    expected = rotators.shifts([0], [6e4], np.array(vectors[:1]), np.array(vectors[:1]))
    assert rotators.shifts([0], [6e4], vectors[0], vectors[:1]) == expected
    assert rotators.shifts([], [], np.empty((0, 3)), np.empty((0, 3))).shape == (0,)


@pytest.mark.parametrize("distribution", [(0, 1, 2), lambda u: 5.0])
def test_bad_distributions(distribution):
    with pytest.raises(AttitudeError, match=r"the distribution of period_h .* shape"):
        drawn(["A", "B"], "period_h", 1, distribution)


def test_without_sorcha_the_class_is_a_sentence():
    """In a process of its own, in which sorcha is not found, also where it is installed."""
    asked = """
import importlib.util, sys

found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *given: None if name == "sorcha" else found(name, *given)
import attitude.survey

try:
    attitude.survey.LightCurve
except attitude.AttitudeError as err:
    print(err)
assert "sorcha" not in sys.modules
"""
    run = subprocess.run(
        [sys.executable, "-c", asked], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "LightCurve is part of the light-curve class" in run.stdout
    assert "which is not installed" in run.stdout


CONFIGURATION = """
[EXPERT]
randomization_on = False
vignetting_on = False
trailing_losses_on = False
"""


def _ephemeris(orbit, visits, name):
    """Rows of sorcha's ephemeris of one object where it is in the field of a visit."""
    field, mjd, ra, dec = visits
    first = epochs.instant("2023-09-14T00:00:00 TDB")  # MJD 60201
    # seconds of TT: TDB differs by 2 ms, in which nothing moves by more than 100 m
    seconds = (mjd - 60201.0) * 86400.0 + 32.184
    earth = paths.body("earth", "builtin", center="sun")
    earth = paths.compress(earth, first, first.after(400 * 86400.0), 1e3)
    light = np.zeros(len(mjd))
    for _ in range(3):
        body, speed = orbit.state(first, seconds - light)
        own, moving = earth.state(first, seconds)
        towards = body - own
        distance = np.linalg.norm(towards, axis=1)
        light = distance / 299792458.0
    right = np.degrees(np.arctan2(towards[:, 1], towards[:, 0])) % 360.0
    north = np.degrees(np.arcsin(towards[:, 2] / distance))
    unit = [np.radians(each) for each in (right, north, ra, dec)]
    near = np.sin(unit[1]) * np.sin(unit[3])
    near += np.cos(unit[1]) * np.cos(unit[3]) * np.cos(unit[0] - unit[2])
    here = np.flatnonzero(near > math.cos(math.radians(1.5)))[:60]
    phase = np.degrees(
        np.arccos(np.sum(body * towards, 1) / distance / np.linalg.norm(body, axis=1))
    )
    found = {"ObjID": [name] * len(here), "FieldID": field[here], "fieldMJD_TAI": mjd[here],
             "Range_LTC_km": distance[here] / 1e3, "RangeRate_LTC_km_s": np.zeros(len(here)),
             "RA_deg": right[here], "RARateCosDec_deg_day": np.zeros(len(here)),
             "Dec_deg": north[here], "DecRate_deg_day": np.zeros(len(here))}  # fmt: skip
    for label, vectors in (("Obj_Sun", (body, speed)), ("Obs_Sun", (own, moving))):
        for suffix, unit_of, each in (("", "_km", vectors[0]), ("v", "_km_s", vectors[1])):
            for k, axis in enumerate("xyz"):
                ltc = "_LTC" if label == "Obj_Sun" else ""
                found[f"{label}_{suffix}{axis}{ltc}{unit_of}"] = each[here, k] / 1e3
    return {**found, "phase_deg": phase[here]}


@needs_sorcha
def test_in_a_run_of_sorcha_on_its_demo(tmp_path):
    """Its orbits, colours, pointings and configuration; the ephemeris is that of two bodies."""
    import sqlite3

    import pandas
    import sorcha

    demo = Path(sorcha.__file__).parent / "data" / "demo"
    database = sqlite3.connect(demo / "baseline_v2.0_1yr.db")
    query = "select observationId, observationStartMJD, fieldRA, fieldDec from observations"
    visits = np.array(database.execute(query).fetchall()).T
    visits = (visits[0].astype(int), *visits[1:])
    orbits = pandas.read_csv(demo / "sspp_testset_orbits.des", sep=r"\s+")
    names = ["2011_YA42", "2013_CC263", "2010_TC209"]
    parts = []
    for name in names:
        row = orbits[orbits.ObjID == name].iloc[0]
        angles = {
            "inclination": row.inc, "node": row.node, "pericenter_argument": row.argPeri,
            "mean_anomaly": row.ma,
        }  # fmt: skip
        orbit = paths.kepler(
            semi_major_axis=row.a * 149597870700.0, eccentricity=row.e,
            epoch="2023-09-13T00:00:00 TDB",
            **{key: math.radians(each) for key, each in angles.items()},
        )  # fmt: skip
        parts.append(pandas.DataFrame(_ephemeris(orbit, visits, name)))
    ephemeris = pandas.concat(parts)
    assert len(ephemeris) > 30
    ephemeris.to_csv(tmp_path / "ephemeris.csv", index=False)
    table = {name: each[1:4] for name, each in columns(4).items()}
    text = pandas.DataFrame({"ObjID": names, **table, "mode": ["LAM", "nan", "SAM"]})
    text.to_csv(tmp_path / "rotation.txt", sep=" ", index=False, na_rep="nan")
    wanted = orbits[orbits.ObjID.isin(names)]
    wanted.to_csv(tmp_path / "orbits.txt", sep=" ", index=False)
    colours = pandas.read_csv(demo / "sspp_testset_colours.txt", sep=r"\s+")
    colours[colours.ObjID.isin(names)].to_csv(tmp_path / "colours.txt", sep=" ", index=False)
    setup = (demo / "sorcha_config_demo.ini").read_text()
    for old, new in (
        ("ephemerides_type = ar", "ephemerides_type = external"),
        ("lc_model = none", "lc_model = attitude"),
        ("output_columns = basic", "output_columns = all"),
    ):
        assert old in setup
        setup = setup.replace(f"\n{old}", f"\n{new}")
    start, end = setup.index("[SIMULATION]"), setup.index("[FILTERS]")
    setup = setup[:start] + "[SIMULATION]\n" + setup[end:]
    start, end = setup.index("[LINKINGFILTER]"), setup.index("[OUTPUT]")
    setup = setup[:start] + setup[end:]
    (tmp_path / "configuration.ini").write_text(setup + CONFIGURATION)
    command = [
        *(sys.executable, "-m", "attitude.survey", "run", "-c", tmp_path / "configuration.ini"),
        *("-p", tmp_path / "colours.txt", "--ob", tmp_path / "orbits.txt"),
        *("--pd", demo / "baseline_v2.0_1yr.db", "--er", tmp_path / "ephemeris.csv"),
        *("--cp", tmp_path / "rotation.txt", "-o", tmp_path, "-t", "found", "-f"),
    ]
    run = subprocess.run([str(each) for each in command], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr[-2000:]
    found = pandas.read_csv(tmp_path / "found.csv")
    assert len(found) >= 5 and found.ObjID.nunique() >= 2
    for _, row in found.iterrows():
        body = np.array([row[f"Obj_Sun_{axis}_LTC_km"] for axis in "xyz"])
        own = np.array([row[f"Obs_Sun_{axis}_km"] for axis in "xyz"])
        left = emission([row.fieldMJD_TAI], [row.Range_LTC_km])[0]
        k = names.index(row.ObjID)
        right = shift_of({**table, "mode": ["LAM", "", "SAM"]}, k, left, -body, own - body)
        assert row.Delta_m == pytest.approx(right, abs=1e-6)
    assert found.Delta_m.std() > 0.01


@needs_sorcha
def test_classes_with_distributions_and_names_that_are_taken():
    import pandas
    from sorcha.lightcurves.lightcurve_registration import LC_METHODS

    from attitude.survey import light_curve_class
    from attitude.survey._light_curve import RELAXED

    assert {"attitude", "attitude-relaxed"} <= set(LC_METHODS)
    with pytest.raises(AttitudeError, match="another light-curve class has"):
        light_curve_class("attitude")
    made = light_curve_class("attitude-test", draws=RELAXED, seed=3)
    assert LC_METHODS["attitude-test"] is made
    random = np.random.default_rng(2)
    table = pandas.DataFrame(
        {
            "ObjID": np.repeat(["A", "B", "C"], 5),
            "fieldMJD_TAI": random.uniform(60300.0, 60301.0, 15),
            "Range_LTC_km": 2e8,
            **{f"Obj_Sun_{axis}_LTC_km": random.normal(size=15) * 1e8 for axis in "xyz"},
            **{f"Obs_Sun_{axis}_km": random.normal(size=15) * 1e7 for axis in "xyz"},
        }
    )
    shifts = made().compute(table)
    # another order of the rows, and other objects beside them, change nothing
    mixed = table.sample(frac=1.0, random_state=1)
    again = pandas.Series(made().compute(mixed), index=mixed.index)
    np.testing.assert_array_equal(again.sort_index(), shifts)
    np.testing.assert_array_equal(made().compute(table[5:10]), shifts[5:10])
    assert np.all(made().maxBrightness(pandas.DataFrame({"ObjID": ["A", "B"]})) < 0.0)
    # a tumbler draws no period of a relaxed rotator
    tumblers = table.assign(P_psi_h=30.0, P_phi_h=8.0, psi0_deg=0.0, mode="SAM", convention="S")
    assert not np.any(np.isclose(made().compute(tumblers), shifts))
    for wrong in ({"draws": {"perod_h": 3.0}}, {"law": "foo"}, {"shape": "cube.obj"}):
        with pytest.raises(AttitudeError, match=f"{next(iter(wrong))} .*; give"):
            light_curve_class("attitude-wrong", **wrong)
    with pytest.raises(AttitudeError, match="of lower case"):
        light_curve_class("ABC")
    with pytest.raises(ValueError, match="missing column"):
        made().compute(table.drop(columns="Range_LTC_km"))
