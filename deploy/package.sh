#!/bin/sh
# Makes the Debian package and says where it is: deploy/package.sh [amd64|arm64|armhf]
# For this machine's own processor it packs what is in build/; for another one it builds in
# build-ARCH/ with Debian's cross compiler and libraries, and tries the program in an emulator.
cd "$(dirname "$0")/.."
. deploy/prepare.sh

own=$(dpkg --print-architecture)
wanted=${1:-$own}

fail() {
    echo "deploy/package.sh: $*" >&2
    exit 1
}

# sysroot FOLDER: Debian's libraries for the wanted processor, unpacked, not installed.
sysroot() {
    [ ! -e "$1" ] || return 0
    mkdir -p "$(dirname "$1")"
    as_root rm -rf "$1.new"
    echo "Unpacking Debian's libraries for $wanted into $1" >&2
    as_root mmdebstrap --quiet --architectures="$wanted" --variant=extract \
        --include="libc6-dev,libstdc++-12-dev,libgpiod-dev,libcli11-dev,libexpected-dev" \
        --include="libfmt-dev,libspdlog-dev,libtomlplusplus-dev,nlohmann-json3-dev" \
        bookworm "$1.new" >&2
    as_root mv "$1.new" "$1"
}

# glibc_of PROGRAM: the newest version of the C library that it asks for.
glibc_of() {
    "$triplet-objdump" -T "$1" | grep -o 'GLIBC_[0-9.]*' | sed 's/GLIBC_//' | sort -Vu | tail -n 1
}

# try PACKAGE: its program in the emulator.
try() {
    unpacked="$folder/unpacked"
    rm -rf "$unpacked"
    dpkg-deb -x "$1" "$unpacked"
    tribus="qemu-$emulated -L $folder/sysroot $unpacked/usr/bin/tribus"
    newest=$(glibc_of "$unpacked/usr/bin/tribus")
    dpkg --compare-versions "$newest" le 2.36 ||
        fail "needs version $newest of the C library, but the package asks for 2.36"
    for example in "$unpacked"/usr/share/doc/tribus/examples/*.toml; do
        $tribus check "$example" >/dev/null || fail "refuses $example"
    done
    $tribus demo --seconds 2 || fail "its demo failed"
}

# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
install_packages $build_packages $package_packages
if [ "$wanted" = "$own" ]; then
    folder=build
    if [ -e build/CMakeCache.txt ]; then
        cmake --build build --target tribus installed_texts >&2
    else
        build OFF tribus installed_texts
    fi
else
    folder=build-$wanted
    case $wanted in
        arm64) triplet=aarch64-linux-gnu emulated=aarch64 ;;
        armhf) triplet=arm-linux-gnueabihf emulated=arm ;;
        *) fail "knows $own, arm64 and armhf" ;;
    esac
    install_packages "g++-$triplet" mmdebstrap qemu-user
    sysroot "$folder/sysroot"
    cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTRIBUS_TESTS=OFF \
        -DTRIBUS_DEBIAN_ARCHITECTURE="$wanted" -DTRIBUS_SYSROOT="$(pwd)/$folder/sysroot" \
        -DCMAKE_TOOLCHAIN_FILE="$(pwd)/deploy/cross.cmake" >&2
    cmake --build "$folder" --target tribus installed_texts >&2
fi
package=$folder/tribus_$(sed -n 's/^project(tribus VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)_$wanted.deb
rm -f "$package"
(cd "$folder" && cpack -G DEB >&2)
lintian --fail-on error,warning "$package" >&2
[ "$wanted" = "$own" ] || try "$package"
echo "$package"
