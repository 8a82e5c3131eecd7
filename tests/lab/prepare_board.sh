#!/bin/sh
# Prepares a guest with the processor of a board for run_board: Debian's kernel and libraries for
# that processor, unpacked into a folder and never installed. Programs for the board are linked with
# these libraries, too.
#
#   tests/lab/prepare_board.sh arm64|armhf FOLDER [bookworm|trixie]
#
# FOLDER/sysroot has the files; FOLDER/vmlinuz and FOLDER/initrd.gz boot. FOLDER/sysroot/DEBIAN has
# what dpkg-shlibdeps needs to know of the libraries. Does nothing if all that is there, with the
# packages that are needed today.
architecture=$1
folder=$2
release=${3:-bookworm}
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../../deploy/prepare.sh"
. "$here/initrd.sh"
PATH=$PATH:/usr/sbin:/sbin # depmod, modprobe

case $architecture in
    arm64) kernel=linux-image-arm64 ;;
    armhf) kernel=linux-image-armmp ;;
esac
case $release in
    bookworm) standard_library=libstdc++-12-dev ;;
    trixie) standard_library=libstdc++-14-dev ;;
esac

# shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
packages=$(echo libc6-dev $standard_library bash busybox-static $kernel $build_libraries \
    $test_libraries | tr ' ' ,)
# Comes last, so what an interruption left behind is made again.
if [ "$(cat "$folder/packages" 2>/dev/null)" = "$packages" ]; then
    exit 0
fi

# prepare_raspi3b: what run_raspi3b needs. Debian's device tree gives the PL011 to Bluetooth, as Raspberry
# Pi's own one does; without that it is a port, as with dtoverlay=disable-bt.
prepare_raspi3b() {
    cp "$root"/usr/lib/linux-image-*/broadcom/bcm2837-rpi-3-b.dtb "$folder/raspi3b.dtb"
    fdtput -r "$folder/raspi3b.dtb" /soc/serial@7e201000/bluetooth
    mkdir -p "$folder/raspi3b/bin" "$folder/raspi3b/lib" "$folder/raspi3b/modules"
    cp "$root/bin/busybox" "$folder/raspi3b/bin"
    cp "$here/raspi3b_init" "$folder/raspi3b/init"
    cp -L "$root/lib/ld-linux-aarch64.so.1" "$folder/raspi3b/lib"
    put_modules "$root" "$version" "$folder/raspi3b/modules" dwc2 phy-generic ftdi_sio mmc_block \
        bcm2835 bcm2835_wdt
}

# shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
install_packages $board_packages
echo "Unpacking Debian $release for $architecture into $folder" >&2
mkdir -p "$folder"
rm -f "$folder/packages"
folder=$(cd "$folder" && pwd)
root=$folder/sysroot

# unpack SUITE: No security updates: nothing of this is shipped, and on the mirrors the list for armhf
# differs from the signed one.
# shellcheck disable=SC2016 # $1 is the hook's
unpack() {
    as_root rm -rf "$root"
    as_root mmdebstrap --quiet --architectures="$architecture" --variant=extract \
        --include="$packages" \
        --setup-hook='for place in bin lib sbin; do
                mkdir -p "$1/usr/$place"
                ln -s "usr/$place" "$1/$place"
            done' \
        --extract-hook='mkdir -p "$1/DEBIAN" "$1/proc" "$1/sys" "$1/tmp"
            for package in "$1"/var/cache/apt/archives/*.deb; do
                for text in symbols shlibs; do
                    dpkg-deb --ctrl-tarfile "$package" | tar -xO "./$text" 2>/dev/null \
                        >>"$1/DEBIAN/$text" || true
                done
            done' \
        --extract-hook="grep -q '^Codename: $release\$' \"\$1\"/var/lib/apt/lists/*InRelease" \
        "$1" "$root" http://deb.debian.org/debian >&2
}

# Mirrors were seen whose list for armhf is not the signed one under the release's own name, but is
# under the name stable.
unpack "$release" || unpack stable
as_root chown -R "$(id -u)" "$root"
ln -sf busybox "$root/bin/sh"

cp "$root"/boot/vmlinuz-* "$folder/vmlinuz"
version=$(ls "$root/lib/modules")
depmod --basedir "$root" "$version"
start=$(mktemp -d)
trap 'rm -rf "$start"' EXIT
mkdir "$start/bin" "$start/modules"
cp "$root/bin/busybox" "$start/bin"
cp "$here/guest_init" "$start/init"
put_modules "$root" "$version" "$start/modules" virtio_pci 9pnet_virtio 9p overlay
[ "$architecture" != arm64 ] || prepare_raspi3b
# Removes some hundred MB that the guest does not need.
rm -rf "${root:?}/boot" "$root/lib/modules/$version"
pack_initrd "$start" "$folder/initrd.gz"
echo "$packages" >"$folder/packages"
