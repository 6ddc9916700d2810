#!/usr/bin/env python3
"""How long programs take to start and end: wall clock, medians.

    tests/bench/program_start.py build/colift [--rounds 31]
"""
import argparse
import statistics
import subprocess
import time

CALLS = (["--version"], ["--help"], ["check"], ["robots"], ["rank", "--help"], ["run", "--help"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("colift")
    parser.add_argument("--rounds", type=int, default=31)
    args = parser.parse_args()
    print("| command | ms, median | least |\n| --- | ---: | ---: |")
    for call in CALLS:
        took = []
        for _ in range(args.rounds):
            start = time.perf_counter()
            subprocess.run([args.colift, *call], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
            took.append(1e3 * (time.perf_counter() - start))
        print(f"| `colift {' '.join(call)}` | {statistics.median(took):.0f} | {min(took):.0f} |")


if __name__ == "__main__":
    main()
