"""Rules every source file keeps: who may include whom, length, names, words. One unittest a rule; include_rules.txt is the list."""
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODE_FOLDERS = ("pipeline", "sim", "render")
CODE_ENDINGS = {".h", ".cpp"}
LONGEST_FILE = 600  # lines
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def repository_files():
    """Files of the repository: what git knows, or, in an unpacked archive, everything outside the build and output folders."""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            capture_output=True, check=False)
    if listed.returncode == 0:
        names = [name for name in listed.stdout.decode().split("\0") if name]
    else:
        names = [str(p.relative_to(ROOT)) for p in ROOT.rglob("*") if not re.match(r"(build|out|\.git)\b", str(p.relative_to(ROOT)))]
    return sorted(name for name in names if (ROOT / name).is_file())


def code_files(folders=CODE_FOLDERS):
    return [name for name in repository_files() if name.split("/")[0] in folders and pathlib.Path(name).suffix in CODE_ENDINGS]


def includes(name):
    """(line number, "<" or '"', path) of every include of a file."""
    for number, line in enumerate((ROOT / name).read_text().splitlines(), 1):
        if match := INCLUDE.match(line):
            yield number, match.group(1), match.group(2)


class Rules:
    def __init__(self, text):
        self.folders, self.libraries, self.not_in_headers, self.in_one_file = {}, {}, [], []
        for line in text.splitlines():
            line = line.split("#")[0].strip()
            if not line:
                continue
            key, _, value = line.partition(":")
            words = [] if value.strip() == "-" else value.split()
            if key == "not in headers":
                self.not_in_headers = words
            elif key == "in one file":
                self.in_one_file = words
            elif key.startswith("<"):
                self.libraries[key] = words
            else:
                self.folders[key] = words

    def folder_of(self, path):
        matches = [f for f in self.folders if path == f or path.startswith(f + "/")]
        return max(matches, key=len) if matches else None


RULES = Rules((ROOT / "tests/architecture/include_rules.txt").read_text())


def under(name, places):
    return any(name == p or name.startswith(p + "/") or name.startswith(p + ".") for p in places)


def forbidden_includes(name, rules=RULES, lines=None):
    """The problems of one file's includes, one line each."""
    problems = []
    own = rules.folder_of(name)
    if own is None:
        return [f"{name}: no folder of include_rules.txt covers it"]
    for number, kind, path in lines if lines is not None else includes(name):
        if kind == '"':
            target = rules.folder_of(path)
            if target is None:
                problems.append(f'{name}:{number}: "{path}" is not a path from the root into a folder with a rule')
            elif target != own and target not in rules.folders[own]:
                problems.append(f"{name}:{number}: {own} may not include {target}")
        else:
            for library, places in rules.libraries.items():
                if ("<" + path).startswith(library) and not under(name, places):
                    problems.append(f"{name}:{number}: <{path}> belongs in {' '.join(places)} alone")
            if name.endswith(".h") and any(("<" + path).startswith(h) for h in rules.not_in_headers):
                problems.append(f"{name}:{number}: <{path}> is costly to parse; include it in the .cpp only")
    return problems


class SourceRules(unittest.TestCase):
    def none(self, problems):
        self.assertEqual([], problems, "\n" + "\n".join(problems))

    def test_includes_follow_the_arrows(self):
        self.none([p for name in code_files() for p in forbidden_includes(name)])

    def test_the_rule_sees_a_wrong_arrow(self):
        wrong = {("sim/a.cpp", '"', "render/film.h"), ("render/a.cpp", '"', "sim/particles.h"), ("pipeline/base/a.h", '"', "pipeline/contract/frame.h"),
                 ("pipeline/driver/a.cpp", '"', "pipeline/geometry/shape.h"), ("pipeline/geometry/a.cpp", '"', "pipeline/contract/frame.h"),
                 ("sim/a.cpp", "<", "embree3/rtcore.h"), ("pipeline/contract/a.h", "<", "openvdb/openvdb.h")}
        for name, kind, path in wrong:
            self.assertEqual(1, len(forbidden_includes(name, lines=[(1, kind, path)])), (name, path))
        self.assertEqual([], forbidden_includes("sim/a.cpp", lines=[(1, '"', "pipeline/geometry/shape.h")]))

    def test_costly_libraries_stand_in_one_file(self):
        for library in RULES.in_one_file:
            users = {name for name in code_files() for _, kind, path in includes(name) if (kind + path).startswith(library)}
            self.assertLessEqual(len(users), 1, f"{library}: {sorted(users)}")

    def test_linked_targets_follow_the_arrows(self):
        """The build may not link what the sources may not include: thixo_<name> belongs to the folder that defines it."""
        lists = {n: (ROOT / n).read_text() for n in repository_files() if n.endswith("CMakeLists.txt") and n.split("/")[0] in CODE_FOLDERS}
        owner = {}
        for name, text in lists.items():
            for target in re.findall(r"(?:thixo_library|add_library|add_executable)\(\s*([\w-]+)", text):
                owner[target] = RULES.folder_of(os.path.dirname(name))
        problems = []
        for name, text in lists.items():
            own = RULES.folder_of(os.path.dirname(name))
            text = re.sub(r"#.*", "", text)
            for target in re.findall(r"\bthixo_\w+\b|\bthixo-\w+\b", text):
                folder = owner.get(target)
                if folder and folder != own and folder not in RULES.folders[own]:
                    problems.append(f"{name}: {own} may not link {target} of {folder}")
        self.none(problems)

    def test_libraries_of_the_simulation_link_along_the_arrows(self):
        """sim/CMakeLists.txt has a library a folder: what one links, directly or not, its folder may include."""
        text = (ROOT / "sim/CMakeLists.txt").read_text()
        folders, links = {}, {}
        for name, body in re.findall(r"thixo_library\((thixo_\w+)(.*?)\n  DOUBLE\)", text, re.S):
            sources, link = body.split("LINK", 1)
            folders[name] = {f"sim/{source.split('/')[0]}" for source in re.findall(r"[\w/]+\.cpp", sources)}
            links[name] = re.findall(r"\bthixo_\w+", link)
            self.assertEqual(1, len(folders[name]), f"{name} has sources of {folders[name]}")
        self.assertGreater(len(folders), 10)
        problems = []
        for name, own in ((n, next(iter(f))) for n, f in folders.items()):
            for other in (next(iter(folders[link])) for link in links[name] if link in folders):
                if other != own and other not in RULES.folders[own]:
                    problems.append(f"{name}: {own} may not link {other}")
        self.none(problems)

    def test_how_a_scene_is_solved_is_chosen_at_set_up_alone(self):
        """The words of the scene that choose a method are compared in sim/stage; everything else asks Strategy or Plan."""
        words = re.compile(r"\bscene::(Pressure|Viscosity|SolidSteps|Lattice)\b")
        self.none([f"{name}:{number}: {line.strip()}" for name in code_files(("sim",)) if not name.startswith("sim/stage/")
                   for number, line in enumerate((ROOT / name).read_text().splitlines(), 1) if words.search(line)])

    def test_no_header_includes_twenty_others(self):
        self.none([f"{name}: {count} includes" for name in code_files()
                   if name.endswith(".h") and (count := sum(1 for _ in includes(name))) >= 20])

    def test_no_file_is_too_long(self):
        long = [f"{n}: {count} lines" for n in code_files(CODE_FOLDERS + ("tests",))
                if (count := len((ROOT / n).read_text().splitlines())) > LONGEST_FILE]
        self.none(long)

    def test_a_source_file_includes_its_own_header_first(self):
        """Then the build itself proves that header self-contained; headers_alone covers those without a source file."""
        problems = []
        for name in code_files():
            header = name[:-len(".cpp")] + ".h"
            if name.endswith(".cpp") and (ROOT / header).exists():
                first = next(includes(name), (0, "", ""))
                if first[2] != header:
                    problems.append(f'{name}:{first[0]}: include "{header}" first')
        self.none(problems)

    def test_nothing_is_left_open_and_no_path_of_one_machine(self):
        words = re.compile(r"\b(" + "|".join(["TO" + "DO", "FIX" + "ME", "XX" + "X", "HA" + "CK"]) + r")\b|not implemented|unimplemented")
        path = re.compile(r"(?<![\w./$}\"-])/(home|root|work|Users)/")
        texts = {".h", ".cpp", ".py", ".md", ".txt", ".cmake", ".yaml", ".json", ".sh", ""}
        problems = []
        for name in repository_files():
            if pathlib.Path(name).suffix not in texts or name == "tests/architecture/source_rules.py":
                continue
            for number, line in enumerate((ROOT / name).read_text(errors="replace").splitlines(), 1):
                if words.search(line) or path.search(line):
                    problems.append(f"{name}:{number}: {line.strip()[:120]}")
        self.none(problems)

    def test_random_numbers_and_clocks_come_from_base(self):
        banned = re.compile(r"\brand\(|\bstd::random_device|\bstd::mt19937|\bsystem_clock\b|\btime\(nullptr\)|\btime\(NULL\)")
        self.none([f"{n}:{i}: {line.strip()}" for n in code_files() if not n.startswith("pipeline/base/")
                   for i, line in enumerate((ROOT / n).read_text().splitlines(), 1) if banned.search(line)])

    def test_every_test_folder_mirrors_a_source_folder(self):
        extra = {"architecture", "bench", "physics", "scenes", "golden", "data"}
        problems = []
        for name in code_files(("tests",)):
            folder = os.path.dirname(name)[len("tests/"):]
            if folder and folder.split("/")[0] not in extra and not (ROOT / folder).is_dir():
                problems.append(f"{name}: there is no source folder {folder}")
        self.none(sorted(set(problems)))

    def test_fast_tests_simulate_nothing(self):
        """A program of unit tests that advances a simulation says SLOW, and `./thixo test --fast` leaves it out."""
        problems, marked = [], 0
        for name in repository_files():
            if not (name.startswith("tests/") and name.endswith("CMakeLists.txt")):
                continue
            text = re.sub(r"#.*", "", (ROOT / name).read_text())
            for program, words in re.findall(r"thixo_test\((\w+) LABEL unit\b([^)]*)\)", text):
                if "SLOW" in words.split():
                    marked += 1
                    continue
                for source in re.findall(r"[\w/]+\.cpp", words):
                    if re.search(r"\b(make_simulation|advance_frame|step)\(", (ROOT / os.path.dirname(name) / source).read_text()):
                        problems.append(f"{name}: {program} simulates in {source} and does not say SLOW")
        self.none(problems)
        self.assertGreater(marked, 0)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
