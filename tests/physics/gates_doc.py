#!/usr/bin/env python3
"""Writes docs/gates.md from the record of the gates: gates_doc.py GATES-FOLDER > docs/gates.md"""
import pathlib
import sys

print("""# Gates: laws the simulation is held to

`./thixo test --all` records every gate in `build/release/gates/`. This page is made from that record by
`python3 tests/physics/gates_doc.py build/release/gates > docs/gates.md`. The scenes are in `tests/physics/gates/` and run with
`thixo sim` as any other; their probes are the columns of `probes.csv`. A line without a reference is reported, not judged.

The last column names the origin of reference and tolerance: a law, a publication, or a need of those who look at the
film. A **bound on change** comes from none of these. It lies a little above what was measured when the gate was
made, and tells only that something has changed. Most of them are of four kinds:

- *Pressure in drops.* The scale of the surface tension was set by the pressure in such drops. The drops confirm laws by
  what was not set: how fast they swing, and that all radii give one tension.
- *Dam front with a delay.* The delay is the one that brings the simulated front nearest to the experiment's. The
  front's shape alone is held to the experiment; its speed and its distance to the ideal fluid's front are laws.
- *Texture on what melts.* The need is a hundredth of the body's size in the median. Stricter bounds, and those on the
  farthest surfels, are on change.
- *Moves of surfels.* The need is that no surfel moves by a tenth of its support h, which is seen as a pop. Bounds on 99
  surfels in 100 are on change. **A box that melts misses the need**: when the animated surface takes over, a few new
  surfels at its foot move by more.

Waves and outflow are reported without a verdict, for `dfsph` misses what they should be. The pressure of particles resists
a change of their arrangement, as a packing of grains does. At the usual support of two spacings a standing wave is 4 to 5 %
short in period and loses most of its height in five periods. Neither the lattice at the start, nor the step, nor the
solver's tolerance changes that. A support of 2.5 spacings halves the error of the period. Shifts of particles towards an even
distribution (Lind et al. 2012) leave the period as it is, and take away more of the height.

Capillary waves are reported, too. The scale of the tension is that of drops of 7 to 11 spacings at rest. Waves on a flat sheet swing as
if by 0.6 to 0.73 of it: least where the liquid is thin and the wave high. On a sheet that has not settled it is half. Two energies of the surface were tried in its place,
of the gradient and of the lack of the colour. Sheets under the first fly apart, and under the second no longer swing.

| law | quantity | measured | reference | tolerance | source |
|---|---|---|---|---|---|""")
for file in sorted(pathlib.Path(sys.argv[1]).glob("*.tsv")):
    for line in file.read_text().splitlines():
        law, quantity, unit, measured, reference, tolerance, source = line.split("\t")
        with_unit = lambda value: f"{value} {unit}".strip() if value else ""
        print(f"| {law} | {quantity} | {with_unit(measured)} | {with_unit(reference)} | {with_unit(tolerance)} | {source} |")
