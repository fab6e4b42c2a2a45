#!/usr/bin/env bash
# Kills runs at random moments (SIGKILL; 1,000 times unless a number is given) and resumes them: no
# finished row may be lost, changed or measured twice.
set -euo pipefail
cd "$(dirname "$0")/.."
RTBENCH_KILLS=${1:-1000} exec cargo test -p rtbench --test it -- \
    --exact hard_cases::k3_kill_9_loses_no_finished_row --nocapture
