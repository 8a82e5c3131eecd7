#!/bin/sh
# Tries the programs of a package: they start, every example is a valid configuration once its key is
# made, and the demo shows frames.
#   deploy/try.sh FOLDER      with the package unpacked in it
set -eu
tribus=$1/usr/bin/tribus

"$tribus" --version
"$1/usr/bin/tribus-web" --version
"$1/usr/bin/tribus-mqtt" --version
examples=$(mktemp -d)
trap 'rm -r "$examples"' EXIT
cp -r "$1"/usr/share/doc/tribus/examples/. "$examples"
"$tribus" key new "$examples/boat.key" >/dev/null
sed -i "s#/etc/tribus/keys/#$examples/#" "$examples"/*.toml
for example in "$examples"/*.toml; do
    "$tribus" check "$example" >/dev/null || {
        echo "deploy/try.sh: the program refuses the example ${example##*/}" >&2
        exit 1
    }
done
# A busy machine may lose frames on their way through its ptys.
for attempt in 1 2 3; do
    "$tribus" demo --seconds 3 && exit
    echo "deploy/try.sh: demo $attempt of 3 failed" >&2
done
exit 1
