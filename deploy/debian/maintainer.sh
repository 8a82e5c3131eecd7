#!/bin/sh
# Prints who answers for a package, as "NAME <MAIL>": DEBFULLNAME and DEBEMAIL, which Debian's own
# tools read too, else the author of the last commit.
set -eu
if [ -n "${DEBFULLNAME:-}" ] && [ -n "${DEBEMAIL:-}" ]; then
    echo "$DEBFULLNAME <$DEBEMAIL>"
else
    git -C "$(dirname "$0")" log -1 --format='%an <%ae>' 2>/dev/null || {
        echo "deploy/debian/maintainer.sh: without git nothing says who answers for the package:" \
            "set DEBFULLNAME and DEBEMAIL" >&2
        exit 1
    }
fi
