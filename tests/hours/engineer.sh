#!/usr/bin/env bash
# A pipeline engineer's first hour: a test of a log in pytest, a bundle, a picture of a shot's past, a backup while it is
# served, failures as JSON, and a folder of an earlier version. It takes the program and a Python that has pytest:
#   tests/hours/engineer.sh target/release/bendylights python3
set -euo pipefail
bendylights=$(realpath "$1")
# A virtual environment's Python is a link, which must stay one.
python=$(realpath --no-symlinks "$(command -v "$2")")
cd "$(dirname "$0")/../.."
source tests/hours/common.sh
root=$PWD
cd "$work"

step "a shot is lit by a program"
start "$bendylights" serve --data data --listen 0 --scene demo:vases
for exposure in 0.5 1 1.5; do
  ask /sessions/main/edits --json "{\"edits\": [{\"command\":
    {\"type\": \"set\", \"target\": \"/lights/1/exposure\", \"value\": $exposure}}]}" > /dev/null
done
hash=$(ask /sessions/main | field hash)

step "its log is proven in pytest"
"$bendylights" export main --data data -o main.jsonl
cat > test_shot.py <<TEST
import json, pathlib, subprocess, sys

HERE = pathlib.Path("$work")
REPLAY = pathlib.Path("$root/protocol/examples/replay.py")


def test_the_log_comes_to_the_server_s_document():
    found = json.loads(subprocess.check_output([sys.executable, REPLAY, HERE / "main.jsonl"]))
    assert (found["records"], found["hash"]) == (4, "$hash")


def test_a_changed_value_is_seen(tmp_path):
    changed = tmp_path / "changed.jsonl"
    changed.write_bytes((HERE / "main.jsonl").read_bytes().replace(b'"exposure":1.5', b'"exposure":1.6'))
    done = subprocess.run([sys.executable, REPLAY, changed], capture_output=True, text=True)
    assert done.returncode == 1 and "record" in done.stderr, done.stderr
TEST
"$python" -m pytest -q -p no:cacheprovider test_shot.py > pytest.txt || { cat pytest.txt >&2; fail "pytest"; }
holds "$(cat pytest.txt)" "2 passed" "pytest"

step "a bundle goes to another machine, and a picture is made of the shot's past"
"$bendylights" export main --data data -o main.zip
"$bendylights" import main.zip --data other > /dev/null
holds "$("$bendylights" sessions --data other)" "$hash" "the sessions there"
"$bendylights" replay main.jsonl --to 2 --render past.png --size 160x90 --samples 4 > /dev/null 2> said

step "a backup while it is served, and a server over it"
"$bendylights" backup backups/monday --data data > backup.json
same "$(field records < backup.json)" 4 "the records of the backup"
stop
start "$bendylights" serve --data backups/monday --listen 0
same "$(ask /sessions/main | field hash)" "$hash" "the document of the backup"
stop

step "a failure as JSON"
if "$bendylights" --json render nowhere.glb -o x.png 2> failure.json; then fail "a scene that is nowhere is drawn"; fi
holds "$(cat failure.json)" '"exitCode":2' "the failure"

step "a folder of an earlier version"
cp -r "$root/tests/folders/2f44318" old
chmod -R u+w old
start "$bendylights" serve --data old --listen 0
while read -r session records hash; do
  same "$(ask "/sessions/$session" | field seq)" "$records" "the records of $session"
  ask "/sessions/$session/edits" --json '{"edits": [{"undo": "mine"}, {"redo": "mine"}]}' > /dev/null
  "$bendylights" export "$session" --data old -o "$session.jsonl"
  same "$("$bendylights" replay "$session.jsonl" --to "$records" | field hash)" "$hash" "the document of $session"
  "$python" "$root/protocol/examples/replay.py" "$session.jsonl" > /dev/null 2> said || code=$?
  # Records of formats before 3 are this program's to read (REC-5).
  [[ ${code:-0} == 0 || $code == 2 ]] || fail "replay.py on $session"
done < "$root/tests/folders/2f44318.txt"
stop
step "done"
