#!/usr/bin/env python3
"""Holds the table of dependencies in docs/architecture.md against the include graph.

A row `| `folder` | a, b |` says that files of the folder include files of a and b and of no other folder. Both ways:
an include that the table lacks fails, and so does an entry that no file needs any more; a folder without a row too.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
SOURCES = {"*.cpp", "*.hpp", "*.h", "*.glsl", "*.comp"}
ROW = re.compile(r"^\| `((?:host|shaders)/\w+)` \| ([^|]*) \|$", re.MULTILINE)
INCLUDE = re.compile(r'^#include ["<](\w+/[^">]+)[">]', re.MULTILINE)


def place(file):
    """The folder of a file that is included, as in host/base; None for one that the build makes."""
    if (ROOT / "host/include" / file).is_file():
        return "host/include"
    above = next((above for above in ("host", "shaders") if (ROOT / above / file).is_file()), None)
    return above and f"{above}/{file.split('/')[0]}"


def found(folder):
    files = [file for pattern in SOURCES for file in (ROOT / folder).rglob(pattern)]
    names = {name for file in files for name in INCLUDE.findall(file.read_text(encoding="utf-8"))}
    return {place(name) for name in names} - {folder, None}


def main():
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    table = {row[1]: set(re.findall(r"(?:host|shaders)/\w+", row[2])) for row in ROW.finditer(text)}
    folders = {f"{above}/{entry.name}" for above in ("host", "shaders") for entry in (ROOT / above).iterdir()
               if entry.is_dir()}
    faults = [f"{folder} has no row" for folder in sorted(folders - table.keys())]
    faults += [f"{folder} has a row and does not exist" for folder in sorted(table.keys() - folders)]
    for folder in sorted(folders & table.keys()):
        includes = found(folder)
        faults += [f"{folder} includes {other}, which the table does not allow" for other in sorted(includes - table[folder])]
        faults += [f"{folder} includes nothing of {other} any more" for other in sorted(table[folder] - includes)]
    # One way: taking folders away that depend on nothing left must take all of them.
    left = dict(table)
    while ready := [folder for folder, needs in left.items() if not needs & left.keys()]:
        for folder in ready:
            del left[folder]
    if left:
        faults.append(f"{', '.join(sorted(left))} depend on each other in a circle")
    for fault in faults:
        print(f"docs/architecture.md: {fault}")
    print(f"{len(table)} folders, {sum(map(len, table.values()))} dependencies")
    return 1 if faults or not table else 0


if __name__ == "__main__":
    sys.exit(main())
