"""Reads an EXR as OpenEXR's own library and OpenImageIO do, and compares what they find with what was asked for.

    read.py FILE.exr EXPECTED.json

EXPECTED has `channels`, types by name; `attributes`, texts and numbers by name; `size`; and `matrix`, the 16 numbers of
worldToCamera. A failure is one sentence and exit code 1.
"""

import json
import math
import sys

import OpenEXR
import OpenImageIO as oiio

RED, WHITE = (0.64, 0.33), (0.3127, 0.329)


def check(holds, sentence):
    if not holds:
        sys.exit(sentence)


def near(found, expected):
    return len(found) == len(expected) and all(math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-6) for a, b in zip(found, expected))


def with_openexr(path, expected):
    types = {"float16": "half", "float32": "float"}
    # What a file gives is gone with it.
    with OpenEXR.File(path, separate_channels=True) as file:
        header, channels = file.header(), file.channels()
        found = {name: types[str(channel.pixels.dtype)] for name, channel in channels.items()}
        check(found == expected["channels"], f"OpenEXR finds {found}")
        height, width = channels["A"].pixels.shape
        check([width, height] == expected["size"], f"OpenEXR finds {width} x {height}")
        for name, value in expected["attributes"].items():
            check(header.get(name) == value, f"OpenEXR finds {header.get(name)!r} as {name}, not {value!r}")
        check(header["compression"] == OpenEXR.ZIP_COMPRESSION, "it is not compressed by ZIP")
        chromaticities = header["chromaticities"]
        check(near(chromaticities[:2], RED) and near(chromaticities[6:], WHITE), f"OpenEXR finds {chromaticities}")
        matrix = [float(x) for row in header["worldToCamera"] for x in row]
        check(near(matrix, expected["matrix"]), f"OpenEXR finds {matrix}")
        alpha, depth = channels["A"].pixels, channels["Z"].pixels
        seen = depth[alpha == 1]
        check(seen.size > 0 and bool((seen > 0).all()), "depths of what is seen are more than 0")
    # As people read it who want colours: channels of a group in one array, for which they have to be of one type.
    with OpenEXR.File(path) as file:
        check(file.channels()["RGBA"].pixels.shape == (*reversed(expected["size"]), 4), "it has no RGBA")


def with_openimageio(path, expected):
    image = oiio.ImageInput.open(path)
    check(image is not None, f"OpenImageIO cannot open it: {oiio.geterror()}")
    spec = image.spec()
    types = [str(spec.channelformat(k)) for k in range(spec.nchannels)]
    found = dict(zip(spec.channelnames, types))
    check(found == expected["channels"], f"OpenImageIO finds {found}")
    check([spec.width, spec.height] == expected["size"], f"OpenImageIO finds {spec.width} x {spec.height}")
    names = list(spec.channelnames)
    check(names[:4] == ["R", "G", "B", "A"] and spec.alpha_channel == 3, f"OpenImageIO finds {names[:4]} first")
    check(spec.z_channel == names.index("Z"), "OpenImageIO does not find the depth")
    for name, value in expected["attributes"].items():
        check(spec.getattribute(name) == value, f"OpenImageIO finds {spec.getattribute(name)!r} as {name}")
    check(image.read_image() is not None, f"OpenImageIO cannot read it: {oiio.geterror()}")


if __name__ == "__main__":
    file, expectation = sys.argv[1], json.load(open(sys.argv[2], encoding="utf-8"))
    with_openexr(file, expectation)
    with_openimageio(file, expectation)
