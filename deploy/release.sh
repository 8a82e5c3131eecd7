#!/bin/sh
# Makes the packages of a release and says what it did. --help has the rest.
# shellcheck disable=SC2317 # step calls functions by their names
cd "$(dirname "$0")/.."
. deploy/prepare.sh

usage="Usage: deploy/release.sh [--twice] [--tests] [PACKAGE...]

Makes the packages of the last commit for amd64, arm64 and armhf, for Debian 12 (bookworm) and
13 (trixie); what is not committed is left out. PACKAGE names some of them, as arm64-bookworm. Each
is made from scratch, checked by lintian and tried, those of boards in an emulated board
(deploy/package.sh). The packages are in build-release/VERSION/ then, with SHA256SUMS and
report.txt. Needs Debian on amd64, and root or sudo.

--twice makes each a second time, in another folder, and compares the bytes.
--tests runs the tests of each where it is tried. In an emulated board that takes an hour or more.

What was done for this commit is not done again: after an interruption or a failure the same command
goes on. It ends with 1 if something failed; the rest is done nevertheless."

all_packages="amd64-bookworm arm64-bookworm armhf-bookworm amd64-trixie arm64-trixie armhf-trixie"
place=build-release
first=$place/first/tribus
second=$place/second/of/another/length/tribus

# lay_out FOLDER: the commit's files, with new times. Keeps roots and boards of the commit before.
lay_out() {
    [ "$(cat "$1/.commit" 2>/dev/null)" != "$commit" ] || return 0
    mkdir -p "$1"
    find "$1" -mindepth 1 -maxdepth 1 ! -name 'build-*' -exec rm -rf {} +
    rm -rf "$1"/build-*/build
    git archive "$commit" | tar -x -m -C "$1"
    # Recordings that some tests need lie beside the project.
    [ ! -e ../shared ] || ln -sfn "$(realpath ../shared)" "$1/../shared"
    echo "$commit" >"$1/.commit"
}

# package_sh FOLDER OPTION...: prints the path of the package.
package_sh() (
    cd "$1" && shift &&
        SOURCE_DATE_EPOCH=$commit_seconds TRIBUS_COMMIT=$commit \
            deploy/package.sh "${package%-*}" --release "${package#*-}" "$@"
)

# file_of FOLDER: the package's path there.
file_of() {
    case $package in
        *-trixie) echo "$1"/tribus_*+deb13_"${package%-*}".deb ;;
        *) echo "$1/tribus_${version}_${package%-*}.deb" ;;
    esac
}

make_it() {
    lay_out "$first" && made=$(package_sh "$first") && cp "$first/$made" "$results" &&
        echo "${made%%/*}" >"$done/$package.folder"
}

# The root of the first time does for the second: a package knows nothing of it. Libraries of boards
# are found by paths, so they get others.
make_it_again() {
    lay_out "$second" && folder=$(cat "$done/$package.folder") || return 1
    mkdir -p "$second/$folder"
    [ ! -e "$first/$folder/root" ] ||
        ln -sfn "$(realpath "$first/$folder/root")" "$second/$folder/root"
    if [ -e "$first/$folder/board" ]; then
        rm -rf "$second/$folder/board" &&
            cp -al "$first/$folder/board" "$second/$folder/board" || return 1
    fi
    made=$(package_sh "$second" --no-trial) && same "$(file_of "$results")" "$second/$made"
}

# same PACKAGE PACKAGE: or says what differs.
same() (
    sha256sum "$1" "$2"
    ! cmp -s "$1" "$2" || exit 0
    differing=$(mktemp -d)
    trap 'rm -rf "$differing"' EXIT
    dpkg-deb --raw-extract "$1" "$differing/first"
    dpkg-deb --raw-extract "$2" "$differing/second"
    cd "$differing"
    echo "The two packages are not the same bytes. What differs in them:"
    diff -rq first second
    diff first/DEBIAN/control second/DEBIAN/control
    for side in first second; do
        find "$side" -type d -printf '%M %P\n' -o -printf '%M %s %T@ %P\n' | sort >"$side.list"
        strings -a "$side/usr/bin/tribus" >"$side.strings"
    done
    diff first.list second.list
    echo "Texts in the program, the first of those that differ:"
    diff first.strings second.strings | head -n 20
    echo "diffoscope tells more."
    exit 1
)

run_tests() {
    lay_out "$first" && package_sh "$first" --tests
}

# step WHAT COMMAND: unless it was done for this commit. What it says goes into a file.
step() {
    done_file=$done/$package.$1
    log=$place/logs/$package.$1
    [ ! -e "$done_file" ] || return 0
    echo "$(date +%T) $package: $1 ($log)" >&2
    begun=$(date +%s)
    if "$2" >"$log" 2>&1; then
        echo "$(($(date +%s) - begun)) s" >"$done_file"
    else
        echo "failed" >"$done_file.failed"
        echo "$(date +%T) $package: $1 failed. The end of $log:" >&2
        tail -n 20 "$log" >&2
        return 1
    fi
}

# outcome WHAT: how long it took, or what became of it.
outcome() {
    cat "$done/$package.$1" 2>/dev/null || cat "$done/$package.$1.failed" 2>/dev/null || echo "-"
}

report() {
    echo "tribus $version, commit $commit"
    printf '%-15s %-8s %-8s %-8s %s\n' package made twice tests "SHA-256 (first 16)"
    for package in $all_packages; do
        file=$(file_of "$results")
        sum=""
        [ ! -e "$file" ] || sum=$(sha256sum "$file" | cut -c 1-16)
        printf '%-15s %-8s %-8s %-8s %s\n' "$package" "$(outcome made)" "$(outcome twice)" \
            "$(outcome tests)" "$sum"
    done
    echo "made: with lintian and its trial; twice: the same bytes from another folder;"
    echo "tests: the tests of the program, there where it was tried; -: was not asked for."
}

wanted=""
twice=no
tests=no
while [ $# -gt 0 ]; do
    case " $all_packages " in
        *" $1 "*) wanted="$wanted $1" ;;
        *)
            case $1 in
                --help)
                    echo "$usage"
                    exit 0
                    ;;
                --twice) twice=yes ;;
                --tests) tests=yes ;;
                *)
                    echo "deploy/release.sh: knows $all_packages, not $1; --help says more" >&2
                    exit 2
                    ;;
            esac
            ;;
    esac
    shift
done

install_packages git
commit=$(git rev-parse HEAD)
commit_seconds=$(git log -1 --format=%ct)
name_maintainer
export DEBFULLNAME DEBEMAIL
version=$(git show HEAD:CMakeLists.txt | sed -n 's/^project(tribus VERSION \([0-9.]*\).*/\1/p')
results=$place/$version
done=$place/done/$commit
mkdir -p "$done" "$place/logs" "$results"
[ -z "$(git status --porcelain)" ] ||
    echo "There are changes that are not committed: the packages are without them." >&2
# Packages of another commit under the same names would not be what the report says.
[ "$(cat "$results/commit" 2>/dev/null)" = "$commit" ] || rm -f "$results"/*
echo "$commit" >"$results/commit"

failed=0
for package in ${wanted:-$all_packages}; do
    rm -f "$done/$package".*.failed
    [ -e "$(file_of "$results")" ] || rm -f "$done/$package".*
    step made make_it || {
        failed=1
        continue
    }
    [ $twice = no ] || step twice make_it_again || failed=1
    [ $tests = no ] || step tests run_tests || failed=1
done

rm -f "$results/SHA256SUMS"
(cd "$results" && find . -name '*.deb' -printf '%P\n' | sort | xargs -r sha256sum >SHA256SUMS)
report | tee "$results/report.txt"
echo "They are in $results." >&2
exit $failed
