#!/usr/bin/env python3
"""Proves the edit log of a BendyLights session, from SPEC.md and parameters.json alone.

    python3 replay.py LOG.jsonl [--to N]

Applies the changes of every record, with --to up to record N, to an empty document, and holds
document and lines to the log's checkpoints. Prints one line of JSON where all is right, else one
sentence on standard error, and exits with 1; with 2 for formats other than 3 to 6 (REC-5).
"""

import argparse
import json
import math
import re
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

PARAMETERS = Path(__file__).parent.parent / "vectors" / "parameters.json"
LIGHT_TYPES = {"spot": 0, "bendy": 1, "directional": 4, "omni": 5}
PIN_KINDS = {"direction": 0, "lit": 1, "shadowed": 2, "shadow": 3, "look": 4, "coordinates": 5}
NODE_PIN = 0x80
# In a JSON string its quotes would be escaped, so this finds no text that only looks like one.
REFERENCE = re.compile(rb'\{"sameAs":\{"record":(\d+),"at":(\d+),"hash":"([^"]*)"\}\}')
MOST_BYTES = 32 * 1024 * 1024  # of a record in full (REC-6)


class Fault(Exception):
    """Says what is wrong with a log."""


class OtherFormat(Exception):
    """Says that a log has a format that this reader does not take."""


# Values as the bytes that are hashed (DOC-4). The document holds them so, because two values are
# the same, as REC-3 has it, where their bytes are.


def u8(value: int) -> bytes:
    return struct.pack("<B", value)


def u64(value: int) -> bytes:
    return struct.pack("<Q", value)


def f64(*values: float) -> bytes:
    if not all(math.isfinite(value) for value in values):
        raise ValueError("a number is not finite")
    return struct.pack(f"<{len(values)}d", *(value + 0.0 for value in values))  # -0 + 0 is 0


def text(value: str) -> bytes:
    data = value.encode()
    return u64(len(data)) + data


def number(value: float | None) -> bytes:
    return u64(0x7FF8000000000000) if value is None else f64(value)


def vector(value: list[float]) -> bytes:
    x, y, z = value
    return f64(x, y, z)


def rotation(value: list[float]) -> bytes:
    x, y, z, w = value
    return f64(x, y, z, w)


def curve(value: list | None) -> bytes:
    """A curve over an angle; an empty one is `null` (CURVE-1)."""
    pairs = value or []
    return u64(len(pairs)) + b"".join(f64(degrees, share) for degrees, share in pairs)


def links(value: dict | None) -> bytes:
    """Two lists that are sets; two empty ones are `null` (LINK-4)."""
    lists = []
    for name in ("include", "exclude"):
        paths = sorted({path.encode() for path in (value or {}).get(name) or []})
        lists += [u64(len(paths)), *(u64(len(path)) + path for path in paths)]
    return b"".join(lists)


def projection(value: dict) -> bytes:
    [(kind, given)] = value.items()
    plain, aspect = {"perspective": 0, "orthographic": 1}[kind], given.get("aspectRatio")
    head = u8(plain) if aspect is None else u8(plain + 2) + f64(aspect)
    if kind == "orthographic":
        return head + f64(given["ymag"], given["znear"], given["zfar"])
    zfar = given.get("zfar")
    tail = u8(0) + f64(0) if zfar is None else u8(1) + f64(zfar)
    return head + f64(given["yfov"], given["znear"]) + tail


KINDS: dict[str, Callable[[Any], bytes]] = {
    "number": number, "flag": u8, "choice": text, "text": text, "color": vector,
    "vector": vector, "rotation": rotation, "periodicCurve": curve, "links": links,
}  # fmt: skip
CAMERA = {"name": text, "translation": vector, "rotation": rotation, "projection": projection}


# Lights, cameras and pins, from their JSON.


@dataclass
class Parameter:
    """A row of parameters.json, for one type of light or for control points."""

    path: list[str]
    to_bytes: Callable[[Any], bytes]
    default: bytes | None  # None where it has none

    def read(self, value: Any) -> bytes:
        """The value's bytes; `null` is as if it were left out, and that has its default."""
        if value is None and self.default is None:
            raise ValueError(f"a control point is without {self.path[0]}")
        return self.default if value is None else self.to_bytes(value)


def parameters_of(owner: str) -> dict[str, Parameter]:
    """All parameters of a type of light, or of a control point, by ascending name."""
    parameters = {}
    for row in sorted(json.loads(PARAMETERS.read_text("utf-8")), key=lambda row: row["name"]):
        if owner in row["of"]:
            to_bytes, defaults = KINDS[row["kind"]["type"]], row["default"]
            default = to_bytes(defaults[owner]) if owner in defaults else None
            parameters[row["name"]] = Parameter(row["path"].split("/"), to_bytes, default)
    return parameters


OF_LIGHT = {light_type: parameters_of(light_type) for light_type in LIGHT_TYPES}
OF_POINT = parameters_of("point")


@dataclass
class Light:
    type: str
    layout: int
    values: dict[str, bytes]  # of all parameters that its type has, by ascending name
    points: dict[str, list[bytes]]  # of all parameters of control points, by ascending name
    digest: bytes | None = field(default=None, compare=False)  # kept until a value changes


def read_points(given: dict) -> dict[str, list[bytes]]:
    """Control points from one list a parameter, which may be left out or `null` (CMD-11)."""
    points = {}
    for name, parameter in OF_POINT.items():
        [path], count = parameter.path, len(given["points"])
        values = given.get(path)
        points[name] = [parameter.read(v) for v in ([None] * count if values is None else values)]
        if len(points[name]) != count:
            raise ValueError(f"{path} has not one entry for each control point")
    return points


def read_light(placed: dict) -> Light:
    given, light_type = placed["light"], placed["light"]["type"]
    of_point = OF_POINT if light_type == "bendy" else {}
    # What parameters.json does not have would be in no hash, so it must not pass unseen.
    known = [*OF_LIGHT[light_type].values(), *of_point.values()]
    for name in given.keys() - {"type"} - {parameter.path[0] for parameter in known}:
        raise ValueError(f"{PARAMETERS.name} has no {name} for a light of type {light_type}")
    values = {}
    for name, parameter in OF_LIGHT[light_type].items():
        value = given
        for step in parameter.path:
            value = value.get(step) if value else None
        values[name] = parameter.read(value)
    return Light(light_type, placed["layout"], values, read_points(given) if of_point else {})


def read_camera(given: dict) -> dict[str, bytes]:
    """A camera's values in the order in which DOC-4 has them."""
    return {name: to_bytes(given.get(name, "")) for name, to_bytes in CAMERA.items()}


def read_pin(given: dict) -> bytes:
    caster = given.get("caster")
    named = u8(0) + text("") if caster is None else u8(1) + text(caster)
    at, kind = given["at"], PIN_KINDS[given["kind"]]
    # A pin is at a position, or of a node that it names.
    place = u8(NODE_PIN + kind) + text(at) if isinstance(at, str) else u8(kind) + vector(at)
    return u64(given["light"]) + place + named + u8(given["hard"])


# The hash of a document, which is {"scene": as in JSON, and by id "light", "camera" and "pin"}.


def light_digest(light: Light) -> bytes:
    """SHA-256 over a light; what has its default is left out (DOC-4)."""
    if light.digest is None:
        parts = [u8(LIGHT_TYPES[light.type])]
        for name, value in light.values.items():
            if value != OF_LIGHT[light.type][name].default:
                parts += [text(name), value]
        parts.append(u64(len(light.points.get("position", []))))
        for name, values in light.points.items():
            if any(value != OF_POINT[name].default for value in values):
                parts += [text(name), *values]
        light.digest = sha256(b"".join(parts)).digest()
    return light.digest


def document_hash(document: dict[str, Any]) -> str:
    """SHA-256 over the document's content (DOC-4)."""
    scene, parts = document["scene"], [text("bendylights document 3")]
    parts += [u8(1), bytes.fromhex(scene["asset"].removeprefix("sha256:"))] if scene else [u8(0)]
    parts.append(u64(len(document["light"])))
    for id, light in sorted(document["light"].items()):
        parts += [u64(id), u64(light.layout), light_digest(light)]
    parts.append(u64(len(document["camera"])))
    for id, camera in sorted(document["camera"].items()):
        parts += [u64(id), *camera.values()]
    if document["pin"]:
        parts += [text("pins"), u64(len(document["pin"]))]
        for id, pin in sorted(document["pin"].items()):
            parts += [u64(id), pin]
    return sha256(b"".join(parts)).hexdigest()


# Changes (section 3). Each is held to the document before it is applied (REC-3).


def expect(same: bool, what: str, seq: int) -> None:
    if not same:
        raise Fault(f"record {seq} starts from another {what} than the document holds")


def apply(document: dict[str, Any], change: dict, seq: int) -> None:
    """Applies a change of record `seq`."""
    match change["type"]:
        case "scene":
            expect(change.get("old") == document["scene"], "scene", seq)
            document["scene"] = change.get("new")
        case "light" | "camera" | "pin" as what:
            read = {"light": read_light, "camera": read_camera, "pin": read_pin}[what]
            held, id, old, new = document[what], change[what], change.get("old"), change.get("new")
            expect(held.pop(id, None) == (read(old) if old else None), f"{what} {id}", seq)
            if new:
                held[id] = read(new)
        case "cameraParameter":
            [(name, old)], id = change["old"].items(), change["camera"]
            camera = document["camera"].get(id, {})
            expect(camera.get(name) == CAMERA[name](old), f"{name} of camera {id}", seq)
            camera[name] = CAMERA[name](change["new"][name])
        case "lightParameter" | "point" | "controlPoints":
            light = document["light"].get(change["light"])
            expect(light is not None, f"light {change['light']}", seq)
            light.digest = None
            change_light(light, change, seq)
        case other:
            raise ValueError(f"no change has the type {other}")


def change_light(light: Light, change: dict, seq: int) -> None:
    """Applies a change of a part of a light."""
    old, new, of_light = change["old"], change["new"], f"of light {change['light']}"
    if change["type"] == "controlPoints":
        held = (light.layout, light.points)
        expect(held == (old["layout"], read_points(old)), f"control points {of_light}", seq)
        light.layout, light.points = new["layout"], read_points(new)
        return
    [name] = old
    if change["type"] == "lightParameter":
        parameter = OF_LIGHT[light.type][name]
        expect(light.values[name] == parameter.read(old[name]), f"{name} {of_light}", seq)
        light.values[name] = parameter.read(new[name])
    else:
        point, values = change["point"], light.points.get(name, [])
        same = light.layout == change["layout"] and 0 <= point < len(values)
        same = same and values[point] == OF_POINT[name].read(old[name])
        expect(same, f"{name} of control point {point} {of_light}", seq)
        values[point] = OF_POINT[name].read(new[name])


# References (REC-6) are resolved in the text: their hashes are over it, and Python would not write
# every number as the server does. `known` has what was referred to so far, by record and byte.


def in_full(lines: list[bytes], known: dict, seq: int, start: int, end: int) -> bytes:
    """What stands in the line of record `seq` from `start` to `end`, its references resolved."""
    parts, done = [], start
    for reference in REFERENCE.finditer(lines[seq], start, end):
        parts.append(lines[seq][done : reference.start()])
        parts.append(resolve(lines, known, seq, reference))
        done = reference.end()
    parts.append(lines[seq][done:end])
    if sum(len(part) for part in parts) > MOST_BYTES:
        raise Fault(f"record {seq} has more than 32 MiB in full")
    return b"".join(parts)


def resolve(lines: list[bytes], known: dict, seq: int, reference: re.Match[bytes]) -> bytes:
    """The text in full that a reference in the line of record `seq` stands for."""
    record, at = place = int(reference[1]), int(reference[2])
    missing = Fault(f"record {seq} refers to a value that is not at byte {at} of record {record}")
    if place not in known:
        line = lines[record] if 0 < record <= seq else b""
        try:
            # As Latin-1 a byte is a character, so that positions in the text are those of bytes.
            end = json.JSONDecoder().raw_decode(line.decode("latin-1"), at)[1]
        except ValueError:
            raise missing from None
        if record == seq and end > reference.start():  # not "further ahead" in this line
            raise missing
        known[place] = in_full(lines, known, record, at, end)
    if sha256(known[place]).hexdigest().encode() != reference[3]:
        raise missing
    return known[place]


# Log files (section 5).


def parse(line: bytes, where: str) -> dict[str, Any]:
    """The JSON object of a line that has its end (LOG-1)."""
    if line.endswith(b"\r\n"):
        raise Fault(f"{where} ends in CR LF instead of one line feed")
    if not line.endswith(b"\n"):
        raise Fault(f"the log is cut short: {where} does not end in a line feed")
    try:
        value = json.loads(line.decode())
    except (ValueError, RecursionError):
        raise Fault(f"{where} is no JSON") from None
    if not isinstance(value, dict):
        raise Fault(f"{where} is no JSON object")
    return value


def check_format(format: int, taken: tuple[int, ...], what: str) -> None:
    if format not in taken:
        raise OtherFormat(f"{what} is of format {format}, and this reader takes formats 3 to 6")


def check_seq(seq: int, expected: int, what: str) -> None:
    if seq != expected:
        raise Fault(
            f"{what} {seq} stands where {what} {expected} belongs: "
            "a record is missing or out of order"
        )


def check(checkpoint: dict, found: str, proof: str, right: int | None) -> None:
    """Holds the document's hash and the proof to a checkpoint, and tells them apart (LOG-4)."""
    seq, first = checkpoint["seq"], "no checkpoint before that was reached"
    if checkpoint["hash"] != found:
        since = first if right is None else f"it was right after record {right}"
        raise Fault(f"the document after record {seq} is not the one that was logged; {since}")
    if checkpoint["proof"] != proof:
        since = first if right is None else f"they were right up to record {right}"
        raise Fault(f"the lines up to record {seq} are not those that were logged; {since}")


def replay(log: Path, to: int | None) -> dict[str, Any]:
    """Replays a log, up to record `to` where that is given (REC-2, LOG-2)."""
    document: dict[str, Any] = {"scene": None, "light": {}, "camera": {}, "pin": {}}
    seq, checkpoints, right, at_checkpoint = 0, 0, None, False
    with log.open("rb") as file:
        header_line = next(file, b"\n")
        header = parse(header_line, "the header")
        if "format" not in header or "session" not in header:
            raise Fault("the first line is no header")
        check_format(header["format"], (2, 3, 4, 5, 6), "the header")
        lines, known = [header_line[:-1]], {}  # from here on lines[seq] is that of record seq
        proof = sha256(lines[0]).hexdigest() if header["format"] >= 4 else "0" * 64
        for line in file:
            # What stands after record `to`, but for its checkpoint, is not asked for.
            if seq == to and not line.startswith(b'{"checkpoint"'):
                break
            value = parse(line, f"the line after record {seq}")
            try:
                at_checkpoint = "checkpoint" in value
                if at_checkpoint:
                    check_seq(value["checkpoint"]["seq"], seq, "the checkpoint of record")
                    check(value["checkpoint"], document_hash(document), proof, right)
                    right, checkpoints = seq, checkpoints + 1
                    continue
                check_format(value["format"], (3, 4, 5, 6), f"record {value['seq']}")
                check_seq(value["seq"], seq + 1, "record")
                seq += 1
                lines.append(line[:-1])
                full = in_full(lines, known, seq, 0, len(lines[seq]))
                for change in json.loads(full)["changes"]:
                    apply(document, change, seq)
                proof = sha256(proof.encode() + lines[seq]).hexdigest()
            except (AttributeError, LookupError, OverflowError, RecursionError, TypeError,
                    ValueError, struct.error) as error:  # fmt: skip
                what = f"the checkpoint after record {seq}" if at_checkpoint else f"record {seq}"
                reason = f"no {error} is known" if isinstance(error, KeyError) else error
                raise Fault(f"{what} is not as the specification has it: {reason}") from None
    if to is not None and seq < to:
        raise Fault(f"the log ends with record {seq}, before record {to}")
    if to is None and not at_checkpoint:
        raise Fault(f"the log is cut short after record {seq}: its last line is no checkpoint")
    result = {"records": seq, "hash": document_hash(document), "proof": proof}
    return result | {"checkpoints": checkpoints}


def main() -> int:
    arguments = argparse.ArgumentParser(description="Proves the edit log of a session.")
    arguments.add_argument("log", type=Path, metavar="LOG.jsonl")
    arguments.add_argument("--to", type=int, metavar="N", help="stop after record N")
    given = arguments.parse_args()
    try:
        print(json.dumps(replay(given.log, given.to)))
        return 0
    except OtherFormat as sentence:
        print(sentence, file=sys.stderr)
        return 2
    except (Fault, OSError) as sentence:
        print(sentence, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
