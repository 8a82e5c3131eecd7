#!/bin/sh
# Makes the Debian package, tries it and says where it is. --help has the rest.
cd "$(dirname "$0")/.."
. deploy/prepare.sh

usage="Usage: deploy/package.sh [amd64|arm64|armhf] [--release bookworm|trixie] [--tests]
                         [--no-trial]

For this machine's own processor and Debian it packs what is in build/. Else it builds in
build-PROCESSOR-RELEASE/build/ (without the one that is this machine's own). For another processor
it takes that Debian's cross compiler and libraries, and tries the program in an emulated board,
under that Debian's kernel. For another release of Debian it works in a root folder of that Debian
(chroot: as root or with sudo). arm64 is for 64-bit systems, armhf for 32-bit ones from ARMv7 on: a
Raspberry Pi Zero 2, but not a Pi 1 or Zero.

--tests also builds the tests and runs them there, in a board those of the first tier. --no-trial
only makes the package.
Two packages of one commit are the same bytes; SOURCE_DATE_EPOCH is by default the commit's time, and
DEBFULLNAME and DEBEMAIL, who answers for the package, its author's name and address."

# Those that need no tools but their libraries.
test_suites="unit_tests property_tests sim_tests machine_tests loopback_tests"
# How long a guest may take for the demo, or for one of them: 12 minutes on an idle host, more than
# 30 beside other work. Only a guest that hangs takes longer than this.
guest_seconds=7200
# How long the emulated Raspberry Pi may take, in five starts of which each takes half a minute.
raspberry_pi_seconds=900

wrong_use() {
    echo "deploy/package.sh: $*; --help says more" >&2
    exit 2
}

fail() {
    echo "deploy/package.sh: $*" >&2
    exit 1
}

# Time of the files in the package: that of the commit, without git that of the latest version.
commit_seconds() {
    git log -1 --format=%ct 2>/dev/null ||
        date --utc --date="$(sed -n '/^## \[[0-9]/{s/.* - //p;q}' CHANGELOG.md)" +%s
}

# The commit, if these are its files.
clean_commit() {
    [ "$(git rev-parse --show-toplevel 2>/dev/null)" = "$(pwd -P)" ] || return 0
    [ -n "$(git status --porcelain --untracked-files=no)" ] || git rev-parse HEAD
}

cross_compiler() {
    case $wanted in
        "$own") ;;
        arm64) echo g++-aarch64-linux-gnu ;;
        armhf) echo g++-arm-linux-gnueabihf ;;
    esac
}

# make_root: of the wanted Debian, with all that this script needs in there today.
make_root() {
    # shellcheck disable=SC2046,SC2086,SC2154 # lists of words, from deploy/prepare.sh
    packages=$(echo $build_packages $package_packages $test_libraries $(cross_compiler) | tr ' ' ,)
    [ "$(cat "$root/packages" 2>/dev/null)" != "$packages" ] || return 0
    install_packages mmdebstrap
    mkdir -p "$(dirname "$root")"
    as_root rm -rf "$root" "$root.new"
    echo "Making a root of Debian $release in $root" >&2
    as_root mmdebstrap --quiet --variant=apt --architectures="$own" --include="$packages" \
        "$release" "$root.new" >&2
    echo "$packages" | as_root tee "$root.new/packages" >/dev/null
    as_root mv "$root.new" "$root"
}

# in_root WORD...: runs a program there, as this user, in this folder, which has the same path.
in_root() {
    # The mounts are seen by these processes only, and end with them.
    # shellcheck disable=SC2016 # the inner shell's
    as_root unshare --mount sh -eu -c 'user=$1 root=$2 here=$3
        shift 3
        mkdir -p "$root$here"
        mount --bind "$here" "$root$here"
        # Recordings that some tests need lie beside the project.
        if [ -d "$here/../shared" ]; then
            mkdir -p "$root$here/../shared"
            mount --bind "$here/../shared" "$root$here/../shared"
        fi
        for place in dev proc sys; do
            mount --rbind "/$place" "$root/$place"
        done
        exec chroot --userspec="$user" "$root" sh -eu -c "cd \"\$1\"; shift; exec \"\$@\"" \
            sh "$here" "$@"' \
        sh "$(id -u):$(id -g)" "$root" "$(pwd)" "$@"
}

# run_there WORD...: on a machine of the package's kind. $board_clock: of the emulated board.
run_there() {
    if [ "$wanted" != "$own" ]; then
        # shellcheck disable=SC2086 # an option or nothing
        tests/lab/run_board $board_clock "$wanted" "$base/board" $guest_seconds "$@" >&2
    elif [ "$release" != "$own_release" ]; then
        in_root "$@" >&2
    else
        "$@" >&2
    fi
}

# try_raspberry_pi: the program at the ports of an emulated Raspberry Pi 3.
try_raspberry_pi() {
    tests/lab/run_raspi3b "$base/board" $raspberry_pi_seconds "$folder/app/tribus" \
        "$folder/tests/libheap_trap_preload.so" "$folder/tests/allocating_data_thread" -- \
        "$folder/tests/lab/lab_raspi3b_tests" --gtest_brief=1 >&2
}

# build_here: the program, and the tests when asked, in $folder.
build_here() {
    # shellcheck disable=SC2046,SC2086 # lists of words
    install_packages $build_packages $package_packages $(cross_compiler)
    set --
    if [ "$wanted" != "$own" ]; then
        set -- -DTRIBUS_DEBIAN_ARCHITECTURE="$wanted" \
            -DTRIBUS_SYSROOT="$(pwd)/$base/board/sysroot" \
            -DCMAKE_TOOLCHAIN_FILE="$(pwd)/deploy/cross.cmake"
    elif [ $with_tests = ON ]; then
        # shellcheck disable=SC2086
        install_packages $test_libraries
    fi
    # What is in build/ was configured by whoever built it.
    if [ "$folder" != build ] || [ $with_tests = ON ] || [ ! -e build/CMakeCache.txt ]; then
        cmake --preset release -B "$folder" -DTRIBUS_TESTS=$with_tests \
            ${CI:+-DTRIBUS_WERROR=ON} "$@" >&2
    fi
    # shellcheck disable=SC2086 # a list of words
    cmake --build "$folder" --parallel "$(compilers "$with_tests")" --target $targets >&2
}

# pack_here: what is built in $folder.
pack_here() {
    rm -f "$folder"/tribus_*_"$wanted".deb
    (cd "$folder" && cpack -G DEB >&2)
    lintian --fail-on error,warning "$folder"/tribus_*_"$wanted".deb >&2
}

wanted=""
release=""
board_clock=""
with_tests=OFF
with_trial=ON
while [ $# -gt 0 ]; do
    case $1 in
        --help)
            echo "$usage"
            exit 0
            ;;
        --tests) with_tests=ON ;;
        --no-trial) with_trial=OFF ;;
        --release)
            case ${2:-} in
                bookworm | trixie) release=$2 ;;
                *) wrong_use "--release is bookworm or trixie${2:+, not $2}" ;;
            esac
            shift
            ;;
        amd64 | arm64 | armhf) wanted=$1 ;;
        *) wrong_use "knows amd64, arm64 and armhf, not $1" ;;
    esac
    shift
done

own=$(dpkg --print-architecture)
own_release=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
wanted=${wanted:-$own}
release=${release:-$own_release}
[ "$wanted" != amd64 ] || [ "$own" = amd64 ] || wrong_use "makes amd64 on such machines only"
targets="tribus tribus-web tribus-mqtt installed_texts"
[ $with_tests = OFF ] || targets="$targets $test_suites"
# The emulated Raspberry Pi has this processor.
with_ports=$with_tests
[ "$wanted" = arm64 ] && [ "$wanted" != "$own" ] || with_ports=OFF
[ $with_ports = OFF ] || targets="$targets lab_raspi3b_tests"

# From the caller, where this script runs in the root of another release.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(commit_seconds)}
name_maintainer
export SOURCE_DATE_EPOCH DEBFULLNAME DEBEMAIL
# What the programs say of themselves, also where it is built without git (app/build_facts.cmake).
TRIBUS_COMMIT=${TRIBUS_COMMIT:-$(clean_commit)}
export TRIBUS_COMMIT
base=${TRIBUS_PACKAGE_BASE:-build}
if [ "$base" = build ]; then
    [ "$wanted" = "$own" ] || base=$base-$wanted
    [ "$release" = "$own_release" ] || base=$base-$release
fi
folder=$base/build
[ "$base" != build ] || folder=build
root=$base/root

# In the root of another release the caller has built it.
[ -n "${TRIBUS_PACKAGE_BASE:-}" ] || build_page
[ "$wanted" = "$own" ] || tests/lab/prepare_board.sh "$wanted" "$base/board" "$release"
if [ "$release" != "$own_release" ]; then
    make_root
    [ $with_tests = OFF ] || set -- --tests
    in_root env TRIBUS_PACKAGE_BASE="$base" SOURCE_DATE_EPOCH="$SOURCE_DATE_EPOCH" \
        DEBFULLNAME="$DEBFULLNAME" DEBEMAIL="$DEBEMAIL" CI="${CI:-}" TRIBUS_COMMIT="$TRIBUS_COMMIT" \
        deploy/package.sh "$wanted" --no-trial "$@" >&2
else
    build_here
    pack_here
fi

package=$(echo "$folder"/tribus_*_"$wanted".deb)
if [ $with_trial = ON ]; then
    unpacked=$folder/unpacked
    rm -rf "$unpacked"
    dpkg-deb -x "$package" "$unpacked"
    # The demo runs in real time, for which an emulator beside other work is too slow.
    board_clock=--counted-clock
    run_there deploy/try.sh "$unpacked" || fail "its trial failed"
fi
if [ $with_tests = ON ] && [ $with_trial = ON ]; then
    for suite in $test_suites; do
        echo "Tests: $suite" >&2
        board_clock=""
        # These have parts that run in real time, for which an emulator is too slow.
        case $suite in machine_tests | loopback_tests) board_clock=--counted-clock ;; esac
        left_out="InitTextOfEverySet.*"
        # A board runs neither suites that only compute for longer than others of the same kind (the
        # second tier) nor those that read texts, which are the same on every processor: there they
        # take half of the time.
        [ "$wanted" = "$own" ] ||
            left_out="$(cat "$folder/tests/$suite.long"):InitText.*:References.*:Tidy.*:Tables.*"
        # What pages show of running programs is the same everywhere, and an emulator is slow for it.
        left_out="$left_out:LivePageExamples.*"
        run_there "$folder/tests/$suite" --gtest_brief=1 "--gtest_filter=-$left_out" ||
            fail "$suite failed"
    done
    if [ $with_ports = ON ]; then
        echo "Tests: at the ports of an emulated Raspberry Pi 3" >&2
        try_raspberry_pi || fail "the tests at the ports of a Raspberry Pi 3 failed"
    fi
fi
echo "$package"
