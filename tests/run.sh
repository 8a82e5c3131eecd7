#!/bin/sh
# Proves tribus: installs what is needed from Debian's packages, builds it and its tests, runs them.
#
#   tests/run.sh [ARGUMENT...]         the first tier; arguments go to ctest: tests/run.sh -R Sbus
#   tests/run.sh --all [PART...]       the second tier too, or these parts of it
#   tests/run.sh --group GROUP...      groups of the laboratory (docs/laboratory.md), such as lab_gpio,
#                                      or suites, such as sim_tests.NeverStale
#
# Parts, in this order: first page peers fleet laboratory service repository tidy addresses threads simulation fuzz
# mutations.
# All of them take some hours. A part that fails does not stop the others. At the end a table says
# what ran, when, for how long, with which result and of which commit; build/proofs keeps it.
cd "$(dirname "$0")/.."
. deploy/prepare.sh

# step NUMBER TEXT: progress for the person who waits.
step() {
    echo "[$1/3] $(date +%H:%M:%S) $2" >&2
}

# prepare_and_build TARGET...
prepare_and_build() {
    step 1 "Packages (the first time 1 to 2 minutes)"
    # shellcheck disable=SC2086,SC2154 # lists of words, from deploy/prepare.sh
    install_packages $build_packages $test_packages $bench_packages
    step 2 "Building the program and its tests (the first time 8 to 9 minutes on two processors)"
    build ON "$@"
}

# For parts that run the programs from scripts of their own.
build_programs() {
    prepare_and_build tribus tribus-web tribus-mqtt
}

# Many tests wait more than they compute, so six times as many run as there are processors.
run_tests() {
    ctest --test-dir build --output-on-failure --parallel $(($(nproc) * 6)) "$@"
}

first_tier() {
    prepare_and_build all
    step 3 "Testing (4 minutes)"
    passed=0
    run_tests --label-exclude 'lab|long' "$@" || passed=$?
    build/tests/recordings_not_read
    return $passed
}

# laboratory TIER TARGETS CTEST_ARGUMENT...: guests reserve their processors themselves.
laboratory() {
    tests/lab/prepare.sh "$1" build/lab ||
        echo "The laboratory could not be prepared: its tests will fail, the others run." >&2
    # shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
    [ "$1" != full ] || install_packages $arm_packages
    # The package that the service tier installs has the page.
    [ "$1" != service ] || build_page
    # After prepare.sh, because CMake looks whether libgpiod 2 is there.
    # shellcheck disable=SC2086 # a list of words
    prepare_and_build $2
    shift 2
    step 3 "Testing in emulated machines (up to 10 minutes)"
    ctest --test-dir build --output-on-failure --parallel "$(nproc)" "$@"
}

# Prints the targets that groups need.
programs_of() {
    echo "tribus installed_texts heap_trap_preload"
    for group in "$@"; do
        case $group in
            lab_*) echo "${group}_tests" ;;
        esac
    done
}

# Prints the regular expression for groups of the laboratory and for their tests.
groups() {
    echo "^($(echo "$*" | tr ' ' '|'))(\$|\.)"
}

part() {
    case $1 in
        first) first_tier ;;
        page) build_programs && app/web/build.sh --tests ;;
        peers) build_programs && tests/peers/run.sh ;;
        fleet) build_programs && tests/fleet/run.sh ;;
        laboratory) laboratory full 'all second_tier' --label-regex 'lab_fast|lab_full|long' ;;
        service) laboratory service 'all second_tier' --label-regex lab_service ;;
        repository) tests/repository/run.sh ;;
        tidy) .ci/clang_tidy ;;
        addresses | threads) tests/sanitize.sh "$1" ;;
        simulation) tests/sim/run.sh 200 ;;
        fuzz) tests/fuzz/run.sh 60 ;;
        mutations) tests/mutation/run.sh ;;
        *)
            echo "tests/run.sh: no part is called $1; --all has: $all_parts" >&2
            return 2
            ;;
    esac
}

all_parts="first page peers fleet laboratory service repository tidy addresses threads simulation fuzz mutations"
case ${1:-} in
    --all)
        shift
        # shellcheck disable=SC2086 # a list of words
        [ $# -gt 0 ] || set -- $all_parts
        mkdir -p build
        table=build/proofs
        # "+" behind it: with changes that are not committed.
        commit=$(git describe --always --dirty=+ 2>/dev/null || true)
        failed=0
        for name in "$@"; do
            began=$(date +%s)
            result=passed
            (part "$name") || {
                result=FAILED
                failed=1
            }
            line=$(printf '%-12s %s  %5d s  %s  %s' "$name" \
                "$(date -d "@$began" '+%Y-%m-%d %H:%M')" $(($(date +%s) - began)) $result "$commit")
            { grep -v "^$name " $table 2>/dev/null || true; echo "$line"; } >$table.new
            mv $table.new $table
        done
        echo "What ran last, in build/proofs:"
        cat $table
        exit $failed
        ;;
    --group)
        shift
        case " $*" in
            *lab_systemd*) tier=service ;;
            *gpio* | *input* | *modules* | *ppm* | *pwm* | *realtime* | *package*) tier=full ;;
            *" lab_"*) tier=fast ;;
            *)
                targets=all
                case "$*" in *OnArm*)
                    # shellcheck disable=SC2086,SC2154 # a list of words, from deploy/prepare.sh
                    install_packages $arm_packages
                    targets="all arm_programs"
                    ;;
                esac
                # shellcheck disable=SC2086 # a list of words
                prepare_and_build $targets
                step 3 "Testing"
                run_tests -R "$(groups "$@")"
                exit
                ;;
        esac
        laboratory $tier "$(programs_of "$@")" -R "$(groups "$@")"
        ;;
    --help) sed -n '2,/^cd /s/^# \{0,1\}//p' "$0" ;;
    *) first_tier "$@" ;;
esac
