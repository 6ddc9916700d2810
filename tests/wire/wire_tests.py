"""Runs the tests of a far end that is played in Python, each anew where this machine held the far end up."""

import subprocess
import sys
import time


def main(tests, far_end, attempts, at_once=1):
    """Those of `tests` that are named, or all: COLIFT [NAME...]. `far_end` knows its longest_pause, of all instances since
    it was set to 0, MAX_PAUSE and their UNIT, and how to end the last program under test: end_program(). Far end and
    program wait for each other most of the time, so all tests are shared out to `at_once` processes."""
    colift, names = sys.argv[1], sys.argv[2:]
    if at_once > 1 and not names:
        shares = [[test.__name__ for test in tests[i::at_once]] for i in range(min(at_once, len(tests)))]
        processes = [subprocess.Popen([sys.executable, sys.argv[0], colift, *share]) for share in shares]
        ends = [p.wait() for p in processes]  # negative of a process that a signal ended
        return 1 if any(ends) else 0
    failed = 0
    for test in tests:
        if names and test.__name__ not in names:
            continue
        for attempt in range(attempts):
            began = time.monotonic()
            far_end.longest_pause = 0.0
            try:
                test(colift)
                print(f"ok      {test.__name__} ({time.monotonic() - began:.1f} s)", flush=True)
                break
            except Exception as e:  # the next test has its own program
                far_end.end_program()
                # a far end that pauses is a link that is cut: that says nothing about the program
                if far_end.longest_pause > far_end.MAX_PAUSE and attempt + 1 < attempts:
                    print(f"again   {test.__name__}: this far end paused for {far_end.longest_pause:.3g} {far_end.UNIT}",
                          flush=True)
                    continue
                failed += 1
                print(f"FAILED  {test.__name__}: {type(e).__name__}: {str(e)[:2000]}", flush=True)
                break
    return 1 if failed else 0
