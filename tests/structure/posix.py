#!/usr/bin/env python3
"""Nothing outside host/base calls the operating system by POSIX: not one of its headers is included elsewhere in host/, and
none of its functions that standard headers of C declare as well is named."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1]) / "host"
HEADERS = re.compile(r"#\s*include\s*<((?:sys|netinet|arpa|net)/[^>]+|(?:unistd|fcntl|dlfcn|dirent|pthread|poll|termios|netdb|"
                     r"sched|spawn|signal|semaphore|syslog|pwd|grp|glob|fnmatch|ftw|utime|wordexp|strings|langinfo|aio|"
                     r"mqueue|ifaddrs)\.h|csignal)>")
FUNCTIONS = re.compile(r"(?<![\w.>])(?:::)?(setenv|unsetenv|putenv|mkstemps?|mkostemps?|mkdtemp|realpath|fileno|fdopen|popen|"
                       r"pclose|getline_r|random_r|srandom|clock_gettime|nanosleep|localtime_r|gmtime_r|strtok_r|strerror_r|"
                       r"strsignal|sigaction|kill|fork|getpid|isatty|dlopen|dlsym|mmap|munmap)\s*\(")


def main():
    faults = []
    files = [file for pattern in ("*.cpp", "*.hpp", "*.h") for file in ROOT.rglob(pattern)]
    elsewhere = [file for file in files if ROOT / "base" not in file.parents]
    for file in sorted(elsewhere):
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            code = line.split("//")[0]
            found = HEADERS.search(code) or FUNCTIONS.search(re.sub(r'"(?:\\.|[^"\\])*"', '""', code))
            if found:
                faults.append(f"{file.relative_to(ROOT.parent)}:{number}: {found[0].strip()}: POSIX belongs into host/base")
    for fault in faults:
        print(fault)
    print(f"{len(elsewhere)} files outside host/base")
    # The search itself finds what there is to find.
    base = "\n".join(file.read_text(encoding="utf-8") for file in files if file not in elsewhere)
    blind = not HEADERS.search(base) or not FUNCTIONS.search(base)
    if blind:
        print("host/base calls nothing: the search is blind")
    return 1 if faults or blind or not elsewhere else 0


if __name__ == "__main__":
    sys.exit(main())
