#!/usr/bin/env python3
"""Lights a scene over HTTP and renders it, with Python's standard library alone.

    python3 light_a_scene.py http://127.0.0.1:8080 TOKEN_FILE OUT.png [SESSION]

Makes a session of the demo (shot-030 unless it is named), adds a spotlight, bends it, drags the
shadow of a vase, and writes a picture. TOKEN_FILE is `token` in the server's data folder. Prints
the session and how the drag ended. What the server refuses ends it with the server's sentence and
exit code 1.
"""

import argparse
import json
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

SIZE = [640, 360]


class Session:
    """A session of a server, made anew."""

    def __init__(self, server: str, token: str, name: str, scene: str) -> None:
        self.server, self.token = server.rstrip("/"), token
        self.document = self.ask("/sessions", {"name": name, "scene": scene})["document"]
        self.path = f"/sessions/{name}"

    def ask(self, path: str, body: Any = None) -> Any:
        """Sends `body` as JSON, or a GET without one, and gives the answer's JSON or bytes."""
        headers = {"authorization": f"Bearer {self.token}", "content-type": "application/json"}
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.server + path, data, headers)
        with urllib.request.urlopen(request) as answer:
            kind, content = answer.headers["content-type"], answer.read()
        return json.loads(content) if kind.startswith("application/json") else content

    def edit(self, command: dict[str, Any]) -> dict[str, Any]:
        """Carries out one command and gives its result: the record's number, and ids of what is new."""
        (result,) = self.ask(f"{self.path}/edits", {"edits": [{"command": command}]})["results"]
        if result["status"] == "rejected":
            raise SystemExit(result["message"])
        return result

    def picture(self, samples: int) -> bytes:
        """Renders the document as PNG."""
        width, height = SIZE
        return self.ask(f"{self.path}/render?size={width}x{height}&samples={samples}")


def main() -> None:
    arguments = argparse.ArgumentParser(description="Lights the demo over HTTP and renders it.")
    arguments.add_argument("server", help="http://HOST:PORT")
    arguments.add_argument("token_file", type=Path)
    arguments.add_argument("out", metavar="OUT.png")
    arguments.add_argument("session", nargs="?", default="shot-030")
    given = arguments.parse_args()
    shot = Session(given.server, given.token_file.read_text().strip(), given.session, "demo:vases")
    rim = {
        "type": "spot",
        "name": "rim",
        "intensity": 60,
        "coneAngle": 30,
        "transform": {"translation": [2.6, 3.4, 1.6], "rotation": [-0.354, 0.354, 0.146, 0.854]},
    }
    light = shot.edit({"type": "addLight", "light": rim})["added"]["lights"][0]
    shot.edit({"type": "bendLight", "light": light})
    camera = shot.document["cameras"][0]["camera"]
    drag = {"kind": "shadow", "points": [1, 2, 3, 4], "camera": camera, "size": SIZE}
    drag |= {"from": [275, 190], "to": [270, 220]}
    outcome = shot.edit({"type": "dragFeature", "light": light, **drag})["outcome"]
    with open(given.out, "wb") as file:
        file.write(shot.picture(samples=4))
    print(json.dumps({"session": shot.path, "drag": outcome["status"], "picture": given.out}))


if __name__ == "__main__":
    try:
        main()
    except urllib.error.HTTPError as refusal:
        raise SystemExit(json.load(refusal)["error"]["message"]) from refusal
    except (OSError, urllib.error.URLError) as failure:
        raise SystemExit(f"{failure}: is the server there, and the token file?") from failure
