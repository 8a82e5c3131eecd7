#!/bin/sh
# Puts packages into an apt repository that any web server or disk can offer. --help has the rest.
called_in=$(pwd)
cd "$(dirname "$0")/.."
. deploy/prepare.sh

usage="Usage: deploy/repository.sh FOLDER [--key KEY] [PACKAGE...]

Puts PACKAGEs (files of deploy/package.sh or deploy/release.sh; by default those of this version
that deploy/release.sh has made) into the apt repository FOLDER, beside those that it has, and signs
it. FOLDER is made if it is not there. It then has pool/, dists/bookworm and dists/trixie for amd64,
arm64 and armhf, and the public key, tribus-archive-keyring.asc (and .gpg, the same in binary form).
Copy FOLDER to a web server as it is; docs/service.md shows how a board uses it. To take a package
back, delete its file in pool/ and run this again with one that is there.

--key is a secret key of your keyring, as gpg names it. Without it the repository keeps its key; a
new repository gets a new one, without a passphrase, in your keyring: keep a copy of it
(gpg --export-secret-keys), because boards trust no other.

The same packages and the same key make the same bytes in a new folder. Exit status: 0; 1 if it
failed, with nothing changed in FOLDER but new files in pool/; 2 for wrong use."

releases="bookworm trixie"
processors="amd64 arm64 armhf"
keyring=tribus-archive-keyring

fail() {
    echo "deploy/repository.sh: $*" >&2
    exit 1
}

wrong_use() {
    echo "deploy/repository.sh: $*; --help says more" >&2
    exit 2
}

# from_caller PATH: as it is from the current folder on.
from_caller() {
    case $1 in
        /*) echo "$1" ;;
        *) echo "$called_in/$1" ;;
    esac
}

# release_of PACKAGE: prints the Debian release that it was made for, by its version
# (deploy/CMakeLists.txt).
release_of() {
    case $(dpkg-deb -f "$1" Version) in
        *+deb13) echo trixie ;;
        *+deb*) return 1 ;;
        *) echo bookworm ;;
    esac
}

check_package() {
    [ -f "$1" ] || fail "$1: there is no such file"
    name=$(dpkg-deb -f "$1" Package 2>/dev/null) || fail "$1 is no Debian package"
    [ "$name" = tribus ] || fail "$1 is the package $name, not tribus"
    release_of "$1" >/dev/null || fail "$1 is for none of these releases: $releases"
    case " $processors " in
        *" $(dpkg-deb -f "$1" Architecture) "*) ;;
        *) fail "$1 is for $(dpkg-deb -f "$1" Architecture), not for one of: $processors" ;;
    esac
    place=$folder/pool/$(release_of "$1")/$(basename "$1")
    # apt takes what it knows under this version for the same package.
    [ ! -e "$place" ] || cmp -s "$1" "$place" ||
        fail "the repository has another $(basename "$1"): a changed package needs a new version"
}

# seconds_of PACKAGE: time of its newest file.
seconds_of() {
    dpkg-deb --fsys-tarfile "$1" | TZ=UTC tar -t --verbose --full-time |
        awk '{ print $4, $5 }' | sort | tail -n 1 | TZ=UTC date -f - +%s
}

# first_fingerprint OPTION WHAT: of the first key that gpg lists so, or nothing.
first_fingerprint() {
    gpg --batch --quiet --with-colons "$1" "$2" 2>/dev/null |
        sed -n '/^fpr:/{s/^fpr:*\([^:]*\):.*/\1/p;q}'
}

# choose_key: sets $fingerprint.
choose_key() {
    before=""
    [ ! -e "$folder/$keyring.asc" ] ||
        before=$(first_fingerprint --show-keys "$folder/$keyring.asc")
    if [ -n "$key" ]; then
        fingerprint=$(first_fingerprint --list-secret-keys "$key")
        [ -n "$fingerprint" ] || fail "your keyring has no secret key $key;" \
            "gpg --list-secret-keys lists those that it has"
        [ "${before:-$fingerprint}" = "$fingerprint" ] ||
            echo "Boards know the key $before: they need the new $keyring.asc." >&2
    elif [ -n "$before" ]; then
        fingerprint=$(first_fingerprint --list-secret-keys "$before")
        [ -n "$fingerprint" ] || fail "the repository is signed by the key $before, whose secret" \
            "part your keyring does not have: gpg --import it, or name another by --key"
    else
        name="tribus archive $(date --utc +%Y-%m-%dT%H:%M:%SZ)"
        gpg --batch --quiet --passphrase '' --quick-generate-key "$name" ed25519 sign never >&2 ||
            fail "gpg cannot make a key"
        fingerprint=$(first_fingerprint --list-secret-keys "=$name")
        echo "Made the key $fingerprint, \"$name\"." \
            "Keep a copy: gpg --export-secret-keys $fingerprint" >&2
    fi
}

# index_packages RELEASE: into dists.new/RELEASE, in the current folder.
index_packages() {
    for processor in $processors; do
        index=dists.new/$1/main/binary-$processor
        mkdir -p "$index"
        apt-ftparchive --arch "$processor" packages "pool/$1" >"$index/Packages"
        gzip -9nk "$index/Packages"
    done
}

# choose_date: sets $seconds, the date of the new index: that of the newest package, or of the key if
# that is newer, so the same packages give the same bytes. A board keeps an index that is newer than
# the one it finds, so the date goes on if packages were taken back.
choose_date() {
    seconds=$(gpg --batch --with-colons --list-keys "$fingerprint" |
        sed -n '/^pub:/{p;q}' | cut -d : -f 6)
    for package in pool/*/*.deb; do
        newest=$(seconds_of "$package")
        [ "$newest" -le "$seconds" ] || seconds=$newest
    done
    for release in $releases; do
        [ -e "dists/$release/Release" ] || continue
        least=$(date --date="$(sed -n 's/^Date: //p' "dists/$release/Release")" +%s)
        diff -rq --exclude='*Release*' "dists/$release" "dists.new/$release" >/dev/null ||
            least=$((least + 1))
        [ "$least" -le "$seconds" ] || seconds=$least
    done
}

# sign_release RELEASE
sign_release() {
    release=$1
    date=$(date --utc --date="@$seconds" '+%a, %d %b %Y %H:%M:%S UTC')
    set --
    for field in Origin=tribus Label=tribus "Suite=$release" "Codename=$release" Components=main \
        "Architectures=$processors" "Date=$date" "Description=tribus for Debian, $release"; do
        set -- "$@" -o "APT::FTPArchive::Release::$field"
    done
    apt-ftparchive "$@" release "dists.new/$release" >"$work/Release"
    cp "$work/Release" "dists.new/$release/Release"
    sign --clearsign InRelease
    sign --detach-sign Release.gpg
}

# sign HOW NAME: of dists.new/$release/Release. A signature has a time too; gpg warns of another one
# than the clock's.
sign() {
    gpg --batch --quiet --yes --faked-system-time "$seconds!" --digest-algo SHA512 \
        --local-user "$fingerprint" --armor --output "dists.new/$release/$2" "$1" \
        "dists.new/$release/Release" 2>"$work/gpg" || {
        cat "$work/gpg" >&2
        fail "gpg cannot sign with $fingerprint"
    }
}

key=""
folder=""
work=$(mktemp -d)
packages=$work/packages
: >"$packages"
unfinished=$work
trap 'rm -rf "$work" "$unfinished"' EXIT
while [ $# -gt 0 ]; do
    case $1 in
        --help)
            echo "$usage"
            exit 0
            ;;
        --key)
            key=${2:-}
            [ -n "$key" ] || wrong_use "--key needs a key"
            shift
            ;;
        -*) wrong_use "knows no option $1" ;;
        *)
            if [ -z "$folder" ]; then
                folder=$(from_caller "$1")
            else
                from_caller "$1" >>"$packages"
            fi
            ;;
    esac
    shift
done
[ -n "$folder" ] || wrong_use "needs a folder"
if [ ! -s "$packages" ]; then
    version=$(sed -n 's/^project(tribus VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
    find "$(pwd)/build-release/$version" -name '*.deb' 2>/dev/null | sort >"$packages"
    [ -s "$packages" ] || fail "build-release/$version has no packages:" \
        "deploy/release.sh makes them; or name some"
fi
[ ! -e "$folder" ] || [ -d "$folder/pool" ] || [ -z "$(ls -A "$folder")" ] ||
    fail "$folder has files, and is no repository: name a new folder"

# shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
install_packages $repository_packages
umask 022
export LC_ALL=C
while read -r package; do
    check_package "$package"
done <"$packages"
mkdir -p "$folder" || fail "cannot write $folder"
choose_key
for release in $releases; do
    mkdir -p "$folder/pool/$release"
done
while read -r package; do
    place=$folder/pool/$(release_of "$package")/$(basename "$package")
    [ -e "$place" ] || cp "$package" "$place"
done <"$packages"

cd "$folder"
unfinished=$folder/dists.new
rm -rf dists.new
for release in $releases; do
    index_packages "$release"
done
choose_date
for release in $releases; do
    sign_release "$release"
done
gpg --batch --armor --export "$fingerprint" >"$work/$keyring.asc"
gpg --batch --export "$fingerprint" >"$work/$keyring.gpg"
rm -rf dists.old
[ ! -e dists ] || mv dists dists.old
mv dists.new dists
cp "$work/$keyring.asc" "$work/$keyring.gpg" .
rm -rf dists.old
echo "$folder is signed by $fingerprint. Copy all of it to a web server;" \
    "docs/service.md, \"From a repository\", shows how a board uses it." >&2
