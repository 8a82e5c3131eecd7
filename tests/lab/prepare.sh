#!/bin/sh
# Prepares the laboratory's guests: Debian's own kernels, downloaded and unpacked but never
# installed. Does only what is still missing; delete the folder to get newer kernels.
#
#   tests/lab/prepare.sh [fast|full|service [FOLDER]]
#
# fast: the stock kernel. full: the PREEMPT_RT kernel too, and the drivers that Debian's kernel comes
# without, built from Debian's kernel source (build_modules.sh); version 2 of libgpiod, which Debian
# 12 has in its backports only; and the newest kernel that Debian 13 has in its backports, with the
# driver of the PWM chip, for interfaces of the kernel that Debian 12 is too old for. service: the
# stock kernel, and a fresh Debian 12 with systemd as a disk.
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

# offset_of BYTES FILE: where they stand first, or nothing.
offset_of() {
    LC_ALL=C grep -aboF "$1" "$2" | head -n 1 | cut -d : -f 1
}

# unpack_vmlinux VMLINUZ VMLINUX: decompressed once, here; the emulator would need two seconds
# for it at each boot. What follows the kernel in the file is not part of it, which both programs
# call an error.
unpack_vmlinux() {
    offset=$(offset_of "$(printf '\3757zXZ')" "$1")
    if [ -n "$offset" ]; then
        tail -c "+$((offset + 1))" "$1" | xz -dc --single-stream >"$2" 2>/dev/null || [ -s "$2" ]
        return
    fi
    offset=$(offset_of "$(printf '\050\265\057\375')" "$1")
    [ -n "$offset" ] || fail "$1 is compressed with neither xz nor zstd"
    tail -c "+$((offset + 1))" "$1" | zstd -dc >"$2" 2>/dev/null || [ -s "$2" ]
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
    update_package_lists
    # Not installed: it would take the place of the package busybox.
    download "$(package_behind "$1")" busybox-static
    unpack_packages
    mv unpacked/bin/busybox .
    keep_kernel "unpacked/boot/vmlinuz-$(ls unpacked/lib/modules)" unpacked/lib/modules
}

unpack_packages() {
    for package in *.deb; do
        dpkg-deb -x "$package" unpacked
    done
}

# keep_kernel VMLINUZ MODULES: of what is unpacked in the current folder.
keep_kernel() {
    version=$(ls "$2")
    unpack_vmlinux "$1" vmlinux
    # Two thirds of the modules, for hardware that no guest has.
    (cd "$2/$version/kernel" &&
        rm -rf sound drivers/gpu drivers/media drivers/infiniband drivers/scsi drivers/staging \
            drivers/iio drivers/net/ethernet drivers/net/wireless)
    mv "$2" lib/modules
    depmod --basedir . "$version"
    rm -rf unpacked ./*.deb apt.log
    echo "$version" >ready
    say "kernel $version is ready"
}

# sources_of SUITE...: lines for apt.
sources_of() {
    mirror=$(apt-get indextargets --format '$(SITE)' 'Codename: bookworm' | head -n 1)
    for suite in "$@"; do
        echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg]" \
            "${mirror:-http://deb.debian.org/debian} $suite main"
    done
}

# use_lists_of SUITE: from here on apt has lists of packages of its own, in the current folder, so
# that this machine's apt stays as it is.
use_lists_of() {
    mkdir -p lists/partial cache/archives/partial
    sources_of "$1" >sources.list
    cat >apt.conf <<END
Dir::Etc::SourceList "$PWD/sources.list";
Dir::Etc::SourceParts "$PWD/none";
Dir::State::Lists "$PWD/lists";
Dir::Cache "$PWD/cache";
END
    export APT_CONFIG="$PWD/apt.conf"
    apt-get -q update >apt.log 2>&1 || {
        cat apt.log >&2
        fail "cannot read the list of $1"
    }
}

# prepare_newest: into FOLDER/newest. Its driver is built in a Debian 13 of its own, because the
# tools for it do not run on Debian 12.
prepare_newest() (
    [ ! -e "$folder/newest/initrd.gz" ] || return 0
    work="$folder/newest.new"
    as_root rm -rf "$work" "$folder/newest"
    mkdir -p "$work/lib" && cd "$work" || fail "cannot write into $folder"
    sources_of trixie trixie-backports >root.list
    use_lists_of trixie-backports
    image=$(package_behind linux-image-amd64)
    version=${image#linux-image-}
    series=$(echo "$version" | cut -d . -f 1-2)
    download "linux-base-$version" "linux-binary-$version" "linux-modules-$version" \
        "linux-source-$series"
    say "making a Debian 13 that builds a driver for $version"
    as_root env -u APT_CONFIG mmdebstrap --quiet --variant=minbase \
        --include="linux-headers-$version,gcc-14,make" --dpkgopt='path-exclude=/usr/share/doc/*' \
        trixie root root.list >&2 || fail "cannot make a Debian 13"
    build_pwm_driver
    rm linux-source-*.deb
    unpack_packages
    cp "$folder/stock/busybox" .
    keep_kernel "unpacked/usr/lib/modules/$version/vmlinuz" unpacked/usr/lib/modules
    mkdir "lib/modules/$version/updates"
    cp root/tmp/driver/pwm-pca9685.ko "lib/modules/$version/updates"
    depmod --basedir . "$version"
    make_initrd "$work"
    as_root rm -rf root lists cache
    mv "$work" "$folder/newest"
)

# build_pwm_driver: of the kernel's source in the current folder, in the Debian in `root`.
build_pwm_driver() {
    as_root mkdir -m 777 root/tmp/driver
    dpkg-deb --fsys-tarfile linux-source-*.deb |
        tar -xO --wildcards './usr/src/linux-source-*.tar.xz' |
        tar -xJO --wildcards '*/drivers/pwm/pwm-pca9685.c' >root/tmp/driver/pwm-pca9685.c
    echo 'obj-m := pwm-pca9685.o' >root/tmp/driver/Kbuild
    # Its tools read files of the kernel. The mount ends with the shell.
    as_root unshare --mount sh -c "mount -t proc proc root/proc && chroot root \
        make -C /usr/src/linux-headers-$version M=/tmp/driver modules" >make.log 2>&1 || {
        cat make.log >&2
        fail "the driver cannot be built"
    }
    as_root strip --strip-debug root/tmp/driver/pwm-pca9685.ko
}

# prepare_libgpiod: unpacked, not installed.
prepare_libgpiod() (
    [ ! -e "$folder/libgpiod-2" ] || return 0
    work="$folder/libgpiod-2.new"
    rm -rf "$work"
    mkdir -p "$work" && cd "$work" || fail "cannot write into $folder"
    use_lists_of bookworm-backports
    download libgpiod3 libgpiod-dev
    unpack_packages
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
        --include=systemd,systemd-sysv,udev,kmod,iproute2,libgpiod2,libmosquitto1,libnettle8,libstdc++6,procps \
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
    prepare_newest
elif [ "$tier" = service ]; then
    # shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
    install_packages $lab_service_packages
    prepare_systemd
fi
