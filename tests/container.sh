#!/usr/bin/env bash
# Runs the last stage of deploy/Containerfile, step by step, in a Debian root that mmdebstrap makes, and serves from it as the
# image would: for machines that build no images. As root, with a program that was built before:
#   tests/container.sh target/release/bendylights
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "$0")/.."
root=$(mktemp -d)
server=
clean() {
  if [[ $server ]]; then kill -TERM "$server" 2> /dev/null || true; wait "$server" || true; fi
  umount "$root/proc" 2> /dev/null || true
  rm -rf --one-file-system "$root"
}
trap clean EXIT
fail() { echo "error: $*" >&2; exit 1; }

# The stage's instructions, a line each.
stage=$(sed -e ':a' -e '/\\$/N; s/\\\n *//; ta' deploy/Containerfile | grep -v '^#' | tac | sed '/^FROM/q' | tac)
release=$(sed -n 's/^FROM .*debian:\([a-z]*\)-slim$/\1/p' <<< "$stage")
[[ $release ]] || fail "the last stage is of no slim Debian"
echo "== a root of $release"
mmdebstrap --quiet --variant=minbase --format=directory "$release" "$root"
mount -t proc proc "$root/proc"

user=root folder=/ settings=(PATH=/usr/local/bin:/usr/bin:/bin) entry= command= health=
words() { python3 -c 'import json, sys; print("\0".join(json.loads(sys.argv[1])), end="\0")' "$1"; }
while read -r instruction rest; do
  echo "== $instruction $rest"
  case $instruction in
    FROM | VOLUME | EXPOSE | STOPSIGNAL | "") ;;
    RUN) chroot "$root" sh -ec "$rest" ;;
    COPY) [[ $rest == --from=build* ]] || fail "COPY $rest"
          install -m 755 "$program" "$root${rest##* }" ;;
    USER) user=$rest ;;
    ENV) settings+=("$rest") ;;
    WORKDIR) folder=$rest ;;
    ENTRYPOINT) entry=$rest ;;
    CMD) command=$rest ;;
    HEALTHCHECK) health=${rest#*CMD } ;;
    *) fail "no step is known for $instruction" ;;
  esac
done <<< "$stage"

inside=(chroot --userspec="$user" "$root" env -i -C "$folder" "${settings[@]}")
mapfile -d '' -t serve < <(words "$entry"; words "$command")
mapfile -d '' -t check < <(words "$health")
if "${inside[@]}" "${check[@]}" 2> /dev/null; then fail "another server has port 8080"; fi
"${inside[@]}" "${serve[@]}" > "$root/printed" 2> "$root/said" &
server=$!
for _ in {1..300}; do
  if "${inside[@]}" "${check[@]}" 2> /dev/null; then break; fi
  kill -0 "$server" || { cat "$root/said" >&2; fail "it has ended"; }
  sleep 0.1
done
"${inside[@]}" "${check[@]}" || { cat "$root/said" >&2; fail "it is not healthy"; }
cat "$root/printed"
tail -n 1 "$root/said"
token=$("${inside[@]}" cat /var/lib/bendylights/token)
curl -sf -H "Authorization: Bearer $token" "http://127.0.0.1:8080/sessions/main/render?size=160x90" -o "$root/picture.png"
[[ $(head -c 4 "$root/picture.png" | tail -c 3) == PNG ]] || fail "no picture"
[[ $(find "$root/var/cache/bendylights" -type f | wc -l) -gt 0 ]] || fail "no compiled shaders are kept"
[[ $(stat -c %u "$root/var/lib/bendylights/token") -eq 10001 ]] || fail "it runs as somebody else"
echo "== done: healthy, a picture, shaders kept, as $user"
