# What both hours share. Sourced from the checkout's root.

work=$(mktemp -d)
server=

# Stops the server as a service manager does, and waits until it has ended.
stop() {
  [[ $server ]] || return 0
  kill -TERM -- "-$server" 2> /dev/null || true
  wait "$server" || true
  server=
}
trap 'stop; rm -rf "$work"' EXIT
# Each server has a process group of its own, so that one `kill` reaches it behind `make` too.
set -m

step() { echo "== $*"; }
fail() { echo "error: $*" >&2; cat "$work/said" >&2 || true; exit 1; }
same() { [[ $1 == "$2" ]] || fail "$3: $1, and it should be $2"; }
holds() { [[ $1 == *"$2"* ]] || fail "$3: \`$2\` is missing from: $1"; }

# Starts a command that serves, waits for the address that it prints, and sets $host and $auth.
start() {
  # The address of the server before would be taken for this one's.
  : > "$work/printed"
  "$@" > "$work/printed" 2> "$work/said" &
  server=$!
  until address=$(grep -m 1 '^http' "$work/printed"); do
    kill -0 "$server" 2> /dev/null || fail "\`$*\` has ended"
    sleep 0.1
  done
  host=${address%%/#*}
  auth="Authorization: Bearer $(sed 's/.*#token=\([0-9a-f]*\).*/\1/' <<< "$address")"
  for _ in {1..600}; do
    curl -sf "$host/readyz" > /dev/null && return
    sleep 0.1
  done
  fail "it is not ready within a minute"
}

# A field of a JSON object on standard input: `field seq`.
field() { python3 -c 'import json, sys; print(json.load(sys.stdin)[sys.argv[1]])' "$1"; }
ask() { curl -sf -H "$auth" "$host$1" "${@:2}"; }
