#!/usr/bin/env python3
"""Runs Spin over pipeline.pml: the model as it is must hold in every state, and each planted fault
must be found, by the check that is there for it.

usage: pipeline_model_test.py MODEL CC      exits 1 when a claim fails, 77 where spin is missing
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

SAFETY, ENDS = ["-DSAFETY", "-DNOCLAIM"], []
# (planted fault, model size, what is verified, what Spin must say; None: no error)
RUNS = [
    (None, (2, 3), SAFETY, None),
    (None, (1, 2), ENDS, None),
    ("SHORT_RING", (2, 3), SAFETY, "assertion violated"),
    ("RELEASED_TWICE", (2, 3), SAFETY, "assertion violated"),
    ("NO_UNCLAIM", (2, 3), SAFETY, "there=="),
    ("LATE_FLAG", (2, 3), SAFETY, "there=="),
    ("STOP_DOES_NOT_WAIT", (2, 3), SAFETY, "there=="),
    ("LEAVES_FULL_RING", (2, 3), SAFETY, "there=="),
    ("FAILED_FRAME_STAYS", (2, 3), SAFETY, "there=="),
    ("COUNTED_LATE", (2, 3), SAFETY, "delivered<="),
    ("END_STAYS", (2, 3), SAFETY, "invalid end state"),
    ("POOL_STAYS_OPEN", (2, 3), SAFETY, "invalid end state"),
    ("POLLING_SOURCE", (1, 2), ENDS, "acceptance cycle"),
]


def verify(model, compiler, fault, size, checks, folder):
    """(errors, states, what Spin said)."""
    defines = [f"-DSLOTS={size[0]}", f"-DFRAMES={size[1]}"]
    if fault:
        defines.append(f"-DMUTANT_{fault}")
    shutil.copy(model, os.path.join(folder, "pipeline.pml"))
    quiet = {"cwd": folder, "check": True, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    subprocess.run(["spin", "-a", *defines, "pipeline.pml"], **quiet)
    subprocess.run([compiler, "-O1", "-w", "-DCOLLAPSE", *checks, "-o", "pan", "pan.c"], **quiet)
    options = ["-m100000"] if checks else ["-m100000", "-a"]
    said = subprocess.run(["./pan", *options], cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT).stdout.decode()
    errors = int(re.search(r"errors: (\d+)", said).group(1))
    states = int(re.search(r"(\d+) states, stored", said).group(1))
    return errors, states, said


def main():
    model, compiler = sys.argv[1], sys.argv[2]
    if shutil.which("spin") is None:
        print("skipped: spin is not installed (toolchains/setup.sh)")
        return 77
    failed = 0
    for fault, size, checks, expected in RUNS:
        with tempfile.TemporaryDirectory() as folder:
            errors, states, said = verify(model, compiler, fault, size, checks, folder)
        # A search that was cut short proves nothing.
        sound = (errors == 0 and "Search not completed" not in said and "too small" not in said
                 if expected is None else errors > 0 and expected in said)
        what = "every run ends" if not checks else "safe in every state"
        print(f"{fault or 'as in the product':20} {what:20} {size[0]} slots {size[1]} frames "
              f"{states:8} states {'no error' if errors == 0 else expected if sound else said}"
              f"{'' if sound else '   <-- FAILED'}")
        failed += not sound
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
