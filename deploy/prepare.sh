# Functions for the two commands of the README; sourced, not run.
# They print what they do, ask nothing, and do only what is still missing.

set -eu

# Packages of Debian 12 that building the program needs.
build_libraries="libboost-dev libcli11-dev libexpected-dev libfmt-dev libgpiod-dev
    libmosquitto-dev libspdlog-dev libssl-dev libtomlplusplus-dev nettle-dev nlohmann-json3-dev"
build_packages="ca-certificates cmake g++ ninja-build pkg-config $build_libraries"
# Packages that deploy/package.sh needs.
package_packages="dpkg-dev file gzip lintian"
# Packages that the tests need.
test_libraries="libgmock-dev libgtest-dev librapidcheck-dev"
test_packages="$test_libraries apt-utils fish gpg gpg-agent gpgv groff-base python3 python3-canmatrix
    python3-jinja2 python3-jsonschema sigrok-cli systemd tshark zsh"
# The first tier's tests on CAN (tests/lab): clients, and a kernel that is a program, which Debian
# has for PCs only.
test_packages="$test_packages can-utils iproute2 kmod mount"
case $(dpkg --print-architecture) in
    amd64 | i386) test_packages="$test_packages user-mode-linux" ;;
esac
# Packages that make mutations (tests/mutation).
mutation_packages="libclang-common-14-dev python3-clang-14"
# Packages that count instructions (tests/bench), on this processor and, in the second tier, on an
# emulated one.
bench_packages="strace valgrind"
arm_packages="g++-aarch64-linux-gnu qemu-user"
# Packages of the laboratory (tests/lab): an emulator, and programs of the host for its guests.
lab_packages="can-utils cpio iproute2 kmod mount qemu-system-data qemu-system-x86 xz-utils"
# Its full tier builds kernel modules and the package; its service tier installs that on a Debian.
lab_full_packages="bc evtest gcc-12 libelf1 libsdl2-2.0-0 make mmdebstrap zstd $package_packages"
lab_service_packages="e2fsprogs genext2fs mmdebstrap $package_packages"
# Packages that make an apt repository (deploy/repository.sh), and a root that installs from it.
repository_packages="apt-utils gpg gpg-agent"
repository_test_packages="mmdebstrap $repository_packages $package_packages"
# Packages for the laboratory's guests with the processors of boards (tests/lab/prepare_board.sh).
board_packages="binutils cpio device-tree-compiler kmod mmdebstrap qemu-system-arm"

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    else
        sudo "$@"
    fi
}

# Upper limit of the wait for another program that locks apt or dpkg, such as a daily upgrade.
lock_seconds=600

# update_package_lists: apt waits for the lock of dpkg by itself, but not for that of its lists.
update_package_lists() {
    waited=0
    until said=$(as_root env LC_ALL=C apt-get -q update 2>&1); do
        case $said in
            *"Could not get lock"*) ;;
            *) waited=$lock_seconds ;;
        esac
        [ "$waited" -lt $lock_seconds ] || {
            echo "$said" >&2
            return 1
        }
        [ "$waited" -gt 0 ] || echo "Waiting for another program that uses apt: $said" >&2
        waited=$((waited + 5))
        sleep 5
    done
    echo "$said" >&2
}

# install_packages NAME...: installs those that are missing.
install_packages() {
    missing=""
    for package in "$@"; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
            missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    echo "Installing Debian packages:$missing" >&2
    update_package_lists || return 1
    # shellcheck disable=SC2086 # a list of words
    as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get -q -o DPkg::Lock::Timeout=$lock_seconds \
        install --yes --no-install-recommends $missing >&2
}

# compilers ON|OFF: how many may run at once, with or without tests: one for each processor and for
# each 2.4 or 1.4 GiB of memory.
compilers() {
    processors=$(nproc)
    [ "$1" = ON ] && each=2500000 || each=1500000
    fit=$(awk -v each=$each '/^MemAvailable:/ { print int($2 / each) }' /proc/meminfo)
    [ "$fit" -ge 1 ] || fit=1
    [ "$fit" -lt "$processors" ] && echo "$fit" || echo "$processors"
}

# build ON|OFF TARGET...: builds with or without the tests.
build() {
    tests=$1
    shift
    echo "Building tribus in $(pwd)/build (tests: $tests)" >&2
    cmake --preset release -DTRIBUS_TESTS="$tests" ${CI:+-DTRIBUS_WERROR=ON} >&2
    cmake --build --preset release --parallel "$(compilers "$tests")" --target "$@" >&2
}

# name_maintainer: sets DEBFULLNAME and DEBEMAIL, who answers for the package.
name_maintainer() {
    maintainer=$(deploy/debian/maintainer.sh)
    DEBFULLNAME=${maintainer% <*}
    DEBEMAIL=${maintainer##*<}
    DEBEMAIL=${DEBEMAIL%>}
}

# build_page: unless what is built is newer than its sources. It is the same for all processors.
build_page() {
    [ -e app/web/page/dist/index.html ] &&
        [ -z "$(find app/web/build.sh app/web/page -path '*/dist' -prune -o -path '*/node_modules' \
            -prune -o -type f -newer app/web/page/dist/index.html -print)" ] ||
        app/web/build.sh >&2
}
