#!/usr/bin/env bash
# One answer on every instruction set: builds the program for several processors and compares what
# each answers to the cases of `rtbench verify`, to the last bit. Which instructions are used is
# chosen when it is compiled (.cargo/config.toml: x86-64-v3; crate `wide` takes what there is).
# Arguments: names for target-cpu (default: x86-64, the least, and x86-64-v3; this machine must be able
# to run them). RAYS: rays per case and precision (500). ARGUMENTS: of verify, like "--cases ray".
# Rows with a known defect, libraries as shipped, are told but may differ. Exit code 1 if others do.
set -euo pipefail
cd "$(dirname "$0")/.."
processors=("$@")
[ ${#processors[@]} -gt 0 ] || processors=(x86-64 x86-64-v3)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Compares the answers of two records; prints what differs.
same() {
    python3 - "$1" "$2" <<'PYTHON'
import csv, sys

def rows(path):
    key = ("case", "precision", "structure")
    with open(path, newline="") as file:
        return {tuple(row[k] for k in key): row for row in csv.DictReader(file)}

one, other = (rows(path) for path in sys.argv[1:])
if not one or one.keys() != other.keys():
    sys.exit("not the same rows")
differs = [key for key in one if one[key]["answers"] != other[key]["answers"]]
for key in differs:
    known = one[key]["known_defect"]
    print(*key, "differs", f"({known})" if known else "")
print(f"{len(one) - len(differs)} of {len(one)} rows have the same answers")
sys.exit(any(not one[key]["known_defect"] for key in differs))
PYTHON
}

for processor in "${processors[@]}"; do
    target=target/one-answer-$processor
    RUSTFLAGS="-C target-cpu=$processor" cargo build --release --quiet --target-dir "$target"
    code=0
    # shellcheck disable=SC2086
    "$target/release/rtbench" verify --rays "${RAYS:-500}" ${ARGUMENTS:-} \
        --export-csv "$folder/$processor.csv" > "$folder/$processor.txt" || code=$?
    # wrong hits are the same wrong hits everywhere, or are told as a difference
    [ "$code" -eq 0 ] || [ "$code" -eq 4 ] || { cat "$folder/$processor.txt"; exit "$code"; }
    echo "$processor: exit code $code; $(grep -o 'answers [0-9a-f]*' "$folder/$processor.txt")"
done

first=$folder/${processors[0]}.csv
# a planted difference must be seen, or the comparison proves nothing
python3 - "$first" > "$folder/planted.csv" <<'PYTHON'
import csv, sys

with open(sys.argv[1], newline="") as file:
    rows = list(csv.DictReader(file))
planted = next(row for row in rows if not row["known_defect"])
planted["answers"] = "0" * 16
writer = csv.DictWriter(sys.stdout, rows[0].keys())
writer.writeheader()
writer.writerows(rows)
PYTHON
if same "$first" "$folder/planted.csv" > /dev/null; then
    echo "the planted difference was not seen"
    exit 1
fi
status=0
for processor in "${processors[@]:1}"; do
    echo "${processors[0]} and $processor:"
    same "$first" "$folder/$processor.csv" || status=1
done
exit "$status"
