#!/bin/sh
# Prepares the laboratory's guests: Debian's own kernels, downloaded and unpacked but never
# installed. Does only what is still missing; delete the folder to get newer kernels.
#
#   tests/lab/prepare.sh [fast|full|service [FOLDER]]
#
# fast: the stock kernel. full: the PREEMPT_RT kernel too, and the drivers that Debian's kernel comes
# without, built from Debian's kernel source (build_modules.sh); and version 2 of libgpiod, which Debian 12 has in its backports only. service: the stock kernel, and a fresh Debian
# 12 with systemd as a disk.
#
# FOLDER/KERNEL/ has vmlinux, initrd.gz and lib/modules/, FOLDER/libgpiod-2/ has usr/,
# FOLDER/systemd.ext2 is the disk; FOLDER is build/lab if not given.
tier=${1:-fast}
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "${2:-$here/../../build/lab}"
folder=$(cd "${2:-$here/../../build/lab}" && pwd)
. "$here/../../deploy/prepare.sh"
. "$here/initrd.sh"
PATH=$PATH:/usr/sbin:/sbin # depmod, modprobe

say() {
    echo "Laboratory: $*" >&2
}

fail() {
    say "$*"
    exit 1
}

# download PACKAGE...: their .deb files, into the current folder.
download() {
    say "downloading $*"
    # apt's own user cannot write into this folder, which apt mentions each time.
    apt-get -q download "$@" >apt.log 2>&1 || {
        cat apt.log >&2
        fail "cannot download $*"
    }
}

# package_behind METAPACKAGE: the one with the kernel that the metapackage now stands for.
package_behind() {
    apt-cache depends "$1" | sed -n 's/^ *Depends: \(linux-[a-z]*-[0-9].*\)/\1/p' | head -n 1
}

# unpack_vmlinux VMLINUZ VMLINUX: decompressed once, here; the emulator would need two seconds
# for it at each boot.
unpack_vmlinux() {
    offset=$(LC_ALL=C grep -aboF "$(printf '\3757zXZ')" "$1" | head -n 1 | cut -d : -f 1)
    [ -n "$offset" ] || fail "$1 is not compressed with xz"
    # What follows the kernel in the file is not part of it, which xz calls an error.
    tail -c "+$((offset + 1))" "$1" | xz -dc --single-stream >"$2" 2>/dev/null || [ -s "$2" ]
}

# make_initrd KERNEL_FOLDER: busybox, and the modules it takes to reach the host's files or a disk.
make_initrd() (
    root=$(mktemp -d)
    trap 'rm -rf "$root"' EXIT
    mkdir "$root/bin" "$root/modules" "$root/modules-disk"
    cp "$1/busybox" "$root/bin"
    cp "$here/guest_init" "$root/init"
    version=$(cat "$1/ready")
    put_modules "$1" "$version" "$root/modules" virtio_pci 9pnet_virtio 9p overlay
    put_modules "$1" "$version" "$root/modules-disk" virtio_blk ext4
    pack_initrd "$root" "$1/initrd.gz"
)

# prepare_kernel NAME METAPACKAGE: into FOLDER/NAME.
prepare_kernel() {
    kernel="$folder/$1"
    if [ ! -e "$kernel/ready" ]; then
        rm -rf "$kernel"
        mkdir -p "$kernel/lib"
        (cd "$kernel" && unpack_kernel "$2")
    fi
    if [ ! -e "$kernel/initrd.gz" ] ||
        [ -n "$(find "$here/guest_init" -newer "$kernel/initrd.gz")" ]; then
        make_initrd "$kernel"
    fi
}

unpack_kernel() {
    # A list of packages that is older than the archive names files that are gone.
    as_root apt-get -q update >&2
    # Not installed: it would take the place of the package busybox.
    download "$(package_behind "$1")" busybox-static
    for package in *.deb; do
        dpkg-deb -x "$package" unpacked
    done
    mv unpacked/bin/busybox .
    version=$(ls unpacked/lib/modules)
    unpack_vmlinux "unpacked/boot/vmlinuz-$version" vmlinux
    # Two thirds of the modules, for hardware that no guest has.
    (cd "unpacked/lib/modules/$version/kernel" &&
        rm -rf sound drivers/gpu drivers/media drivers/infiniband drivers/scsi drivers/staging \
            drivers/iio drivers/net/ethernet drivers/net/wireless)
    mv unpacked/lib/modules lib/modules
    depmod --basedir . "$version"
    rm -rf unpacked ./*.deb apt.log
    echo "$version" >ready
    say "kernel $version is ready"
}

# prepare_libgpiod: unpacked, not installed. With lists of packages of its own, so that this
# machine's apt stays as it is.
prepare_libgpiod() (
    [ ! -e "$folder/libgpiod-2" ] || return 0
    work="$folder/libgpiod-2.new"
    rm -rf "$work"
    mkdir -p "$work/lists/partial" "$work/cache/archives/partial"
    cd "$work"
    mirror=$(apt-get indextargets --format '$(SITE)' 'Codename: bookworm' | head -n 1)
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg]" \
        "${mirror:-http://deb.debian.org/debian} bookworm-backports main" >sources.list
    cat >apt.conf <<END
Dir::Etc::SourceList "$work/sources.list";
Dir::Etc::SourceParts "$work/none";
Dir::State::Lists "$work/lists";
Dir::Cache "$work/cache";
END
    export APT_CONFIG="$work/apt.conf"
    apt-get -q update >apt.log 2>&1 || {
        cat apt.log >&2
        fail "cannot read the list of bookworm-backports"
    }
    download libgpiod3 libgpiod-dev
    for package in *.deb; do
        dpkg-deb -x "$package" unpacked
    done
    mv unpacked "$folder/libgpiod-2"
    rm -rf "$work"
)

# prepare_systemd: a minimal Debian with the libraries that the program's package needs and those of
# its test, without what only people read and what only delays the boot.
prepare_systemd() {
    disk="$folder/systemd.ext2"
    if [ -e "$disk" ] && [ -z "$(find "$here/guest.service" "$here/prepare.sh" -newer "$disk")" ]; then
        return 0
    fi
    say "making a Debian with systemd"
    rm -f "$disk.new.ext2"
    as_root mmdebstrap --quiet --variant=minbase \
        --include=systemd,systemd-sysv,udev,kmod,iproute2,libgpiod2,libmosquitto1,libstdc++6,procps \
        --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-exclude=/usr/share/man/*' \
        --dpkgopt='path-exclude=/usr/share/locale/*' \
        --customize-hook='rm "$1/etc/dpkg/dpkg.cfg.d/99mmdebstrap"' \
        --customize-hook="upload '$here/guest.service' /etc/systemd/system/guest.service" \
        --customize-hook='systemctl --root "$1" enable guest.service' \
        --customize-hook='systemctl --root "$1" mask getty@tty1.service serial-getty@ttyS0.service \
            systemd-logind.service systemd-random-seed.service apt-daily.timer \
            apt-daily-upgrade.timer dpkg-db-backup.timer e2scrub_all.timer fstrim.timer' \
        bookworm "$disk.new.ext2" >&2
    as_root chown "$(id -u)" "$disk.new.ext2"
    # mmdebstrap leaves room for root only.
    truncate -s +96M "$disk.new.ext2"
    /sbin/resize2fs "$disk.new.ext2" >&2
    mv "$disk.new.ext2" "$disk"
}

[ "$(dpkg --print-architecture)" = amd64 ] || fail "it runs on amd64 machines only"
# shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
install_packages $lab_packages
prepare_kernel stock linux-image-amd64
if [ "$tier" = full ]; then
    # shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
    install_packages $lab_full_packages
    prepare_kernel rt linux-image-rt-amd64
    "$here/build_modules.sh" "$folder/stock"
    prepare_libgpiod
elif [ "$tier" = service ]; then
    # shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
    install_packages $lab_service_packages
    prepare_systemd
fi
