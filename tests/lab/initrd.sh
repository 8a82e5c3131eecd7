# Functions for prepare.sh and prepare_board.sh. Sourced, not run.

# put_modules ROOT VERSION FOLDER MODULE...: copies the modules and those that they need, in the
# order of loading.
put_modules() {
    from=$1
    version=$2
    to=$3
    shift 3
    number=100
    for module in "$@"; do
        modprobe --dirname "$from" --set-version "$version" --show-depends "$module"
    done | sed -n 's/^insmod \([^ ]*\).*/\1/p' | while read -r file; do
        cp "$file" "$to/$number-$(basename "$file")"
        case $file in
            *.xz) xz -d "$to/$number-$(basename "$file")" ;;
        esac
        number=$((number + 1))
    done
}

# pack_initrd FOLDER FILE
pack_initrd() (
    cd "$1"
    find . | cpio --quiet -o -H newc -R 0:0 | gzip -1 >"$2.new"
    mv "$2.new" "$2"
)
