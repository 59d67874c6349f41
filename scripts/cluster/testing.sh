# Functions of the tests in this folder. This file is sourced, not run.

say() { printf '%s %s: %s\n' "$(date +%T)" "${0##*/}" "$*" >&2; }

# Says what is wrong, and ends with status 1.
fail() { say "FAILED: $*"; exit 1; }

# The longest time, in seconds, that a test waits for an event. A wait ends as soon as its event happens, so that the limit can be
# much longer than any wait takes on a loaded machine.
LIMIT_S=1800

# Repeats a command until it succeeds, and fails after LIMIT_S seconds.
wait_until() { # what is waited for, command...
    local end=$((SECONDS + LIMIT_S)) what=$1
    shift
    until "$@"; do
        [ "$SECONDS" -lt "$end" ] || fail "waited $LIMIT_S s until $what"
        sleep 0.5
    done
}

# Succeeds if a journal begins with the whole lines of an earlier copy of it. Then no entry of the copy was measured again. The
# copy may end within a line, which is not compared.
goes_on() { # journal, copy
    local whole
    whole=$(wc -l <"$2")
    cmp -s <(head -n "$whole" "$1") <(head -n "$whole" "$2")
}
