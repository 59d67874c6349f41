# What the tests of this folder share. It is sourced, not run.

say() { printf '%s %s: %s\n' "$(date +%T)" "${0##*/}" "$*" >&2; }

# Says what is wrong, and ends with status 1.
fail() { say "FAILED: $*"; exit 1; }

# A limit for the case that something never happens. Every wait ends as soon as the thing happens, so the limit is much
# longer than any of them takes on a loaded machine.
LIMIT_S=1800

# Repeats a command until it succeeds.
wait_until() { # what is waited for, command...
    local end=$((SECONDS + LIMIT_S)) what=$1
    shift
    until "$@"; do
        [ "$SECONDS" -lt "$end" ] || fail "waited $LIMIT_S s until $what"
        sleep 0.5
    done
}

# Whether a journal begins with the whole lines of an earlier copy of it: then nothing that the copy has was measured
# again. The copy may end within a line.
goes_on() { # journal, copy
    local whole
    whole=$(wc -l <"$2")
    cmp -s <(head -n "$whole" "$1") <(head -n "$whole" "$2")
}
