#!/bin/sh
# Prints a package's changelog in Debian's form: the versions and dates of CHANGELOG.md, which is in
# the package too.
#   deploy/debian/changelog.sh CHANGELOG.md VERSION MAINTAINER
# A VERSION that CHANGELOG.md does not have is UNRELEASED, of the time SOURCE_DATE_EPOCH.
set -eu
changes=$1
version=$2
maintainer=$3
export LC_ALL=C

# entry VERSION DISTRIBUTION DATE
entry() {
    printf 'tribus (%s) %s; urgency=medium\n\n  * %s\n\n -- %s  %s\n' "$1" "$2" \
        "/usr/share/doc/tribus/CHANGELOG.md says what users notice." "$maintainer" \
        "$(date --utc --date="$3" --rfc-email)"
}

released=$(sed -n 's/^## \[\([0-9.]*\)\] - \([0-9-]*\)$/\1 \2/p' "$changes")
plain=${version%%+*}
first=yes
case "$released" in
    "$plain "*) ;;
    *)
        entry "$version" UNRELEASED "@${SOURCE_DATE_EPOCH:-$(date +%s)}"
        first=no
        ;;
esac
echo "$released" | while read -r number day; do
    if [ $first = yes ]; then
        number=$version
    else
        echo
    fi
    entry "$number" stable "$day"
    first=no
done
