#!/bin/sh
# Packs a package anew, so that it is the same bytes wherever it is made, with a changelog in
# Debian's form. CPack leaves folders the permissions of the umask, and counts them with the size
# that they have on this file system.
#   deploy/debian/repack.sh PACKAGE
# With SOURCE_DATE_EPOCH no file in it is newer than that.
set -eu
umask 022
here=$(cd "$(dirname "$0")" && pwd)
package=$1
unpacked=$(mktemp -d)
trap 'rm -rf "$unpacked"' EXIT
# mktemp makes a folder of this user only.
chmod 755 "$unpacked"
dpkg-deb --raw-extract "$package" "$unpacked"
field() {
    sed -n "s/^$1: //p" "$unpacked/DEBIAN/control"
}
pages=usr/share/doc/$(field Package)
if [ -e "$unpacked/$pages/CHANGELOG.md" ]; then
    "$here/changelog.sh" "$unpacked/$pages/CHANGELOG.md" "$(field Version)" "$(field Maintainer)" \
        >"$unpacked/$pages/changelog"
    gzip -9n "$unpacked/$pages/changelog"
    (cd "$unpacked" && md5sum "$pages/changelog.gz" >>DEBIAN/md5sums)
fi
find "$unpacked" -type d -exec chmod 755 {} +
# As dpkg-gencontrol counts: each file in whole KiB, and one for whatever else it is.
kib=$(find "$unpacked" -mindepth 1 -path "$unpacked/DEBIAN" -prune -o -printf '%y %s\n' |
    awk '$1 == "f" { kib += int(($2 + 1023) / 1024); next } { kib += 1 } END { print kib }')
sed -i "s/^Installed-Size: .*/Installed-Size: $kib/" "$unpacked/DEBIAN/control"
# Several threads would cut the data into other blocks than one.
dpkg-deb --root-owner-group --threads-max=1 -Zxz --build "$unpacked" "$package" >/dev/null
