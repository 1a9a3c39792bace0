# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Make a wheel of a built package: make_wheel.py PACKAGE VERSION FOLDER [LICENSES], and print its path.

PACKAGE is <build>/python/tandem of a static build. The wheel is for this interpreter on systems with the
shared libraries that the build wants: none but C's where build_wheel.sh made it. LICENSES is a folder of files.
"""

from __future__ import annotations

import base64
import hashlib
import pathlib
import sys
import sysconfig
import zipfile


def make_wheel(
    package: pathlib.Path, version: str, folder: pathlib.Path, licenses: pathlib.Path | None = None
) -> pathlib.Path:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    tag = f"{python}-{python}-{system}"
    info = f"tandem-{version}.dist-info"
    files = {
        f"tandem/{path.name}": path.read_bytes()
        for path in sorted(package.iterdir())
        if path.suffix in (".py", ".pyi", ".so", ".html", ".js") or path.name == "py.typed"
    }
    for path in sorted(licenses.iterdir()) if licenses else []:
        files[f"{info}/licenses/{path.name}"] = path.read_bytes()
    # pybind11 supports numpy 2 from 2.12 on; Debian 12 has 2.10.
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: tandem\nVersion: {version}\nLicense: MIT\n"
        f"Summary: XPBD rigid bodies: scenes, states as numpy arrays, batches\nRequires-Dist: numpy<2\n"
    ).encode()
    files[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: tandem\nRoot-Is-Purelib: false\nTag: {tag}\n"
    ).encode()
    record = "".join(
        f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n"
        for name, data in files.items()
    )
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    folder.mkdir(parents=True, exist_ok=True)
    wheel = folder / f"tandem-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as out:
        for name, data in files.items():
            # A fixed time, so that the same build gives the same wheel.
            out.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return wheel


if __name__ == "__main__":
    package, version, *folders = sys.argv[1:]
    print(make_wheel(pathlib.Path(package), version, *map(pathlib.Path, folders)))
