#!/bin/sh
# docs/quality.md is what the service's rules give, to the last digit: made anew and compared.
set -eu
"${B:-build}/bin/dexel" bench quality --markdown >"${B:-build}/quality.md"
diff docs/quality.md "${B:-build}/quality.md"
