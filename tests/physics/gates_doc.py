#!/usr/bin/env python3
"""Writes docs/gates.md from what the gates measured: gates_doc.py GATES-FOLDER > docs/gates.md"""
import pathlib
import sys

print("""# Gates: laws the simulation is held to
Made from a run of `./thixo test --all`, which records every gate in `build/release/gates/`, by
`python3 tests/physics/gates_doc.py build/release/gates > docs/gates.md`. The scenes are in tests/physics/gates/ and run with
`thixo sim` as any other; their probes are the columns of `probes.csv`. A line without a reference is reported, not judged.

| law | quantity | measured | reference | tolerance | source |
|---|---|---|---|---|---|""")
for file in sorted(pathlib.Path(sys.argv[1]).glob("*.tsv")):
    for line in file.read_text().splitlines():
        law, quantity, unit, measured, reference, tolerance, source = line.split("\t")
        with_unit = lambda value: f"{value} {unit}".strip() if value else ""
        print(f"| {law} | {quantity} | {with_unit(measured)} | {with_unit(reference)} | {with_unit(tolerance)} | {source} |")
