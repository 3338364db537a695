#!/usr/bin/env python3
"""Runs the benchmarks, writes docs/performance.md and docs/performance.json, and compares ratios with those recorded before.

    cmake --preset bench && cmake --build --preset bench
    python3 tests/bench/record.py build/bench/bin            all of them: about an hour on a quiet machine
    python3 tests/bench/record.py build/bench/bin rays cache     only these runs; the others keep their records
    python3 tests/bench/record.py build/bench/bin --check    writes nothing

Exit code 1 where a ratio is worse than its record by more than --tolerance (0.1: a tenth), else 0.
"""
import argparse
import datetime
import json
import os
import pathlib
import subprocess
import sys

import figures

ROOT = pathlib.Path(__file__).resolve().parents[2]


def perform(run, folder):
    """Runs one program; its Counters or Lines."""
    command = [folder / run.program, *run.arguments]
    if run.names:
        command += [f"--benchmark_filter={run.names}", "--benchmark_format=json", f"--benchmark_repetitions={run.repetitions}",
                    f"--benchmark_enable_random_interleaving={'true' if run.interleaved else 'false'}"]
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True, check=True)
    return figures.Counters(json.loads(done.stdout)) if run.names else figures.Lines(done.stdout)


def machine():
    """Processor and number of cores, without what names this one machine."""
    models = [line.split(":")[1].strip() for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    return f"{models[0] if models else 'unknown processor'}, {os.cpu_count()} cores"


def measure(names, folder):
    """A record of every figure that the named runs give."""
    records = {}
    for name in names:
        print(f"record: {name}", file=sys.stderr, flush=True)
        load = os.getloadavg()[0]
        result = perform(figures.RUNS[name], folder)
        for figure in figures.FIGURES:
            if figure.run != name:
                continue
            value, ratio = figure.value(result), figure.ratio and figure.ratio(result)
            records[figure.name] = {"value": value, "ratio": ratio, "met": figure.met and figure.met(value, ratio), "machine": machine(),
                                    "load": round(load, 1), "date": datetime.date.today().isoformat()}
    return records


def comparisons(before, records, tolerance):
    """A line for each figure that was measured, and whether any ratio is worse."""
    lines, worse = [], False
    for name, record in records.items():
        old = before.get(name, {}).get("ratio")
        if record["ratio"] is None:
            continue
        if old is None:
            lines.append(f"{name}: ratio {record['ratio']:.3g}, the first record")
            continue
        change = record["ratio"] / old - 1
        slower = change > tolerance
        worse = worse or slower
        lines.append(f"{name}: ratio {record['ratio']:.3g}, before {old:.3g} ({change:+.0%}){', WORSE' if slower else ''}")
    return lines, worse


def number(value):
    return "" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def document(records):
    rows = []
    for figure in figures.FIGURES:
        record = records.get(figure.name)
        if not record:
            continue
        met = {None: "", True: "yes", False: "no"}[record["met"]]
        before = "" if record.get("before") is None else f"{record['ratio'] / record['before'] - 1:+.0%}"
        rows.append(f"| {figure.name} | {figure.aim} | {met} | {number(record['value'])} {figure.unit} | {number(record['ratio'])} "
                    f"| {figure.reference} | {before} | {record['machine']}, load {record['load']} | {record['date']} |")
    return "\n".join(["""# Performance

Written by `python3 tests/bench/record.py build/bench/bin`, which also compares with the record before (docs/performance.json).
A ratio is the cost here over the cost of the reference: smaller is better. Most references are measured in the same run.
"Of another run" marks those that are not. Read ratios; bare figures depend on the machine and on its load, which is given.

Aims are ratios too, unless they have a unit. Where a line names a program, its figure was measured on a machine of this kind.
Benchmarks that were never recorded have no line.

| what | aim, limit or peer | met | figure | ratio | to | ratio, since the record before | machine | date |
|---|---|---|---|---|---|---|---|---|""", *rows, ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="where the benchmarks are: build/bench/bin")
    parser.add_argument("runs", nargs="*", help=f"of: {', '.join(figures.RUNS)}; all when left out")
    parser.add_argument("--check", action="store_true", help="compare only, write nothing")
    parser.add_argument("--tolerance", type=float, default=0.1, help="by what share a ratio may be worse")
    parser.add_argument("--docs", type=pathlib.Path, default=ROOT / "docs", help="where performance.md and performance.json are")
    asked = parser.parse_args()
    unknown = set(asked.runs) - set(figures.RUNS)
    if unknown:
        parser.error(f"no such run: {', '.join(sorted(unknown))}")
    file = asked.docs / "performance.json"
    before = json.loads(file.read_text()) if file.exists() else {}
    records = measure(asked.runs or figures.RUNS, asked.folder)
    lines, worse = comparisons(before, records, asked.tolerance)
    print("\n".join(lines))
    if not asked.check:
        for name, record in records.items():
            record["before"] = before.get(name, {}).get("ratio")
        known = {figure.name for figure in figures.FIGURES}
        merged = {name: record for name, record in {**before, **records}.items() if name in known}
        file.write_text(json.dumps(merged, indent=1) + "\n")
        (asked.docs / "performance.md").write_text(document(merged))
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
