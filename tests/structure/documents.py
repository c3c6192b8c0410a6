#!/usr/bin/env python3
"""Holds the documents against the repository.

Every relative link of a Markdown file leads to a file, and to a heading where it names one; every path in backticks that
begins with a folder of the repository exists (NAME stands for any); README.md has at most 9 KB, and no document more than 500 lines.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(sys.argv[1])
MOST_BYTES_OF_README, MOST_LINES = 9 * 1024, 500
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
PATH = re.compile(r"`((?:cmake|docs|host|scenes|shaders|tests)/[\w./-]+)`")
CODE = re.compile(r"^( {4}.*|```.*?^```)$", re.MULTILINE | re.DOTALL)


def documents():
    """Those that git knows or would; all but build folders where there is no git."""
    try:
        listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard", "*.md"],
                                capture_output=True, text=True, check=True).stdout.split("\n")
        return sorted(ROOT / name for name in listed if name and (ROOT / name).is_file())
    except (OSError, subprocess.CalledProcessError):
        return sorted(path for path in ROOT.rglob("*.md") if not path.is_relative_to(ROOT / "build"))


def anchors(text):
    """What GitHub makes of headings: small letters, no punctuation, spaces as dashes, numbers where they repeat."""
    seen = {}
    for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")
        count = seen[name] = seen.get(name, -1) + 1
        yield name if count == 0 else f"{name}-{count}"


def faults_of(path):
    text = path.read_text(encoding="utf-8")
    prose = CODE.sub("", text)
    for link in LINK.findall(prose):
        if re.match(r"[a-z]+:", link):
            continue
        file, _, anchor = link.partition("#")
        target = (path.parent / file).resolve() if file else path
        if not target.exists():
            yield f"links to {link}, which does not exist"
        elif anchor and anchor not in anchors(target.read_text(encoding="utf-8")):
            yield f"links to {link}, but there is no such heading"
    for name in PATH.findall(prose):
        if "NAME" not in name and not (ROOT / name).exists():
            yield f"names {name}, which does not exist"
    if path == ROOT / "README.md" and len(text.encode()) > MOST_BYTES_OF_README:
        yield f"has {len(text.encode())} bytes, more than {MOST_BYTES_OF_README}"
    if text.count("\n") > MOST_LINES:
        yield f"has {text.count(chr(10))} lines, more than {MOST_LINES}: split it by topic"


def main():
    files = documents()
    faults = [f"{path.relative_to(ROOT)} {fault}" for path in files for fault in faults_of(path)]
    for fault in faults:
        print(fault)
    print(f"{len(files)} documents")
    return 1 if faults or not files else 0


if __name__ == "__main__":
    sys.exit(main())
