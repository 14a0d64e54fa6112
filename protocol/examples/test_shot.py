#!/usr/bin/env python3
"""An edit log as a test case: the shot stays the one that was approved.

    python3 test_shot.py

`bendylights export SESSION -o shot.jsonl` writes such a log. Keep it beside the tests of a
pipeline with the hash that `bendylights replay` prints, and replay it wherever it must hold.
"""

import tempfile
import unittest
from pathlib import Path

from replay import Fault, replay

LOG = Path(__file__).parent.parent / "vectors" / "logs" / "lights.jsonl"
APPROVED = "4cef41e8e43f59032578a84254cd636b1a1de5354c17c10f528e8b6f0e51b947"


class Shot(unittest.TestCase):
    """Replays a log without a server."""

    def test_the_document_is_the_approved_one(self) -> None:
        self.assertEqual(replay(LOG, to=None)["hash"], APPROVED)

    def test_an_earlier_step_is_another_document(self) -> None:
        self.assertNotEqual(replay(LOG, to=1)["hash"], APPROVED)

    def test_a_changed_value_is_caught(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            changed = Path(folder) / "changed.jsonl"
            changed.write_text(LOG.read_text().replace('"height":3.0', '"height":3.5', 1))
            with self.assertRaises(Fault):
                replay(changed, to=None)


if __name__ == "__main__":
    unittest.main()
