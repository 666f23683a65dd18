#!/bin/sh
# The manual pages are correct mdoc.
set -u
command -v mandoc >/dev/null || { echo "no mandoc"; exit 77; }
mandoc -Tlint -W warning docs/*.[1-8]
