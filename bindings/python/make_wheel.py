# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Make a wheel of a built package: make_wheel.py PACKAGE VERSION FOLDER, and print its path.

PACKAGE is <build>/python/tandem of a static build. The wheel is for this interpreter on systems with the
shared libraries of FCL and libccd, which it does not bring.
"""

import base64
import hashlib
import pathlib
import sys
import sysconfig
import zipfile


def make_wheel(package: pathlib.Path, version: str, folder: pathlib.Path) -> pathlib.Path:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    tag = f"{python}-{python}-{system}"
    info = f"tandem-{version}.dist-info"
    files = {
        f"tandem/{path.name}": path.read_bytes()
        for path in sorted(package.iterdir())
        if path.suffix in (".py", ".pyi", ".so") or path.name == "py.typed"
    }
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: tandem\nVersion: {version}\nLicense: MIT\n"
        f"Summary: XPBD rigid bodies: scenes, states as numpy arrays, batches\nRequires-Dist: numpy\n"
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
            # A fixed time: the same build gives the same wheel.
            out.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return wheel


if __name__ == "__main__":
    print(make_wheel(pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])))
