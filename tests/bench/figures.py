"""What the benchmarks are read for: the programs to run, and the figures that docs/performance.md shows.

A ratio is the cost here over the cost of a reference: smaller is better. Most references are measured in the same run, turn by turn. Their
ratios depend little on the machine and on its load. "Of another run" marks the other references.
"""
import dataclasses
import re
import typing


@dataclasses.dataclass(frozen=True)
class Run:
    """A program of build/bench/bin. With `names`, a regular expression, it is a Google Benchmark, else it prints lines."""
    program: str
    names: str = ""
    arguments: tuple = ()
    repetitions: int = 3
    interleaved: bool = True


@dataclasses.dataclass(frozen=True)
class Figure:
    """`value`, `ratio` and `met` take what the run gave: Counters or Lines. `met` also takes value and ratio."""
    name: str
    run: str
    unit: str
    value: typing.Callable
    ratio: typing.Callable = None
    reference: str = ""
    aim: str = ""
    met: typing.Callable = None


class Counters:
    """Medians over the repetitions of a Google Benchmark: counters["grid_search/97336/212", "cpu_time"]."""
    def __init__(self, document):
        self.values = {}
        for entry in document["benchmarks"]:
            if entry["run_type"] != "iteration":
                continue
            if entry.get("error_occurred"):
                raise ValueError(f"{entry['name']}: {entry['error_message']}")
            name = re.sub(r"/(real_time|manual_time|iterations:\d+|repeats:\d+)", "", entry["run_name"])
            for key, value in entry.items():
                if isinstance(value, (int, float)):
                    self.values.setdefault((name, key), []).append(value)

    def __getitem__(self, key):
        values = sorted(self.values[key])
        middle = len(values) // 2
        return values[middle] if len(values) % 2 else (values[middle - 1] + values[middle]) / 2


class Lines:
    """What a program printed; `find` gives the numbers that a regular expression captures, in its first match."""
    def __init__(self, text):
        self.text = text

    def find(self, pattern):
        match = re.search(pattern, self.text)
        if not match:
            raise ValueError(f"nothing matches '{pattern}' in:\n{self.text}")
        numbers = [float(group) for group in match.groups()]
        return numbers[0] if len(numbers) == 1 else numbers


RUNS = {
    "search": Run("search_bench", "(grid|nanoflann)_search/300763/212"),
    "density": Run("density_bench", "(density_sweep|bare_reference)/217"),
    "eos": Run("step_bench", "step_of/0/217|bare_sweep/217"),
    "dfsph": Run("step_bench", "step_of/1/217|bare_sweep/217", interleaved=False),  # each change of the dam takes a minute
    "sizes": Run("step_bench", "steps_by_size/[01]/(10000|1000000)$", repetitions=1),
    "viscosity": Run("viscosity_bench", "viscous_step/1000"),
    "elastic": Run("solids_bench", "elastic_sub_step/1/30000|bare_sweep/30000|embedded_surface"),
    "cantilever": Run("solids_bench", "cantilever/6/5/30000/2", repetitions=1),
    "contact": Run("contact_bench", "contact/|contact_surface"),
    "many bodies": Run("contact_bench", "contact_of_many", repetitions=1),
    "breaking": Run("fragments_bench", "can_break/(0|8)|fragments/(100|200)"),
    "surface": Run("surface_bench", "glass_update/1/|pool_update|splash_update"),
    "geometry": Run("geometry_bench", "."),
    "cache": Run("cache_bench", "."),
    "rays": Run("surfel_rays_bench", "blended|trimmed"),
    "commit": Run("commit_bench", "."),
    "scale": Run("scale_bench", arguments=("1e6",)),
    "picture": Run("picture_bench"),
    "memory": Run("memory_bench"),
    "dam break": Run("dam_break_bench"),
    "published": Run("published_bench", arguments=("1", "fig_5_05_bust", "fig_5_24_octopus", "fig_6_09_melting_bust:36")),
}

# Programs that need files of their user, and so have no run.
BY_HAND = {"clean_bench"}


def time_over(own, reference, clock="cpu_time"):
    return lambda c: c[own, clock] / c[reference, clock]


def rate_under(own, reference):
    return lambda c: c[reference, "items_per_second"] / c[own, "items_per_second"]


def counter(name, key, scale=1):
    return lambda c: scale * c[name, key]


def inverse(read):
    return lambda c: 1 / read(c)


def found(pattern, place=None):
    return lambda lines: lines.find(pattern) if place is None else lines.find(pattern)[place]


def ratio_at_most(limit):
    return lambda value, ratio: ratio <= limit


def published(figure):
    """A line of published_bench: milliseconds of a step and its update, and how many times as fast as the dissertation's they are."""
    line = rf"{figure} .*\| +([\d.]+) = .*\| +([\d.]+) = .*\| +[\d.]+ +(\d+)\n"
    return Figure(f"{figure}: a step and its surface", "published", "ms", lambda lines: sum(lines.find(line)[:2]),
                  lambda lines: 1 / lines.find(line)[2], "dissertation, 5.10", "1/50", ratio_at_most(1 / 50))


def rays(name, what, aim="", limit=None):
    return Figure(f"blended surfels, {what}", "rays", "million rays a second", counter(name, "surfels"), inverse(counter(name, "ratio")),
                  "Embree's discs, bare", aim, limit and ratio_at_most(limit))


SPLISHSPLASH = "SPlisHSPlasH 2.16"
SCALE_LINE = r" 1000000 surfels: .*, +(\d+) bytes each; ray +(\d+) ns primary \(discs +(\d+)\)"
DAM_LINE = r"([\d.]+) simulated seconds per hour\n\d+ steps, ([\d.]+) ms each"
MELTING_STEP = r"a step +([\d.]+) ms, published [\d.]+ s: (\d+) times"
MELTING_UPDATE = r"an update +([\d.]+) ms, published [\d.]+ s an iteration: (\d+) times"

FIGURES = [
    Figure("neighbour search, 300 763 particles, 37 neighbours", "search", "ns a particle",
           counter("grid_search/300763/212", "s/particle", 1e9), time_over("grid_search/300763/212", "nanoflann_search/300763/212"), "nanoflann",
           "1/7", ratio_at_most(1 / 7)),
    Figure("density sweep with walls", "density", "ms", counter("density_sweep/217", "cpu_time"), time_over("density_sweep/217", "bare_reference/217"),
           "the bare sums"),
    Figure("step, `eos`, 100 000 particles, one thread", "eos", "million particle-steps a second", counter("step_of/0/217", "items_per_second", 1e-6),
           time_over("step_of/0/217", "bare_sweep/217"), "a bare sweep", f"{SPLISHSPLASH}: 0.49 million"),
    Figure("step, `dfsph`, 100 000 particles, one thread", "dfsph", "million particle-steps a second",
           counter("step_of/1/217", "items_per_second", 1e-6), time_over("step_of/1/217", "bare_sweep/217"), "a bare sweep",
           f"{SPLISHSPLASH}: 0.47 million"),
    Figure("step, `eos`, a million particles, by particle", "sizes", "million particle-steps a second",
           counter("steps_by_size/0/1000000", "items_per_second", 1e-6), rate_under("steps_by_size/0/1000000", "steps_by_size/0/10000"),
           "ten thousand particles"),
    Figure("step, `dfsph`, a million particles, by particle", "sizes", "million particle-steps a second",
           counter("steps_by_size/1/1000000", "items_per_second", 1e-6), rate_under("steps_by_size/1/1000000", "steps_by_size/1/10000"),
           "ten thousand particles"),
    Figure("dam break, `dfsph`, 94 000 particles, two threads", "dam break", "simulated seconds an hour", found(DAM_LINE, 0),
           lambda lines: lines.find(DAM_LINE)[1] / lines.find(r"a bare sweep ([\d.]+)"), "a bare sweep", f"{SPLISHSPLASH}: 37",
           lambda value, ratio: value >= 37),
    Figure("memory of a running `eos` simulation", "memory", "bytes a particle", lambda lines: float(re.findall(r"slope: (\d+) bytes", lines.text)[-1]),
           lambda lines: float(re.findall(r"slope: (\d+) bytes", lines.text)[-1]) / 960, f"{SPLISHSPLASH}, of another run", f"{SPLISHSPLASH}: 960",
           ratio_at_most(1)),
    Figure("viscosity, one iteration", "viscosity", "ms", counter("viscous_step/1000", "ms_per_iteration"),
           lambda c: c["viscous_step/1000", "ms_per_iteration"] / c["viscous_step/1000", "density_sweep_ms"], "a density sweep"),
    Figure("elastic sub-step, 30 000 particles, one thread", "elastic", "ns a particle", counter("elastic_sub_step/1/30000", "ns_per_particle"),
           lambda c: c["elastic_sub_step/1/30000", "real_time"] / c["bare_sweep/30000", "real_time"], "a bare sweep"),
    Figure("cantilever in implicit steps of 5 ms, 30 000 particles", "cantilever", "simulated seconds an hour",
           counter("cantilever/6/5/30000/2", "simulated_s_per_hour"), lambda c: 97 / c["cantilever/6/5/30000/2", "simulated_s_per_hour"],
           "Kugelstadt et al. 2021, of another run", "Kugelstadt et al. 2021: 97", ratio_at_most(1)),
    Figure("surfels of a solid, moved", "elastic", "million surfels a second", counter("embedded_surface/1/10000", "items_per_second", 1e-6)),
    Figure("contact of two bodies", "contact", "contact nodes", counter("contact/1", "nodes"), counter("contact/1", "over_elastic"),
           "the elastic sub-steps"),
    Figure("contact surface of two bodies", "contact", "surfels", counter("contact_surface/1", "surfels"), counter("contact_surface/1", "over_apart"),
           "the same surfaces apart"),
    *[Figure(f"contact of {n} bodies, {what}", "many bodies", "us a body", counter(f"contact_of_many/{block}", key),
             counter(f"contact_of_many/{block}", ratio), "30 bodies, by body", "1.5", ratio_at_most(1.5))
      for n, block in ((300, "10/6/5"), (1000, "10/10/10"))
      for what, key, ratio in (("forces", "us_per_body", "over_30"), ("surface", "surface_us_per_body", "surface_over_30"))],
    *[Figure(f"a step of what can break, {what}", "breaking", "ms", counter(f"can_break/{number}", "real_time"),
             counter(f"can_break/{number}", "over_unbreakable"), "the same that never breaks", "1.05", ratio_at_most(1.05))
      for number, what in ((0, "implicit"), (8, "eight sub-steps"))],
    *[Figure(f"{n} fragments in a row that push each other", "breaking", "us a fragment", counter(f"fragments/{n}", "us_per_fragment"),
             counter(f"fragments/{n}", "over_50"), "50 fragments, by fragment", "1.2", ratio_at_most(1.2)) for n in (100, 200)],
    *[Figure(f"animated surface, {what}", "surface", "us a surfel", counter(name, "us_per_surfel"), inverse(counter(name, "times_published")),
             "dissertation, 6.7", "1/50", ratio_at_most(1 / 50))
      for name, what in (("glass_update/1", "poured into a glass"), ("pool_update", "a pool"), ("splash_update", "a splash"))],
    published("fig_5_05_bust"),
    published("fig_5_24_octopus"),
    Figure("fig_6_09_melting_bust: a step", "published", "ms", found(MELTING_STEP, 0), lambda lines: 1 / lines.find(MELTING_STEP)[1],
           "dissertation, table 6.1", "1/50", ratio_at_most(1 / 50)),
    Figure("fig_6_09_melting_bust: an update of the surface", "published", "ms", found(MELTING_UPDATE, 0),
           lambda lines: 1 / lines.find(MELTING_UPDATE)[1], "dissertation, table 6.1, an iteration", "1/50", ratio_at_most(1 / 50)),
    Figure("projection onto the implicit surface", "geometry", "million a second", counter("projection_orthogonal", "items_per_second", 1e-6),
           rate_under("projection_orthogonal", "reference_one_evaluation"), "one evaluation"),
    Figure("winding number by clusters", "geometry", "million a second", counter("winding_number", "items_per_second", 1e-6),
           rate_under("winding_number", "reference_all_solid_angles"), "the sum over all triangles"),
    Figure("sampled shape, distance", "geometry", "million a second", counter("sampled_distance", "items_per_second", 1e-6),
           rate_under("sampled_distance", "reference_exact_distance"), "the exact distance to a mesh"),
    Figure("writing a frame of a million particles", "cache", "ms", counter("cache_write", "real_time"), time_over("cache_write", "raw_write", "real_time"),
           "the bare bytes"),
    Figure("reading a frame of a million particles", "cache", "ms", counter("cache_read", "real_time"), time_over("cache_read", "raw_read", "real_time"),
           "the bare bytes"),
    rays("blended_primary", "primary rays", "1/0.7", 1 / 0.7),
    rays("blended_bounce", "bounces", "1/0.6", 1 / 0.6),
    rays("blended_crossing", "crossing rays"),
    rays("trimmed_primary", "primary rays, trimmed"),
    rays("trimmed_crossing", "crossing rays, trimmed"),
    rays("trimmed_curved", "primary rays, a curved sheet trimmed"),
    Figure("500 000 surfels made ready for rays", "commit", "ms", counter("commit", "surfels_ms"), inverse(counter("commit", "ratio")), "Embree's discs",
           "60 ms", lambda value, ratio: value <= 60),
    Figure("a million surfels, primary ray", "scale", "ns", found(SCALE_LINE, 1), lambda lines: lines.find(SCALE_LINE)[1] / lines.find(SCALE_LINE)[2],
           "Embree's discs, bare"),
    Figure("a million surfels, memory", "scale", "bytes each", found(SCALE_LINE, 0)),
    Figure("picture of 500 000 surfels, all threads", "picture", "s", found(r"picture in ([\d.]+) s"),
           lambda lines: lines.find(r"picture in ([\d.]+) s") / 3.4, "Cycles with spheres, of another run", "3.4 s", ratio_at_most(1)),
    Figure("picture of 500 000 surfels, peak of memory", "picture", "MB", found(r"peak (\d+) MB"), aim="200 MB", met=lambda value, ratio: value <= 200),
]
