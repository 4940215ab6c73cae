"""The copy of three.js in the package, made anew from the npm registry.

    python docs/make_three.py            # the newest release
    python docs/make_three.py 0.187.0

needs npm.  It writes what the viewer uses of the library, bundled by esbuild as one script that
defines THREE, with the licence and the version, into attitude/viewer/page/three/.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "attitude" / "viewer" / "page" / "three"
ESBUILD = "0.28.2"
# What attitude/viewer/page/*.js uses; tests compare.
NAMES = (
    *("AmbientLight", "ArrowHelper", "BufferAttribute", "BufferGeometry", "CircleGeometry"),
    *("Color", "DirectionalLight", "DoubleSide", "Group", "Line", "LineBasicMaterial"),
    *("Mesh", "MeshBasicMaterial", "MeshLambertMaterial", "PCFShadowMap"),
    *("PerspectiveCamera", "Quaternion", "Scene", "SphereGeometry", "Vector3", "WebGLRenderer"),
)


def bundled(version):
    """Write the script, the licence and the version of a release."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        packages = [f"three@{version}", f"esbuild@{ESBUILD}"]
        subprocess.run(["npm", "install", "--no-save", *packages], cwd=folder, check=True)
        entry = folder / "entry.js"
        controls = 'export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";'
        entry.write_text(f'export {{ {", ".join(NAMES)} }} from "three";\n{controls}\n')
        esbuild = folder / "node_modules" / "@esbuild"
        program = next(esbuild.glob("*/bin/esbuild"), folder / "node_modules" / ".bin" / "esbuild")
        out = folder / "three.min.js"
        options = ["--bundle", "--minify", "--format=iife", "--global-name=THREE"]
        three = folder / "node_modules" / "three"
        found = json.loads((three / "package.json").read_text())["version"]
        banner = f"/*! three.js {found}, MIT License, (c) three.js authors */"
        options += ["--target=es2020", f"--banner:js={banner}", f"--outfile={out}"]
        subprocess.run([program, entry, *options], cwd=folder, check=True)
        FOLDER.mkdir(parents=True, exist_ok=True)
        shutil.copy(out, FOLDER / "three.min.js")
        shutil.copy(three / "LICENSE", FOLDER / "LICENSE")
        (FOLDER / "VERSION").write_text(found + "\n")


if __name__ == "__main__":
    bundled(sys.argv[1] if len(sys.argv) > 1 else "latest")
