#!/usr/bin/env python3
"""Lights a scene over HTTP and renders it, with Python's standard library alone.

    python3 light_a_scene.py http://127.0.0.1:8080 TOKEN OUT.png

Makes a session of the demo, adds a spotlight, bends it, drags the shadow of a vase, and writes a
picture. Prints the session's name and how the drag ended. A refused request ends it with the
server's sentence and exit code 1.
"""

import json
import sys
import urllib.error
import urllib.request
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
        if "error" in result:
            raise SystemExit(result["error"]["message"])
        return result

    def picture(self, samples: int) -> bytes:
        """Renders the document as PNG."""
        width, height = SIZE
        return self.ask(f"{self.path}/render?size={width}x{height}&samples={samples}")


def main() -> None:
    server, token, out = sys.argv[1:]
    shot = Session(server, token, "shot-030", "demo:vases")
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
    drag |= {"from": [275, 190], "to": [260, 235]}
    outcome = shot.edit({"type": "dragFeature", "light": light, **drag})["outcome"]
    with open(out, "wb") as file:
        file.write(shot.picture(samples=4))
    print(json.dumps({"session": shot.path, "drag": outcome["status"], "picture": out}))


if __name__ == "__main__":
    try:
        main()
    except urllib.error.HTTPError as refusal:
        raise SystemExit(json.load(refusal)["error"]["message"]) from refusal
