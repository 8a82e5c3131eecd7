#!/bin/sh
# Installs what is needed from Debian's packages, builds tribus, and runs its demo.
# Arguments go to the demo: deploy/demo.sh --seconds 20
# deploy/demo.sh --web shows the page before a daemon with the demo's receiver and servos, and prints
# its address and a code. It builds the page, too (app/web/build.sh).
cd "$(dirname "$0")/.."
. deploy/prepare.sh
# shellcheck disable=SC2086 # a list of words
install_packages $build_packages
if [ "${1:-}" != --web ]; then
    build OFF tribus
    exec build/app/tribus demo "$@"
fi
shift
build OFF tribus tribus-web
build_page

folder=$(mktemp -d)
# Also the folder of the control socket, with the name of the daemon.
mkdir "$folder/demo" "$folder/state"
export RUNTIME_DIRECTORY="$folder/demo"
file=$folder/demo.toml
programs=""
end() {
    trap - EXIT INT TERM
    # shellcheck disable=SC2086 # a list of numbers
    kill $programs 2>/dev/null || true
    wait
    rm -rf "$folder"
}
trap end EXIT
trap 'end; exit 0' INT TERM

# wait_for FILE: until a program has made it.
wait_for() {
    for _ in $(seq 50); do
        [ ! -s "$1" ] && [ ! -S "$1" ] || return 0
        sleep 0.1
    done
    echo "deploy/demo.sh: $1 did not come" >&2
    exit 1
}

build/app/tribus demo --far-ends "$file" "$@" >/dev/null &
programs="$programs $!"
wait_for "$file"
build/app/tribus run "$file" &
programs="$programs $!"
wait_for "$folder/demo/control"
build/app/tribus-web serve --configurations "$folder" --state "$folder/state" \
    --page app/web/page/dist &
page=$!
programs="$programs $page"
sleep 0.5
kill -0 $page 2>/dev/null || exit 1
build/app/tribus pair --state "$folder/state" --configurations "$folder"
echo "Ctrl-C ends the demo." >&2
wait $page
