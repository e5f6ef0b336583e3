"""Stops of a run at random moments, each of which the same command has to finish.

``python -m tests.stops CASE.toml FOLDER COUNT SEED`` runs a case undisturbed, then `COUNT` times with a stop,
and tells by JSON what was stopped and what differs in the end. The program is loaded once; every run is a
process of its own that was split off.
"""

import json
import os
import random
import shutil
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path

import xarray as xr

from exudyn_crawler import Case, simulate
from exudyn_crawler.__main__ import main

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
OWN = {"run.json", "run.log", ".lock", "report.html"}
"""What tells of a run itself; the page has its record."""


def begin(case: Path, out: Path) -> int:
    """Begin the command in a process of its own, whose number is returned."""
    process = os.fork()
    if process:
        return process
    with (out.parent / f"{out.name}.txt").open("a") as told:
        os.dup2(told.fileno(), 1)
        os.dup2(told.fileno(), 2)
    # a shell gives its commands this one, a test runner may not
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.argv = ["exudyn-crawler", "run", str(case), "--out", str(out)]
    code = 99
    try:
        main()
    except SystemExit as end:
        code = int(end.code or 0)
    finally:
        sys.stdout.flush()
        os._exit(code)


def ended(process: int) -> int:
    """Exit code of a process, negative for a signal, once it has ended."""
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def differences(out: Path, whole: Path) -> list[str]:
    """Names of the files that differ or that only one of two folders has."""
    names = [
        {path.relative_to(one).as_posix() for path in one.rglob("*") if path.is_file()} - OWN
        for one in (out, whole)
    ]
    both = names[0] & names[1]
    return sorted((names[0] ^ names[1]) | {name for name in both if not same(out / name, whole / name)})


def same(one: Path, other: Path) -> bool:
    """Whether two files hold the same; of NetCDF and archives, the numbers bit for bit."""
    if one.suffix == ".nc":
        first, second = xr.load_dataset(one, engine="h5netcdf"), xr.load_dataset(other, engine="h5netcdf")
        # the bytes of texts are places in memory
        numbers = [name for name, one in first.variables.items() if one.dtype != object]
        bits = [first[name].values.tobytes() == second[name].values.tobytes() for name in numbers]
        return first.identical(second) and all(bits)
    return one.read_bytes() == other.read_bytes()


def stopped(case: Path, out: Path, moment: float, kind: signal.Signals) -> dict[str, object]:
    """Run a case with a stop after some seconds, then by the same command until it says that it is done."""
    process = begin(case, out)
    time.sleep(moment)
    with suppress(ProcessLookupError):
        os.kill(process, kind)
    first = ended(process)
    then = None if first == 0 else ended(begin(case, out))
    record = out / "run.json"
    status = json.loads(record.read_text())["status"] if record.exists() else "no record"
    told = {"moment": round(moment, 3), "signal": kind.name}
    return told | {"ended": first, "then": then, "status": status}


def trials(case: Path, folder: Path, count: int, seed: int) -> list[dict[str, object]]:
    """Stops at moments drawn from the whole time of an undisturbed run, and what differs from it."""
    draw = random.Random(seed)
    whole = folder / "whole"
    # the first one finds nothing in memory and takes longer
    for out in (whole, folder / "again"):
        start = time.monotonic()
        code = ended(begin(case, out))
        assert code == 0, (folder / f"{out.name}.txt").read_text()
    took = time.monotonic() - start
    assert differences(out, whole) == []
    found = []
    for number in range(count):
        out = folder / f"stopped_{number}"
        kind = SIGNALS[number % len(SIGNALS)]
        moment = took * (number + draw.random()) / count
        # a run that was faster than the one before it has ended by then
        while (one := stopped(case, out, moment, kind))["ended"] == 0:
            shutil.rmtree(out)
            moment *= 0.8
        one["differs"] = differences(out, whole)
        one["told"] = (folder / f"{out.name}.txt").read_text()
        found.append(one)
        shutil.rmtree(out)
    return found


if __name__ == "__main__":
    # loads what is compiled, which the runs then share
    simulate(Case.translation(), 0.01)
    chosen, folder, count, seed = sys.argv[1:]
    print(json.dumps(trials(Path(chosen), Path(folder), int(count), int(seed))))
