"""Every header without a source file of its name compiles alone (source_rules.py sees to the others).

Usage: headers_alone.py COMPILER FLAG...
Most headers include Eigen by way of pipeline/base/math.h. That one is precompiled once, for all.
"""
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile

import source_rules


def compile_alone(header, command):
    source = f'#include "{header}"\n#include "{header}"\n'  # twice: the guard works
    done = subprocess.run([*command, "-fsyntax-only", "-x", "c++", "-"], input=source, capture_output=True, text=True, check=False)
    return header, done.returncode, done.stderr


def main():
    command = sys.argv[1:]
    headers = [n for n in source_rules.code_files()
               if n.endswith(".h") and not (source_rules.ROOT / (n[:-len(".h")] + ".cpp")).exists()]
    if not headers:
        sys.exit("no header found: the test would test nothing")
    failed = 0
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        common = pathlib.Path(folder) / "common.h"
        common.write_text('#include "pipeline/base/math.h"\n')
        subprocess.run([*command, "-x", "c++-header", common, "-o", f"{common}.gch"], check=True)
        command += ["-include", common]
        for header, code, message in pool.map(lambda h: compile_alone(h, command), headers):
            if code:
                failed += 1
                print(f"{header} does not compile alone:\n{message}")
    print(f"{len(headers)} headers compiled alone, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
