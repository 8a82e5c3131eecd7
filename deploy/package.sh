#!/bin/sh
# Makes the Debian package, tries it and says where it is. --help has the rest.
cd "$(dirname "$0")/.."
. deploy/prepare.sh

usage="Usage: deploy/package.sh [amd64|arm64|armhf] [--release bookworm|trixie] [--tests]

For this machine's own processor and Debian it packs what is in build/. For another processor it
builds in build-PROCESSOR/ with Debian 12's cross compiler and libraries, and runs the program in an
emulator, under that Debian's kernel. For another release of Debian it builds in
build-RELEASE/build/, in a root folder of that Debian (chroot: as root or with sudo). arm64 is for
64-bit systems, armhf for 32-bit ones from ARMv7 on: a Raspberry Pi Zero 2, but not a Pi 1 or Zero.

--tests also builds the tests and runs them there."

# Those that need no tools but their libraries.
test_suites="unit_tests property_tests sim_tests loopback_tests"
# How long a guest may take for the demo, or for one of them.
guest_seconds=1800

wrong_use() {
    echo "deploy/package.sh: $*; --help says more" >&2
    exit 2
}

fail() {
    echo "deploy/package.sh: $*" >&2
    exit 1
}

# root FOLDER: of the wanted Debian, with all that this script needs in there.
root() {
    [ ! -e "$1" ] || return 0
    mkdir -p "$(dirname "$1")"
    as_root rm -rf "$1.new"
    echo "Making a root of Debian $release in $1" >&2
    # shellcheck disable=SC2086 # lists of words, from deploy/prepare.sh
    as_root mmdebstrap --quiet --variant=apt --architectures="$wanted" \
        --include="$(echo $build_packages $package_packages $test_libraries | tr ' ' ,)" \
        "$release" "$1.new" >&2
    as_root mv "$1.new" "$1"
}

# in_root FOLDER WORD...: this script there, as this user, with the folder's own build/.
in_root() {
    mkdir -p build "$1/build"
    # The mounts are seen by these processes only, and end with them.
    # shellcheck disable=SC2016 # the inner shell's
    as_root unshare --mount sh -eu -c 'user=$1 folder=$2
        shift 2
        mount --bind . "$folder/root/mnt"
        mount --bind "$folder/build" "$folder/root/mnt/build"
        for place in dev proc sys; do
            mount --rbind "/$place" "$folder/root/$place"
        done
        exec chroot --userspec="$user" "$folder/root" /mnt/deploy/package.sh "$@"' \
        sh "$(id -u):$(id -g)" "$@"
}

# run_there WORD...: on a machine of the package's kind.
run_there() {
    if [ "$wanted" = "$own" ]; then
        "$@" >&2
    else
        tests/lab/run_board "$wanted" "$folder" $guest_seconds "$@" >&2
    fi
}

# build_across: with the cross compiler, in $folder.
build_across() {
    case $wanted in
        arm64) install_packages g++-aarch64-linux-gnu ;;
        armhf) install_packages g++-arm-linux-gnueabihf ;;
    esac
    tests/lab/prepare_board.sh "$wanted" "$folder"
    cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTRIBUS_TESTS="$with_tests" \
        -DTRIBUS_DEBIAN_ARCHITECTURE="$wanted" -DTRIBUS_SYSROOT="$(pwd)/$folder/sysroot" \
        -DCMAKE_TOOLCHAIN_FILE="$(pwd)/deploy/cross.cmake" ${CI:+-DTRIBUS_WERROR=ON} >&2
    # shellcheck disable=SC2086 # a list of words
    cmake --build "$folder" --target $targets >&2
}

wanted=""
release=""
with_tests=OFF
while [ $# -gt 0 ]; do
    case $1 in
        --help)
            echo "$usage"
            exit 0
            ;;
        --tests) with_tests=ON ;;
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
targets="tribus installed_texts"
[ $with_tests = OFF ] || targets="$targets $test_suites"

if [ "$wanted" != "$own" ]; then
    [ "$release" = "$own_release" ] || [ "$release" = bookworm ] ||
        wrong_use "makes $wanted for bookworm only; on a board with $release it needs no options"
    # shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
    install_packages $build_packages $package_packages
    folder=build-$wanted
    build_across
elif [ "$release" != "$own_release" ]; then
    install_packages mmdebstrap
    folder=build-$release
    root "$folder/root"
    [ $with_tests = OFF ] || set -- --tests
    made=$(in_root "$folder" "$@")
    echo "$folder/$made"
    exit
else
    # shellcheck disable=SC2086
    install_packages $build_packages $package_packages
    folder=build
    if [ $with_tests = OFF ] && [ -e build/CMakeCache.txt ]; then
        cmake --build build --target tribus installed_texts >&2
    else
        # shellcheck disable=SC2086
        [ $with_tests = OFF ] || install_packages $test_libraries
        # shellcheck disable=SC2086
        build $with_tests $targets
    fi
fi

rm -f "$folder"/tribus_*_"$wanted".deb
(cd "$folder" && cpack -G DEB >&2)
package=$(echo "$folder"/tribus_*_"$wanted".deb)
lintian --fail-on error,warning "$package" >&2
unpacked=$folder/unpacked
rm -rf "$unpacked"
dpkg-deb -x "$package" "$unpacked"
run_there deploy/try.sh "$unpacked" || fail "its trial failed"
if [ $with_tests = ON ]; then
    for suite in $test_suites; do
        echo "Tests: $suite" >&2
        run_there "$folder/tests/$suite" --gtest_brief=1 || fail "$suite failed"
    done
fi
echo "$package"
