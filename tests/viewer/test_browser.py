"""The page in a real browser: it draws, keeps the motion, and answers keys and mouse."""

import numpy as np
import pytest

from attitude import Arcs, Body, FreeRotation, Impulse, Scene, Spin, catalog, cli, shape
from attitude.formats import mission
from attitude.frames import quaternion
from attitude.viewer import _subject, view
from tests.support import browser
from tests.support.places import ROOT

DAY = 86400.0
# Errors of drivers without graphics hardware, which tell nothing about the page.
OF_DRIVERS = ("GPU stall due to ReadPixels", "Automatic fallback to software WebGL")


def toutatis():
    return catalog.entry("toutatis").motion()


def lit(motion):
    body = shape.Ellipsoid((2.1, 1.2, 1.0)).facets(1000)
    return Scene(motion, None, observer=(1, 0.2, 0.1), sun=(0.3, 1, 0.2), shape=body)


def angle(p, q):
    """Between two attitudes, degrees."""
    off = quaternion.multiply(quaternion.conjugate(p), q)
    return np.degrees(2.0 * np.arctan2(np.linalg.norm(off[..., 1:], axis=-1), np.abs(off[..., 0])))


def known(errors):
    return [each for each in errors if not any(known in each for known in OF_DRIVERS)]


@pytest.fixture(scope="module")
def chromium():
    with browser.running() as found:
        yield found


@pytest.fixture(scope="module")
def shown(chromium, tmp_path_factory):
    """The page of 30 days of Toutatis, lit and seen."""
    path = tmp_path_factory.mktemp("viewer") / "toutatis.html"
    view(lit(toutatis()), stop=30 * DAY, title="4179 Toutatis", output=path)
    with browser.opened(chromium, path) as (page, errors):
        yield page, errors


def test_it_draws_without_errors(shown):
    page, errors = shown
    assert known(errors) == []
    assert page.title() == "4179 Toutatis"
    # The body is lit: pixels of the canvas are bright on one side of the picture.
    bright = page.evaluate(
        """() => {
          const canvas = document.getElementById("picture");
          const copy = document.createElement("canvas");
          copy.width = canvas.width; copy.height = canvas.height;
          const pen = copy.getContext("2d");
          pen.drawImage(canvas, 0, 0);
          const data = pen.getImageData(0, 0, copy.width, copy.height).data;
          let count = 0;
          for (let k = 0; k < data.length; k += 4) if (data[k] > 120) count++;
          return count / (data.length / 4);
        }"""
    )
    assert 0.01 < bright < 0.6
    assert "Long-axis mode" in page.inner_text("#kind")
    assert "period psi" in page.inner_text("#facts")


def test_the_pose_is_that_of_the_package(shown):
    page, _ = shown
    times = np.linspace(0.0, 30 * DAY, 400) * 0.999 + 17.0
    poses = np.array(page.evaluate("times => times.map(t => attitudeViewer.pose(t))", list(times)))
    assert angle(poses, toutatis().at(times).wxyz).max() < 0.2


def test_the_arrow_of_the_rate_is_that_of_the_package(shown):
    page, _ = shown
    t = 1234567.0
    drawn = page.evaluate(
        "t => { attitudeViewer.clock.play(false); attitudeViewer.drawAt(t); "
        "return attitudeViewer.stage.rate.toArray(); }",
        t,
    )
    expected = toutatis().at(t).angular_velocity_inertial
    assert np.allclose(drawn, expected, rtol=0, atol=2e-3 * np.linalg.norm(expected))


def test_keys_and_scrubber(shown):
    page, errors = shown
    now = "attitudeViewer.clock.time"
    page.evaluate("attitudeViewer.clock.play(true)")
    page.keyboard.press(" ")
    assert page.evaluate("attitudeViewer.clock.playing") is False
    page.keyboard.press("Home")
    assert page.evaluate(now) == 0.0
    page.keyboard.press("ArrowRight")
    assert page.evaluate(now) == pytest.approx(30 * DAY / 1000)
    page.keyboard.press("End")
    assert page.evaluate(now) == pytest.approx(30 * DAY)
    page.evaluate(
        "() => { const bar = document.getElementById('scrubber'); bar.value = 50000; "
        "bar.dispatchEvent(new Event('input')); }"
    )
    assert page.evaluate(now) == pytest.approx(15 * DAY)
    assert page.inner_text("#utc") == "1992-11-24 17:49:47 UTC"
    for key, name in (("2", "observer"), ("3", "sun"), ("4", "body"), ("1", "inertial")):
        page.keyboard.press(key)
        assert page.evaluate("attitudeViewer.views.current") == name
        page.wait_for_timeout(50)
    page.keyboard.press("p")
    assert page.evaluate("attitudeViewer.stage.poinsot.plane.visible") is True
    page.click("input[name=axes]")
    assert page.evaluate("attitudeViewer.stage.arrows.axes[0].object.visible") is False
    assert known(errors) == []


def test_the_cursor_of_the_curve_is_dragged(shown):
    page, _ = shown
    box = page.locator("#curve").bounding_box()
    middle = box["x"] + 58 + (box["width"] - 58 - 24) / 2
    page.mouse.move(box["x"] + 100, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(middle, box["y"] + 60)
    page.mouse.up()
    assert page.evaluate("attitudeViewer.clock.time") == pytest.approx(15 * DAY, rel=0.01)


def test_a_thinned_curve_has_no_dot_and_late_years_no_date(chromium, tmp_path):
    """Of 3200 turns the curve holds extremes, which have no value at a time."""
    body = shape.Ellipsoid((3, 2, 1.5)).facets(300)
    spin = Spin(epoch="9999-12-31T23:59", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 0.15, 1))
    scene = Scene(
        FreeRotation(Body(moments=(10, 20, 26)), spin), None, (0, 1, 0), (1, 0, 0), shape=body
    )
    for stop, has_dot in ((600.0, True), (20_000.0, False)):
        view(scene, stop=stop, output=tmp_path / "late.html")
        with browser.opened(chromium, tmp_path / "late.html") as (page, errors):
            page.evaluate(
                "t => { attitudeViewer.clock.play(false); attitudeViewer.clock.set(t);"
                " attitudeViewer.drawAt(t); }", stop / 2
            )  # fmt: skip
            assert page.inner_text("#utc") in ("300.0000 s", "10000.00 s")
            columns = page.evaluate(
                """() => {
                  const { width, height } = document.getElementById("curve");
                  const pen = document.getElementById("curve").getContext("2d");
                  const data = pen.getImageData(0, 0, width, height).data;
                  const white = new Set();
                  for (let k = 0; k < data.length; k += 4)
                    if (Math.min(data[k], data[k + 1], data[k + 2]) > 250 && data[k + 3] > 250)
                      white.add((k / 4) % width);
                  return white.size;
                }"""
            )
            assert (columns > 3) == has_dot
            assert known(errors) == []


def test_views_turn_the_world(shown):
    """From the observer its direction points at the camera; from the body, x stays."""
    page, _ = shown
    found = page.evaluate(
        """() => {
          const { stage, views, panel, drawAt } = attitudeViewer;
          const of = (name, make) => { panel.choose(name); drawAt(1e6); return make(); };
          const world = (vector) => vector.applyQuaternion(stage.world.quaternion).toArray();
          const to = new stage.direction.constructor();
          return {
            observer: of("observer", () => world(stage.observer.at(1e6, to))),
            body: of("body", () => world(to.set(1, 0, 0).applyQuaternion(stage.pose))),
          };
        }"""
    )
    assert np.allclose(found["observer"], [1, 0, 0], atol=1e-6)
    assert np.allclose(found["body"], [1, 0, 0], atol=1e-6)


def test_impulses_jump(chromium, tmp_path):
    """At an impulse the rate jumps and the attitude does not; both sides are kept."""
    motion = toutatis()
    arcs = Arcs(motion.body, motion.spin, Impulse(10 * DAY, -0.8 * motion.momentum, "icrf"))
    path = tmp_path / "arcs.html"
    view(arcs, stop=20 * DAY, output=path)
    times = np.concatenate([np.linspace(0, 20 * DAY, 97), 10 * DAY + np.array([-1.0, 1.0])])
    with browser.opened(chromium, path, 400, 300) as (page, errors):
        poses = page.evaluate("times => times.map(t => attitudeViewer.pose(t))", list(times))
        assert known(errors) == []
    assert angle(np.array(poses), arcs.at(times).wxyz).max() < 0.2


def test_frames_draw_what_changed(chromium, tmp_path):
    """The shadows are drawn again where pose or light changed; a paused page draws nothing."""
    wing = shape.box_wing((10, 4, 4), (14, 5), wings=1)
    scene = Scene(toutatis(), None, observer=(1, 0.2, 0.1), sun=(0.3, 1, 0.2), shape=wing)
    path = tmp_path / "wing.html"
    view(scene, stop=DAY, output=path)
    with browser.opened(chromium, path, 400, 300) as (page, errors):
        found = page.evaluate(
            """() => {
              const { stage, clock, drawAt, panel } = attitudeViewer;
              clock.play(false);
              const drawn = [];
              const draw = (time, change = () => {}) => {
                change();
                drawAt(time);
                const { calls, triangles } = stage.renderer.info.render;
                drawn.push([calls, triangles]);
              };
              panel.choose("inertial");
              draw(1000);
              draw(1000, () => stage.camera.position.multiplyScalar(1.2));
              draw(5000);
              draw(5000, () => panel.toggle("shadows"));
              draw(5000, () => panel.toggle("shadows"));
              return drawn;
            }"""
        )
        (first, moved, later, without, again) = found
        facets = len(wing.facets)
        assert first == later == again
        assert first[1] - moved[1] == first[1] - without[1] == facets
        assert first[0] - moved[0] == 1
        page.wait_for_timeout(100)
        counts = page.evaluate(
            """async () => {
              const { frames, clock } = attitudeViewer;
              const pause = () => new Promise((done) => setTimeout(done, 300));
              await pause();
              const before = { ...frames };
              await pause();
              const paused = frames.drawn - before.drawn, passed = frames.count - before.count;
              clock.play(true);
              await pause();
              return [passed, paused, frames.drawn - before.drawn];
            }"""
        )
        assert counts[0] > 1 and counts[1] == 0 and counts[2] > 1
        assert known(errors) == []


def test_shadows_of_closed_bodies_have_no_stripes(chromium, tmp_path):
    """Where a body stands in its own shadow, the picture is that with 16 times as many texels.

    A bias along the normals lets light through in stripes along the neck of two lobes, one towards
    the light in single pixels.
    """
    path = tmp_path / "lobes.html"
    assert cli.main(["view", "toutatis", "--output", str(path)]) == 0
    with browser.opened(chromium, path, 900, 700) as (page, errors):
        stripes = page.evaluate(
            """() => {
              const { stage, clock, drawAt, quality } = attitudeViewer;
              clock.play(false);
              quality.level = 0;
              for (const group of Object.values(stage.arrows))
                for (const arrow of group) arrow.object.visible = false;
              stage.camera.position.multiplyScalar(0.6);
              stage.camera.updateMatrixWorld();
              const pixels = (shadows, share = 0.1) => {
                stage.reduce({ ...stage.full, shadows });
                drawAt(share * clock.duration);
                stage.draw();
                const { width, height } = stage.canvas;
                const copy = document.createElement("canvas");
                Object.assign(copy, { width, height });
                const pen = copy.getContext("2d");
                pen.drawImage(stage.canvas, 0, 0);
                return pen.getImageData(0, 0, width, height).data;
              };
              const usual = pixels(2048), { shadow } = stage.light;
              const neck = pixels(2048, 0.4), row = 8 * stage.canvas.width;
              let lone = 0;
              for (let k = row; k < neck.length - row; k += 4) {
                const dark = [-8, 8, -row, row].filter((away) => neck[k + away] < 50);
                if (neck[k] > 55 && dark.length > 2) lone++;
              }
              shadow.normalBias = 0;
              const fine = pixels(8192);
              let lit = 0, other = 0;
              for (let k = 0; k < fine.length; k += 4) {
                if (fine[k] > 60) lit++;
                if (Math.abs(usual[k] - fine[k]) > 40) other++;
              }
              return [lit, other, lone];
            }"""
        )
        assert known(errors) == []
    assert stripes[0] > 50_000 and stripes[1] < 1e-3 * stripes[0] and stripes[2] < 10, stripes


def test_slow_frames_draw_less_and_a_still_picture_is_whole(chromium, tmp_path):
    """Frames 50 ms apart lower the quality level by level; the page at rest draws all facets."""
    ball = shape.Ellipsoid((1.0, 0.8, 0.7)).facets(12_000)
    body = ball.moved((-0.9, 0.0, 0.0)).joined(ball.moved((0.9, 0.0, 0.0)))
    scene = Scene(toutatis(), None, observer=(1, 0.2, 0.1), sun=(0.3, 1, 0.2), shape=body)
    path = tmp_path / "slow.html"
    view(scene, stop=DAY, output=path)
    with browser.opened(chromium, path, 400, 300) as (page, errors):
        found = page.evaluate(
            """async () => {
              const { stage, clock, quality, drawAt } = attitudeViewer;
              clock.play(false);
              const drawn = [];
              let now = quality.last + 1000;
              const frames = (count, apart, changed) => {
                for (let k = 0; k < count; k++) {
                  stage.changed = changed;
                  quality.frame((now += apart));
                }
                drawAt(clock.time);
                const { width, height } = stage.canvas;
                drawn.push([
                  quality.drawn,
                  quality.level,
                  stage.mesh.geometry.index.count / 3,
                  stage.light.shadow.mapSize.x,
                  width / height,
                  width,
                ]);
              };
              quality.level = 0;
              frames(20, 16, false);
              frames(41, 17, true);
              for (let k = 0; k < 5; k++) frames(8, 50, true);
              frames(20, 16, false);
              frames(1, 16, true);
              frames(8, 150, true);
              const levels = quality.levels.length;
              await new Promise((done) => setTimeout(done, 1000));
              return [drawn, levels, quality.drawn];
            }"""
        )
        assert known(errors) == []
    drawn, levels, left = found
    still, fast, *slow, rest, again, slower = drawn
    assert levels == 5 and left == 0
    assert still == fast and still[:4] == [0, 0, len(body), 2048]
    assert [each[0] for each in slow] == [1, 2, 3, 4, 4]
    assert slow[0][2:4] == [len(body), 1024]
    assert 1000 < slow[1][2] <= _subject.COARSE
    assert slow[-1][3] == 512 and slow[-1][5] == pytest.approx(0.3 * still[5], abs=1)
    assert rest == [0, 4, *still[2:]]
    # After a pause one level more is tried; frames that take 150 ms lower it by two.
    assert again[0] == 3 and slower[0] == 4
    assert all(each[4] == pytest.approx(still[4], rel=0.02) for each in drawn)


PASS = ROOT / "data" / "mission" / "envisat-glints.toml"
NIGHT = ("2013-10-23T20:40:00", "2013-10-23T21:20:00")


@pytest.fixture(scope="module")
def eclipsed(tmp_path_factory):
    """The page of Envisat, which leaves the Earth's shadow after 19.4 minutes, and its scene."""
    scene = mission.read(PASS).scene
    path = tmp_path_factory.mktemp("umbra") / "envisat.html"
    view(scene, start=NIGHT[0], stop=NIGHT[1], title="Envisat", output=path)
    return path, scene


def brightest(page):
    """The largest red of the grey pixels of the picture: arrows and labels are coloured."""
    return page.evaluate(
        """() => {
          const canvas = document.getElementById("picture");
          const copy = document.createElement("canvas");
          copy.width = canvas.width; copy.height = canvas.height;
          const pen = copy.getContext("2d");
          pen.drawImage(canvas, 0, 0);
          const data = pen.getImageData(0, 0, copy.width, copy.height).data;
          let most = 0;
          for (let k = 0; k < data.length; k += 4) {
            const spread = Math.max(data[k], data[k + 1], data[k + 2]) -
              Math.min(data[k], data[k + 1], data[k + 2]);
            if (spread < 30 && data[k + 2] < data[k]) most = Math.max(most, data[k]);
          }
          return most;
        }"""
    )


def test_a_body_in_the_umbra_is_dark_and_the_page_says_so(chromium, eclipsed):
    path, _ = eclipsed
    with browser.opened(chromium, path) as (page, errors):
        page.evaluate("attitudeViewer.clock.play(false)")
        for name in ("axes", "momentum", "rate", "sun", "observer"):
            page.evaluate(f"attitudeViewer.panel.toggle('{name}', false)")
        seen = {}
        for seconds in (600.0, 1500.0):
            page.evaluate(f"attitudeViewer.clock.set({seconds})")
            page.wait_for_timeout(300)
            words = page.inner_text("#shade")
            seen[seconds] = words, brightest(page)
        assert seen[600.0][0] == "in the Earth's umbra" and seen[1500.0][0] == ""
        assert seen[600.0][1] < 0.6 * seen[1500.0][1], seen
        assert known(errors) == []


def test_labels_hide_no_other_on_a_small_screen(chromium, eclipsed):
    """At 390 pixels, where momentum, rate and z point to one side: at 40 times of the span."""
    with browser.opened(chromium, eclipsed[0], width=390, height=760) as (page, _):
        page.evaluate("attitudeViewer.clock.play(false)")
        worst, hidden = page.evaluate(
            """() => {
              const { drawAt, stage, clock } = attitudeViewer;
              let worst = 0, hidden = 0;
              for (let k = 0; k <= 40; k++) {
                drawAt((k / 40) * clock.duration);
                hidden += document.querySelectorAll("#labels span[hidden]").length;
                const boxes = [...document.querySelectorAll("#labels span, #views")]
                  .filter((each) => !each.hidden).map((each) => each.getBoundingClientRect());
                for (const a of boxes) for (const b of boxes) if (a !== b) {
                  const x = Math.min(a.right, b.right) - Math.max(a.left, b.left);
                  const y = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
                  if (x > 0) worst = Math.max(worst, y);
                }
              }
              return [worst, hidden];
            }"""
        )
        assert hidden == 0  # of arrows beyond the edge
        assert worst < 3.0  # pixels: lines of text are 16 apart and 17 high
        box = page.locator("#utc").bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= 390
        assert "2013-10-23" in page.inner_text("#utc")


def test_the_picture_is_saved_with_its_title_and_curve(chromium, eclipsed, tmp_path):
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    with browser.opened(chromium, eclipsed[0]) as (page, errors):
        page.evaluate("attitudeViewer.clock.play(false); attitudeViewer.clock.set(1500)")
        page.wait_for_timeout(300)
        with page.expect_download() as download:
            page.click("#share")
        name = download.value.suggested_filename
        assert name.startswith("Envisat-2013-10-23") and name.endswith(".png")
        download.value.save_as(tmp_path / "picture.png")
        sizes = page.evaluate(
            """() => [document.getElementById("stage").clientWidth,
                      document.getElementById("stage").clientHeight,
                      document.getElementById("curve").clientHeight]"""
        )
        assert known(errors) == []
    with image.open(tmp_path / "picture.png") as saved:
        assert saved.size == (2 * sizes[0], 2 * (sizes[1] + sizes[2]))
        rows = np.asarray(saved.convert("L"), dtype=float)
    title, curve = rows[: 2 * 36], rows[-2 * sizes[2] :]
    assert title.max() > 200 and curve.max() > 150  # letters, and the line of the curve


def test_without_webgl_there_are_numbers(chromium, eclipsed):
    path, scene = eclipsed
    page = chromium.new_page()
    page.add_init_script(
        """const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
          return kind.startsWith("webgl") ? null : get.call(this, kind, ...more);
        };"""
    )
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(path.as_uri())
    page.wait_for_selector("#numbers td")
    assert errors == []
    assert "draws no WebGL" in page.inner_text("#numbers p")
    row = page.locator("#numbers tr").nth(13).inner_text().split("\t")
    date = row[0].replace(" ", "T")
    assert date == "2013-10-23T21:00:00"
    shown = np.array(row[1:5], dtype=float)
    assert angle(shown, scene.at(date).attitude.wxyz) < 0.2
    assert "Short-axis mode" in page.inner_text("#kind")
    page.close()
