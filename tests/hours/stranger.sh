#!/usr/bin/env bash
# A stranger's first hour, from a checkout: `make demo`, the page, ten lines of curl, a restart on the same folder, and a
# scene of one's own. `tests/hours/stranger.sh dev` takes the build of the tests.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-release}
source tests/hours/common.sh

step "make demo"
start make demo PROFILE="$profile" DATA="$work/demo" LISTEN=0
page=$(curl -sf "$host/")
holds "$page" "BendyLights" "the page"
script=$(grep -o '/assets/[^"]*\.js' <<< "$page" | head -n 1)
curl -sf "$host$script" > /dev/null || fail "the page's script $script"

step "ten lines of curl"
holds "$(ask /sessions)" '"main"' "the sessions"
ask /sessions --json '{"name": "shot-010", "scene": "demo:vases"}' > /dev/null
ask "/sessions/shot-010/render?size=160x90" -o "$work/before.png"
ask /sessions/shot-010/edits --json '{"edits": [{"command": {"type": "set", "target": "/lights/1/exposure", "value": 2}}]}' > /dev/null
ask "/sessions/shot-010/render?size=160x90" -o "$work/after.png"
cmp -s "$work/before.png" "$work/after.png" && fail "a light two stops brighter looks the same"
ask /sessions/shot-010/edits --json '{"edits": [{"undo": "mine"}]}' > /dev/null
ask "/sessions/shot-010/render?size=160x90" -o "$work/undone.png"
cmp -s "$work/before.png" "$work/undone.png" || fail "what was undone looks another way than before"
holds "$(ask /sessions/shot-010/log)" '"seq":3' "the log"
holds "$(ask /sessions/shot-010/nodes)" 'vase' "the scene's nodes"
holds "$(ask /metrics)" 'bendylights_edits_total{outcome="committed"}' "the metrics"

step "a restart on the same folder"
before=$(ask /sessions/shot-010 | field hash)
stop
start make demo PROFILE="$profile" DATA="$work/demo" LISTEN=0
same "$(ask /sessions/shot-010 | field hash)" "$before" "the document after a restart"
stop

step "a scene of one's own"
if [[ $profile == dev ]]; then folder=debug; else folder=$profile; fi
bendylights=$(realpath "${CARGO_TARGET_DIR:-target}/$folder/bendylights")
cd "$work"
"$bendylights" example mine > /dev/null
"$bendylights" render mine/room.glb --lights mine/lights.json --size 160x90 -o room.png 2> "$work/said"
"$bendylights" bend --scene mine/room.glb --light lamp > bent.json 2>> "$work/said"
"$bendylights" render mine/room.glb --lights bent.json --size 160x90 -o bent.png 2>> "$work/said"
start "$bendylights" serve --data demo --listen 0 --scene mine/room.glb
holds "$(cat "$work/said")" 'is served as session `room`' "the note on where the scene is"
holds "$address" '&session=room' "the address"
holds "$(ask /sessions/room)" '"room.glb"' "the session"
stop
step "done"
