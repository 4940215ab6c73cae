"""How large is a page of the viewer, how exact is it, and how long does a frame take?

    python benchmarks/viewer.py

Frames are timed in headless Chromium, whose OpenGL is here computed by the processor (SwiftShader):
the whole frame, the script alone, without the calls that draw, and frames a second while the motion
plays, where the page draws less if frames take too long.  Needs the extra viewer-test.
"""

import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import Scene, catalog, shape
from attitude.viewer import _page, view
from benchmarks.doc_tables import Table, printed
from tests.support import browser

DAY = 86400.0
MAKES = ("viewer",)
NEEDS = ("playwright",)
# Milliseconds of the script of a frame, with calls that draw left out, of the whole frame, and of
# one in which the camera alone moves; draw calls and triangles of both.
TIMED = """count => {
  const { stage, clock, quality, drawAt } = attitudeViewer;
  clock.play(false);
  quality.use(0);
  const pixel = new Uint8Array(4);
  const gl = stage.renderer.getContext();
  const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  const each = (work, n) => {
    const begin = performance.now();
    for (let k = 0; k < n; k++) work((clock.duration * k) / n);
    return (performance.now() - begin) / n;
  };
  drawAt(0); wait();
  const whole = each((time) => { drawAt(time); wait(); }, count);
  const { render } = stage.renderer.info;
  const work = [render.calls, render.triangles];
  const turned = each(() => { stage.camera.position.x += 0.01; drawAt(0); wait(); }, count);
  const less = [render.calls, render.triangles];
  gl.drawArrays = gl.drawElements = () => {};
  return [each(drawAt, 500), whole, turned, work, less];
}"""

# Frames a second of a motion that plays, and the facets of the body in them.
PLAYED = """async (seconds) => {
  const { stage, clock, frames } = attitudeViewer;
  clock.play(true);
  const pause = (time) => new Promise((done) => setTimeout(done, 1000 * time));
  await pause(3);
  const drawn = frames.drawn, begin = performance.now();
  await pause(seconds);
  const rate = (1000 * (frames.drawn - drawn)) / (performance.now() - begin);
  return [rate, stage.mesh.geometry.index.count / 3, stage.renderer.getPixelRatio()];
}"""


def tables(quick):
    """The block of docs/viewer.md."""
    yield Table("viewer", printed(main))


def scene(facets):
    """Toutatis as two balls in contact, which shadow each other."""
    ball = shape.Ellipsoid((1.2, 1.0, 0.9)).facets(facets // 2)
    body = ball.moved((-0.9, 0.0, 0.0)).joined(ball.scaled(0.7).moved((0.9, 0.0, 0.0)))
    motion = catalog.entry("toutatis").motion()
    return Scene(motion, None, observer=(1, 0.2, 0.1), sun=(0.3, 1, 0.2), shape=body)


def main():
    library = len((_page.FOLDER / "three" / "three.min.js").read_bytes())
    print(f"three.js {_page.version()}, {library / 1e3:.0f} kB")
    with tempfile.TemporaryDirectory() as folder, browser.running() as chromium:
        for facets in (1000, 100_000):
            what, file = scene(facets), Path(folder) / "page.html"
            view(what, stop=30 * DAY)  # compiles
            begin = time.process_time()
            view(what, stop=30 * DAY, output=file)
            made = time.process_time() - begin
            size = (file.stat().st_size - library) / 1e3
            print(f"30 days of Toutatis, {len(what.shape)} facets, light curve")
            print(f"  beside the library       {size:8.0f} kB, made in {made:.1f} s")
            for width, height in ((1100, 760), (400, 300)):
                with browser.opened(chromium, file, width, height) as (opened, _):
                    rate, triangles, ratio = opened.evaluate(PLAYED, 5)
                    script, drawn, turned, work, less = opened.evaluate(TIMED, 20)
                print(
                    f"  {width:4d} x {height} pixels: a frame {drawn:7.1f} ms by the processor, "
                    f"its script {script:.2f} ms; {turned:.1f} ms where the camera alone moves"
                )
                print(
                    f"    while it plays: {rate:.0f} frames a second, of {triangles:.0f} facets "
                    f"and {ratio:.1f} pixels for one of the page"
                )
            print(
                f"  a frame: {work[0]} draw calls, {work[1]} triangles; {less[0]} and {less[1]} "
                "where the camera alone moves"
            )


if __name__ == "__main__":
    main()
