#!/bin/sh
# Installs tribus from an apt repository in fresh roots of Debian, as docs/service.md shows, and tries
# what a repository is for: upgrades, and that nothing is installed that somebody changed on the way.
#
#   tests/repository/run.sh [bookworm|trixie|PACKAGE...]     both releases, if none is named
#
# Makes the packages of this processor (deploy/package.sh), or takes a PACKAGE of that, for the release
# that it is for. Needs root or sudo, and Debian's archive.
cd "$(dirname "$0")/../.."
. deploy/prepare.sh

work=$(pwd)/build/repository
page=docs/service.md
package_of_release=""

fail() {
    echo "tests/repository/run.sh: $*" >&2
    exit 1
}

# make_root RELEASE: a fresh one in $work/root, with nothing but apt. $work keeps a packed one.
make_root() {
    packed=$work/$1.tar
    if [ ! -e "$packed" ] || [ -n "$(find "$packed" -mtime +7)" ]; then
        as_root rm -rf "$packed" "$work/new.tar"
        as_root mmdebstrap --quiet --variant=apt --include=ca-certificates "$1" "$work/new.tar" >&2
        as_root mv "$work/new.tar" "$packed"
    fi
    as_root rm -rf "$work/root"
    as_root mkdir "$work/root"
    as_root tar -x -f "$packed" -C "$work/root" --exclude './dev/*'
    as_root cp -L /etc/resolv.conf "$work/root/etc/resolv.conf"
    as_root mkdir -p "$work/root/srv/tribus"
}

# in_root: runs a script of standard input there, where the repository is /srv/tribus.
in_root() {
    # The mounts are seen by these processes only, and end with them.
    # shellcheck disable=SC2016 # the inner shell's
    as_root unshare --mount sh -eu -c 'root=$1 repository=$2
        for place in dev proc sys; do
            mount --rbind "/$place" "$root/$place"
        done
        mount --bind "$repository" "$root/srv/tribus"
        exec chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
            DEBIAN_FRONTEND=noninteractive sh -eu' sh "$work/root" "$work/tribus" >"$work/said" 2>&1
}

# expect WORDS: what the last script has said has them, a basic regular expression.
expect() {
    grep -q "$1" "$work/said" || {
        cat "$work/said" >&2
        fail "$release: nothing says \"$1\""
    }
}

# commands_of_page: what the page says that a board types, here as root and from this disk.
commands_of_page() {
    # shellcheck disable=SC2016 # marks of the page
    sed -n '/^## From a repository$/,/^## /p' $page | sed -n '/^```sh$/,/^```$/{/^```/!p}' |
        sed -e 's/sudo //g' -e 's# -O \([^ ]*\) https://[^ ]*/\([^ ]*\)# \2 \1#' \
            -e 's#wget #cp /srv/tribus/#' -e 's#https://[^ ]*/tribus#file:/srv/tribus#' \
            -e 's/apt install/apt-get install -y/' -e 's/^apt /apt-get /' -e 's/&& apt /\&\& apt-get /g'
}

# newer PACKAGE VERSION NEW: prints the path of the same package with a newer version.
newer() {
    rm -rf "$work/newer"
    dpkg-deb --raw-extract "$1" "$work/newer"
    sed -i "s/^Version: .*/Version: $2/" "$work/newer/DEBIAN/control"
    changed=$work/tribus_$2_$own.deb
    dpkg-deb --root-owner-group -Zgzip --build "$work/newer" "$changed" >/dev/null
    echo "$changed"
}

install_as_the_page_says() {
    commands_of_page >"$work/commands"
    [ "$(wc -l <"$work/commands")" -ge 4 ] || fail "$page has no commands in \"From a repository\""
    in_root <"$work/commands" || {
        cat "$work/said" >&2
        fail "$release: the commands of $page failed"
    }
    in_root <<END || fail "$release: what was installed does not work: $(tail -n 5 "$work/said")"
test "\$(dpkg-query -W -f '\${Version}' tribus)" = "$version"
tribus --version
id tribus
getent group gpio uinput
install -d /etc/tribus/keys
tribus key new /etc/tribus/keys/boat.key
for file in /usr/share/doc/tribus/examples/*.toml; do
    tribus check "\$file" >/dev/null
done
rm -r /etc/tribus/keys
tribus demo --seconds 3 || tribus demo --seconds 3 || tribus demo --seconds 3
END
    expect "tribus"
}

# Before 0.3.0 a drop-in for a virtual joystick named no group.
name_old_drop_ins() {
    in_root <<'END' || fail "$release: an upgrade from 0.2.0 failed: $(tail -n 5 "$work/said")"
drop_ins=/etc/systemd/system/tribus@pad.service.d
mkdir -p $drop_ins
printf '[Service]\nDeviceAllow=/dev/uinput rw\n' >$drop_ins/old.conf
printf '[Service]\nDeviceAllow=/dev/uinput rw\nSupplementaryGroups=uinput\n' >$drop_ins/new.conf
/var/lib/dpkg/info/tribus.postinst configure 0.2.0
/var/lib/dpkg/info/tribus.postinst configure 0.3.0
rm -r $drop_ins
END
    expect "old.conf needs a line SupplementaryGroups=uinput"
    [ "$(grep -c "SupplementaryGroups" "$work/said")" = 1 ] ||
        fail "$release: an upgrade names another drop-in too: $(cat "$work/said")"
}

upgrade() {
    next=99.0.0
    case $version in *+*) next=$next+${version#*+} ;; esac
    deploy/repository.sh "$work/tribus" "$(newer "$package_of_release" "$next")" 2>"$work/said" ||
        fail "a newer version cannot be added: $(cat "$work/said")"
    in_root <<END || fail "$release: the upgrade failed: $(tail -n 5 "$work/said")"
apt-get -q update
apt-get -q -y upgrade
test "\$(dpkg-query -W -f '\${Version}' tribus)" = "$next"
END
}

# `tribus pair` lets the page write /etc/tribus.
purge() {
    in_root <<END || fail "$release: purge did not clean up: $(tail -n 5 "$work/said")"
chmod 750 /etc/tribus
tribus pair
test "\$(stat -c %U:%G:%a /etc/tribus)" = root:tribus-web:770
echo >/etc/tribus/servos.toml
apt-get -q -y purge tribus
test "\$(stat -c %U:%G:%a /etc/tribus)" = root:root:750
apt-get -q -y install tribus
rm /etc/tribus/servos.toml
apt-get -q -y purge tribus
test ! -e /etc/tribus
END
}

# refused WHAT WORDS: neither index nor package that somebody changed is taken.
refused() {
    if in_root <<END; then
rm -f /var/lib/apt/lists/*srv_tribus*
apt-get -q -o APT::Update::Error-Mode=any update
apt-get -q -y install tribus
END
        cat "$work/said" >&2
        fail "$release: apt took $1"
    fi
    expect "$2"
    as_root chroot "$work/root" dpkg-query -W tribus >/dev/null 2>&1 &&
        fail "$release: $1 was installed"
    rm -r "$work/tribus"
    cp -a "$work/good" "$work/tribus"
}

refuse_what_was_changed() {
    rm -rf "$work/good"
    cp -a "$work/tribus" "$work/good"
    file=$(find "$work/tribus/pool/$release" -name 'tribus_99*')
    printf 'other bytes' | dd of="$file" bs=1 seek=4000 conv=notrunc 2>/dev/null
    refused "a package that was changed" "Hash Sum mismatch"
    index=$work/tribus/dists/$release/main/binary-$own/Packages
    sed -i 's/^Version: 99/Version: 98/' "$index"
    gzip -9nkf "$index"
    refused "an index that was changed" "File has unexpected size\|Hash Sum mismatch"
    sed -i 's/^Label: tribus/Label: tribut/' "$work/tribus/dists/$release/InRelease"
    rm "$work/tribus/dists/$release/Release" "$work/tribus/dists/$release/Release.gpg"
    refused "a release file that was changed" "is not signed"
    gpg --batch --quiet --passphrase '' --quick-generate-key "stranger $release" ed25519 sign never
    deploy/repository.sh "$work/tribus" --key "stranger $release" "$package_of_release" 2>/dev/null
    refused "a repository of another key" "is not signed"
    in_root <<END || fail "$release: the good repository is refused: $(tail -n 5 "$work/said")"
apt-get -q update
apt-get -q -y install tribus
END
}

# shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
install_packages $repository_test_packages
own=$(dpkg --print-architecture)
mkdir -p "$work"
GNUPGHOME=$(mktemp -d)
export GNUPGHOME
trap 'gpgconf --kill all; rm -rf "$GNUPGHOME"' EXIT
[ $# -gt 0 ] || set -- bookworm trixie
rm -rf "$work/tribus"
for release in "$@"; do
    case $release in
        *+deb13_*.deb) package_of_release=$release release=trixie ;;
        *.deb) package_of_release=$release release=bookworm ;;
        *) package_of_release=$(deploy/package.sh --release "$release" --no-trial) ;;
    esac
    deploy/repository.sh "$work/tribus" "$package_of_release"
    version=$(dpkg-deb -f "$package_of_release" Version)
    make_root "$release"
    for each in install_as_the_page_says name_old_drop_ins upgrade purge refuse_what_was_changed; do
        echo "$release: $(echo $each | tr _ ' ')" >&2
        $each
    done
    as_root rm -rf "$work/root"
    echo "$release: passed" >&2
done
